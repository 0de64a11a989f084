"""Markers of a person, or centres of joints, as a clip of joints.

What is kept: the frame rate, the joint centres computed from the markers, the bone lengths
(medians). What is lost: the markers themselves, and the rotation of bones about their own axis.
``marker_gaps`` says how gaps are filled. A joint that can be spared (spine, chest, head, wrists,
toes) is estimated where its markers are lost for longer; a file that lacks others is refused,
naming the markers. A unit that makes the body more than twice too large or too small is corrected,
with a note.

``marker_names`` says which names are known; what all have before or behind (``Anna:``, ``_1``) is
the performer's. Notation: W is the distance between LASI and RASI; left, up and ahead are the axes
of the pelvis (left: RASI to LASI; ahead: from the middle of the back markers, orthogonal).

- hip: from the middle of LASI and RASI 0.36 W to the side, 0.19 W back, 0.30 W down (Bell,
  Brand, Pedersen, Human Movement Science 8, 1989);
- knee and ankle: between the outer and the inner marker, or without an inner one 5 cm and 4 cm from
  the outer towards the middle, along the pelvis's left axis made orthogonal to the bone;
- shoulder: 5 cm below the marker along the trunk; elbow: between its markers, or its marker;
  wrist: between its markers;
- neck: between C7 and CLAV, or between the shoulders (over their centres); chest: between T10 and
  STRN; head: middle of the head's markers.

A file of centres has them as they are; its neck, if it has none, is over the middle of both. These
are plain regressions: good to 1 to 4 cm, enough to recognise a motion, not for clinical use.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from motiondb.body import body, rotation, world
from motiondb.body.retarget import neck_over, solved_body
from motiondb.errors import CaptureError, NoBodyError
from motiondb.files.limits import ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.marker_gaps import (
    LONGEST_GAP,
    bridge,
    fill_gaps,
    front_notes,
    gaps_of,
    longest_gap,
    seen,
)
from motiondb.files.readers.marker_names import Named, name_markers
from motiondb.files.text import distinct, quoted, take_name
from motiondb.files.units import UNITS
from motiondb.records import Clip, FloatArray

Markers = Mapping[str, FloatArray]  # Marker name -> array (frames, 3), metres, NaN where lost


@dataclass(frozen=True)
class MarkerFile:
    """What a file says about its markers."""

    labels: Sequence[str]
    n_frames: int
    track: Callable[[int], FloatArray]  # Of a label (frames, 3), file units, NaN where lost
    fps: float
    unit: str  # As the file names it, "" for none
    up: str  # The axis that is up as the file says, "" for none
    usual_up: str  # The axis of the format
    format: str
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class MarkerTracks:
    """Markers as a file has them, without a body; or series of numbers, as of joint angles."""

    labels: tuple[str, ...]
    # (frames, markers, 3): metres, y up, NaN where a marker was not seen; (frames, series, 1)
    places: FloatArray
    fps: float
    format: str
    notes: tuple[str, ...] = ()

    @property
    def what(self) -> str:
        """What the tracks are."""
        return "markers" if self.places.shape[2] == 3 else "series"


_SIDED = {
    "hips": ("ASI", "HJC"),
    "knees": ("KNE", "KJC"),
    "ankles": ("ANK", "AJC"),
    "shoulders": ("SHO", "SJC"),
    "elbows": ("ELB", "EJC"),
}  # What every joint set needs: a marker, or the centre of the joint
_NEEDED = (
    *(side + name for names in _SIDED.values() for name in names for side in "LR"),
    *("LPSI", "RPSI", "SACR", "C7", "CLAV", "NECK"),
)  # For joints that are not estimated
_HEAD = ("LFHD", "RFHD", "LBHD", "RBHD", "HEAD")
_PLUG_IN_GAIT = (
    *("LASI", "RASI", "LPSI", "RPSI", "SACR", "LKNE", "RKNE", "LANK", "RANK", "LTOE", "RTOE"),
    *("LHEE", "RHEE", "LSHO", "RSHO", "LELB", "RELB", "LWRA", "RWRA", "LWRB", "RWRB"),
    *("C7", "CLAV", "STRN", "T10", "LFHD", "RFHD", "LBHD", "RBHD"),
)
_KNEE, _ANKLE, _SHOULDER = 0.05, 0.04, 0.05
"""Metres from the marker to the joint centre: half the width of an adult's knee and ankle with the
radius of the marker, and the depth of the shoulder joint below the skin. Rounded to a centimetre;
not tuned."""
_CHEST_SHARE, _SPINE_SHARE, _HEAD_SHARE = 0.55, 0.45, 0.4
"""Positions of joints without markers, as fractions from the pelvis to the neck (chest), to the
chest (spine), and beyond the neck along the trunk (head); close to those of the canonical body."""
_FOREARM_SHARE, _COLLAR_SHARE = 0.9, 0.2
"""Length of the forearm by the upper arm, and the collar's place from neck to shoulder: close to
the canonical body."""
_TOE_AHEAD, _TOE_DOWN = 0.14, 0.06  # Metres from the ankle to the toe joint on the canonical body


def read_markers(
    file: MarkerFile, n_bytes: int, path: object, options: ReadOptions
) -> dict[str, Clip]:
    """Solve the joints of each performer; "" for the only one."""
    check_clip_size(file.n_frames, len(body.JOINTS), n_bytes, path, options.limits)
    performers, left_out = _performers(file)
    file = replace(file, notes=file.notes + left_out)
    if len(performers) == 1:
        return {"": _solve(file, next(iter(performers.values())), path, options)}
    clips, faults = dict[str, Clip](), list[CaptureError]()
    for name, named in performers.items():
        try:
            clips[name] = _solve(file, named, f"{path}#{name}", options)
        except CaptureError as error:  # the others may be whole
            faults.append(error)
    if not clips:
        raise faults[0]
    told = tuple(f"Another performer is left out: {error}" for error in faults)
    return {name: replace(clip, notes=clip.notes + told) for name, clip in clips.items()}


def read_tracks(file: MarkerFile, n_bytes: int, path: object, options: ReadOptions) -> MarkerTracks:
    """Read the markers of a file as they are, in metres and with y up, gaps left as gaps."""
    check_clip_size(file.n_frames, len(file.labels), n_bytes, path, options.limits)
    labels = distinct([label or f"unnamed {n}" for n, label in enumerate(file.labels, start=1)])
    tracks = {label: file.track(n) for n, label in enumerate(labels)}
    tracks = {label: track for label, track in tracks.items() if seen(track).any()}
    if not tracks:
        raise CaptureError(
            path, "expected markers, found none that was ever seen. Export it again."
        )
    unit = unit_of(file.unit, path) if options.unit is None else options.unit
    turn = world.to_y_up(options.up or file.up or file.usual_up)
    rate = check_rate(file.fps, path) if options.fps is None else options.fps
    places = rotation.rotate(turn, np.stack(list(tracks.values()), axis=1) * unit)
    lost = {label: longest_gap(track) / rate for label, track in tracks.items()}
    gaps = gaps_of([label for label, seconds in lost.items() if seconds > LONGEST_GAP], lost)
    told = (f"Lost for long, and left as gaps: {gaps}.",) if gaps else ()
    return MarkerTracks(tuple(tracks), places, rate, file.format, file.notes + told)


def only_performer(clips: Mapping[str, Clip], path: object, options: ReadOptions) -> Clip:
    """Return the clip of the performer that is asked for, or of the only one (CaptureError)."""
    if len(clips) == 1 and not options.take:
        return next(iter(clips.values()))
    if options.take in clips:
        return clips[options.take]
    if len(clips) == 1:
        told = f"expected no performer to be named, as there is one alone, found {options.take!r}."
        raise CaptureError(path, told + " Leave it out.")
    wanted = f"a performer {options.take!r}" if options.take else "one performer"
    raise CaptureError(
        path,
        f"expected {wanted}, found {len(clips)}: {', '.join(sorted(clips))}. Name one: "
        f"FILE#{min(clips)}.",
    )


def _performers(file: MarkerFile) -> tuple[dict[str, Named], tuple[str, ...]]:
    """Return the markers of the performers that have a whole body, else of the best one.

    Also a note on others that have several markers.
    """
    groups = [
        *name_markers(file.labels).items(),
        *_named_within(file.labels, "").items(),
        *_named_within(file.labels, "[0-9_]*").items(),
    ]
    whole: list[tuple[str, Named]] = []
    partly: list[tuple[str, Named]] = []
    for is_partly, kept in enumerate((whole, partly)):
        for who, named in groups:
            taken = {n for _, other in whole + partly for n in itertools.chain(*other.values())}
            there = {m for m, ns in named.items() if any(seen(file.track(n)).any() for n in ns)}
            is_apart = taken.isdisjoint(itertools.chain(*named.values()))
            if is_apart and (len(named) >= _PARTLY if is_partly else not missing_markers(there)):
                kept.append((who, named))
    if not whole:
        return {"": max((named for _, named in groups), key=len, default={})}, ()
    whole, copies = _without_copies(file, whole)
    short = [who.rpartition(":")[2] for who, _ in whole]
    names = [name if short.count(name) == 1 else who for name, (who, _) in zip(short, whole)]
    names = distinct([take_name(name.strip("_-. ") or "unnamed") for name in names])
    notes = tuple(
        f"{quoted(who.strip('_-. :')) or 'Another'} has no whole body and is left out; missing or "
        f"never seen: {'; '.join(missing_markers(set(named)) or ['all'])}."
        for who, named in partly
    )
    return dict(zip(names, (named for _, named in whole))), copies + notes


def _without_copies(
    file: MarkerFile, whole: list[tuple[str, Named]]
) -> tuple[list[tuple[str, Named]], tuple[str, ...]]:
    """Leave out markers that stand where those of another name are, as filtered ones; and notes."""

    def middle(named: Named) -> FloatArray:
        needed = [file.track(numbers[0]) for name, numbers in named.items() if name in _NEEDED]
        return np.nanmedian(np.array(needed), axis=0)

    def colons(named: Named) -> int:
        return file.labels[next(iter(named.values()))[0]].count(":")

    kept, notes = list[tuple[str, Named]](), list[str]()
    for who, named in whole:
        near = [
            other
            for other, known in kept
            if other in who and colons(named) == colons(known)  # as LASI and LASI_f
            if np.nanmedian(np.linalg.norm(middle(named) - middle(known), axis=1))
            < _COPY * np.nanmax(np.nanstd([file.track(n[0]) for n in known.values()], axis=0))
        ]
        if not near:
            kept.append((who, named))
        else:
            notes.append(
                f"The markers with {quoted(who.strip(': '))} in their names stand where the "
                "others are, and are left out as a copy of them."
            )
    return kept, tuple(notes)


def _named_within(labels: Sequence[str], behind: str) -> dict[str, Named]:
    """Return markers whose names stand within labels, by what is around them but for `behind`."""
    pattern = re.compile(_LABEL_WITHIN + behind, re.IGNORECASE)
    within: dict[str, Named] = {}
    for number, label in enumerate(labels):
        if match := pattern.fullmatch(label):
            before, name, after = match.groups("")
            within.setdefault(before + after, {}).setdefault(name.upper(), []).append(number)
    return within


def missing_markers(names: frozenset[str] | set[str]) -> list[str]:
    """Return what a set of marker names lacks, as messages say it.

    >>> missing_markers(set(_PLUG_IN_GAIT) - {"LKNE", "C7", "SACR"})
    ['LKNE']
    >>> missing_markers({side + names[0] for names in _SIDED.values() for side in "LR"})
    ['LPSI and RPSI, or SACR']
    """
    missing = [
        side + markers[0]
        for markers in _SIDED.values()
        for side in "LR"
        if not {side + name for name in markers} & names
    ]
    if len(front := {"LASI", "RASI"} & names) == 1 and not missing:
        missing += {"LASI", "RASI"} - front
    if {"LASI", "RASI"} <= names and "SACR" not in names and not {"LPSI", "RPSI"} <= names:
        missing.append("LPSI and RPSI, or SACR")
    return missing


def joint_centres(markers: Markers) -> FloatArray:
    """Compute the canonical joints of markers; `markers` (frames, 3); result (frames, 21, 3)."""
    left, up, ahead, front = _pelvis_axes(markers)
    points: dict[str, FloatArray] = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        if "LASI" in markers:
            width = np.median(np.linalg.norm(markers["LASI"] - markers["RASI"], axis=-1))
            hip = front + width * (0.36 * sign * left - 0.19 * ahead - 0.30 * up)
        else:
            hip = markers[f"{side.upper()}HJC"]
        points[f"{side}_hip"] = hip
        points |= _leg(markers, side, sign * left, hip)
    pelvis = points["pelvis"] = (points["l_hip"] + points["r_hip"]) / 2.0
    neck = points["neck"] = _neck(markers)
    chest = pelvis + _CHEST_SHARE * (neck - pelvis)
    if {"T10", "STRN"} <= set(markers):
        chest = bridge((markers["T10"] + markers["STRN"]) / 2.0, chest)
    points["chest"] = chest
    points["spine"] = pelvis + _SPINE_SHARE * (chest - pelvis)
    points["head"] = bridge(_mean(markers, *_HEAD), neck + _HEAD_SHARE * (neck - chest))
    for side in "lr":
        points |= _arm(markers, side, rotation.normalize(neck - chest), neck)
    return np.stack([points[name] for name in body.JOINTS], axis=1)


def _pelvis_axes(markers: Markers) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the axes left, up and ahead (frames, 3), and the middle of the front markers."""
    if "LASI" in markers:
        front, back = _mean(markers, "LASI", "RASI"), _back(markers)
        left = rotation.normalize(markers["LASI"] - markers["RASI"])
        up = rotation.normalize(np.cross(front - back, left))
    else:
        front = _mean(markers, "LHJC", "RHJC")
        left = rotation.normalize(markers["LHJC"] - markers["RHJC"])
        up = _orthogonal(_neck(markers) - front, left)
    return left, up, np.cross(left, up), front


