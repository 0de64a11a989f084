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

The regression is weighted and centred: with x_i, y_i and w_i the features, targets and weight of a
row, and means over all rows by their weights, the slopes minimise

    sum_i w_i |y_i - mean y - (x_i - mean x) . slopes|^2 + ridge |slopes|^2.

Rows are left out in one of three ways: by another fit (:func:`left_out`), by subtracting their sums
(:class:`Sums`), or, where the means may stay, from the residuals with all rows
(:meth:`Regression.without`). With X the rows left out, A the inverse of the sum of products with
the ridge, H = X A X' and e their residuals with all rows, those without them are (I - H)^-1 e.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray, IntArray
from motiondb.symbols.hmm_jobs import one_blas_thread

T = TypeVar("T")


def fit_ridge(
    vectors: FloatArray, target: FloatArray, ridge: float, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Slopes (columns, words) and constants (words,); every row weighs 1 without `weights`.

    Shapes: `vectors` (n, columns); `target` (n, words); `weights` (n,).
    """
    if weights is None:
        mean_v, mean_y = vectors.mean(axis=0), target.mean(axis=0)
        v, y = vectors - mean_v, target - mean_y
    else:
        root = np.sqrt(weights)[:, None]
        mean_v, mean_y = weights @ vectors / weights.sum(), weights @ target / weights.sum()
        v, y = root * (vectors - mean_v), root * (target - mean_y)
    if len(v) < v.shape[1]:  # the dual solution, whose matrix is smaller
        slopes = v.T @ np.linalg.solve(v @ v.T + ridge * np.eye(len(v)), y)
    else:
        slopes = np.linalg.solve(v.T @ v + ridge * np.eye(v.shape[1]), v.T @ y)
    return slopes, mean_y - mean_v @ slopes


@dataclass(frozen=True, eq=False)
class Sums:
    """Weighted sums over rows, from which the sums of some rows can be subtracted."""

    n: float  # Sum of the weights
    vectors: FloatArray  # (columns,): sum of x
    targets: FloatArray  # (words,): sum of y
    gram: FloatArray  # (columns, columns): sum of x x'
    cross: FloatArray  # (columns, words): sum of x y'

    def __sub__(self, other: Sums) -> Sums:
        return by_fields(operator.sub, self, other)

    def solve(self, ridge: float) -> tuple[FloatArray, FloatArray]:
        """Slopes (columns, words), and mean x . slopes (words,): what constants lack to mean y."""
        mean_v, mean_y = self.vectors / self.n, self.targets / self.n
        matrix = self.gram - self.n * np.outer(mean_v, mean_v) + ridge * np.eye(len(mean_v))
        goal = self.cross - self.n * np.outer(mean_v, mean_y)
        with one_blas_thread():  # sums of several threads differ in their last bits
            slopes = np.linalg.solve(matrix, goal).astype(np.float64, copy=False)
        # one order of summation: a matrix product's last bits depend on the number of threads
        return slopes, np.asarray(np.einsum("i,ij->j", mean_v, slopes, optimize=False))


def sum_rows(vectors: FloatArray, targets: FloatArray, weights: FloatArray) -> Sums:
    """Sums of rows: `vectors` (n, columns); `targets` (n, words); `weights` (n,)."""
    weighted = (vectors * weights[:, None]).T
    return Sums(
        float(weights.sum()),
        weights @ vectors,
        weights @ targets,
        weighted @ vectors,
        weighted @ targets,
    )


def by_fields(operation: Callable[[object, object], object], one: T, other: T) -> T:
    """An operation on the fields of two records; None where a field of either is None."""
    pairs = zip(vars(one).values(), vars(other).values())
    return type(one)(*(None if a is None or b is None else operation(a, b) for a, b in pairs))


@dataclass(frozen=True, eq=False)
class Regression:
    """What of a regression does not depend on its targets."""

    rows: FloatArray  # (n, columns): features less their mean, times the roots of the weights
    roots: FloatArray  # (n, 1): roots of the weights
    centre: FloatArray  # (columns,): weighted mean of the features
    gram: FloatArray  # (columns, columns): sum of products of ``rows``, with the ridge
    inverse: FloatArray  # (columns, columns): its inverse A

    def fit(self, target: FloatArray) -> Fitted:
        """The regression with targets (n, words)."""
        weights = self.roots[:, 0] ** 2
        mean = weights @ target / weights.sum()
        centred = self.roots * (target - mean)
        slopes = self.inverse @ (self.rows.T @ centred)
        return Fitted(self, mean, slopes, centred - self.rows @ slopes)


@dataclass(frozen=True, eq=False)
class Fitted:
    """A regression with its targets."""

    regression: Regression
    mean: FloatArray  # (words,): weighted mean of the targets
    slopes: FloatArray  # (columns, words)
    residuals: FloatArray  # (n, words): times the roots of the weights

    def errors(self, which: IntArray | slice) -> FloatArray:
        """Residuals of some rows by the regression without them, times the roots."""
        all_of_it = self.regression
        rows = all_of_it.rows[which]
        return residuals_without(rows, all_of_it.gram, all_of_it.inverse, self.residuals[which])

    def without(self, which: IntArray | slice) -> FloatArray:
        """Slopes (columns, words) without some rows; the means stay those of all rows."""
        back = self.regression.rows[which].T @ self.errors(which)
        return np.asarray(self.slopes - self.regression.inverse @ back)


def prepare(vectors: FloatArray, weights: FloatArray, ridge: float) -> Regression:
    """The regression on `vectors` (n, columns) with `weights` (n,)."""
    roots = np.sqrt(weights)[:, None]
    centre = weights @ vectors / weights.sum()
    rows = (vectors - centre) * roots
    gram = rows.T @ rows + ridge * np.eye(vectors.shape[1])
    inverse = np.asarray(np.linalg.inv(gram), dtype=np.float64)
    return Regression(rows, roots, np.asarray(centre), gram, inverse)


def residuals_without(
    rows: FloatArray, gram: FloatArray, inverse: FloatArray, residuals: FloatArray
) -> FloatArray:
    """Residuals of rows by the regression without them, from those with all rows: (n, words).

    Shapes: `rows` (n, columns); `gram`, `inverse` (columns, columns); `residuals` (n, words).
    """
    if len(rows) > rows.shape[1]:  # the smaller system
        back = np.linalg.solve(gram - rows.T @ rows, rows.T @ residuals)
        return np.asarray(residuals + rows @ back)
    block = rows @ inverse @ rows.T
    return np.asarray(np.linalg.solve(np.eye(len(rows)) - block, residuals))


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
