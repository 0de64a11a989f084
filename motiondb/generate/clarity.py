"""Clarity: how well a segment of motion shows the requested words, and no others.

Notation: p_r(w) the probability that segment r shows word w; A the requested words. A segment that
shows a kick and a handstand is a worse example of "kick" than one that shows a kick alone, so the
clarity of word w is

    c_r(w) = p_r(w) [prod_{v not in A} (1 - p_r(v))]^h,    w in A,

For h = 1 this is the probability that the word is shown and no other, if words are independent.
They are not: a motion of sitting on a stool shows "stool" too. Hence the exponent h < 1. The
clarity of a symbol is the geometric mean of two means over its segments: over all of them, and over
the few clearest, which are those that generation uses.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray, IntArray

CLEAREST = 3  # Number of clearest segments
UNASKED_SHARE = 0.5  # h


def log_unasked(probabilities: FloatArray, asked: IntArray) -> FloatArray:
    """sum_{v not in A} log(1 - p_r(v)) of every segment: array (segments,), at most 0.

    Shapes: `probabilities` (segments, words); `asked` (requested words,).

    >>> np.exp(log_unasked(np.array([[0.9, 0.5, 0.2]]), np.array([0]))).round(6)
    array([0.4])
    """
    others = np.ones(probabilities.shape[1], dtype=bool)
    others[asked] = False
    return np.asarray(np.log1p(-probabilities[:, others]).sum(axis=1))


def symbol_clarity(
    probabilities: FloatArray,
    asked: IntArray,
    symbols: IntArray,
    n_symbols: int,
    unasked_share: float = UNASKED_SHARE,
) -> FloatArray:
    """Clarity of the requested words in every symbol: array (symbols, requested words), 0 to 1.

    Shapes: `probabilities` (segments, words); `asked` (requested words,); `symbols` (segments,).

    >>> symbol_clarity(np.array([[0.8, 0.5], [0.2, 0.0]]), np.array([0]), np.array([0, 1]), 2, 1.0)
    array([[0.4],
           [0.2]])
    """
    clear = probabilities[:, asked]
    clear = clear * np.exp(unasked_share * log_unasked(probabilities, asked))[:, None]
    answer = np.zeros((n_symbols, len(asked)))
    for symbol in np.unique(symbols):
        rising = np.sort(clear[symbols == symbol], axis=0)
        answer[symbol] = np.sqrt(rising.mean(axis=0) * rising[-CLEAREST:].mean(axis=0))
    return answer
