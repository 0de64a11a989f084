"""The poses of a library entry: frames of its capture, mirrored, bent and stretched.

Only polishing needs poses; sampling uses places alone.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motiondb.body import pose_vectors, retarget, rotation
from motiondb.errors import SceneError
from motiondb.records import IntArray, Motion
from motiondb.scene.clips.clip_variants import edited_stretch
from motiondb.scene.clips.clips import ClipSource
from motiondb.scene.clips.ground import compose, inverse


def source_frames(source: ClipSource, n_frames: int, before: int = 0, after: int = 0) -> IntArray:
    """Return the frames of an entry's capture, with more frames at both ends for blending.

    Before the beginning and after the end of the capture its first and last frames are repeated.

    Shapes: result (before + frames + after,), int.
    """
    frames = np.arange(source.start - before, source.end + after)
    return np.asarray(np.clip(frames, 0, n_frames - 1))


def clip_motion(
    source: ClipSource,
    motions: Mapping[str, Motion],
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
    before: int = 0,
    after: int = 0,
) -> Motion:
    """Return the motion of an entry, placed on the ground.

    `before`: Frames of the capture added before the entry, for blending. They are stretched like
    the entry, and bend no further.
    """
    motion = _motion_of(source, motions)
    frames = source_frames(source, motion.n_frames, before, after)
    local, heading = pose_vectors.heading_rotations(motion)
    root = motion.root_positions[frames].astype(np.float64)
    path = np.column_stack([root[:, 0], root[:, 2], heading[frames]])
    length = source.end - source.start
    shares = np.clip((np.arange(len(frames)) - before) / length, 0.0, 1.0)
    path = edited_stretch(path, shares, source.bend, source.stretch)
    placed = compose(compose(np.asarray(at), inverse(path[before])), path)
    turned = local[frames]
    turned[:, 0] = rotation.multiply(pose_vectors.yaw(placed[:, 2]), turned[:, 0])
    positions = np.column_stack([placed[:, 0], root[:, 1], placed[:, 1]])
    return Motion(
        rotation.unroll(turned).astype(np.float32),
        positions.astype(np.float32),
        motion.leg_length,
        motion.notes,
    )


def _motion_of(source: ClipSource, motions: Mapping[str, Motion]) -> Motion:
    if source.capture not in motions:
        raise SceneError(
            f"{source.capture}: expected the capture that a clip was taken from, found none of"
            " this name. Add it again, or make the scene again."
        )
    motion = motions[source.capture]
    return retarget.mirror(motion) if source.mirrored else motion
