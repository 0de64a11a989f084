"""Gaps of markers: what is filled, and what is left; and markers with each other's names.

Markers on one part of the body (pelvis, trunk, head, wrist, foot) stand in for each other: a lost
one keeps its place among three of the others, or its distance to one, both of which change in
proportion to time from one end of the gap to the other. Else gaps of up to half a second of the
markers that cannot be spared are filled along a straight line. Longer ones of a knee, an ankle, a
shoulder or an elbow are filled beside the trunk, with a note that says not to believe the limb
there. What is still lost stays NaN.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from motiondb.body import rotation
from motiondb.records import LARGEST, BoolArray, FloatArray

_MOST_LOST = 10  # Missing frames for each that is there, beyond which numbers of frames say nothing
LONGEST_GAP = 0.5
"""Longest gap of a marker that is filled along a line, seconds. Over half a second a limb can swing
out and back, which a straight line would hide."""
_TOLD = 0.25  # Seconds above which such a gap is told: a knee may be 10 cm beside the line
_PARTS = (
    (("LASI", "RASI", "LPSI", "RPSI", "SACR"), (), False),
    (("C7", "CLAV", "STRN", "T10"), ("LSHO", "RSHO"), True),
    (("LSHO",), ("C7", "CLAV", "STRN", "T10"), False),
    (("RSHO",), ("C7", "CLAV", "STRN", "T10"), False),
    (("LFHD", "RFHD", "LBHD", "RBHD"), (), True),
    (("LWRA", "LWRB"), (), True),
    (("RWRA", "RWRB"), (), True),
    (("LANK", "LHEE", "LTOE"), ("LKNE",), False),
    (("RANK", "RHEE", "RTOE"), ("RKNE",), False),
)
"""The markers of each part; others that nearly keep their places on it; whether one of them is
enough to tell where another is. A shoulder that is lost for a second is within 1.2 cm so in 10 real
walks, and within 10 cm (median 3 cm) while tennis is served."""
_TRUNK = (
    *("LASI", "RASI", "SACR", "LPSI", "RPSI", "LHJC", "RHJC", "NECK", "C7", "CLAV", "T10", "STRN"),
    *("LSJC", "RSJC"),
)
_LIMBS = ("KNE", "KJC", "ANK", "AJC", "SHO", "SJC", "ELB", "EJC")
"""Markers beside which those of limbs are drawn where they are lost for long."""
_FLAT = 0.1  # Sine of the angle between three markers below which they are no frame

_FRONT_AND_BACK = (
    *("LASI LPSI", "RASI RPSI", "LASI SACR", "RASI SACR", "LTOE LANK", "RTOE RANK", "CLAV C7"),
    *("STRN T10", "LFHD LBHD", "RFHD RBHD"),
)
_TOGETHER = (
    *(f"{s}{a} {s}{b}" for s in "LR" for a, b in (("WRA", "WRB"), ("KNE", "KNM"), ("ANK", "HEE"))),
    *(f"{s}{a} {s}{b}" for s in "LR" for a, b in (("ANK", "ANM"), ("ELB", "ELM"))),
    *_FRONT_AND_BACK,
)
_APART = 0.35  # Median metres between markers of one part: .28 at most in 19 real captures
_BACKWARDS = -0.3  # Median cosine with the other pairs; it is .72 or more in 14 real captures


def fill_gaps(
    markers: Mapping[str, FloatArray], fps: float, needed: Collection[str], all_limbs: bool = True
) -> tuple[dict[str, FloatArray], tuple[str, ...]]:
    """Fill gaps of tracks (frames, 3) and leave out markers that were never seen; also notes.

    `needed`: names of those that cannot be estimated. `all_limbs`: draw limbs beside the trunk
    where they are lost for long, too.
    """
    raw = {name: track for name, track in markers.items() if seen(track).any()}
    filled = {name: _from_part(name, raw) for name in raw}
    tracks = {
        name: straight(track, LONGEST_GAP * fps) if name in needed else track
        for name, track in filled.items()
    }
    long = {name: longest_gap(track) / fps for name, track in raw.items()}
    long = {name: seconds for name, seconds in long.items() if seconds > LONGEST_GAP}
    by_others = [name for name in long if name in needed and seen(filled[name]).all()]
    guessed = []
    for name in long if all_limbs else ():
        if name in needed and name[1:] in _LIMBS and not seen(tracks[name]).all():
            tracks[name] = _beside_trunk(name, raw, filled)
            guessed += [name] if seen(tracks[name]).all() else []
    lines = {n: longest_gap(t) / fps for n, t in filled.items() if n in needed and n not in long}
    along = [name for name, seconds in lines.items() if seconds > _TOLD]
    spared = [name for name in long if name not in needed]
    notes = []
    if never := sorted(set(markers) - set(raw)):
        notes.append(f"Never seen, taken as absent: {', '.join(never)}.")
    if along:
        notes.append(f"Lost and filled along a straight line: {gaps_of(along, lines)}.")
    for names, how in (
        (by_others, "filled from the markers beside them"),
        (spared, "estimated there from the rest of the body"),
        (guessed, "drawn there beside the trunk; do not believe the motion of these limbs"),
    ):
        if names:
            notes.append(f"Lost for long and {how}: {gaps_of(names, long)}.")
    return tracks, tuple(notes)


def _beside_trunk(
    name: str, raw: Mapping[str, FloatArray], filled: Mapping[str, FloatArray]
) -> FloatArray:
    """Fill a marker's gaps by its place among three of the trunk, as it changes over the gap."""
    track = filled[name].copy()
    for three in itertools.combinations([filled[n] for n in _TRUNK if n in filled], 3):
        if seen(track).all():
            break
        _carry(track, raw[name], three[0], _axes(*three))
    return track


