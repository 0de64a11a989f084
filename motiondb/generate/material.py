"""The captures that a new motion is made of, and the new motion with the origin of its frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body import pose_vectors, rotation
from motiondb.learn.recognition import FramePool
from motiondb.records import FloatArray, IntArray, Motion


@dataclass(frozen=True, eq=False)
class Takes:
    """Motion of all captures, as far as generation needs it."""

    frames: FramePool
    motion: Callable[[int], Motion]  # Gives the motion of a capture by its number
    # Gives the first frames and last frames + 1 of the times for which a capture holds a posture
    held: Callable[[int, str], Sequence[tuple[int, int]]]


@dataclass(frozen=True, eq=False)
class Material:
    """Some captures by number, as paths with rotations and as pose vectors about common means."""

    motions: Mapping[int, Motion]
    # Capture -> root path (frames, 4) and local rotations (frames, joints, 4)
    paths: Mapping[int, tuple[FloatArray, FloatArray]]
    means: FloatArray  # (joints, 4): mean local rotations
    vectors: Mapping[int, FloatArray]  # Capture -> pose vectors: array (frames, values)


@dataclass(frozen=True, eq=False)
class SequenceMotion:
    """A motion along a sequence of symbols or actions, with the origin of its frames."""

    motion: Motion  # On the canonical body
    # (frames,): capture that each frame comes from; -1 where it comes from the HMMs
    captures: IntArray
    frames: FloatArray  # (frames,): frame of that capture, 30 a second; 0 from the HMMs
    edits: tuple[str, ...]  # Per frame what was done to it
    lengths: tuple[int, ...]  # Frames of every symbol, or of every action


def gather(takes: Takes, captures: Iterable[int]) -> Material:
    """The motions of some captures as paths and pose vectors."""
    motions = {c: takes.motion(c) for c in sorted(captures)}
    paths = {c: pose_vectors.to_path(m) for c, m in motions.items()}
    means = pose_vectors.mean_rotations(np.concatenate([turned for _, turned in paths.values()]))
    return Material(motions, paths, means, {c: pose_vectors_of(paths[c], means) for c in paths})


def pose_vectors_of(path: tuple[FloatArray, FloatArray], means: FloatArray) -> FloatArray:
    """Pose vectors (frames, values) of a root path and local rotations about their means."""
    turning = pose_vectors.TURNING
    relative = rotation.multiply(rotation.conjugate(means)[turning], path[1][:, turning])
    return np.concatenate([path[0], rotation.log(relative).reshape(len(path[0]), -1)], axis=1)
