"""A player's clips spliced into one motion, shown in edited time on an edited way.

Every clip is taken from its capture with some frames more at both ends, mirrored, bent and
stretched as its entry says; neighbours are cross-faded by :mod:`motiondb.generate.stitching`, their
ways as steps and turns, their poses as rotations relative to the heading. What comes out has the
frames of the string, one after the other, and knows of each which frame of which clip it is. Then
time is read at the frames of the scene (poses interpolated along the shortest arc), the edited way
is put under the poses, and feet are held where they stand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.errors import SceneError
from motiondb.generate.contact import lock_feet
from motiondb.generate.stitching import BLEND_FRAMES, Piece, stitch
from motiondb.pose import body, pose_vectors, rotation
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.scene.clip_motion import clip_motion
from motiondb.scene.clips import ClipSource

_MARGIN = 20
"""Frames of the capture round a clip that are looked at: its blend, and how velocities begin."""
_HALF = BLEND_FRAMES // 2


@dataclass(frozen=True, eq=False)
class Spliced:
    """A player's string as one stretch of frames, at the pace of the captures.

    Attributes
    ----------
    places : array (frames, 3), the way as spliced, from the first clip's place.
    heights : array (frames,), of the pelvis, metres.
    rotations : array (frames, 21, 4), local, the pelvis's relative to the heading.
    clips : array (frames,), the clip that weighs most; source_frames : its frame of the capture.
    shares : array (frames,), its weight, 1 away from seams.
    """

    places: FloatArray
    heights: FloatArray
    rotations: FloatArray
    clips: IntArray
    source_frames: IntArray
    shares: FloatArray

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.heights)


def splice(
    sources: Sequence[ClipSource], motions: Mapping[str, Motion], origin: FloatArray
) -> Spliced:
    """The clips ``sources`` one after another, the first beginning at ``origin`` (x, z, theta).

    Raises
    ------
    SceneError : a capture is not among the motions.
    """
    played, pieces = {}, []
    for number, source in enumerate(sources):
        moved = clip_motion(*_cut(source, motions), before=_HALF, after=_HALF + 1)
        played[number] = pose_vectors.to_path(moved)
        pieces.append(Piece(number, _HALF, _HALF + source.end - source.start))
    whole = stitch(pieces, played)
    path = whole.path
    motion = pose_vectors.from_path(
        path, whole.rotations, (float(origin[0]), float(origin[1])), float(origin[2])
    )
    turns = origin[2] + np.concatenate([[0.0], np.cumsum(path[:-1, 3])]) / 30.0
    turns[0] = origin[2]
    starts = np.array([source.start for source in sources])
    return Spliced(
        np.column_stack([motion.root_positions[:, 0], motion.root_positions[:, 2], turns]),
        path[:, 0],
        whole.rotations,
        whole.captures,
        starts[whole.captures] + whole.frames - _HALF,
        whole.shares,
    )


def _cut(source: ClipSource, motions: Mapping[str, Motion]) -> tuple[ClipSource, dict[str, Motion]]:
    """A clip's source in the part of its capture round it, and that part."""
    if source.capture not in motions:
        raise SceneError(
            f"{source.capture}: expected the capture that a clip was taken from, found none of"
            " this name. Add it again, or make the scene anew."
        )
    motion = motions[source.capture]
    first, last = max(source.start - _MARGIN, 0), min(source.end + _MARGIN, motion.n_frames)
    part = Motion(
        motion.local_rotations[first:last], motion.root_positions[first:last], motion.leg_length
    )
    inside = replace(source, start=source.start - first, end=source.end - first)
    return inside, {source.capture: part}


def show(spliced: Spliced, at: FloatArray, places: FloatArray) -> Motion:
    """The motion that shows source frames ``at`` (frames,) on a way (frames, 3), feet held."""
    at = np.clip(at, 0.0, spliced.n_frames - 1.0)
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
    return lock_feet(shown)