def bridge(track: FloatArray, estimate: FloatArray) -> FloatArray:
    """Fill a track (frames, 3) by an estimate, moved so that it meets the track at every gap.

    >>> track, estimate = np.full((3, 3), np.nan), np.ones((3, 3))
    >>> track[0] = 2.0
    >>> bridge(track, estimate)[:, 0]
    array([2., 2., 2.])
    """
    if not seen(track).any():
        return estimate
    return np.where(np.isnan(track), estimate + straight(track - estimate, np.inf), track)


def straight(track: FloatArray, longest: float) -> FloatArray:
    """Fill the gaps of a track (frames, 3) up to so many frames along straight lines.

    >>> track = np.array([[0.0, 0, 0], [np.nan] * 3, [2.0, 0, 0]])
    >>> straight(track, 1)[1], straight(track, 0.5)[1]
    (array([1., 0., 0.]), array([nan, nan, nan]))
    """
    known = np.flatnonzero(seen(track))
    if len(known) in (0, len(track)):
        return track
    frames = np.arange(len(track))
    lines = np.stack([np.interp(frames, known, track[known, axis]) for axis in range(3)], axis=-1)
    for start, end in _gaps(track):
        if end - start > longest:
            lines[start:end] = np.nan
    return lines


def longest_gap(track: FloatArray) -> int:
    """Return the frames of the longest gap of a track."""
    return max((end - start for start, end in _gaps(track)), default=0)


def gaps_of(names: Sequence[str], seconds: Mapping[str, float]) -> str:
    """Write names of markers with the seconds that they are lost for."""
    return ", ".join(f"{name} ({seconds[name]:.1f} s)" for name in sorted(names))


_SENTINEL = 999.0  # From which on a number that stands thrice is no place


def is_place(numbers: FloatArray) -> BoolArray:
    """Say which x, y, z (..., 3) can be a place: not infinite, and not 0 or 999 and more thrice.

    Programs write markers that they lost as zeros, 9999.99 or -9999.

    >>> is_place(np.array([[0.0, 0, 0], [9999.99] * 3, [np.nan] * 3, [1, 1, 1], [1e10, 0, 1]]))
    array([False, False, False,  True, False])
    """
    with np.errstate(invalid="ignore"):
        sizes = np.abs(numbers)
        inside = np.asarray((sizes < LARGEST).all(axis=-1))
        differ = np.asarray((numbers != numbers[..., :1]).any(axis=-1))
        return inside & (differ | ((sizes[..., 0] > 0.0) & (sizes[..., 0] < _SENTINEL)))


def count_notes(stated: str, n_frames: int) -> tuple[str, ...]:
    """Note a header that says another number of frames than there are, as in a file cut short."""
    if not stated.isdecimal() or int(stated) == n_frames:
        return ()
    return (f"The header says {stated} frames; there are {n_frames}.",)


