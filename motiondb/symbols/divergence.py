"""Distances between symbols: a symmetric Kullback-Leibler rate, estimated by Monte Carlo.

With y_in the n-th of N sequences of T frames sampled from symbol i,

    d_n(i, j) = 1 / 2T [ log P_i(y_in) - log P_j(y_in) + log P_j(y_jn) - log P_i(y_jn) ]
    D(i, j)   = max(0, mean_n d_n(i, j)),   variance = var_n d_n(i, j) / N,   D(i, i) = 0.

A symbol that has reached its last state stays there, so that every P is a density over sequences of
T frames; then the expectation of d_n is not negative, and a negative estimate is set to 0. All
symbols share their random numbers: sequence n of every symbol has the same uniforms for its
transitions and the same normals for its frames. That lowers the variance of the differences.
Symbols of one state have D = symmetric divergence of their Gaussians.

Source: Juang and Rabiner, A probabilistic distance measure for hidden Markov models, 1985; paper A
prints it with one sequence.
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm

N_SEQUENCES = 32
"""Sequences a symbol. Chosen by hand; the variance of every distance is stored beside it."""
_LONGEST = 60  # frames, 4 s: a self-loop near 1 would ask for endless sequences. By hand.
_VALUES_AT_ONCE = 2_000_000  # 16 MB of samples: bounds memory, changes no result


def divergence(
    symbols: MotionSymbols,
    rng: np.random.Generator,
    *,
    n_sequences: int = N_SEQUENCES,
    n_frames: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Distances between all pairs of symbols.

    Shapes: result (symbols, symbols).

    `n_frames`: T; None: the mean expected duration of the symbols, at most 60, and at least as many
    frames as the longest symbol has states.
    """
    if n_sequences < 2:
        raise MotionDBError(
            f"divergence: expected at least 2 sequences a symbol, found {n_sequences}. "
            "One sequence has no variance: sample more."
        )
    waiting = _waiting_at_the_end(symbols)
    n_frames = n_frames or typical_duration(symbols)
    n_symbols, _, n_dims = symbols.means.shape
    uniforms = rng.random((n_sequences, n_frames))
    normals = rng.standard_normal((n_sequences, n_frames, n_dims))
    losses = np.empty((n_symbols, n_sequences, n_symbols))
    width = max(1, _VALUES_AT_ONCE // normals.size)
    for first in range(0, n_symbols, width):
        some = np.arange(first, min(first + width, n_symbols))
        frames = sample_together(waiting, some, uniforms, normals).reshape(-1, n_dims)
        starts = np.arange(0, len(frames), n_frames)
        totals = hmm.score(waiting, frames, starts, starts + n_frames).astype(np.float64)
        totals = totals.reshape(len(some), n_sequences, n_symbols)
        true = totals[np.arange(len(some)), :, some]
        losses[some] = (true[:, :, None] - totals) / n_frames
    both = 0.5 * (losses.transpose(1, 0, 2) + losses.transpose(1, 2, 0))
    distances = np.maximum(both.mean(axis=0), 0.0)
    variances = both.var(axis=0, ddof=1) / n_sequences
    np.fill_diagonal(distances, 0.0)
    np.fill_diagonal(variances, 0.0)
    return distances, variances


def typical_duration(symbols: MotionSymbols) -> int:
    """Mean expected duration of the symbols in frames, at most 60 for each of them.

    >>> s = MotionSymbols(np.array([2]), np.array([[0.9, 0.5]]), *[np.ones((1, 2, 1))] * 2)
    >>> typical_duration(s)  # 10 + 2 frames
    12
    """
    real = np.arange(symbols.self_loops.shape[1]) < symbols.n_states[:, None]
    stays = np.where(real, 1.0 / np.maximum(1.0 - symbols.self_loops, 1.0 / _LONGEST), 0.0)
    mean = float(np.mean(np.minimum(stays.sum(axis=1), _LONGEST)))
    return max(round(mean), int(symbols.n_states.max()))


def sample_together(
    symbols: MotionSymbols, chosen: IntArray, uniforms: FloatArray, normals: FloatArray
) -> FloatArray:
    """Sequences of several symbols from the same random numbers.

    Shapes: `chosen` (chosen,); `uniforms` (sequences, frames); `normals` (sequences, frames,
    dimensions); result (chosen, sequences, frames, dimensions).
    """
    rows = chosen[:, None]
    state = np.zeros((len(chosen), len(uniforms)), dtype=np.int64)
    frames = np.empty((len(chosen), *normals.shape))
    for t in range(normals.shape[1]):
        frames[:, :, t] = symbols.means[rows, state]
        frames[:, :, t] += np.sqrt(symbols.covars[rows, state]) * normals[:, t]
        moves = uniforms[:, t] >= symbols.self_loops[rows, state]
        state = np.minimum(state + moves, symbols.n_states[rows] - 1)
    return frames


def _waiting_at_the_end(symbols: MotionSymbols) -> MotionSymbols:
    loops = symbols.self_loops.copy()
    loops[np.arange(symbols.n_symbols), symbols.n_states - 1] = 1.0
    return MotionSymbols(symbols.n_states, loops, symbols.means, symbols.covars)
