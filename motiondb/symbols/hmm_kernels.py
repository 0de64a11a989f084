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

Densities. With diagonal covariances, for frame x, mean m and variance v of a state, all centred on
c,

    log N(x; m, v) = sum_d [ x_d^2 (-1 / 2 v_d) + x_d (m_d / v_d) ]
                     - 1/2 sum_d [ m_d^2 / v_d + log(2 pi v_d) ]

is one row of [x^2, x] times one column of weights. The centre c is the mean of all means: the
squares would cancel badly far from the origin. The product is computed in single precision, unless
a state is so narrow, or so far from the centre, that its terms would still cancel. It is not left
to BLAS, and no kernel uses fast math: then the order of a sum would depend on the processor, and
learning amplifies differences in the last bit (docs/decisions/the-same-seed-on-any-machine.md).

Recognition spends most of its time in the forward recursion over many symbols at once. There the
densities come as blocks of a matrix product with states before symbols, so that the innermost loops
run over symbols without branches or calls, and are vectorised.

Source: Rabiner, A tutorial on hidden Markov models, 1989, sections III and IV; token passing after
Young, Russell and Thornton, 1989.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols

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


@njit(cache=True, nogil=True)
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


LOWEST_SCORE = -1e30  # ``NEVER`` in single precision


@njit(cache=True, nogil=True, error_model="numpy")
def score_block(
    log_densities: Float32Array,
    first: int,
    symbols: LogSymbols,
    must_exit: bool,
    scores: Float32Array,
    intervals: IntArray,
) -> None:
    """Forward probabilities of segments under symbols, written into ``scores``.

    Parameters
    ----------
    log_densities : array (frames, states, symbols)
        Log densities of a block that begins with symbol ``first``.
    first : int
        Number of the block's first symbol.
    symbols : LogSymbols
        All symbols.
    must_exit : bool
        Whether a path must leave the last state at the end of its segment.
    intervals : array (segments, 3)
        Start and end in the block, and row of ``scores``.
    scores : array (all segments, all symbols)
        Results, written in the rows of ``intervals`` and the block's columns.
    """
    _, n_padded, n_symbols = log_densities.shape
    shape = (n_padded, n_symbols)
    stay, leave, onward = np.empty(shape), np.empty(shape), np.empty(shape)
    for k in range(n_padded):
        for s in range(n_symbols):
            stay[k, s], leave[k, s] = (
                symbols.log_stay[first + s, k],
                symbols.log_leave[first + s, k],
            )
            onward[k, s] = leave[k, s] if k + 1 < symbols.n_states[first + s] else NEVER
    alpha, fresh = np.empty(shape), np.empty(shape)
    for number in range(len(intervals)):
        start, end, row = intervals[number]
        alpha[1:], fresh[1:] = NEVER, NEVER
        alpha[0] = log_densities[start, 0]
        for t in range(start + 1, end):
            for s in range(n_symbols):
                fresh[0, s] = alpha[0, s] + stay[0, s] + log_densities[t, 0, s]
            for k in range(1, min(t - start, n_padded - 1) + 1):
                step = (alpha[k], alpha[k - 1], stay[k], onward[k - 1])
                _step(step, log_densities[t, k], fresh[k])
            alpha, fresh = fresh, alpha
        for s in range(n_symbols):
            last = symbols.n_states[first + s] - 1
            total = alpha[last, s] + leave[last, s]
            if not must_exit:
                total = alpha[0, s]
                for k in range(1, last + 1):
                    total = log_add(total, alpha[k, s])
            scores[row, first + s] = max(total, LOWEST_SCORE)


@njit(cache=True, nogil=True, error_model="numpy")
def _step(
    origin: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    log_densities: Float32Array,
    alpha: FloatArray,
) -> None:
    """Forward step of one state for many symbols; log(1 + exp(-d)) without calls or branches.

    exp(-y) for y = d / 256 < 0.16 by its series to y^4, then squared 8 times; and
    log(1 + u) = 2 artanh(u / (2 + u)) by its series to z^13. The error is below 2e-8.
    """
    here, before, stay, onward = origin
    for s in range(len(here)):
        a, b = here[s] + stay[s], before[s] + onward[s]
        y = np.minimum(np.abs(a - b), 40.0) * (1.0 / 256.0)
        u = 1.0 - y * (1.0 - y * (1.0 / 2.0) * (1.0 - y * (1.0 / 3.0) * (1.0 - y * (1.0 / 4.0))))
        u *= u
        u *= u
        u *= u
        u *= u
        u *= u
        u *= u
        u *= u
        u *= u
        z = u / (2.0 + u)
        w = z * z
        series = 1.0 / 9.0 + w * (1.0 / 11.0 + w * (1.0 / 13.0))
        series = 1.0 + w * (1.0 / 3.0 + w * (1.0 / 5.0 + w * (1.0 / 7.0 + w * series)))
        alpha[s] = max(a, b) + 2.0 * z * series + log_densities[s]


BLOCK_VALUES = 1_500_000
"""Log densities held at once (6 MB), if one segment under a few symbols does not need more."""
SIMD_WIDTH = 8  # Symbols are taken in multiples of this: floats in a vector register of 256 bits
_SINGLE_PRECISION_LIMIT = 2e4  # sum_d m^2 / v up to which single precision errs by some 1e-3 nats