def with_missing(numbers: FloatArray, rows: FloatArray) -> tuple[FloatArray, tuple[str, ...]]:
    """Put rows of NaN where the numbers of the frames leave some out, with a note."""
    steps = np.diff(numbers)
    step = float(np.median(steps)) if len(steps) else 1.0
    if not (step > 0 and (steps > 0).all() and (steps % step == 0).all()):
        return rows, ()
    at = ((numbers - numbers[0]) / step).astype(np.int64)
    lost = int(at[-1]) + 1 - len(rows)
    if not 0 < lost <= _MOST_LOST * len(rows):
        return rows, ()
    whole = np.full((len(rows) + lost, *rows.shape[1:]), np.nan)
    whole[at] = rows
    return whole, (f"By their numbers {lost} frames are missing; they are taken as not seen.",)


def seen(track: FloatArray) -> BoolArray:
    """Say for which frames a track has places."""
    return np.asarray(~np.isnan(track).any(axis=1))


def _gaps(track: FloatArray) -> list[tuple[int, int]]:
    """Return the half-open intervals of frames in which a track has no places."""
    edges = np.flatnonzero(np.diff(np.concatenate([[1], seen(track).astype(int), [1]])))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _from_part(name: str, raw: Mapping[str, FloatArray]) -> FloatArray:
    """Fill a marker's gaps from those on the same part of the body: by threes, else by ones."""
    track = raw[name].copy()
    for part, beside, is_one_enough in _PARTS:
        if name not in part or seen(track).all():
            continue
        others = [raw[other] for other in (*part, *beside) if other in raw and other != name]
        for three in itertools.combinations(others, 3):
            _carry(track, raw[name], three[0], _axes(*three))
        for other in others if is_one_enough else ():
            _carry(track, raw[name], other, np.broadcast_to(np.eye(3), (len(track), 3, 3)))
    return track


def _carry(
    track: FloatArray, measured: FloatArray, origin: FloatArray, axes: FloatArray | None
) -> None:
    """Fill the gaps of a track by its place in axes (frames, 3, 3) at an origin, in proportion."""
    if axes is None:
        return
    place = np.einsum("fik,fi->fk", axes, measured - origin)
    if not seen(place).any():
        return
    carried = origin + np.einsum("fik,fk->fi", axes, straight(place, np.inf))
    gap = ~seen(track)
    track[gap] = carried[gap]


def _axes(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray | None:
    """Return the axes (frames, 3, 3), as columns, of three points; None if they lie on a line."""
    first = rotation.normalize(b - a)
    normal = np.cross(first, rotation.normalize(c - a))
    sizes = np.linalg.norm(normal, axis=1)
    if not np.nanmedian(np.append(sizes, 0.0 if np.isnan(sizes).all() else np.nan)) > _FLAT:
        return None
    normal = rotation.normalize(normal)
    return np.stack([first, np.cross(normal, first), normal], axis=-1)


def front_notes(markers: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Note markers of the front that are behind those of the back, if the others are not."""
    ways = {
        f"{front} and {back}": rotation.normalize(markers[front] - markers[back])
        for front, back in (names.split() for names in _FRONT_AND_BACK)
        if front in markers and back in markers
    }
    wrong = []
    for names, way in ways.items():
        others = np.nansum([other for name, other in ways.items() if name != names], axis=0)
        ahead = np.sum(way * rotation.normalize(others), axis=-1) if len(ways) > 2 else np.ones(1)
        known = ahead[np.isfinite(ahead)]
        if len(known) and np.median(known) < _BACKWARDS:
            wrong.append(names)
    apart = [
        names.replace(" ", " and ")
        for names in _TOGETHER
        if {*names.split()} <= markers.keys() and _between(markers, *names.split()) > _APART
    ]
    for high, low in (("CLAV", "STRN"), ("C7", "T10")):
        if {high, low, "LSHO", "RSHO"} <= markers.keys():
            far, near = (
                _between(markers, one, "LSHO") + _between(markers, one, "RSHO")
                for one in (low, high)
            )
            apart += [f"{high} and {low}"] * (far < near)
    if apart:
        return (
            f"Markers are not where their names say: {', '.join(apart)}. Their names look "
            "exchanged. Rename the markers.",
        )
    if not wrong:
        return ()
    return (
        f"Front is behind back for most of the take, other than for the rest: {', '.join(wrong)}. "
        "Their names look exchanged. Rename the markers.",
    )


def _between(markers: Mapping[str, FloatArray], one: str, other: str) -> float:
    """Return the median distance of two markers; 0 where they are never seen together."""
    apart = np.linalg.norm(markers[one] - markers[other], axis=1)
    return float(np.median(known)) if len(known := apart[np.isfinite(apart)]) else 0.0
