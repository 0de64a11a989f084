"""How clearly a piece of motion shows what was asked for, and nothing else.

Notation: p_r(w) the probability that segment r shows word w; A the words asked for. A segment that
shows a kick and a handstand answers "kick" less well than one that shows a kick alone, so each word
counts

    c_r(w) = p_r(w) [prod_{v not in A} (1 - p_r(v))]^h,    w in A,

the probability of the word while nothing is shown that was not asked for, words taken as
independent. They are not: whoever sits on a stool shows "stool" too; so what was not asked for
counts by a share h. A symbol is as clear as its segments: the geometric mean of what all of them
show on average and what the clearest few show, for these are what generation takes.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray, IntArray

CLEAREST = 3
"""Segments by which a symbol is judged to be able to show a word."""
UNASKED_SHARE = 0.5
"""h: how much what was not asked for counts, beside what was."""


def log_unasked(probabilities: FloatArray, asked: IntArray) -> FloatArray:
    """sum_{v not in A} log(1 - p_r(v)) of every segment: array (segments,), at most 0.

    Parameters
    ----------
    probabilities : array (segments, words)
        Below 1.
    asked : array
        Word numbers A.

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
    """How clearly every symbol shows the words asked for: array (symbols, len(asked)), 0 to 1.

    Parameters
    ----------
    probabilities : array (segments, words)
        Below 1.
    asked : array
        Word numbers A, all different.
    symbols : array (segments,)
        The symbol of every segment. One without segments shows nothing.
    unasked_share : float, optional
        h, from 0 to 1.

    >>> symbol_clarity(np.array([[0.8, 0.5], [0.2, 0.0]]), np.array([0]), np.array([0, 1]), 2, 1.0)
    array([[0.4],
           [0.2]])
    """
    clear = probabilities[:, asked]
    clear = clear * np.exp(unasked_share * log_unasked(probabilities, asked))[:, None]
    answer = np.zeros((n_symbols, len(asked)))
    for symbol in np.unique(symbols):
        own = np.sort(clear[symbols == symbol], axis=0)
        answer[symbol] = np.sqrt(own.mean(axis=0) * own[-CLEAREST:].mean(axis=0))
    return answer
