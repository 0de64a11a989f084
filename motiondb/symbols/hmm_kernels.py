"""The recursions of left-to-right HMMs, compiled.

Notation: o_t frame t of T, k a state of K, a_k its self-loop, b_k(o_t) its Gaussian density.

    forward     alpha_t(k) = b_k(o_t) [alpha_t-1(k) a_k + alpha_t-1(k - 1) (1 - a_k-1)]
    stayed      rho_t(k)   = alpha_t-1(k) a_k b_k(o_t) / alpha_t(k)
    posterior   gamma_t-1(k) = gamma_t(k) rho_t(k) + gamma_t(k + 1) [1 - rho_t(k + 1)]

A state has two successors, so that a frame costs O(K), not O(K^2). The forward recursion is in the
log domain, where ``NEVER`` is the logarithm of zero: scaled probabilities underflow under a wrong
symbol, and a state of negligible probability now may be the only one that explains later frames.
Of the paths in state k at frame t, the share rho_t(k) was in it a frame before; so posteriors go
back from those of the last frame, gamma_T = alpha_T / P(o), without logarithms. Where the path must
leave the last state, gamma_T(K) = 1.

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
run over states and symbols without branches or calls, and are vectorised. They are in single
precision, relative to the likeliest state of each symbol, whose sum is kept in double precision:
the results were those of double precision to the last bit of the scores.

Source: Rabiner, A tutorial on hidden Markov models, 1989, sections III and IV (the posteriors: the
backward recursion divided by P(o)); token passing after Young, Russell and Thornton, 1989.
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
    n_frames, n_states = len(frames), symbols.n_states[s]
    densities, columns = np.empty((n_frames, n_states)), frames.T.copy()
    total = np.empty(n_frames)
    for k in range(n_states):
        total[:] = 0.0
        for d in range(len(columns)):
            column, mean, precision = (
                columns[d],
                symbols.means[s, k, d],
                symbols.precisions[s, k, d],
            )
            for t in range(n_frames):
                deviation = column[t] - mean
                total[t] += deviation * deviation * precision
        for t in range(n_frames):
            densities[t, k] = symbols.constants[s, k] - 0.5 * total[t]
    return densities


@njit(cache=True, nogil=True, error_model="numpy")
def forward(
    densities: FloatArray, stay: FloatArray, leave: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """log alpha of the last frame (states,), and rho of all frames (frames, states)."""
    n_frames, n_states = densities.shape
    alpha, stayed = np.full(n_states, NEVER), np.ones((n_frames, n_states))
    alpha[0] = densities[0, 0]
    for t in range(1, n_frames):
        for k in range(min(t, n_states - 1), 0, -1):
            on, same = alpha[k - 1] + leave[k - 1], alpha[k] + stay[k]
            apart = abs(on - same)
            alpha[k], less = max(on, same) + densities[t, k], 0.0
            if apart < _NO_CHANGE:
                less = np.exp(-apart)
                alpha[k] += np.log1p(less)
            stayed[t, k] = (1.0 if same >= on else less) / (1.0 + less)
        alpha[0] += stay[0] + densities[t, 0]
    return alpha, stayed


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
    leave = symbols.log_leave[s]
    must_exit = must_exit and n_frames >= n_states
    ends, stayed = forward(densities, symbols.log_stay[s], leave)
    if must_exit:
        ends[:-1], ends[-1] = NEVER, ends[-1] + leave[n_states - 1]
    total = log_sum(ends)
    gamma, stays, leaves = np.zeros((n_frames, n_states)), np.zeros(n_states), np.zeros(n_states)
    if total < 0.5 * NEVER:
        return gamma, stays, leaves, total
    gamma[n_frames - 1] = np.exp(ends - total)
    for t in range(n_frames - 1, 0, -1):
        for k in range(n_states):
            same = gamma[t, k] * stayed[t, k]
            gamma[t - 1, k] += same
            stays[k] += same
            if k > 0:
                on = gamma[t, k] - same
                gamma[t - 1, k - 1] += on
                leaves[k - 1] += on
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


LOWEST_SCORE = np.float32(-1e30)  # ``NEVER`` in single precision
_RENEWED = 4  # Frames after which forward probabilities are made relative to the largest again


@njit(cache=True, nogil=True, error_model="numpy")
def score_block(
    log_densities: Float32Array,
    which: IntArray,
    symbols: LogSymbols,
    must_exit: bool,
    scores: Float32Array,
    first: int,
    intervals: IntArray,
) -> None:
    """Forward probabilities of segments under symbols, written into ``scores``.

    Parameters
    ----------
    log_densities : array (frames, states, which)
        Log densities of a block under some symbols.
    which : array (which,)
        The numbers of these.
    symbols : LogSymbols
        All symbols.
    must_exit : bool
        Whether a path must leave the last state at the end of its segment.
    scores : array (all segments, columns)
        Results, written in the rows of ``intervals`` and the columns from ``first`` on.
    first : int
        Column of the first of the symbols.
    intervals : array (segments, 3)
        Start and end in the block, and row of ``scores``.
    """
    n_frames, n_padded, n_symbols = log_densities.shape
    size = n_padded * n_symbols
    densities = log_densities.reshape(n_frames, size)
    stay, onward = _moves(symbols, which)
    alpha, fresh = np.empty(size, np.float32), np.empty(size, np.float32)
    peaks, none = np.empty(n_symbols, np.float32), np.zeros(n_symbols, np.float32)
    sums = np.empty(n_symbols)
    for number in range(len(intervals)):
        start, end, row = intervals[number]
        alpha[n_symbols:], fresh[n_symbols:], sums[:] = LOWEST_SCORE, LOWEST_SCORE, 0.0
        alpha[:n_symbols] = densities[start, :n_symbols]
        for t in range(start + 1, end):
            now, top = densities[t], min(t - start + 1, n_padded) * n_symbols
            for n in range(n_symbols):
                fresh[n] = alpha[n] + stay[n] + now[n]
            before = alpha[: top - n_symbols], onward[: top - n_symbols]
            here = alpha[n_symbols:top], stay[n_symbols:top]
            _step(here, before, now[n_symbols:top], fresh[n_symbols:top])
            if (t - start) % _RENEWED == 0:
                _renew(fresh[:top], peaks, sums)
            alpha, fresh = fresh, alpha
        if not must_exit:  # as if each state were moved to from the one before, at once
            for k in range(1, n_padded):
                others = alpha[k * n_symbols : (k + 1) * n_symbols]
                _step((alpha[:n_symbols], none), (others, none), none, fresh[:n_symbols])
                alpha[:n_symbols] = fresh[:n_symbols]
        for n in range(n_symbols):
            total = np.float64(alpha[n])
            if must_exit:
                last = symbols.n_states[which[n]] - 1
                total = alpha[last * n_symbols + n] + symbols.log_leave[which[n], last]
            scores[row, first + n] = max(total + sums[n], LOWEST_SCORE)


@njit(cache=True, nogil=True)
def _moves(symbols: LogSymbols, which: IntArray) -> tuple[Float32Array, Float32Array]:
    """Log probabilities to stay, and to move on within some symbols: (states * symbols,)."""
    n_padded, n_symbols = symbols.log_stay.shape[1], len(which)
    stay = np.empty((n_padded, n_symbols), np.float32)
    onward = np.full((n_padded, n_symbols), LOWEST_SCORE)
    for k in range(n_padded):
        for n in range(n_symbols):
            s = which[n]
            stay[k, n] = max(symbols.log_stay[s, k], LOWEST_SCORE)
            if k + 1 < symbols.n_states[s]:
                onward[k, n] = max(symbols.log_leave[s, k], LOWEST_SCORE)
    return stay.ravel(), onward.ravel()


@njit(cache=True, nogil=True, error_model="numpy")
def _step(
    here: tuple[Float32Array, Float32Array],
    before: tuple[Float32Array, Float32Array],
    log_densities: Float32Array,
    alpha: Float32Array,
) -> None:
    """Forward step of states that may be moved to; log(1 + exp(-d)) without calls or branches.

    exp(-d) = 2^-n 2^-f, n whole; 2^-f on [0, 1) and log(1 + u) / u on [0, 1] by polynomials that
    interpolate at Chebyshev's points. Both err by less than 3e-7.
    """
    f4, i4 = np.float32, np.int32
    own, stay = here
    others, onward = before
    for i in range(len(alpha)):
        a, b = own[i] + stay[i], others[i] + onward[i]
        x = min(abs(a - b), f4(40.0)) * f4(1.4426950408889634)
        n = i4(x)
        f = x - f4(n)
        p = f4(0.055298119) - f * (f4(0.0092091804) - f * f4(0.00094687703))
        p = f4(0.99999994) - f * (f4(0.69314313) - f * (f4(0.24017896) - f * p))
        u = p * i4((i4(127) - n) << i4(23)).view(np.float32)
        g = f4(0.17687477) - u * (f4(0.10685003) - u * (f4(0.0434939) - u * f4(0.0083711526)))
        g = f4(0.49997175) - u * (f4(0.33271928) - u * (f4(0.24474774) - u * g))
        alpha[i] = max(a, b) + u * (f4(0.99999978) - u * g) + log_densities[i]


@njit(cache=True, nogil=True)
def _renew(alpha: Float32Array, peaks: Float32Array, sums: FloatArray) -> None:
    """Take the largest of each symbol's states from all of them, and add it to ``sums``."""
    n_symbols = len(peaks)
    rows = alpha.reshape(-1, n_symbols)
    peaks[:] = rows[0]
    for k in range(1, len(rows)):
        row = rows[k]
        for s in range(n_symbols):
            peaks[s] = max(peaks[s], row[s])
    for k in range(len(rows)):
        row = rows[k]
        for s in range(n_symbols):
            row[s] -= peaks[s]
    for s in range(n_symbols):
        sums[s] += peaks[s]