def _back(markers: Markers) -> FloatArray:
    """Return the middle of the back of the pelvis (frames, 3), NaN where it is lost."""
    if not {"LPSI", "RPSI"} <= set(markers):
        return markers["SACR"]
    middle = (markers["LPSI"] + markers["RPSI"]) / 2.0
    return bridge(middle, markers["SACR"]) if "SACR" in markers else middle


def _neck(markers: Markers) -> FloatArray:
    """Return the base of the neck (frames, 3)."""
    if {"C7", "CLAV"} & set(markers):
        return _mean(markers, "C7", "CLAV")
    if "NECK" in markers:
        return markers["NECK"]
    if "LSJC" not in markers:  # on the skin, about as high as the neck
        return (markers["LSHO"] + markers["RSHO"]) / 2.0
    hip = "HJC" if "LHJC" in markers else "ASI"
    return neck_over(*([markers[side + end] for side in "LR"] for end in ("SJC", hip)))


def _centre(markers: Markers, side: str, joint: str, outer: str, inner: str) -> FloatArray | None:
    """Return a joint's centre, or the middle of its markers on both sides, if there is either."""
    if (centre := markers.get(side + joint)) is not None:
        return centre
    if {side + outer, side + inner} <= set(markers):
        middle = (markers[side + outer] + markers[side + inner]) / 2.0
        return bridge(middle, markers[side + outer])
    return None


