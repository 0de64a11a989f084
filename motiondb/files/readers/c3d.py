"""Reader of C3D: marker positions, read by ezc3d (the extra ``c3d``), as a clip of joints.

What is kept: the frame rate, the joint centres computed from the markers, the bone lengths
(medians). What is lost: the markers themselves, analog channels, forces, and the rotation of bones
about their own axis. Gaps of up to half a second are filled along a straight line; a file with
longer ones is refused, naming the markers. The up axis is the one along which the body stands.

The markers are Vicon's Plug-in Gait (LASI RASI, LPSI RPSI or SACR, LKNE LANK LTOE LHEE, LSHO LELB
LWRA LWRB, C7 CLAV STRN T10, LFHD RFHD LBHD RBHD); the CMU database's names of the pelvis (LFWT RFWT
LBWT RBWT) are accepted too. Notation: W is the distance between LASI and RASI; left, up and ahead
are the axes of the pelvis (left: RASI to LASI; ahead: from the middle of the back markers,
orthogonal).

- hip: from the middle of LASI and RASI 0.36 W to the side, 0.19 W back, 0.30 W down (Bell,
  Brand, Pedersen, Human Movement Science 8, 1989);
- knee and ankle: 5 cm and 4 cm from the marker towards the middle, along the pelvis's left axis
  made orthogonal to the bone;
- shoulder: 5 cm below the marker along the trunk; elbow: its marker; wrist: between its markers;
- neck: between C7 and CLAV; chest: between T10 and STRN; head: middle of the head's markers.

These are plain regressions: good to 1 to 4 cm, enough to recognise a motion, not for clinical use.

A damaged file can make ezc3d loop for ever, fill the memory or end its process. So it runs in
a child process with limits, and lets the other captures of a folder be read.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from motiondb.body import body, rotation
from motiondb.body.retarget import solve_rotations
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadLimits, ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.child_process import end_child_with_parent, read_in_child
from motiondb.files.text import quoted
from motiondb.files.units import UNITS
from motiondb.records import Clip, FloatArray, Skeleton

Markers = Mapping[str, FloatArray]  # Marker name -> array (frames, 3), metres, y up

ALIASES = MappingProxyType(
    {"LFWT": "LASI", "RFWT": "RASI", "LBWT": "LPSI", "RBWT": "RPSI", "SACRUM": "SACR", "CV7": "C7"}
)  # Other names -> the names used here
REQUIRED = ("LASI", "RASI", "LKNE", "RKNE", "LANK", "RANK", "LSHO", "RSHO", "LELB", "RELB")
"""Markers that every joint set needs; the back of the pelvis and the neck are needed as well."""
_FURTHER = "LPSI RPSI SACR LTOE RTOE LHEE RHEE LWRA LWRB RWRA RWRB C7 CLAV STRN T10"
_HEAD = ("LFHD", "RFHD", "LBHD", "RBHD")
USED = (*REQUIRED, *_FURTHER.split(), *_HEAD)
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


def missing_markers(names: frozenset[str] | set[str]) -> list[str]:
    """Return what a set of marker names lacks, as messages say it.

    >>> missing_markers(set(USED) - {"LKNE", "C7", "SACR"})
    ['LKNE']
    >>> missing_markers(set(REQUIRED))
    ['LPSI and RPSI, or SACR', 'C7 or CLAV']
    """
    missing = [name for name in REQUIRED if name not in names]
    if "SACR" not in names and not {"LPSI", "RPSI"} <= names:
        missing.append("LPSI and RPSI, or SACR")
    if not {"C7", "CLAV"} & names:
        missing.append("C7 or CLAV")
    return missing


def joint_centres(markers: Markers) -> FloatArray:
    """Compute the canonical joints of markers; `markers` (frames, 3); result (frames, 21, 3)."""
    left, up, ahead, front = _pelvis_axes(markers)
    width = np.median(np.linalg.norm(markers["LASI"] - markers["RASI"], axis=-1))
    points: dict[str, FloatArray] = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        hip = front + width * (0.36 * sign * left - 0.19 * ahead - 0.30 * up)
        points[f"{side}_hip"] = hip
        points |= _leg(markers, side, sign * left, hip)
    points["pelvis"] = (points["l_hip"] + points["r_hip"]) / 2.0
    points["neck"] = _mean(markers, "C7", "CLAV")
    if {"T10", "STRN"} <= set(markers):
        points["chest"] = _mean(markers, "T10", "STRN")
    else:
        points["chest"] = points["pelvis"] + _CHEST_SHARE * (points["neck"] - points["pelvis"])
    points["spine"] = points["pelvis"] + _SPINE_SHARE * (points["chest"] - points["pelvis"])
    trunk = points["neck"] - points["chest"]
    heads = [name for name in _HEAD if name in markers]
    beyond = points["neck"] + _HEAD_SHARE * trunk
    points["head"] = _mean(markers, *heads) if heads else beyond
    for side in "lr":
        points |= _arm(markers, side, rotation.normalize(trunk), points["neck"])
    return np.stack([points[name] for name in body.JOINTS], axis=1)


def _pelvis_axes(markers: Markers) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the axes left, up and ahead (frames, 3), and the middle of the front markers."""
    front = _mean(markers, "LASI", "RASI")
    both = {"LPSI", "RPSI"} <= set(markers)
    back = _mean(markers, "LPSI", "RPSI") if both else markers["SACR"]
    left = rotation.normalize(markers["LASI"] - markers["RASI"])
    up = rotation.normalize(np.cross(front - back, left))
    return left, up, np.cross(left, up), front


