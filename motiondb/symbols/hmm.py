"""Left-to-right Gaussian HMMs, all symbols at once: score, fit, align, sample.

A symbol starts in state 0. It stays in state k with probability a_k and moves to state k + 1 with
probability 1 - a_k; from the last state that move leaves the symbol. There are no other moves. A
frame o_t of state k is Gaussian with diagonal covariance.

Two likelihoods of a segment o_1 ... o_T:

- free end (``exit=False``, for recognition): the symbol has not been left before o_T, and the path
  may end in any state. This is what hmmlearn's ``score`` computes
  (:meth:`motiondb.records.MotionSymbols.to_hmmlearn`).
- ``exit=True``: the path ends in the last state and leaves it after o_T. These are the densities of
  whole passages: they add up over symbols in series. Zero for segments of fewer frames than states.

Frames are one array for all captures, segments are intervals [start, end) in it; they may overlap.
The results do not depend on the number of threads.

Source: Rabiner, A tutorial on hidden Markov models, 1989; left to right as in paper A.
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm_kernels as kernels
from motiondb.symbols.emissions import check_symbols, log_density_blocks, log_symbols
from motiondb.symbols.hmm_fit import SELF_LOOP_BOUNDS, fit, initialise
from motiondb.symbols.hmm_jobs import (
    check_assignment,
    check_segments,
    frame_blocks,
    in_threads,
)
from motiondb.symbols.network import segment_by_symbols
from motiondb.symbols.score_kernels import score_block

__all__ = [
    "SELF_LOOP_BOUNDS",
    "fit",
    "initialise",
    "sample",
    "score",
    "segment_by_symbols",
    "viterbi",
    "viterbi_all",
]


def score(
    symbols: MotionSymbols,
    frames: FloatArray | Float32Array,
    starts: IntArray,
    ends: IntArray,
    *,
    exit: bool = False,
) -> Float32Array:
    """Log-likelihood of every segment under every symbol.

    Shapes: `frames` (frames, dimensions); `starts`, `ends` (segments,); result (segments, symbols).

    `exit`: Whether the path must leave the symbol at the segment's end (see the module).
    """
    check_symbols(symbols)
    frames, starts, ends = check_segments(symbols, frames, starts, ends)
    prepared = log_symbols(symbols)
    scores = np.empty((len(starts), symbols.n_symbols), dtype=np.float32)

    def score_some(block: tuple[int, int, IntArray]) -> None:
        low, high, intervals = block
        for first, densities in log_density_blocks(symbols, frames[low:high]):
            score_block(densities, first, prepared, exit, scores, intervals)

    in_threads(score_some, list(frame_blocks(starts, ends)))
    return scores


def viterbi(
    symbols: MotionSymbols, s: int, frames: FloatArray | Float32Array, *, exit: bool = False
) -> IntArray:
    """Most probable state of every frame of one segment under symbol s: array (frames,).

    Shapes: `frames` (frames, dimensions).

    `exit`: Whether the path must end in the last state. A segment of fewer frames than states
    cannot, and then may end anywhere.
    """
    return viterbi_all(symbols, frames, *_one_segment(s, frames), exit=exit)


def viterbi_all(
    symbols: MotionSymbols,
    frames: FloatArray | Float32Array,
    starts: IntArray,
    ends: IntArray,
    assignment: IntArray,
    *,
    exit: bool = False,
) -> IntArray:
    """Most probable states of segments, each under its symbol.

    Shapes: `frames` (frames, dimensions); `starts`, `ends`, `assignment` (segments,); result (sum
    of the segments' lengths,).
    """
    check_symbols(symbols)
    frames, starts, ends = check_segments(symbols, frames, starts, ends)
    frames = np.ascontiguousarray(frames, dtype=np.float64)
    segments = check_assignment(symbols, starts, ends, assignment)
    prepared = log_symbols(symbols)
    offsets = np.cumsum(ends - starts)
    states = np.empty(int(offsets[-1]) if len(offsets) else 0, dtype=np.int64)
    for start, end, s, place in segments:
        path = kernels.best_path(frames[start:end], prepared, s, exit)
        states[offsets[place] - len(path) : offsets[place]] = path
    return states


def sample(
    symbols: MotionSymbols, s: int, rng: np.random.Generator, *, length: int | None = None
) -> tuple[FloatArray, IntArray]:
    """Sample one passage through symbol s, from the first state out of the last.

    Shapes: result (frames, dimensions).

    `length`: Number of frames; the states are then drawn from their distribution given that the
    symbol is left after so many frames. None: the duration of every state is geometric.
    """
    n_states = int(symbols.n_states[s])
    loops = symbols.self_loops[s, :n_states]
    if length is None:
        if loops.max() >= 1.0:
            raise MotionDBError(
                f"symbol {s}: expected self-loops below 1, found 1. Give the length to sample."
            )
        states = np.repeat(np.arange(n_states), rng.geometric(1.0 - loops))
    else:
        states = _states_of_length(loops, s, length, rng)
    noise = rng.standard_normal((len(states), symbols.means.shape[2]))
    return symbols.means[s, states] + noise * np.sqrt(symbols.covars[s, states]), states


def _states_of_length(loops: FloatArray, s: int, length: int, rng: np.random.Generator) -> IntArray:
    """States of a passage of exactly ``length`` frames, drawn from their posterior."""
    n_states = len(loops)
    if length < n_states:
        raise MotionDBError(
            f"symbol {s}: expected a length of at least {n_states} frames (its states), found "
            f"{length}. Ask for more frames."
        )
    loops = np.clip(loops, 1e-6, 1 - 1e-6)
    log_beta = np.full((length, n_states), kernels.NEVER)
    log_beta[-1, -1] = 0.0
    for t in range(length - 2, -1, -1):
        on = np.append(np.log1p(-loops[:-1]) + log_beta[t + 1, 1:], kernels.NEVER)
        log_beta[t] = np.logaddexp(np.log(loops) + log_beta[t + 1], on)
    states = np.zeros(length, dtype=np.int64)
    uniform = rng.random(length)
    for t in range(1, length):
        k = states[t - 1]
        log_stay = np.log(loops[k]) + log_beta[t, k] - log_beta[t - 1, k]
        states[t] = k + int(k + 1 < n_states and uniform[t] >= np.exp(log_stay))
    return states


def _one_segment(s: int, frames: FloatArray | Float32Array) -> tuple[IntArray, IntArray, IntArray]:
    return np.array([0]), np.array([len(frames)]), np.array([s])
