"""Description length of segments under symbols, and which symbols to remove to shorten it.

    L = - sum_i log P(o_i | winner(i)) + n ln S + sum_s price(s)
    price(s) = K_s (2 D + 1) / 2 ln(F)

in nats, for n segments, S symbols of K_s states in D dimensions, and F frames.

Source: Rissanen, Modeling by shortest data description, 1978.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols


def prices(symbols: MotionSymbols, n_frames: int) -> FloatArray:
    """Bits of each symbol's means, variances and self-loops, in nats: array (symbols,)."""
    each = 0.5 * (2 * symbols.means.shape[2] + 1) * np.log(max(n_frames, 2))
    return symbols.n_states * each


def description_length(
    log_likelihood: float, n_segments: int, symbols: MotionSymbols, n_frames: int
) -> float:
    """L, nats, given the segments' total log-likelihood under their symbols.

    >>> s = MotionSymbols(np.array([1]), np.ones((1, 1)), np.zeros((1, 1, 2)), np.ones((1, 1, 2)))
    >>> round(description_length(-10.0, 3, s, 100), 4)  # 10 + 3 ln 1 + 5 / 2 ln 100
    21.5129
    """
    names = n_segments * np.log(symbols.n_symbols)
    return float(-log_likelihood + names + prices(symbols, n_frames).sum())


def deaths(
    scores: Float32Array | FloatArray, prices: FloatArray, least: int = 1
) -> tuple[IntArray, FloatArray]:
    """Which symbols to remove, greedily, and how much each removal shortens the description.

    After each removal the loss of likelihood is computed again, so that the gains add up. The
    list ends with the first removal that lengthens the description, but holds at least ``least``
    symbols; one symbol always stays.

    Shapes: `scores` (segments, symbols); `prices` (symbols,); result (removals,).

    >>> scores = np.array([[-10.0, -50.0, -12.0], [-60.0, -10.0, -55.0]])
    >>> order, gains = deaths(scores, np.full(3, 20.0))
    >>> order, gains.round(1)  # 20 + 2 ln 3/2 - 0, then 20 + 2 ln 2 - 40
    (array([2, 0]), array([ 20.8, -18.6]))
    """
    alive, rows = np.arange(scores.shape[1]), np.arange(len(scores))
    order: list[int] = []
    gains: list[float] = []
    while len(alive) > 1 and (len(order) < least or gains[-1] > 0):
        left = scores[:, alive].astype(np.float64)
        winners = np.argmax(left, axis=1)
        best = left[rows, winners]
        left[rows, winners] = -np.inf
        loss = np.bincount(winners, weights=best - left.max(axis=1), minlength=len(alive))
        names = len(rows) * np.log(len(alive) / (len(alive) - 1))
        gain = prices[alive] + names - loss
        weakest = int(np.argmax(gain))
        order.append(int(alive[weakest]))
        gains.append(float(gain[weakest]))
        alive = np.delete(alive, weakest)
    return np.array(order, dtype=np.int64), np.array(gains)
