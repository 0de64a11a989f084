"""Motion along a sequence of symbols, from the HMMs on pose vectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.body import pose_vectors
from motiondb.generate import contact, series, trajectory
from motiondb.generate.segment_material import SegmentMaterial
from motiondb.records import FloatArray, IntArray, Motion


@dataclass(frozen=True, eq=False)
class SymbolPlan:
    """Symbols that are to be shown, one after the other."""

    symbols: IntArray  # (symbols,): the symbols in their order
    positions: tuple[int, ...]  # Per symbol the number of its action
    actions: tuple[tuple[str, ...], ...]  # Words of every action


@dataclass(frozen=True, eq=False)
class SequenceMotion:
    """A motion along a sequence of symbols, with the origin of its frames."""

    motion: Motion  # On the canonical body
    # (frames,): capture that each frame comes from; -1 where drawn from the HMMs
    captures: IntArray
    frames: FloatArray  # (frames,): frame of that capture, 30 a second; 0 where drawn
    edits: tuple[str, ...]  # Per frame what was done to it
    lengths: tuple[int, ...]  # Frames of every symbol, or of every action


def _trajectory(material: SegmentMaterial, sequence: IntArray) -> tuple[FloatArray, IntArray]:
    """The most probable trajectory (frames, D) and per frame its position in the sequence."""
    joined = material.series(sequence)
    states = np.repeat(np.arange(len(joined.self_loops)), series.expected_durations(joined))
    means, covars = joined.means[states], joined.covars[states]
    values = trajectory.most_probable(means, covars)
    n_dims = values.shape[1]
    values = trajectory.widen(values, means[:, :n_dims], covars[:, :n_dims])
    return values, joined.positions[states]


def model_motion(material: SegmentMaterial, sequence: IntArray) -> SequenceMotion:
    """Motion along the most probable trajectory; `sequence` (symbols,)."""
    values, owner = _trajectory(material, sequence)
    leg_length = float(np.median(list(material.leg_lengths.values())))
    motion = pose_vectors.from_vectors(values, material.means, leg_length=leg_length)
    motion = contact.lock_feet(motion)
    return SequenceMotion(
        motion,
        np.full(motion.n_frames, -1),
        np.zeros(motion.n_frames),
        ("trajectory",) * motion.n_frames,
        tuple(np.bincount(owner, minlength=len(sequence)).tolist()),
    )
