"""A player's clips spliced into one motion, and shown in edited time on an edited path.

Every clip is taken from its capture with more frames at both ends, mirrored, bent and stretched
like its entry. Neighbours are cross-faded by :mod:`motiondb.generate.stitching`: their paths as
steps and turns, their poses as rotations relative to the heading. A player who waits does not
freeze: a clip in place is played forwards and backwards. The result has the frames of the string in
order, and the clip and frame that each comes from. To show it, time is read at the frames of the
scene (poses interpolated along the shortest arc), the edited path replaces the own one, and feet
are held where they stand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, pose_vectors, retarget, rotation
from motiondb.body.features import runs
from motiondb.errors import SceneError
from motiondb.generate.contact import FEET, find_contacts, lock_feet
from motiondb.generate.stitching import BLEND_FRAMES, Piece, stitch
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.clips.clip_motion import clip_motion
from motiondb.scene.clips.clips import ClipSource
from motiondb.scene.clips.ground import compose, inverse, relative
from motiondb.scene.polish.seam_steps import step_at_seams
from motiondb.scene.polish.stepping import step_feet
from motiondb.scene.timing.playing import Part

_MARGIN = 20
"""Frames of the capture around a clip that are used: for the blend, and for velocities at its
ends."""
_HALF = BLEND_FRAMES // 2  # Frames of a blend on each side of a seam


@dataclass(frozen=True, eq=False)
class Spliced:
    """A player's string as one sequence of frames, at the pace of the captures."""

    lead: int  # Frames of waiting before the string's first
    places: FloatArray  # (frames, 3), m and rad: the path as spliced, from the first clip's place
    heights: FloatArray  # (frames,), m: height of the pelvis
    # (frames, 21, 4): local rotations; that of the pelvis is relative to the heading
    rotations: FloatArray
    parts: tuple[Part, ...]
    part: IntArray  # (frames,), int: index of the part with the largest weight
    source_frames: IntArray  # (frames,), int: its frame of the capture
    shares: FloatArray  # (frames,): its weight; 1 away from seams
    # (frames, 2), bool: whether the left and the right foot stand in the capture
    contacts: NDArray[np.bool_]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.heights)

    @property
    def waits(self) -> NDArray[np.bool_]:
        """Whether the player stands and waits: array (frames,)."""
        return np.array([part.waits for part in self.parts])[self.part]

    def rows(self, source: FloatArray) -> FloatArray:
        """Return rows of the arrays, possibly between two, at frames of the string, ends held."""
        return np.clip(source + self.lead, 0.0, self.n_frames - 1.0)

    def shown_frames(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the capture's frames at rows ``at``, and how many of them pass in a row.

        Between two rows of one part, the frame is interpolated. Where another part begins it is
        that of the nearer row, because there is no frame between those of two captures.
        """
        before, nearest = np.floor(at).astype(np.int64), np.rint(at).astype(np.int64)
        after = np.minimum(before + 1, self.n_frames - 1)
        same = (self.part[before] == self.part[after]) & (after > before)
        rate = np.where(same, self.source_frames[after] - self.source_frames[before], 0)
        return self.source_frames[nearest] + (at - nearest) * rate, np.where(same, rate, 1.0)


@dataclass(frozen=True, eq=False)
class Taken:
    """A source with its margins: path values, rotations, frames, contacts."""

    path: FloatArray
    rotations: FloatArray
    frames: IntArray
    contacts: NDArray[np.bool_]


Shelf = dict[tuple[ClipSource, bool], Taken]
"""Sources that were taken already, to be played, or to wait in (True)."""


def splice(
    parts: Sequence[Part],
    motions: Mapping[str, Motion],
    origin: FloatArray,
    shelf: Shelf | None = None,
) -> Spliced:
    """Return parts one after another, the string's first one beginning at ``origin``.

    Shapes: `origin` (3,), m and rad.

    `parts`: Of the string, with those before it, whose ``clip`` is -1, and after it.
    """
    shelf = {} if shelf is None else shelf
    played, pieces = {}, []
    shown: dict[int, IntArray] = {}
    stands: dict[int, NDArray[np.bool_]] = {}
    for number, part in enumerate(parts):
        key = part.source, part.waits
        if key not in shelf:
            shelf[key] = _taken(part.source, motions, part.waits)
        taken, start = shelf[key], 0 if part.waits else _HALF
        taken = _waiting(taken, part.n_frames) if part.waits else taken
        played[number] = taken.path, taken.rotations
        shown[number], stands[number] = taken.frames, taken.contacts
        pieces.append(Piece(number, start, start + part.n_frames))
    whole = stitch(pieces, played)
    begin = sum(part.n_frames for part in parts if part.clip < 0)
    frames = np.zeros(len(whole.path), dtype=np.int64)
    contacts = np.zeros((len(frames), 2), dtype=bool)
    for number, which in shown.items():
        here = whole.captures == number
        frames[here] = which[whole.frames[here]]
        contacts[here] = stands[number][whole.frames[here]]
    return Spliced(
        begin,
        _ways(whole.path, origin, begin),
        whole.path[:, 0],
        whole.rotations,
        tuple(parts),
        whole.captures,
        frames,
        whole.shares,
        contacts,
    )


def _taken(source: ClipSource, motions: Mapping[str, Motion], waits: bool) -> Taken:
    """Return a source's frames; with those that blend with its neighbours unless it is waiting."""
    inside, around = _cut(source, motions)
    if waits:
        path, turned = pose_vectors.to_path(clip_motion(inside, around))
        frames = source.start + np.arange(len(path))
        return Taken(path, turned, frames, np.zeros((len(path), 2), dtype=bool))
    moved = clip_motion(inside, around, before=_HALF, after=_HALF + 1)
    stands = _contacts(inside, around[source.capture], moved.n_frames)
    frames = source.start - _HALF + np.arange(moved.n_frames)
    return Taken(*pose_vectors.to_path(moved), frames, stands)


def _contacts(source: ClipSource, motion: Motion, n_frames: int) -> NDArray[np.bool_]:
    """Return the feet that stand in the capture at a clip and its margin: array (frames, 2)."""
    contacts = find_contacts(retarget.motion_positions(motion, FEET)[0])
    contacts = contacts[:, ::-1] if source.mirrored else contacts
    return contacts[np.clip(source.start - _HALF + np.arange(n_frames), 0, len(contacts) - 1)]


def _waiting(taken: Taken, n_frames: int) -> Taken:
    """Return a source played forwards and backwards for ``n_frames``."""
    length = len(taken.path)
    there = np.arange(n_frames) % max(2 * length - 2, 1)
    which = np.where(there < length, there, 2 * length - 2 - there)
    places = _ways(taken.path, np.zeros(3), 0)[which]
    values = np.zeros((n_frames, 4))
    values[:, 0] = taken.path[which, 0]
    values[:-1, 1:] = relative(places[1:], places[:-1]) * MOTION_FPS
    return Taken(values, taken.rotations[which], taken.frames[which], taken.contacts[which])


def _ways(path: FloatArray, origin: FloatArray, begin: int) -> FloatArray:
    """Return the path of path values (frames, 4) that is at ``origin`` at frame ``begin``."""
    turns = np.concatenate([[0.0], np.cumsum(path[:-1, 3])]) / MOTION_FPS
    c, s = np.cos(turns), np.sin(turns)
    x, z = path[:, 1], path[:, 2]
    steps = np.stack([x * c + z * s, z * c - x * s], axis=1)[:-1] / MOTION_FPS
    way = np.column_stack([np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), turns])
    return compose(compose(np.asarray(origin, dtype=float), inverse(way[begin])), way)


