"""Local alignment of symbol sequences with the symbols' distances as substitution costs.

Notation: q the query's symbols, x a capture's, D their distances. A pair scores 1 - D[q, x] / scale
(1 for the same symbol, negative beyond ``scale``), a gap costs ``GAP``. Pairs are weighted by the
query segment's share of the query's duration, so that the score of a perfect match is 1.

Source: Smith and Waterman, Identification of common molecular subsequences, 1981.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.records import FloatArray, IntArray

GAP = 0.5  # Cost of a gap, where a match scores 1


def distance_scale(distances: FloatArray) -> float:
    """Distance above which two symbols count as unrelated: the median over pairs.

    Shapes: `distances` (symbols, symbols).
    """
    pairs = distances[np.triu_indices(len(distances), 1)]
    return max(float(np.median(pairs)), 1e-9) if len(pairs) else 1.0


def align(
    query: IntArray, weights: FloatArray, symbols: IntArray, distances: FloatArray, scale: float
) -> tuple[float, int, int]:
    """Best local alignment of a query with one capture.

    Shapes: `query`, `weights` (l,); `symbols` (n,); `distances` (symbols, symbols).
    """
    similarity = 1.0 - distances[np.ix_(query, symbols)] / scale
    return _smith_waterman(similarity * weights[:, None], weights * GAP)


@njit(cache=True)
def _smith_waterman(pairs: FloatArray, gaps: FloatArray) -> tuple[float, int, int]:
    """Best local alignment by scores of pairs (query, capture) and costs of gaps (query,)."""
    n_query, n_symbols = pairs.shape
    mean_gap = gaps.mean()
    score = np.zeros((n_query + 1, n_symbols + 1))
    origin = np.zeros((n_query + 1, n_symbols + 1), np.int64)
    for j in range(n_symbols + 1):
        origin[0, j] = j
    top, first, last = 0.0, 0, 0
    for i in range(1, n_query + 1):
        for j in range(1, n_symbols + 1):
            best, start = 0.0, j
            diagonal = score[i - 1, j - 1] + pairs[i - 1, j - 1]
            if diagonal > best:
                best = diagonal
                start = origin[i - 1, j - 1] if score[i - 1, j - 1] > 0.0 else j - 1
            up = score[i - 1, j] - gaps[i - 1]
            if up > best:
                best, start = up, origin[i - 1, j]
            left = score[i, j - 1] - mean_gap
            if left > best:
                best, start = left, origin[i, j - 1]
            score[i, j], origin[i, j] = best, start
            if best > top:
                top, first, last = best, start, j
    return top, first, last
