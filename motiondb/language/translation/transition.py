"""Bigram models of symbol sequences with beginning and end, plain and by clusters.

Row 0 of every matrix is the beginning of a capture, row s + 1 symbol s; column 0 is its end, column
s + 1 symbol s. Paper A's eq. 5 has no first term, and its eq. 6 divides by *all* occurrences, so
that its rows sum to less than 1; with beginning and end every row sums to 1. A row without counts
(a symbol that occurs in no capture) has the end with probability 1.

By clusters, P(symbol' | symbol) = P(cluster' | cluster) P(symbol' | cluster'); beginning and end
are separate clusters. (Paper A's eq. 9 has the first factor only, which is not a distribution over
symbols.) A pair of symbols has a probability above 0 exactly where its pair of clusters was seen.
With one symbol a cluster this is the plain bigram.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motiondb.records import FloatArray, IntArray

UNSEEN = 0.5
"""Pseudo-count of a symbol within its cluster (Krichevsky and Trofimov): none has probability 0."""


def count_transitions(sequences: Iterable[IntArray], n_symbols: int) -> FloatArray:
    """Count how often each symbol follows each other symbol: array (symbols + 1, symbols + 1).

    Counts are additive over captures: a capture is removed by subtracting its counts.

    >>> count_transitions([np.array([0, 0, 1])], 2)
    array([[0., 1., 0.],
           [0., 1., 1.],
           [1., 0., 0.]])
    """
    counts = np.zeros((n_symbols + 1, n_symbols + 1))
    for sequence in sequences:
        if len(sequence):
            nodes = np.concatenate([[0], np.asarray(sequence, dtype=np.int64) + 1, [0]])
            np.add.at(counts, (nodes[:-1], nodes[1:]), 1.0)
    return counts


def log_bigram(counts: FloatArray) -> FloatArray:
    """log P(column | row) of the plain bigram, array (symbols + 1, symbols + 1); -inf where unseen.

    Shapes: `counts` (symbols + 1, symbols + 1).
    """
    return _log(_rows_to_one(counts))


def log_clustered_bigram(counts: FloatArray, clusters: IntArray) -> FloatArray:
    """log P(column | row) of the clustered bigram, array (symbols + 1, symbols + 1).

    Shapes: `counts` (symbols + 1, symbols + 1); `clusters` (symbols,).

    >>> walk_to_sit = count_transitions([np.array([0, 2]), np.array([1])], 3)
    >>> np.exp(log_clustered_bigram(walk_to_sit, np.array([0, 0, 1])))[2].round(2)
    array([0.5, 0. , 0. , 0.5])
    """
    node = np.append(0, np.unique(np.asarray(clusters), return_inverse=True)[1].ravel() + 1)
    n_clusters = int(node.max()) + 1
    between = np.zeros((n_clusters, n_clusters))
    np.add.at(between, (node[:, None], node[None, :]), counts)
    weights = counts.sum(axis=0) + UNSEEN
    within = weights / np.bincount(node, weights, n_clusters)[node]
    return _log(_rows_to_one(between)[node[:, None], node[None, :]] * within[None, :])


def log_interpolated_bigram(counts: FloatArray, clusters: IntArray) -> FloatArray:
    """log of the plain bigram mixed with the clustered one, array (symbols + 1, symbols + 1).

    In a row with N counts on D different followers the weight of the plain bigram is N / (N + D):
    it is large for a symbol that was seen often with few followers. A row without counts is that of
    the clustered bigram. Rows sum to 1. On held-out captures this gave a larger likelihood than one
    weight for all rows (``docs/measured/quality.md``, "Analogy"), and than other multiples of D.

    Shapes: `counts` (symbols + 1, symbols + 1); `clusters` (symbols,).

    Witten and Bell, The zero-frequency problem, 1991.

    >>> counts = count_transitions([np.array([0, 0, 0]), np.array([1])], 2)
    >>> np.exp(log_interpolated_bigram(counts, np.array([0, 0])))[1].round(3)
    array([0.4 , 0.54, 0.06])
    """
    total = counts.sum(axis=1, keepdims=True)
    followers = (counts > 0).sum(axis=1, keepdims=True)
    share = total / np.maximum(total + followers, 1.0)
    plain, clustered = np.exp(log_bigram(counts)), np.exp(log_clustered_bigram(counts, clusters))
    return _log(share * plain + (1.0 - share) * clustered)


def _rows_to_one(counts: FloatArray) -> FloatArray:
    totals = counts.sum(axis=1, keepdims=True)
    probabilities = counts / np.where(totals > 0, totals, 1.0)
    probabilities[totals[:, 0] <= 0, 0] = 1.0
    return probabilities


def _log(probabilities: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        return np.log(probabilities)
