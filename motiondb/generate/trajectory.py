"""The most probable smooth trajectory of motion symbols in series.

Fine symbols: recognition needs few broad states; a smooth trajectory needs at least eight states a
second. After Viterbi alignment, each state of a symbol is divided into ``SPLIT`` parts of equal
length within every segment of the symbol. Mean, variance and duration of each part are estimated
over these segments, on pose vectors with first and second differences, at 30 frames a second. The
result is again a set of left-to-right HMMs.

Series: a state with self-loop a is left with probability 1 - a, in the last state of symbol k for
the first state of symbol k + 1, so that every row of the transition matrix sums to 1. (Paper A sets
this exit to 1, which gives rows of a larger sum.)

Trajectory: c (frames, D) the static values sought; W stacks them with their time differences

    delta c_t = (c_{t+1} - c_{t-1}) / 2,    delta^2 c_t = c_{t+1} - 2 c_t + c_{t-1}

(ends repeated); mu and U the means and variances of all three along the state sequence. The most
probable c solves W' U^-1 W c = W' U^-1 mu, a banded system for each dimension. Its variance is too
small; ``widen`` raises the variance of each dimension towards that of the states.

Source: Tokuda et al., Speech parameter generation algorithms for HMM-based speech synthesis (2000);
Toda and Tokuda (2007) for the global variance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray, MotionSymbols

SPLIT = 3  # Number of parts of a recognition state
VARIANCE_FLOOR = 1e-3  # Least variance of a state, as a share of the overall variance


@dataclass(frozen=True, eq=False)
class Series:
    """The states of joined HMMs in their order, N in all."""

    self_loops: FloatArray  # (N,): probability to stay in a state
    means: FloatArray  # (N, dimensions)
    covars: FloatArray  # (N, dimensions): variances
    positions: IntArray  # (N,): position in the sequence of the symbol that each state belongs to


def join_series(symbols: MotionSymbols, sequence: IntArray) -> Series:
    """Put the HMMs of a symbol sequence in series; `sequence` (length,)."""
    counts = symbols.n_states[sequence]
    picks = [(s, k) for s, n in zip(sequence, counts) for k in range(n)]
    rows, states = np.array(picks).T
    return Series(
        symbols.self_loops[rows, states],
        symbols.means[rows, states],
        symbols.covars[rows, states],
        np.repeat(np.arange(len(sequence)), counts),
    )


def expected_durations(series: Series) -> IntArray:
    """Number of frames of each state: array (N,), the rounded mean 1 / (1 - self-loop), at least 1.

    Rounding errors are carried over to the next state, so the total is correct to one frame.
    """
    mean = 1.0 / np.maximum(1.0 - series.self_loops, 1e-3)
    ends = np.round(np.cumsum(mean)).astype(np.int64)
    return np.maximum(np.diff(ends, prepend=0), 1)


def fine_symbols(
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
    """Divide every visit of a state in a path (frames,) into SPLIT equal parts.

    A skipped state has no frames.

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


def with_deltas(values: FloatArray) -> FloatArray:
    """Append first and second differences: array (frames, 3 D), from `values` (frames, D)."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    delta = (padded[2:] - padded[:-2]) / 2.0
    delta2 = padded[2:] - 2.0 * padded[1:-1] + padded[:-2]
    return np.concatenate([values, delta, delta2], axis=1)


def most_probable(means: FloatArray, covars: FloatArray) -> FloatArray:
    """Most probable trajectory c: array (frames, D), from `means`, `covars` (frames, 3 D)."""
    from scipy.linalg import solveh_banded

    n_frames, n_dims = len(means), means.shape[1] // 3
    result = np.empty((n_frames, n_dims))
    for d in range(n_dims):
        columns = [d, d + n_dims, d + 2 * n_dims]
        band, right = _normal_equations(means[:, columns], 1.0 / covars[:, columns])
        result[:, d] = solveh_banded(band, right, lower=True)
    return result


def _normal_equations(mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower band (3, frames) of W' P W and the vector W' P mu for one dimension."""
    n = len(mean)
    band = np.zeros((3, n))
    right = np.zeros(n)
    windows = (((0, 1.0),), ((-1, -0.5), (1, 0.5)), ((-1, 1.0), (0, -2.0), (1, 1.0)))
    time = np.arange(n)
    for w, window in enumerate(windows):
        weighted = precision[:, w]
        for step, factor in window:
            column = np.clip(time + step, 0, n - 1)
            np.add.at(right, column, factor * weighted * mean[:, w])
            for other_step, other in window:
                row = np.clip(time + other_step, 0, n - 1)
                lag = row - column
                keep = lag >= 0
                np.add.at(band, (lag[keep], column[keep]), (factor * other * weighted)[keep])
    return band, right


def widen(
    trajectory: FloatArray, means: FloatArray, covars: FloatArray, strength: float = 0.8
) -> FloatArray:
    """Scale every dimension about its mean, by 1 to 1.6, towards the variance of the states.

    All arrays (frames, D).
    """
    centre = trajectory.mean(axis=0)
    wanted = means.var(axis=0) + covars.mean(axis=0)
    variance = np.maximum(trajectory.var(axis=0), 1e-12)
    factor = np.clip(np.sqrt(wanted / variance), 1.0, 1.6)
    return centre + (trajectory - centre) * (1.0 + strength * (factor - 1.0))
