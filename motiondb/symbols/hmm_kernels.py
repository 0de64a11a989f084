"""The recursions of left-to-right HMMs, compiled.

Notation: o_t frame t of T, k a state of K, a_k its self-loop, b_k(o_t) its Gaussian density.

    forward     alpha_t(k) = b_k(o_t) [alpha_t-1(k) a_k + alpha_t-1(k - 1) (1 - a_k-1)]
    backward    beta_t(k)  = a_k b_k(o_t+1) beta_t+1(k) + (1 - a_k) b_k+1(o_t+1) beta_t+1(k + 1)
    posterior   gamma_t(k) = alpha_t(k) beta_t(k) / P(o)

A state has two successors, so that a frame costs O(K), not O(K^2). All recursions are in the log
domain, where ``NEVER`` is the logarithm of zero: scaled probabilities underflow under a wrong
symbol, and a state of negligible probability now may be the only one that explains later frames.
Where the path must leave the last state, beta_T(K) = 1 - a_K and beta_T is 0 elsewhere; otherwise
beta_T = 1.

All kernels release the interpreter's lock; ``motiondb.symbols.hmm`` runs them in threads.

Source: Rabiner, A tutorial on hidden Markov models, 1989, sections III and IV; token passing after
Young, Russell and Thornton, 1989.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.records import FloatArray, IntArray

NEVER = -1e300  # The logarithm of probability zero; finite, so that no difference is NaN
_NEGLIGIBLE = 1e-14  # posteriors below this change no expected count in double precision
_NO_CHANGE = 37.0  # exp(-37) is below half a unit in the last place of 1


class LogSymbols(NamedTuple):
    """Symbols as the kernels use them; axes as in ``MotionSymbols``."""

    n_states: IntArray  # (symbols,): number of states
    log_stay: FloatArray  # (symbols, states): log a_k
    log_leave: FloatArray  # (symbols, states): log (1 - a_k)
    means: FloatArray  # (symbols, states, dimensions): means
    precisions: FloatArray  # (symbols, states, dimensions): 1 / variance
    constants: FloatArray  # (symbols, states): log density of a state at its mean


class Statistics(NamedTuple):
    """Expected counts, and sums over the segments of each symbol."""

    occupancy: FloatArray  # (symbols, states): expected frames in each state
    stays: FloatArray  # (symbols, states): expected self-transitions
    leaves: FloatArray  # (symbols, states): expected moves to the next state, or out of the symbol
    # (symbols, states, dimensions): weighted sum of o - m, with m the mean before the step
    deviations: FloatArray
    squares: FloatArray  # (symbols, states, dimensions): weighted sum of (o - m)^2


@njit(cache=True, nogil=True)
def log_add(a: float, b: float) -> float:
    """Return log(exp(a) + exp(b)) for finite a and b."""
    if a < b:
        a, b = b, a
    if a - b > _NO_CHANGE:
        return a
    return a + np.log1p(np.exp(b - a))


@njit(cache=True, nogil=True, fastmath=True)
def state_log_densities(frames: FloatArray, symbols: LogSymbols, s: int) -> FloatArray:
    """log b_k(o_t) of symbol s: array (frames, states of s)."""
    n_states = symbols.n_states[s]
    densities = np.empty((len(frames), n_states))
    for t in range(len(frames)):
        for k in range(n_states):
            total = 0.0
            for d in range(frames.shape[1]):
                deviation = frames[t, d] - symbols.means[s, k, d]
                total += deviation * deviation * symbols.precisions[s, k, d]
            densities[t, k] = symbols.constants[s, k] - 0.5 * total
    return densities


@njit(cache=True, nogil=True)
def forward(densities: FloatArray, stay: FloatArray, leave: FloatArray) -> FloatArray:
    """log alpha: array (frames, states)."""
    n_frames, n_states = densities.shape
    alpha = np.full((n_frames, n_states), NEVER)
    alpha[0, 0] = densities[0, 0]
    for t in range(1, n_frames):
        alpha[t, 0] = alpha[t - 1, 0] + stay[0] + densities[t, 0]
        for k in range(1, min(t + 1, n_states)):
            on = alpha[t - 1, k - 1] + leave[k - 1]
            alpha[t, k] = log_add(alpha[t - 1, k] + stay[k], on) + densities[t, k]
    return alpha


@njit(cache=True, nogil=True)
def final_weights(n_states: int, log_exit: float, must_exit: bool) -> FloatArray:
    """log beta of the last frame: array (states,)."""
    weights = np.zeros(n_states)
    if must_exit:
        weights[:] = NEVER
        weights[n_states - 1] = log_exit
    return weights


@njit(cache=True, nogil=True)
def backward(
    densities: FloatArray, stay: FloatArray, leave: FloatArray, final: FloatArray
) -> FloatArray:
    """log beta: array (frames, states)."""
    n_frames, n_states = densities.shape
    beta = np.empty((n_frames, n_states))
    beta[n_frames - 1] = final
    for t in range(n_frames - 2, -1, -1):
        last = n_states - 1
        beta[t, last] = stay[last] + densities[t + 1, last] + beta[t + 1, last]
        for k in range(last):
            on = leave[k] + densities[t + 1, k + 1] + beta[t + 1, k + 1]
            beta[t, k] = log_add(stay[k] + densities[t + 1, k] + beta[t + 1, k], on)
    return beta


@njit(cache=True, nogil=True)
def log_sum(values: FloatArray) -> float:
    """Return log(sum(exp(values)))."""
    total = values[0]
    for value in values[1:]:
        total = log_add(total, value)
    return total


@njit(cache=True, nogil=True)
def posteriors(
    frames: FloatArray, symbols: LogSymbols, s: int, must_exit: bool
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Gamma (frames, states), expected stays and leaves (states,), and log P(o) of one segment.

    A segment with fewer frames than states cannot leave the symbol, so that it may end in any
    state. One that the symbol cannot produce (self-loops of 0 or 1) has no expected counts.
    """
    densities = state_log_densities(frames, symbols, s)
    n_frames, n_states = densities.shape
    stay, leave = symbols.log_stay[s], symbols.log_leave[s]
    must_exit = must_exit and n_frames >= n_states
    final = final_weights(n_states, leave[n_states - 1], must_exit)
    alpha = forward(densities, stay, leave)
    beta = backward(densities, stay, leave, final)
    total = log_sum(alpha[n_frames - 1] + final)
    stays, leaves = np.zeros(n_states), np.zeros(n_states)
    if total < 0.5 * NEVER:
        return np.zeros((n_frames, n_states)), stays, leaves, total
    gamma = np.exp(alpha + beta - total)
    for t in range(n_frames - 1):
        for k in range(n_states):
            if gamma[t, k] < _NEGLIGIBLE:
                continue
            before = alpha[t, k] - total
            stays[k] += np.exp(before + stay[k] + densities[t + 1, k] + beta[t + 1, k])
            if k + 1 < n_states:
                leaves[k] += np.exp(
                    before + leave[k] + densities[t + 1, k + 1] + beta[t + 1, k + 1]
                )
    if must_exit:
        leaves[n_states - 1] += 1.0
    return gamma, stays, leaves, total


