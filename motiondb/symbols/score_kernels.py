"""The forward recursion over many symbols at once, on which recognition spends most of its time.

Same recursion and notation as ``hmm_kernels``. The densities come as blocks of a matrix product
(``emissions``) with states before symbols, so that the innermost loops run over symbols without
branches or calls, and are vectorised.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.hmm_kernels import NEVER, LogSymbols, log_add

LOWEST_SCORE = -1e30  # ``NEVER`` in single precision


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
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


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
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