def _leg(
    markers: Markers, side: str, outward: FloatArray, hip: FloatArray
) -> dict[str, FloatArray]:
    """Return knee, ankle and toe of a side; ``outward`` is the pelvis's axis to that side."""
    letter = side.upper()
    knee = _centre(markers, letter, "KJC", "KNE", "KNM")
    if knee is None:
        marker = markers[f"{letter}KNE"]
        knee = marker - _KNEE * _orthogonal(outward, marker - hip)
    ankle = _centre(markers, letter, "AJC", "ANK", "ANM")
    if ankle is None:
        marker = markers[f"{letter}ANK"]
        ankle = marker - _ANKLE * _orthogonal(outward, marker - markers.get(f"{letter}KNE", knee))
    shin = rotation.normalize(ankle - knee)
    ahead = rotation.normalize(np.cross(shin, outward) * (1.0 if side == "l" else -1.0))
    if (heel := markers.get(f"{letter}HEE")) is not None:
        ahead = rotation.normalize(bridge(_orthogonal(ankle - heel, shin), ahead))
    toe = ankle + _TOE_AHEAD * ahead + _TOE_DOWN * shin
    if f"{letter}TOE" in markers:
        toe = bridge(markers[f"{letter}TOE"], toe)
    elif {f"{letter}FM1", f"{letter}FM5"} & set(markers):
        toe = bridge(_mean(markers, f"{letter}FM1", f"{letter}FM5"), toe)
    return {f"{side}_knee": knee, f"{side}_ankle": ankle, f"{side}_toe": toe}