@njit(cache=True, nogil=True)
def accumulate(
    frames: FloatArray,
    symbols: LogSymbols,
    must_exit: bool,
    statistics: Statistics,
    log_likelihoods: FloatArray,
    segments: IntArray,
) -> None:
    """The E step: add the segments' expected counts to ``statistics``.

    Parameters
    ----------
    frames : array (frames, dimensions)
        Feature vectors, one row a frame.
    symbols : LogSymbols
        The symbols.
    must_exit : bool
        Whether a path must leave the last state at the end of its segment.
    statistics : Statistics
        Changed in place.
    log_likelihoods : array (all segments,)
        Filled in for these segments.
    segments : array (segments, 4)
        Start, end, symbol and place in ``log_likelihoods``.
    """
    for number in range(len(segments)):
        start, end, s, place = segments[number]
        gamma, stays, leaves, total = posteriors(frames[start:end], symbols, s, must_exit)
        log_likelihoods[place] = total
        for k in range(symbols.n_states[s]):
            statistics.stays[s, k] += stays[k]
            statistics.leaves[s, k] += leaves[k]
            for t in range(end - start):
                weight = gamma[t, k]
                if weight < _NEGLIGIBLE:
                    continue
                statistics.occupancy[s, k] += weight
                for d in range(frames.shape[1]):
                    deviation = frames[start + t, d] - symbols.means[s, k, d]
                    statistics.deviations[s, k, d] += weight * deviation
                    statistics.squares[s, k, d] += weight * deviation * deviation


@njit(cache=True, nogil=True)
def best_path(frames: FloatArray, symbols: LogSymbols, s: int, must_exit: bool) -> IntArray:
    """Most probable states of one segment (Viterbi): array (frames,).

    Of paths of equal probability the one that moves on later is taken, and at a free end the one
    that ends in the lowest state.
    """
    densities = state_log_densities(frames, symbols, s)
    n_frames, n_states = densities.shape
    stay, leave = symbols.log_stay[s], symbols.log_leave[s]
    best = np.full(n_states, NEVER)
    best[0] = densities[0, 0]
    moved = np.zeros((n_frames, n_states), np.bool_)
    for t in range(1, n_frames):
        for k in range(min(t, n_states - 1), 0, -1):
            on, same = best[k - 1] + leave[k - 1], best[k] + stay[k]
            moved[t, k] = on > same or k == t
            best[k] = max(on, same) + densities[t, k]
        best[0] += stay[0] + densities[t, 0]
    k = n_states - 1
    if not (must_exit and n_frames >= n_states):
        k = int(np.argmax(best))
    states = np.empty(n_frames, np.int64)
    for t in range(n_frames - 1, -1, -1):
        states[t] = k
        if moved[t, k]:
            k -= 1
    return states