@njit(cache=True, nogil=True)
def score_again(
    frames: FloatArray | Float32Array,
    weighing: tuple[FloatArray, FloatArray, FloatArray],
    symbols: LogSymbols,
    likely: IntArray,
    intervals: IntArray,
    scores: Float32Array,
) -> None:
    """Scores (segments, likely) of segments, each under symbols of its own.

    Shapes: `likely` (segments, likely); `intervals` (segments, 2): starts and ends.

    `weighing`: What :func:`weigh` gives.
    """
    weights, constants, centre = weighing
    n_terms, n_padded, n_likely = len(weights), len(constants), likely.shape[1]
    columns = np.empty((n_terms, n_padded * n_likely), weights.dtype)
    constant = np.empty(n_padded * n_likely, weights.dtype)
    whole, n_dims = np.zeros((1, 3), np.int64), len(centre)
    for number in range(len(intervals)):
        start, end = intervals[number]
        which = likely[number]
        for k in range(n_padded):
            for n in range(n_likely):
                constant[k * n_likely + n] = constants[k, which[n]]
                for d in range(n_terms):
                    columns[d, k * n_likely + n] = weights[d, k, which[n]]
        terms = np.empty((end - start, n_terms), weights.dtype)
        for t in range(end - start):
            for d in range(n_dims):
                terms[t, n_dims + d] = frames[start + t, d] - centre[d]
                terms[t, d] = terms[t, n_dims + d] * terms[t, n_dims + d]
        block = np.empty((end - start, n_padded * n_likely), weights.dtype)
        _products(terms, columns, constant, block)
        shaped = block.astype(np.float32).reshape(end - start, n_padded, n_likely)
        whole[0] = 0, end - start, number
        score_block(shaped, which, symbols, False, scores, 0, whole)