def _cut(source: ClipSource, motions: Mapping[str, Motion]) -> tuple[ClipSource, dict[str, Motion]]:
    """Return a clip's source relative to a part of its capture around it, and that part."""
    if source.capture not in motions:
        raise SceneError(
            f"{source.capture}: expected the capture that a clip was taken from, found none of"
            " this name. Add it again, or make the scene again."
        )
    motion = motions[source.capture]
    first, last = max(source.start - _MARGIN, 0), min(source.end + _MARGIN, motion.n_frames)
    part = Motion(
        motion.local_rotations[first:last], motion.root_positions[first:last], motion.leg_length
    )
    inside = replace(source, start=source.start - first, end=source.end - first)
    return inside, {source.capture: part}


def show(spliced: Spliced, at: FloatArray, places: FloatArray) -> Motion:
    """Return the motion that shows rows ``at`` (frames,) on a path (frames, 3), with feet held.

    A player who waits stands, and takes small steps where the path turns or shifts. At seams, feet
    that would slide take a step.
    """
    before = np.floor(at).astype(np.int64)
    after = np.minimum(before + 1, spliced.n_frames - 1)
    share = at - before
    heights = (1.0 - share) * spliced.heights[before] + share * spliced.heights[after]
    local = rotation.slerp(
        spliced.rotations[before],
        spliced.rotations[after],
        np.repeat(share[:, None], len(body.JOINTS), axis=1),
    )
    local[:, 0] = rotation.multiply(pose_vectors.yaw(places[:, 2]), local[:, 0])
    root = np.column_stack([places[:, 0], heights, places[:, 1]])
    shown = Motion(
        rotation.unroll(local).astype(np.float32), root.astype(np.float32), body.LEG_LENGTH
    )
    waits = standing(spliced, at)
    nearest = np.rint(at).astype(np.int64)
    held = lock_feet(shown, waits, spliced.contacts[nearest])
    return step_at_seams(step_feet(held, waits), spliced.shares[nearest] < 1.0)


def standing(spliced: Spliced, at: FloatArray) -> NDArray[np.bool_]:
    """Return at which of the rows ``at`` the player waits and has come to rest: array (frames,)."""
    waits = spliced.waits[np.rint(at).astype(np.int64)]
    for start, end in runs(waits):
        if start > 0:
            waits[start : min(start + _HALF, end)] = False
    return waits