def _arm(
    markers: Markers, side: str, trunk_up: FloatArray, neck: FloatArray
) -> dict[str, FloatArray]:
    """Return collar, shoulder, elbow and wrist of a side."""
    letter = side.upper()
    shoulder = markers.get(f"{letter}SJC")
    if shoulder is None:
        shoulder = markers[f"{letter}SHO"] - _SHOULDER * trunk_up
    elbow = _centre(markers, letter, "EJC", "ELB", "ELM")
    elbow = markers[f"{letter}ELB"] if elbow is None else elbow
    wrist = _mean(markers, f"{letter}WJC", f"{letter}WRA", f"{letter}WRB")
    wrist = bridge(wrist, elbow + _FOREARM_SHARE * (elbow - shoulder))
    collar = neck + _COLLAR_SHARE * (shoulder - neck)
    return {
        f"{side}_collar": collar,
        f"{side}_shoulder": shoulder,
        f"{side}_elbow": elbow,
        f"{side}_wrist": wrist,
    }


def _mean(markers: Markers, *names: str) -> FloatArray:
    """Return the mean (frames, 3) of those of the named markers that are seen, NaN for none."""
    none = np.full_like(next(iter(markers.values())), np.nan)
    tracks = np.stack([markers.get(name, none) for name in names])
    known = ~np.isnan(tracks)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(known, tracks, 0.0).sum(axis=0) / known.sum(axis=0))