BLOCK_VALUES = 200_000
"""Log densities held at once (.8 MB), if one segment under a few symbols does not need more."""
SIMD_WIDTH = 16  # Symbols are taken in multiples of this: floats in a vector register of 512 bits
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
    symbols: MotionSymbols, frames: FloatArray | Float32Array
) -> Iterator[tuple[IntArray, Float32Array]]:
    """Log densities of the frames under every state, some symbols at a time.

    Shapes: `frames` (frames, dimensions); yields the numbers of the symbols, and an array (frames,
    states, symbols).
    """
    n_padded = symbols.means.shape[1]
    width = BLOCK_VALUES // max(1, len(frames) * n_padded)
    width = max(width // SIMD_WIDTH, 1) * SIMD_WIDTH
    weights, constants, centre = weigh(symbols)
    n_symbols = weights.shape[2]
    centred = (frames - centre).astype(weights.dtype)
    terms = np.concatenate([np.square(centred), centred], axis=1)
    for first in range(0, n_symbols, width):
        some = slice(first, first + width)
        columns = weights[:, :, some].reshape(len(weights), -1)
        block = np.empty((len(frames), columns.shape[1]), dtype=weights.dtype)
        _products(terms, columns, constants[:, some].reshape(-1), block)
        shaped = block.reshape(len(frames), n_padded, -1)
        which = np.arange(n_symbols, dtype=np.int64)[some]
        yield which, np.asarray(shaped, dtype=np.float32)


@njit(cache=True, nogil=True)
def _products(
    rows: FloatArray, columns: FloatArray, constants: FloatArray, out: FloatArray
) -> None:
    """rows @ columns + constants, each sum in the order of the terms, on every processor.

    Shapes: `rows` (n, terms), `columns` (terms, m), `constants` (m,), `out` (n, m), of one type.
    """
    n, n_terms = rows.shape
    for i in range(0, n, 2):  # two rows and four terms at once, to read and write less often
        other = min(i + 1, n - 1)
        row, total, below, under = rows[i], out[i], rows[other], out[other]
        for j in range(len(total)):
            total[j] = constants[j]
            under[j] = constants[j]
        if other == i:
            below, under = np.zeros_like(row), np.empty_like(total)
        for d in range(0, n_terms - 3, 4):
            x, y, z, w = row[d], row[d + 1], row[d + 2], row[d + 3]
            p, q, r, s = below[d], below[d + 1], below[d + 2], below[d + 3]
            a, b, c, e = columns[d], columns[d + 1], columns[d + 2], columns[d + 3]
            for j in range(len(total)):
                total[j] += x * a[j] + y * b[j] + z * c[j] + w * e[j]
                under[j] += p * a[j] + q * b[j] + r * c[j] + s * e[j]
        for d in range(n_terms - n_terms % 4, n_terms):
            for j in range(len(total)):
                total[j] += row[d] * columns[d, j]
                under[j] += below[d] * columns[d, j]


@lru_cache(maxsize=4)  # the same for all captures that are scored or cut one after another
def weigh(symbols: MotionSymbols) -> tuple[FloatArray, FloatArray, FloatArray]:
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
