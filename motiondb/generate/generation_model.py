"""Motion symbols for generation: finer states over pose vectors and their differences.

Recognition needs few broad states; a smooth trajectory needs at least eight states a second. After
Viterbi alignment, each state of a symbol is divided into ``SPLIT`` parts of equal length within
every segment of the symbol. Mean, variance and duration of each part are estimated over these
segments, on pose vectors (``pose.pose_vectors``) with first and second differences, at 30 frames a
second. The result is again a set of left-to-right HMMs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.generate.trajectory import with_deltas
from motiondb.records import FloatArray, IntArray, MotionSymbols

SPLIT = 3  # Number of parts of a recognition state
VARIANCE_FLOOR = 1e-3  # Least variance of a state, as a share of the overall variance


def generation_symbols(
    segments: Sequence[Sequence[FloatArray]], states: Sequence[Sequence[IntArray]], n_states: int
) -> MotionSymbols:
    """Estimate the finer symbols; `segments` each (frames, D); `states` each (frames,)."""
    n_fine = SPLIT * n_states
    everything = np.concatenate([with_deltas(v) for group in segments for v in group])
    floor = np.maximum(VARIANCE_FLOOR * everything.var(axis=0), 1e-10)
    means = np.empty((len(segments), n_fine, everything.shape[1]))
    covars = np.empty_like(means)
    loops = np.empty((len(segments), n_fine))
    for s, (group, paths) in enumerate(zip(segments, states)):
        values = np.concatenate([with_deltas(v) for v in group])
        fine = np.concatenate([fine_states(path, n_states) for path in paths])
        count = np.bincount(fine, minlength=n_fine).astype(float)
        for k in range(n_fine):
            inside = values[fine == k] if count[k] else values[[_nearest(fine, k)]]
            means[s, k] = inside.mean(axis=0)
            covars[s, k] = np.maximum(inside.var(axis=0), floor)
        duration = np.maximum(count / len(group), 1.0)
        loops[s] = 1.0 - 1.0 / duration
    return MotionSymbols(np.full(len(segments), n_fine), loops, means, covars)


def fine_states(path: IntArray, n_states: int) -> IntArray:
    """Divide every visit of a state into SPLIT equal parts; a skipped state has no frames.

    Shapes: `path` (frames,).

    >>> fine_states(np.array([0, 0, 0, 1, 1, 1, 1]), 2)
    array([0, 1, 2, 3, 3, 4, 5])
    """
    fine = np.empty(len(path), dtype=np.int64)
    for state in range(n_states):
        inside = np.flatnonzero(path == state)
        fine[inside] = SPLIT * state + np.arange(len(inside)) * SPLIT // max(len(inside), 1)
    return fine


def _nearest(fine: IntArray, k: int) -> int:
    return int(np.argmin(np.abs(fine - k)))