def _leg(
    markers: Markers, side: str, outward: FloatArray, hip: FloatArray
) -> dict[str, FloatArray]:
    """Return knee, ankle and toe of a side; ``outward`` is the pelvis's axis to that side."""
    letter = side.upper()
    knee_marker, ankle_marker = markers[f"{letter}KNE"], markers[f"{letter}ANK"]
    knee = knee_marker - _KNEE * _orthogonal(outward, knee_marker - hip)
    ankle = ankle_marker - _ANKLE * _orthogonal(outward, ankle_marker - knee_marker)
    toe = markers.get(f"{letter}TOE")
    if toe is None:
        heel = markers.get(f"{letter}HEE")
        shin = rotation.normalize(ankle - knee)
        ahead = rotation.normalize(np.cross(shin, outward) * (1.0 if side == "l" else -1.0))
        if heel is not None:
            ahead = rotation.normalize(_orthogonal(ankle - heel, shin))
        toe = ankle + _TOE_AHEAD * ahead + _TOE_DOWN * shin
    return {f"{side}_knee": knee, f"{side}_ankle": ankle, f"{side}_toe": toe}


def _arm(
    markers: Markers, side: str, trunk_up: FloatArray, neck: FloatArray
) -> dict[str, FloatArray]:
    """Return collar, shoulder, elbow and wrist of a side."""
    letter = side.upper()
    shoulder = markers[f"{letter}SHO"] - _SHOULDER * trunk_up
    elbow = markers[f"{letter}ELB"]
    wrists = [name for name in (f"{letter}WRA", f"{letter}WRB") if name in markers]
    wrist = _mean(markers, *wrists) if wrists else elbow + _FOREARM_SHARE * (elbow - shoulder)
    collar = neck + _COLLAR_SHARE * (shoulder - neck)
    return {
        f"{side}_collar": collar,
        f"{side}_shoulder": shoulder,
        f"{side}_elbow": elbow,
        f"{side}_wrist": wrist,
    }


def _mean(markers: Markers, *names: str) -> FloatArray:
    """Return the mean (frames, 3) of those of the named markers that are present."""
    present = [markers[name] for name in names if name in markers]
    return np.asarray(np.mean(present, axis=0))