@lru_cache(maxsize=4)
def log_symbols(symbols: MotionSymbols) -> LogSymbols:
    """Compute the logarithms and reciprocals of the parameters that the kernels use."""
    loops = np.asarray(symbols.self_loops, dtype=np.float64)
    with np.errstate(divide="ignore"):
        log_stay = np.maximum(np.log(loops), NEVER)
        log_leave = np.maximum(np.log1p(-loops), NEVER)
    covars = np.ascontiguousarray(symbols.covars, dtype=np.float64)
    return LogSymbols(
        n_states=np.ascontiguousarray(symbols.n_states, dtype=np.int64),
        log_stay=log_stay,
        log_leave=log_leave,
        means=np.ascontiguousarray(symbols.means, dtype=np.float64),
        precisions=1.0 / covars,
        constants=-0.5 * np.log(2 * np.pi * covars).sum(axis=2),
    )


def check_symbols(symbols: MotionSymbols) -> None:
    """Refuse symbols whose arrays do not fit together or that hold impossible values."""
    n_symbols, n_padded = np.shape(symbols.self_loops)
    expected = (n_symbols, n_padded, np.shape(symbols.means)[-1])
    for name in ("means", "covars"):
        shape = np.shape(getattr(symbols, name))
        if shape != expected:
            raise MotionDBError(
                f"symbols.{name}: expected shape {expected}, found {shape}. "
                "Give every state a mean and a variance in every dimension."
            )
    n_states = symbols.n_states
    if (
        n_symbols == 0
        or len(n_states) != n_symbols
        or n_states.min() < 1
        or n_states.max() > n_padded
    ):
        raise MotionDBError(
            f"symbols.n_states: expected {n_symbols} numbers from 1 to {n_padded}, found "
            f"{np.array2string(n_states, threshold=6)}. Give every symbol at least one state."
        )
    if not (np.all(np.isfinite(symbols.means)) and np.all(symbols.covars > 0)):
        raise MotionDBError(
            "symbols: expected finite means and variances above 0, found others. "
            "Fit the symbols with a positive variance floor."
        )
    if not (np.all(symbols.self_loops >= 0) and np.all(symbols.self_loops <= 1)):
        raise MotionDBError(
            "symbols.self_loops: expected probabilities from 0 to 1, found others. Fit them anew."
        )


def log_density_blocks(
    symbols: MotionSymbols, frames: FloatArray | Float32Array, which: IntArray | None = None
) -> Iterator[tuple[int, Float32Array]]:
    """Log densities of the frames under every state, some symbols at a time.

    Shapes: `frames` (frames, dimensions); `which` (symbols,): numbers of the symbols, None: all.
    """
    n_padded = symbols.means.shape[1]
    width = BLOCK_VALUES // max(1, len(frames) * n_padded)
    width = max(width // SIMD_WIDTH, 1) * SIMD_WIDTH
    weights, constants, centre = _weights(symbols)
    if which is not None:
        weights, constants = weights[:, :, which], constants[:, which]
    n_symbols = weights.shape[2]
    centred = (frames - centre).astype(weights.dtype)
    terms = np.concatenate([np.square(centred), centred], axis=1)
    for first in range(0, n_symbols, width):
        some = slice(first, first + width)
        columns = weights[:, :, some].reshape(len(weights), -1)
        block = np.tile(constants[:, some].reshape(-1), (len(frames), 1))
        _add_product(terms, columns, block)
        shaped = block.reshape(len(frames), n_padded, -1)
        yield first, np.asarray(shaped, dtype=np.float32)


@njit(cache=True, nogil=True)
def _add_product(rows: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Add rows @ columns to ``out``, each sum in the order of the terms, on every processor.

    Shapes: `rows` (n, terms), `columns` (terms, m), `out` (n, m), all of one type.
    """
    n_terms = rows.shape[1]
    for i in range(len(rows)):
        row, total = rows[i], out[i]
        for d in range(0, n_terms - 3, 4):  # four terms at once, to read ``total`` less often
            x, y, z, w = row[d], row[d + 1], row[d + 2], row[d + 3]
            a, b, c, e = columns[d], columns[d + 1], columns[d + 2], columns[d + 3]
            for j in range(len(total)):
                total[j] += x * a[j] + y * b[j] + z * c[j] + w * e[j]
        for d in range(n_terms - n_terms % 4, n_terms):
            for j in range(len(total)):
                total[j] += row[d] * columns[d, j]


@lru_cache(maxsize=4)  # the same for all captures that are scored or cut one after another
def _weights(symbols: MotionSymbols) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights (2 * dimensions, states, symbols), constants (states, symbols), centre."""
    real = np.arange(symbols.means.shape[1]) < symbols.n_states[:, None]
    centre = symbols.means[real].mean(axis=0)
    means = np.where(real[..., None], symbols.means - centre, 0.0).transpose(2, 1, 0)
    covars = symbols.covars.transpose(2, 1, 0)
    spread = (means**2 / covars).sum(axis=0)
    constants = -0.5 * (spread + np.log(2 * np.pi * covars).sum(axis=0))
    weights = np.concatenate([-0.5 / covars, means / covars])
    dtype = np.float32 if spread.max() < _SINGLE_PRECISION_LIMIT else np.float64
    return np.ascontiguousarray(weights, dtype=dtype), constants.astype(dtype), centre
