"""Ridge regression, of which each map from motion to words is one.

=================  ==========================  ====================  ===============================
map                rows                        features              targets
=================  ==========================  ====================  ===============================
word map           described intervals         score vectors         y: 1 for each word
caption map        described intervals         score vectors         y / |y|
description map    described intervals         kernels of score      y / |y|
                                               vectors
pooled map         described intervals         pooled statistics     y / |y|
place map          segments of captioned takes vectors of windows    places y, estimated in rounds
edge map           frames of captioned takes   soft levels of        places y, estimated in rounds
                                               features and change
judge              windows of 3 s              pooled statistics     1 / sqrt(actions) for each word
unplaced           windows of segments         vectors of windows    the words of the whole take
=================  ==========================  ====================  ===============================

The first four weigh every described interval alike or by performer, the others every take by the
root of its length, so that long takes weigh more than short ones, but less than in proportion.
Predictions that calibrations are fitted to leave out the performer, or the take, itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray, IntArray


def fit_ridge(
    vectors: FloatArray, target: FloatArray, ridge: float
) -> tuple[FloatArray, FloatArray]:
    """Slopes (columns, words) and constants (words,) of centred ridge regression.

    Shapes: `vectors` (n, columns); `target` (n, words).
    """
    mean_v, mean_y = vectors.mean(axis=0), target.mean(axis=0)
    v, y = vectors - mean_v, target - mean_y
    if len(v) < v.shape[1]:  # the dual solution, whose matrix is smaller
        weights = v.T @ np.linalg.solve(v @ v.T + ridge * np.eye(len(v)), y)
    else:
        weights = np.linalg.solve(v.T @ v + ridge * np.eye(v.shape[1]), v.T @ y)
    return weights, mean_y - mean_v @ weights


def solve_sums(
    n: float,
    vectors: FloatArray,
    gram: FloatArray,
    targets: FloatArray,
    cross: FloatArray,
    ridge: float,
) -> tuple[FloatArray, FloatArray]:
    """Slopes (columns, words) from sums over n rows, and their product with the mean vector.

    Shapes: `vectors` (columns,), `gram` (columns, columns), `targets` (words,), `cross` (columns,
    words): sums of v, v v', y and v y'.
    """
    from threadpoolctl import threadpool_limits

    mean_v, mean_y = vectors / n, targets / n
    matrix = gram - n * np.outer(mean_v, mean_v) + ridge * np.eye(len(mean_v))
    goal = cross - n * np.outer(mean_v, mean_y)
    with threadpool_limits(1):  # sums of several threads differ in their last bits
        slopes = np.linalg.solve(matrix, goal).astype(np.float64, copy=False)
    # one order of summation: a matrix product's last bits depend on the number of threads
    return slopes, np.asarray(np.einsum("i,ij->j", mean_v, slopes, optimize=False))


def shared_words(presence: NDArray[np.bool_], groups: IntArray) -> NDArray[np.bool_]:
    """Words of two or more groups; all words if there are none: array (words,).

    Shapes: `presence` (n, words); `groups` (n,).
    """
    said = [presence[groups == group].any(axis=0) for group in np.unique(groups)]
    shared: NDArray[np.bool_] = np.sum(said, axis=0) > 1
    return shared if shared.any() else np.ones_like(shared)


def left_out(vectors: FloatArray, target: FloatArray, groups: IntArray, ridge: float) -> FloatArray:
    """Predicted target of every interval, by the regression without its group: array (n, words).

    Shapes: `vectors` (n, symbols); `target` (n, words); `groups` (n,).
    """
    predicted = np.zeros_like(target)
    for group in np.unique(groups):
        test = groups == group
        if test.all():
            predicted[test] = target.mean(axis=0)
            continue
        weights, offsets = fit_ridge(vectors[~test], target[~test], ridge)
        predicted[test] = vectors[test] @ weights + offsets
    return predicted
