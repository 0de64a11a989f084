"""The segments that a new motion is made of: their motions as vectors, and HMMs on these.

A symbol's HMM sees whitened features, from which there is no way back to rotations. So the frames
of a symbol's segments are divided among its states by the most probable path, and a second HMM with
the same states is fitted to pose vectors, from which a motion can be made
(:mod:`motiondb.body.pose_vectors`, :mod:`motiondb.generate.generation_model`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from motiondb.body import pose_vectors, rotation
from motiondb.body.features import FEATURE_STEP
from motiondb.errors import QueryError
from motiondb.generate import generation_model, series
from motiondb.learn.learned import Learned
from motiondb.learn.symbol_fitting import FeaturePool
from motiondb.records import FloatArray, IntArray, Motion, MotionSymbols
from motiondb.symbols import hmm

MEMBERS = 60  # Largest number of segments per symbol; the most probable ones are used


@dataclass(frozen=True, eq=False)
class Takes:
    """Motion of all captures, as far as generation needs it."""

    features: FeaturePool
    motion: Callable[[int], Motion]  # Gives the motion of a capture by its number


@dataclass(frozen=True, eq=False)
class SegmentMaterial:
    """Segments of the symbols of one sequence, and HMMs on their pose vectors."""

    numbers: Mapping[int, int]  # Symbol -> its number among the symbols used
    members: tuple[IntArray, ...]  # each (n,): rows of the segment table, per symbol used
    # Capture -> root path (frames, 4) and local rotations (frames, joints, 4)
    paths: Mapping[int, tuple[FloatArray, FloatArray]]
    leg_lengths: Mapping[int, float]  # Capture -> leg length of the performer, metres
    means: FloatArray  # (joints, 4): mean local rotations
    vectors: Mapping[int, FloatArray]  # Capture -> pose vectors: array (frames, values)
    hmms: MotionSymbols  # HMMs on pose vectors, one per symbol used

    def rows(self, symbol: int) -> IntArray:
        """Rows of the segment table for one symbol."""
        return self.members[self.numbers[symbol]]

    def series(self, sequence: IntArray) -> series.Series:
        """HMMs of a symbol sequence, joined one after the other."""
        numbers = np.array([self.numbers[int(s)] for s in sequence])
        return series.join_series(self.hmms, numbers)


def gather_material(learned: Learned, takes: Takes, sequence: IntArray) -> SegmentMaterial:
    """Segments and HMMs for a symbol sequence."""
    used = np.unique(sequence)
    members = tuple(_members(learned, int(s)) for s in used)
    captures = sorted({int(learned.segments.capture_ids[i]) for rows in members for i in rows})
    motions = {c: takes.motion(c) for c in captures}
    paths = {c: pose_vectors.to_path(m) for c, m in motions.items()}
    means = pose_vectors.mean_rotations(np.concatenate([turned for _, turned in paths.values()]))
    vectors = {c: pose_vectors_of(paths[c], means) for c in paths}
    return SegmentMaterial(
        {int(s): n for n, s in enumerate(used)},
        members,
        paths,
        {c: m.leg_length for c, m in motions.items()},
        means,
        vectors,
        _fit_hmms(learned, takes.features, used, members, vectors),
    )


def place_of(learned: Learned, row: int) -> tuple[int, int, int]:
    """Capture, first frame and last frame + 1 of a row of the segment table."""
    table = learned.segments
    return int(table.capture_ids[row]), int(table.starts[row]), int(table.ends[row])


def _fit_hmms(
    learned: Learned,
    pool: FeaturePool,
    used: IntArray,
    members: tuple[IntArray, ...],
    vectors: Mapping[int, FloatArray],
) -> MotionSymbols:
    segments, states = [], []
    for symbol, rows in zip(used, members):
        of_symbol, paths = [], []
        for row in rows:
            capture, start, end = place_of(learned, row)
            whitened = learned.feature_space.project(pool.of_capture(capture))
            features = whitened[start // FEATURE_STEP : -(-end // FEATURE_STEP)]
            path = hmm.viterbi(learned.symbols, int(symbol), features)
            of_symbol.append(vectors[capture][start:end])
            paths.append(np.repeat(path, FEATURE_STEP)[: end - start])
        segments.append(of_symbol)
        states.append(paths)
    return generation_model.generation_symbols(
        segments, states, int(learned.symbols.n_states.max())
    )


def _members(learned: Learned, symbol: int) -> IntArray:
    """Rows of the most probable segments of a symbol."""
    rows = np.flatnonzero(learned.segments.symbols == symbol)
    if len(rows) == 0:
        raise QueryError(
            f"symbol {symbol}: expected segments in the database, found none. Learn again."
        )
    order = np.argsort(-learned.segments.log_likelihoods[rows], kind="stable")
    return np.sort(rows[order[:MEMBERS]])


def pose_vectors_of(path: tuple[FloatArray, FloatArray], means: FloatArray) -> FloatArray:
    """Pose vectors (frames, values) of a root path and local rotations about their means."""
    turning = pose_vectors.TURNING
    relative = rotation.multiply(rotation.conjugate(means)[turning], path[1][:, turning])
    return np.concatenate([path[0], rotation.log(relative).reshape(len(path[0]), -1)], axis=1)