def _orthogonal(vector: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the unit vector along the part of ``vector`` that is orthogonal to ``direction``."""
    along = rotation.normalize(direction)
    return rotation.normalize(vector - np.sum(vector * along, axis=-1, keepdims=True) * along)


CPU_SECONDS = 5.0
"""Processor time of the child for a file of 10 MB, in proportion for larger ones. ezc3d reads 13 MB
in 0.4 s; a damaged file that makes it loop takes all of the time."""
LONGEST_GAP = 0.5
"""Longest gap of a marker that is filled, seconds. Over half a second a limb can swing out and
back, which a straight line would hide."""
_UNIT_NAMES = MappingProxyType(
    {"millimeters": "mm", "meters": "m", "centimeters": "cm", "inches": "inch", "in": "inch"}
)


def read_c3d(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a C3D file; bad frames are those that lack a needed marker."""
    recording = read_points(data, path, options.limits)
    tracks = _named(recording.labels, recording.points, path)
    rate = check_rate(recording.fps, path) if options.fps is None else options.fps
    scale = _unit(recording.unit, path) if options.unit is None else options.unit
    missing = missing_markers(set(tracks))
    if missing:
        present = ", ".join(sorted(tracks)) or "none of the set"
        raise CaptureError(
            path,
            f"expected the markers of Plug-in Gait, found none named {'; '.join(missing)} "
            f"(of the set there are: {present}). Rename the markers, or export the solved skeleton "
            "as BVH.",
        )
    n_frames = recording.points.shape[1]
    check_clip_size(n_frames, len(body.JOINTS), len(data), path, options.limits)
    markers, notes = _fill(tracks, rate, path, options.skip_bad_frames)
    points = joint_centres(_y_up({name: track * scale for name, track in markers.items()}))
    return Clip(
        skeleton=_skeleton(points),
        fps=rate,
        local_rotations=solve_rotations(points),
        root_positions=points[:, 0],
        format="c3d",
        unit=scale,
        notes=notes,
    )


def _named(labels: tuple[str, ...], points: FloatArray, path: object) -> dict[str, FloatArray]:
    """Tracks (frames, 3) of the used markers by name, of the subject that has most of them."""
    subjects: dict[str, dict[str, FloatArray]] = {}
    for label, track in zip(labels, points):
        subject, _, name = label.strip().rpartition(":")
        name = ALIASES.get(name.upper(), name.upper())
        if name in USED:
            subjects.setdefault(subject, {}).setdefault(name, track)
    whole = [subject for subject, tracks in subjects.items() if {"LASI", "RASI"} <= set(tracks)]
    if len(whole) > 1:
        raise CaptureError(
            path,
            f"expected one performer, found {len(whole)}: {', '.join(sorted(whole))}. "
            "Export one performer a file.",
        )
    best = max(subjects.values(), key=len, default={})
    return subjects[whole[0]] if whole else best


def _fill(
    markers: dict[str, FloatArray], fps: float, path: object, skip_bad: bool
) -> tuple[dict[str, FloatArray], tuple[str, ...]]:
    """Tracks without gaps, and notes; what is not needed is dropped where lost for long."""
    filled, notes, lost = {}, [], {}
    for name, track in markers.items():
        straight, longest = _interpolate(track, LONGEST_GAP * fps)
        if np.isnan(straight).any():
            lost[name] = (straight, longest / fps)
        else:
            filled[name] = straight
    if lost and (missing := missing_markers(set(filled))):
        needed = {name for name in lost if name in REQUIRED or any(name in m for m in missing)}
        if skip_bad:
            filled |= {name: lost[name][0] for name in needed}
            good = ~np.isnan(np.stack(list(filled.values()))).any(axis=(0, 2))
            if good.any():
                notes.append(f"Left out {int((~good).sum())} frames with lost markers.")
                return {name: track[good] for name, track in filled.items()}, tuple(notes)
        gaps = ", ".join(f"{name} ({lost[name][1]:.1f} s)" for name in sorted(needed))
        raise CaptureError(
            path,
            f"expected no gap above {LONGEST_GAP:g} s, found lost markers: {gaps}. Fill the gaps "
            "before the export, or pass --skip-bad-frames to leave those frames out.",
        )
    if lost:
        notes.append(f"Left out markers that are lost for long: {', '.join(sorted(lost))}.")
    return filled, tuple(notes)


def _interpolate(track: FloatArray, longest: float) -> tuple[FloatArray, int]:
    """Fill the gaps of a track (frames, 3) along straight lines; also the longest gap.

    >>> track = np.array([[0.0, 0, 0], [np.nan] * 3, [2.0, 0, 0]])
    >>> _interpolate(track, 1)[0][1], _interpolate(track, 0.5)[1]
    (array([1., 0., 0.]), 1)
    """
    seen = ~np.isnan(track[:, 0] + track[:, 1] + track[:, 2])
    if seen.all() or not seen.any():
        return np.where(seen[:, None], track, np.nan), 0 if seen.all() else len(track)
    frames, known = np.arange(len(track)), np.flatnonzero(seen)
    straight = np.stack(
        [np.interp(frames, known, track[known, axis]) for axis in range(3)], axis=-1
    )
    edges = np.flatnonzero(np.diff(np.concatenate([[1], seen.astype(int), [1]])))
    gaps = edges.reshape(-1, 2)
    for start, end in gaps.tolist():
        if end - start > longest:
            straight[start:end] = np.nan
    return straight, int(np.diff(gaps, axis=1).max())


def _unit(name: str, path: object) -> float:
    """Return the metres per unit of a C3D unit name."""
    known = _UNIT_NAMES.get(name.strip().lower(), name.strip().lower()) or "mm"
    if known not in UNITS:
        raise CaptureError(
            path, f"expected POINT:UNITS mm, cm, m or inch, found {quoted(name)}. Give --unit."
        )
    return UNITS[known]


def _y_up(markers: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Turn the world so that the axis along which the body stands (feet to shoulders) is y."""
    tops = np.mean([markers["LSHO"], markers["RSHO"]], axis=0)
    feet = np.mean([markers["LANK"], markers["RANK"]], axis=0)
    up = int(np.argmax(np.abs(np.median(tops - feet, axis=0))))
    axes, signs = {
        0: ([1, 0, 2], [-1.0, 1.0, 1.0]),
        1: ([0, 1, 2], [1.0, 1.0, 1.0]),
        2: ([0, 2, 1], [1.0, 1.0, -1.0]),
    }[up]
    return {name: track[:, axes] * np.array(signs) for name, track in markers.items()}


def _skeleton(points: FloatArray) -> Skeleton:
    """Return the canonical skeleton with this body's bone lengths (medians over the frames)."""
    standard = body.standard_skeleton()
    parents = body.PARENTS.clip(0)
    lengths = np.median(np.linalg.norm(points - points[:, parents], axis=-1), axis=0)
    usual = np.linalg.norm(body.OFFSETS, axis=-1)
    ratio = np.where(usual > 0, lengths / np.where(usual > 0, usual, 1.0), 1.0)
    collars = [body.INDEX["l_collar"], body.INDEX["r_collar"]]
    ratio[collars] = ratio[body.INDEX["neck"]]
    return replace(standard, offsets=body.OFFSETS * ratio[:, None])


@dataclass(frozen=True, eq=False)
class Recording:
    """Marker tracks as a file has them."""

    labels: tuple[str, ...]  # Name of each marker, as written
    points: FloatArray  # (markers, frames, 3): file axes and units; NaN where a marker was not seen
    fps: float
    unit: str  # Name of the length unit, such as "mm"


def read_points(data: bytes, path: object, limits: ReadLimits) -> Recording:
    """Read the markers in the bytes of a C3D file."""
    if importlib.util.find_spec("ezc3d") is None:
        raise CaptureError(
            path,
            "expected the package ezc3d to read C3D, found none. pip install motiondb[c3d]",
        )
    _check_size(data, path)
    module = "motiondb.files.readers.c3d"
    read = read_in_child(module, data, limits, CPU_SECONDS)
    if read is None or not {"labels", "points", "fps", "unit"} <= read.keys():
        raise CaptureError(path, "expected a whole C3D file, found a damaged one. Export it again.")
    recording = Recording(
        tuple(read["labels"].tolist()), read["points"], float(read["fps"]), str(read["unit"])
    )
    if recording.points.ndim != 3 or recording.points.shape[1] == 0:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    return recording


def _check_size(data: bytes, path: object) -> None:
    """Refuse bytes that are not a C3D file, or are shorter than their header says.

    The header holds 16-bit words: word 2 is the number of points, word 3 the number of analog
    values in a frame, words 4 and 5 the first and the last frame, word 9 the block (of 512 bytes)
    where the data begin. Words 7 and 8 are the scale, which is negative when the data are floats.
    Byte 4 of the parameters names the byte order.
    """
    if data[1:2] != b"\x50" or len(data) < 512:
        raise CaptureError(path, "expected a C3D file, found something else. Export it again.")
    processor = data[(data[0] - 1) * 512 :][3:4] if data[0] else b""
    order = ">" if processor == b"\x56" else "<"
    words = np.frombuffer(data[:20], f"{order}u2").astype(int)
    high = data[15] if order == "<" else data[12]
    frame = (4 * words[1] + words[2]) * (4 if high >= 128 else 2)
    expected = (words[8] - 1) * 512 + (words[4] - words[3] + 1) * frame
    if len(data) < expected:
        raise CaptureError(
            path,
            f"expected {expected} bytes as the header says, found {len(data)}. "
            "The file is cut short: export it again.",
        )


def convert(source: str, target: str) -> None:
    """Read a C3D file with ezc3d and write its markers as npz: the work of the child process."""
    import ezc3d

    content = ezc3d.c3d(source)
    parameters = content["parameters"]["POINT"]
    points = np.asarray(content["data"]["points"], dtype=float)[:3]
    units = parameters["UNITS"]["value"] if "UNITS" in parameters else ["mm"]
    np.savez(
        target,
        labels=np.array([str(label) for label in parameters["LABELS"]["value"]], dtype=str),
        points=np.moveaxis(points, 0, -1),
        fps=float(parameters["RATE"]["value"][0]),
        unit=str(units[0]) if len(units) else "mm",
    )


if __name__ == "__main__":
    convert(*end_child_with_parent()[:2])
