"""Motion symbols in series: one left-to-right HMM for a whole sequence.

Notation: symbol k has n_k states with self-loops a; its last state is left with probability 1 - a.
In the series this exit leads to the first state of symbol k + 1 with the same probability, so that
every row of the transition matrix sums to 1. (Paper A sets it to 1, which gives rows of a larger
sum.) In the matrix the last state of the series has a self-loop of 1; when sequences are sampled,
they end with its exit probability.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray, MotionSymbols


@dataclass(frozen=True, eq=False)
class Series:
    """A joined HMM: N states in order."""

    startprob: FloatArray  # (N,): initial probabilities
    transmat: FloatArray  # (N, N): transition probabilities; rows sum to 1
    self_loops: FloatArray  # (N,): probability to stay in a state, also for the last one
    means: FloatArray  # (N, dimensions): means
    covars: FloatArray  # (N, dimensions): variances
    positions: IntArray  # (N,): position in the sequence of the symbol that each state belongs to


def join_series(symbols: MotionSymbols, sequence: IntArray) -> Series:
    """Put the HMMs of a symbol sequence in series; `sequence` (length,)."""
    counts = symbols.n_states[sequence]
    picks = [(s, k) for s, n in zip(sequence, counts) for k in range(n)]
    rows, states = np.array(picks).T
    self_loops = symbols.self_loops[rows, states]
    n = len(rows)
    transmat = np.diag(self_loops)
    transmat[np.arange(n - 1), np.arange(1, n)] = 1.0 - self_loops[:-1]
    transmat[-1, -1] = 1.0
    startprob = np.zeros(n)
    startprob[0] = 1.0
    return Series(
        startprob,
        transmat,
        self_loops,
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


def sample_states(series: Series, rng: np.random.Generator) -> IntArray:
    """Sample a path through the states, from the first out of the last: array (frames,)."""
    durations = rng.geometric(np.maximum(1.0 - series.self_loops, 1e-3))
    return np.repeat(np.arange(len(durations)), durations)


def sample_outputs(series: Series, states: IntArray, rng: np.random.Generator) -> FloatArray:
    """Sample outputs (frames, dimensions), every frame independently, as in paper A.

    Shapes: `states` (frames,).
    """
    noise = rng.normal(size=(len(states), series.means.shape[1]))
    return series.means[states] + np.sqrt(series.covars[states]) * noise
