"""Reader of C3D: marker positions, read by ezc3d (the extra ``c3d``), as a clip of joints.

What is kept: the frame rate, the positions of the joints that
:mod:`motiondb.files.readers.markers` computes, the bone lengths (medians). What is lost: the
markers themselves, analog channels, forces, and the rotation of bones about their own axis. Gaps of
up to half a second are filled along a straight line; a file with longer ones is refused, naming the
markers. The up axis is the one along which the body stands.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from motiondb.body import body
from motiondb.body.retarget import solve_rotations
from motiondb.errors import CaptureError
from motiondb.files.limits import MAX_FPS, MIN_FPS, ReadOptions, check_clip_size
from motiondb.files.readers.c3d_points import read_points
from motiondb.files.readers.markers import ALIASES, REQUIRED, USED, joint_centres, missing_markers
from motiondb.files.text import quoted
from motiondb.files.units import UNITS
from motiondb.records import Clip, FloatArray, Skeleton

LONGEST_GAP = 0.5
"""Longest gap of a marker that is filled, seconds. Over half a second a limb can swing out and
back, which a straight line would hide."""
_UNIT_NAMES = MappingProxyType(
    {"millimeters": "mm", "meters": "m", "centimeters": "cm", "inches": "inch", "in": "inch"}
)


def read_c3d(data: bytes, path: object, options: ReadOptions | None = None) -> Clip:
    """Read the clip in the bytes of a C3D file.

    `options`: How to read it. ``skip_bad_frames`` leaves out frames in which a needed marker is
    lost for longer than a gap that is filled.
    """
    options = options or ReadOptions()
    recording = read_points(data, path, options.limits)
    tracks = _named(recording.labels, recording.points, path)
    rate = recording.fps if options.fps is None else options.fps
    if options.fps is None and not MIN_FPS <= rate <= MAX_FPS:
        raise CaptureError(
            path,
            f"expected a frame rate from {MIN_FPS:g} to {MAX_FPS:g}, found {rate:g}. "
            "Give the right frame rate with --fps.",
        )
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
    """Return the tracks (frames, 3) of the used markers by name, without their subject's prefix.

    Where labels name several subjects, the subject with most of the used markers is taken.
    """
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
    """Return tracks without gaps, and notes.

    Markers that are not needed are dropped where they are lost for long.
    """
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
    """Fill the gaps of a track along straight lines.

    Shapes: `track`, result (frames, 3).

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
    return Skeleton(
        names=standard.names,
        parents=standard.parents,
        offsets=body.OFFSETS * ratio[:, None],
        end_sites=standard.end_sites,
        channels=standard.channels,
    )