def _orthogonal(vector: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the unit vector along the part of ``vector`` that is orthogonal to ``direction``."""
    along = rotation.normalize(direction)
    return rotation.normalize(vector - np.sum(vector * along, axis=-1, keepdims=True) * along)


_LABEL_WITHIN = f"(.*?)({'|'.join(_PLUG_IN_GAIT)})(.*?)"
_COPY = 0.1  # Of the spread of a body's markers: a copy of them is nearer
_PARTLY = 8  # Markers of a body from which a performer without a whole one is told: a prop has less
_UNIT_NAMES = MappingProxyType(
    {"mill": "mm", "cent": "cm", "mete": "m", "metr": "m", "inch": "inch", "in": "inch", "": "mm"}
)  # First four letters of names, after which some programs cut


def _solve(file: MarkerFile, named: Named, path: object, options: ReadOptions) -> Clip:
    """Solve the joints of one performer; bad frames are those that lack a needed marker."""
    tracks = {
        name: max(map(file.track, numbers), key=lambda track: seen(track).sum())
        for name, numbers in named.items()
    }
    twice = ", ".join(sorted(name for name, numbers in named.items() if len(numbers) > 1))
    notes = file.notes
    if twice:
        notes += (
            f"Markers that occur more than once, of which the one seen most is taken: {twice}.",
        )
    if {"SACR", "C7", "CLAV", "STRN", "T10"} & tracks.keys() and "LASI" not in tracks:
        joints = "hips, knees and ankles" if "LKJC" in tracks else "hips"
        notes += (f"Markers named hip are taken for the centres of the {joints}.",)
    if "LSHO" in tracks and not {"C7", "CLAV", "NECK"} & tracks.keys():
        notes += ("There is no marker of the neck (C7, CLAV); it is taken between the shoulders.",)
    if "NECK" not in tracks and len(neck := {"C7", "CLAV"} & tracks.keys()) == 1:
        notes += (f"The neck is taken at {min(neck)}, as the other of C7 and CLAV is missing.",)
    notes += _estimated(tracks)
    if options.swap_sides:
        other = {"L": "R", "R": "L"}
        tracks = {other.get(name[0], name[0]) + name[1:]: t for name, t in tracks.items()}
    rate = check_rate(file.fps, path) if options.fps is None else options.fps
    filled, gap_notes = fill_gaps(tracks, rate, _NEEDED, not options.skip_bad_frames)
    if missing := missing_markers(set(filled)):
        labels = {name: file.labels[numbers[0]] for name, numbers in named.items()}
        there = ", ".join(sorted(labels.get(name, name) for name in filled)) or "none that is known"
        never = ", ".join(sorted(labels.get(name, name) for name in set(tracks) - set(filled)))
        raise NoBodyError(
            path,
            f"expected the markers of a whole body, as Plug-in Gait names them, found none for "
            f"{'; '.join(missing)} (there are: {there}{never and '; never seen: '}{never}). "
            "Rename the markers, or export the solved skeleton as BVH.",
        )
    tracks, bad_notes = _good_frames(filled, rate, path, options.skip_bad_frames)
    unit, unit_notes = _find_unit(file.unit, tracks, path, options.unit)
    markers = {name: track * unit for name, track in tracks.items()}
    points = joint_centres(markers)
    up, up_notes = _up(file, points, rate, options.up)
    turn = np.broadcast_to(world.to_y_up(up), (len(points), 4))
    if options.mirror_world:
        mirrored = [-1.0, 1.0, 1.0]
        turned = {name: rotation.rotate(turn, track) for name, track in markers.items()}
        points = joint_centres({name: track * mirrored for name, track in turned.items()})
    else:
        points = rotation.rotate(turn[:, None], points)
    skeleton, rotations = solved_body(points)
    return Clip(
        skeleton=skeleton,
        fps=rate,
        local_rotations=rotations,
        root_positions=points[:, 0],
        format=file.format,
        unit=unit,
        notes=notes + front_notes(markers) + gap_notes + bad_notes + unit_notes + up_notes,
        up="y",
    )


def _estimated(names: Collection[str]) -> tuple[str, ...]:
    """Note wrists and toes for which there are no markers."""
    lacking = {
        "wrists": [side for side in "LR" if not any(f"{side}{m}" in names for m in _WRIST)],
        "toes": [side for side in "LR" if not any(f"{side}{m}" in names for m in _TOES)],
    }
    said = [
        name if len(sides) == 2 else f"{'left' if sides == ['L'] else 'right'} {name[:-1]}"
        for name, sides in lacking.items()
        if sides
    ]
    if not said:
        return ()
    return (f"No markers are known for {' and '.join(said)}: estimated from the rest of the body.",)


_WRIST, _TOES = ("WRA", "WRB", "WJC"), ("TOE", "FM1", "FM5")


def _good_frames(
    tracks: dict[str, FloatArray], fps: float, path: object, skip_bad: bool
) -> tuple[dict[str, FloatArray], tuple[str, ...]]:
    """Refuse tracks that lack needed markers for long, or leave out these frames, with a note."""
    sided = [side + name for names in _SIDED.values() for name in names for side in "LR"]
    if "LASI" in tracks:
        sided = [name for name in sided if not name.endswith("HJC")]
    needed = {name: tracks[name] for name in sided if name in tracks}
    backs = [name for name in ("LPSI", "RPSI", "SACR") if name in tracks]
    if "LASI" in tracks:
        needed[" and ".join(backs)] = _back(tracks)
    necks = [name for name in ("C7", "CLAV") if name in tracks]
    if necks:
        needed["C7 and CLAV"] = _neck(tracks)
    elif "NECK" not in tracks:
        needed["the shoulders, as there is no C7 or CLAV"] = _neck(tracks)
    lost = {name: longest_gap(track) / fps for name, track in needed.items()}
    lost = {name: seconds for name, seconds in lost.items() if seconds > 0}
    if not lost:
        return tracks, ()
    good = np.all([seen(track) for track in needed.values()], axis=0)
    if skip_bad and good.any():
        note = f"Left out {int((~good).sum())} frames with lost markers."
        return {name: track[good] for name, track in tracks.items()}, (note,)
    gaps = gaps_of(list(lost), lost)
    raise CaptureError(
        path,
        f"expected no gap above {LONGEST_GAP:g} s, found lost markers: {gaps}. Fill the gaps "
        "before the export, or pass --skip-bad-frames to leave those frames out.",
    )


def unit_of(name: str, path: object) -> float:
    """Return the metres per unit of a unit's name."""
    short = name.strip().lower()
    known = _UNIT_NAMES.get(short[:4], short)
    if known not in UNITS:
        raise CaptureError(
            path, f"expected the unit mm, cm, m or inch, found {quoted(name)}. Give --unit."
        )
    return UNITS[known]


def _find_unit(
    name: str, tracks: Markers, path: object, asked: float | None
) -> tuple[float, tuple[str, ...]]:
    """Return the unit asked for, or a file's, or the one in which its markers are on a person."""
    if asked is not None:
        return asked, ()
    stated = unit_of(name, path)
    is_skin = "LASI" in tracks
    typical = 0.9 if is_skin else world.TYPICAL_LEG
    leg = (_SIDED[part][:: 1 if is_skin else -1] for part in ("hips", "knees", "ankles"))
    down = [next(name for name in names if f"L{name}" in tracks) for names in leg]
    ways = [
        np.linalg.norm(tracks[side + a] - tracks[side + b], axis=1)
        for side in "LR"
        for a, b in pairwise(down)
    ]
    return world.checked_unit(stated, float(np.median(np.sum(ways, axis=0))) / 2.0, typical)


def _up(
    file: MarkerFile, points: FloatArray, fps: float, asked: str
) -> tuple[str, tuple[str, ...]]:
    """Return the axis that is up, and notes.

    A C3D whose Y_SCREEN has the wrong sign, as Qualisys writes it, is told by a body that stands
    the other way.
    """
    if asked:
        return asked, ()
    if not file.up:
        found = world.find_up(points, fps, usual=file.usual_up)
        return found.up, found.notes
    other = file.up.lstrip("-")
    if file.up != other:
        found = world.find_up(points, fps, usual=file.up)
        if found.is_sure and found.up == other:
            return other, (
                f"POINT:Y_SCREEN says that {file.up} is up, but the body stands along {other}, "
                "which is taken. Give the axis (--up) if this is wrong.",
            )
    return file.up, ()
