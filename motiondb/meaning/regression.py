"""One regression for every map from motion to words, and one calibration of its answers.

**Ridge regression.** Each map is one:

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
judge              windows of 3 s              kernels of pooled     1 / sqrt(actions) for each word
                                               statistics
unplaced           windows of segments         vectors of windows    the words of the whole take
=================  ==========================  ====================  ===============================

The first four weigh every described interval alike or by performer, the others every take by the
root of its length. Predictions that calibrations are fitted to leave out the performer, or the
take, itself. With x_i, y_i and w_i the features, targets and weight of a row, and means over all
rows by their weights, the slopes minimise

    sum_i w_i |y_i - mean y - (x_i - mean x) . slopes|^2 + ridge |slopes|^2.

Rows are left out in one of two ways: by another fit (:func:`left_out`) or, where the means may
stay, from the residuals with all rows (:meth:`Fitted.without`). With X the rows left out, A the
inverse of the sum of products with the ridge, H = X A X' and e their residuals with all rows, those
without them are (I - H)^-1 e.

**Calibrated probabilities of answers.** Cues x_1 ... x_n of an answer (such as its similarity) give
the probability that it is right by

    P(right) = sigmoid(w . x + c),    every w >= 0,

logistic regression on answers that are known to be right or wrong. A ridge on w, in units of the
cues' standard deviations, gives weight 0 to a cue without information. The same queries are
repeated with all right answers removed: the threshold below which nothing matches is the value of
the best answer that separates the two cases with the largest balanced accuracy.

Source: Platt, Probabilistic outputs for support vector machines (1999).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray

from motiondb.records import Axes, Float32Array, FloatArray, IntArray, MayBeUnknown, Sizes
from motiondb.symbols.hmm_jobs import one_blas_thread

AT_ONCE = 2**11  # Rows in ``blocks``
SMALLER = 0.4  # Rows a column from which the system of the columns takes less work to solve
ANSWERS_AT_ONCE = 2**16  # Rows of a logistic regression that are looked at together
PARTS_AT_ONCE = 2**9  # Rows of the parts that are left out together, unless one has more


def fit_ridge(
    vectors: FloatArray, target: FloatArray, ridge: float, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Slopes (columns, words) and constants (words,); every row weighs 1 without `weights`.

    Shapes: `vectors` (n, columns); `target` (n, words); `weights` (n,).
    """
    (fitted,) = fit_ridges(vectors, target, [ridge], weights)
    return fitted


def fit_ridges(
    vectors: FloatArray,
    target: FloatArray,
    ridges: Sequence[float],
    weights: FloatArray | None = None,
) -> list[tuple[FloatArray, FloatArray]]:
    """As :func:`fit_ridge`, for several ridges: the products of the rows are computed once."""
    if weights is None:
        mean_v, mean_y, root = vectors.mean(axis=0), target.mean(axis=0), np.ones((len(vectors), 1))
    else:
        mean_v, mean_y = weights @ vectors / weights.sum(), weights @ target / weights.sum()
        root = np.sqrt(weights)[:, None]
    if len(vectors) < vectors.shape[1]:  # the dual solution, whose matrix is smaller
        v, y = root * (vectors - mean_v), root * (target - mean_y)
        gram, eye = v @ v.T, np.eye(len(v))
        slopes = [v.T @ np.linalg.solve(gram + ridge * eye, y) for ridge in ridges]
    else:
        gram, eye = np.zeros((len(mean_v),) * 2), np.eye(len(mean_v))
        cross = np.zeros((len(mean_v), len(mean_y)))
        for first in range(0, len(vectors), PARTS_AT_ONCE):
            some = slice(first, first + PARTS_AT_ONCE)
            v, y = root[some] * (vectors[some] - mean_v), root[some] * (target[some] - mean_y)
            gram += v.T @ v
            cross += v.T @ y
        slopes = [np.linalg.solve(gram + ridge * eye, cross) for ridge in ridges]
    return [(each, mean_y - mean_v @ each) for each in slopes]


class Additive:
    """A record whose sums and differences are those of its fields; None where one of two is."""

    def __add__(self, other: Self) -> Self:
        return self._by_fields(operator.add, other)

    def __sub__(self, other: Self) -> Self:
        return self._by_fields(operator.sub, other)

    def _by_fields(self, operation: Callable[[object, object], object], other: Self) -> Self:
        pairs = zip(vars(self).values(), vars(other).values())
        return type(self)(*(None if a is None or b is None else operation(a, b) for a, b in pairs))


@dataclass(frozen=True, eq=False)
class Sums:
    """Weighted sums over rows."""

    n: float  # Sum of the weights
    vectors: FloatArray  # (columns,): sum of x
    targets: FloatArray  # (words,): sum of y
    gram: FloatArray  # (columns, columns): sum of x x'
    cross: FloatArray  # (columns, words): sum of x y'

    def solve(self, ridge: float) -> tuple[FloatArray, FloatArray]:
        """Slopes (columns, words), and mean x . slopes (words,): what constants lack to mean y."""
        mean_v, mean_y = self.vectors / self.n, self.targets / self.n
        matrix = self.gram - self.n * np.outer(mean_v, mean_v) + ridge * np.eye(len(mean_v))
        goal = self.cross - self.n * np.outer(mean_v, mean_y)
        with one_blas_thread():  # sums of several threads differ in their last bits
            slopes = np.linalg.solve(matrix, goal).astype(np.float64, copy=False)
        # one order of summation: a matrix product's last bits depend on the number of threads
        return slopes, np.asarray(np.einsum("i,ij->j", mean_v, slopes, optimize=False))


@dataclass(frozen=True, eq=False)
class MadeRows:
    """Rows that are made, some groups at a time, where they are looked at."""

    bounds: IntArray  # (groups + 1,): group n has the rows from bounds[n] to bounds[n + 1]
    make: Callable[[Sequence[int]], FloatArray]  # Numbers of groups, rising -> all their rows

    def __len__(self) -> int:
        return int(self.bounds[-1])

    def __getitem__(self, which: IntArray | slice) -> FloatArray:
        numbers = np.arange(len(self))[which]
        if not len(numbers):
            return self.make([0])[:0]
        groups = np.searchsorted(self.bounds, numbers, side="right") - 1
        looked_at, place = np.unique(groups, return_inverse=True)
        firsts = np.cumsum([0, *np.diff(self.bounds)[looked_at]])[:-1]
        return self.make(looked_at.tolist())[numbers - self.bounds[groups] + firsts[place]]


@dataclass(frozen=True, eq=False)
class Regression:
    """What of a regression does not depend on its targets."""

    # (n, columns): features less their mean, times the roots of the weights
    rows: FloatArray | Float32Array | MadeRows
    roots: FloatArray  # (n, 1): roots of the weights
    centre: FloatArray  # (columns,): weighted mean of the features
    gram: FloatArray  # (columns, columns): sum of products of ``rows``, with the ridge
    inverse: FloatArray  # (columns, columns): its inverse A

    def fit(self, target: FloatArray) -> Fitted:
        """The regression with targets (n, words)."""
        weights = self.roots[:, 0] ** 2
        mean = weights @ target / weights.sum()
        centred = _Centred(self.roots, target, mean)
        cross = np.zeros((len(self.centre), target.shape[1]))
        for some in blocks(len(target)):
            cross += self.rows[some].astype(np.float64).T @ centred[some]
        return Fitted(self, mean, self.inverse @ cross, centred)

    def apart(self, which: slice) -> FloatArray | None:
        """I - H of some rows, which no target changes; None where a smaller system is solved."""
        rows = self.rows[which].astype(np.float64)
        return None if len(rows) > rows.shape[1] else without_share(rows, self.inverse)

    def centred(self, target: MadeRows, mean: FloatArray) -> MadeRows:
        """Targets less their mean, times the roots of the weights."""

        def make(groups: Sequence[int]) -> FloatArray:
            own = [self.roots[target.bounds[n] : target.bounds[n + 1]] for n in groups]
            return np.asarray(np.concatenate(own) * (target.make(groups) - mean))

        return MadeRows(target.bounds, make)


@dataclass(frozen=True, eq=False)
class _Centred:
    """Targets less their mean, times the roots of the weights, made where they are looked at."""

    roots: FloatArray
    target: FloatArray
    mean: FloatArray

    def __getitem__(self, which: IntArray | slice) -> FloatArray:
        return np.asarray(self.roots[which] * (self.target[which] - self.mean))


@dataclass(frozen=True, eq=False)
class Fitted:
    """A regression with its targets."""

    regression: Regression
    mean: FloatArray  # (words,): weighted mean of the targets
    slopes: FloatArray  # (columns, words)
    centred: _Centred | MadeRows  # (n, words): targets less their mean, times the roots

    def of_others(self, which: IntArray | slice, apart: FloatArray | None = None) -> FloatArray:
        """Predictions for some rows by the regression without them, centred, times the roots.

        `apart`: What :meth:`Regression.apart` gave for them.
        """
        centred = self.centred[which]
        rows = np.asarray(self.regression.rows[which], dtype=np.float64)
        return centred - self._errors(rows, centred, apart)

    def without(self, which: IntArray) -> FloatArray:
        """Slopes (columns, words) without some rows; the means stay those of all rows."""
        if len(which) <= len(self.slopes):  # the smaller system
            rows = np.asarray(self.regression.rows[which], dtype=np.float64)
            back = rows.T @ self._errors(rows, self.centred[which])
            return np.asarray(self.slopes - self.regression.inverse @ back)
        gram = self.regression.gram.copy()
        cross = gram @ self.slopes
        for some in blocks(len(which)):
            rows = np.asarray(self.regression.rows[which[some]], dtype=np.float64)
            gram -= rows.T @ rows
            cross -= rows.T @ self.centred[which[some]]
        return np.asarray(np.linalg.solve(gram, cross), dtype=np.float64)

    def left_out(
        self, parts: Sequence[slice], apart: Sequence[FloatArray | None] | None = None
    ) -> FloatArray:
        """As :meth:`of_others`, of parts that follow one another, each without itself alone."""
        begin, known = parts[0].start, apart or [None] * len(parts)
        found = np.empty((parts[-1].stop - begin, self.slopes.shape[1]))
        gram, inverse = self.regression.gram, self.regression.inverse
        for some, inside in together(parts):
            rows = np.asarray(self.regression.rows[inside], np.float64)
            centred, low = self.centred[inside], inside.start
            residuals = centred - rows @ self.slopes
            for part, own in zip(parts[some], known[some]):
                a, b = part.start - low, part.stop - low
                left = residuals_without(rows[a:b], gram, inverse, residuals[a:b], own)
                found[part.start - begin : part.stop - begin] = centred[a:b] - left
        return found

    def _errors(
        self, rows: FloatArray, centred: FloatArray, apart: FloatArray | None = None
    ) -> FloatArray:
        gram, inverse = self.regression.gram, self.regression.inverse
        return residuals_without(rows, gram, inverse, centred - rows @ self.slopes, apart)


def prepare(
    vectors: FloatArray | Float32Array,
    weights: FloatArray,
    ridge: float,
    *,
    overwrite: bool = False,
) -> Regression:
    """The regression on `vectors` (n, columns) with `weights` (n,); sums are of double precision.

    `overwrite`: Whether ``vectors`` may become the rows; of hours of motion they are large.
    """
    roots = np.sqrt(weights)[:, None]
    total = np.zeros(vectors.shape[1])
    for some in blocks(len(vectors)):
        total += weights[some] @ vectors[some].astype(np.float64)
    centre = total / weights.sum()
    rows = vectors if overwrite else vectors.copy()
    gram = ridge * np.eye(vectors.shape[1])
    for some in blocks(len(rows)):
        rows[some] = roots[some] * (rows[some] - centre)
        block = rows[some].astype(np.float64)
        gram += block.T @ block
    inverse = np.asarray(np.linalg.inv(gram), dtype=np.float64)
    return Regression(rows, roots, np.asarray(centre), gram, inverse)


def blocks(n_rows: int) -> list[slice]:
    """Rows that are looked at together, which bounds memory."""
    return [slice(first, first + AT_ONCE) for first in range(0, n_rows, AT_ONCE)]


def together(parts: Sequence[slice]) -> Iterator[tuple[slice, slice]]:
    """Runs of parts that are looked at together, and their rows; products of many are quicker."""
    first = 0
    while first < len(parts):
        low, last = parts[first].start, first + 1
        while last < len(parts) and parts[last].stop - low <= PARTS_AT_ONCE:
            last += 1
        yield slice(first, last), slice(low, parts[last - 1].stop)
        first = last


def without_share(rows: FloatArray, inverse: FloatArray) -> FloatArray:
    """I - H of the module's docstring: array (n, n); `rows` (n, columns)."""
    return np.asarray(np.eye(len(rows)) - rows @ inverse @ rows.T)


def residuals_without(
    rows: FloatArray,
    gram: FloatArray,
    inverse: FloatArray,
    residuals: FloatArray,
    apart: FloatArray | None = None,
) -> FloatArray:
    """Residuals of rows by the regression without them, from those with all rows: (n, words).

    Shapes: `rows` (n, columns); `gram`, `inverse` (columns, columns); `residuals` (n, words).

    `apart`: I - H of the rows, where it is known.
    """
    if apart is None and len(rows) > SMALLER * rows.shape[1]:
        back = np.linalg.solve(gram - rows.T @ rows, rows.T @ residuals)
        return np.asarray(residuals + rows @ back)
    apart = without_share(rows, inverse) if apart is None else apart
    return np.asarray(np.linalg.solve(apart, residuals))


def shared_words(presence: NDArray[np.bool_], groups: IntArray) -> NDArray[np.bool_]:
    """Words of two or more groups; all words if there are none: array (words,).

    Shapes: `presence` (n, words); `groups` (n,).
    """
    said = [presence[groups == group].any(axis=0) for group in np.unique(groups)]
    shared: NDArray[np.bool_] = np.sum(said, axis=0) > 1
    return shared if shared.any() else np.ones_like(shared)


def left_out(
    vectors: FloatArray, target: FloatArray, groups: IntArray, ridges: Sequence[float]
) -> list[FloatArray]:
    """For each ridge, the target of every interval by the map without its group: (n, words).

    Shapes: `vectors` (n, symbols); `target` (n, words); `groups` (n,).
    """
    predicted = [np.zeros_like(target) for _ in ridges]
    for group in np.unique(groups):
        test = groups == group
        if test.all():
            for each in predicted:
                each[test] = target.mean(axis=0)
            continue
        fitted = fit_ridges(vectors[~test], target[~test], ridges)
        for each, (weights, offsets) in zip(predicted, fitted):
            each[test] = vectors[test] @ weights + offsets
    return predicted


_RIDGE = 1.0  # chosen by hand; not tuned
_LEAST_PRECISION = 1e-3  # of the prior of other coefficients, so that there is one solution
_ROUNDS = 100  # largest number of Newton steps; a few suffice


@dataclass(frozen=True, eq=False)
class Certainty:
    """A calibration of answers."""

    weights: Annotated[FloatArray, Axes("cues")]  # w, at least 0
    constant: float
    # Value of the best answer below which nothing matches; NaN where it is unknown
    threshold: Annotated[float, MayBeUnknown]

    def log_odds(self, cues: FloatArray) -> FloatArray:
        """Calibrated log-odds (...,) of cues (..., cues)."""
        # a matrix product's last bits depend on how many answers there are
        return np.asarray(np.add.reduce(cues * self.weights, axis=-1) + self.constant)


@dataclass(frozen=True)
class KindCertainty:
    """Certainty of answers to one kind of question."""

    whole: Certainty | None = None  # Certainty that all of the question holds
    # Certainty that the capture shows the action that the answer shows
    part: Certainty | None = None


def kind_cues(asked: float, excluded: float | None) -> FloatArray:
    """Cues of an answer: array (1,) or, where something is excluded, array (2,)."""
    return np.array([asked] if excluded is None else [asked, -excluded])


@dataclass(frozen=True)
class Certainties:
    """Certainty of answers; None if there are too few captions."""

    words: Annotated[Certainty | None, Sizes({"cues": 1})] = None  # Of an answer to words
    example: Annotated[Certainty | None, Sizes({"cues": 2})] = None  # Of an answer to an example
    # Certainty of the interval of an action, given that the capture shows the action, and several
    # actions (:mod:`motiondb.meaning.place_certainty`)
    place: Annotated[Certainty | None, Sizes({"cues": 8})] = None
    # That a capture shows an action throughout, where ``place`` was learned
    single: Annotated[Certainty | None, Sizes({"cues": 6})] = None
    # Of an answer to one action but not another
    without: Annotated[KindCertainty, Sizes({"cues": 2})] = field(default_factory=KindCertainty)
    # Of an answer to one of several actions
    either: Annotated[KindCertainty, Sizes({"cues": 1})] = field(default_factory=KindCertainty)


def probability(log_odds: FloatArray | float) -> FloatArray:
    """Probability of log-odds.

    >>> probability(np.array([0.0, np.log(3.0)])).round(3).tolist()
    [0.5, 0.75]
    """
    bounded = np.minimum(np.maximum(log_odds, -50.0), 50.0)  # np.clip takes six times as long
    return np.asarray(1.0 / (1.0 + np.exp(-bounded)))


def answer_probability(asked: Sequence[float], excluded: Sequence[Sequence[float]]) -> float:
    """Probability that an answer shows all requested actions and no exclusion, if independent.

    `asked`, `excluded`: The probability of each requested action, and of each one of every
    exclusion, which holds if all of its actions are shown.

    >>> answer_probability([0.5], [[0.5, 0.5]])
    0.375
    """
    return math.prod(asked) * math.prod(1.0 - math.prod(actions) for actions in excluded)


def fit_logistic(
    x: FloatArray,
    y: FloatArray,
    start: FloatArray,
    precision: FloatArray,
    counts: FloatArray | None = None,
    n_positive: int = 0,
) -> FloatArray:
    """Coefficients of logistic regression with a normal prior around `start`: array (columns,).

    Newton's method, whose steps are projected so that the first `n_positive` coefficients stay at
    least 0.

    Shapes: `x` (n, columns); `y`, `counts` (n,); `start` (columns,); `precision` (columns,
    columns).
    """
    n = np.ones(len(x)) if counts is None else counts
    positive = np.arange(x.shape[1]) < n_positive
    beta = start.copy()
    for _ in range(_ROUNDS):
        gradient, curvature = precision @ (start - beta), precision.copy()
        for first in range(0, len(x), ANSWERS_AT_ONCE):  # of hours of captions x is large
            some = slice(first, first + ANSWERS_AT_ONCE)
            p = probability(x[some] @ beta)
            gradient += x[some].T @ (n[some] * (y[some] - p))
            curvature += (x[some] * (n[some] * p * (1.0 - p))[:, None]).T @ x[some]
        free = ~(positive & (beta <= 0.0) & (gradient <= 0.0))
        step = np.zeros_like(beta)
        step[free] = np.linalg.solve(curvature[np.ix_(free, free)], gradient[free])
        new = beta + step / max(1.0, float(np.abs(step).max()))
        new[positive] = np.maximum(new[positive], 0.0)
        if np.abs(new - beta).max() < 1e-9:
            break
        beta = new
    return beta


def fit_probability(
    cues: FloatArray, right: NDArray[np.bool_], counts: FloatArray | None = None
) -> tuple[FloatArray, float]:
    """Weights and constant of the module's formula.

    Shapes: `cues` (answers, cues); `right`, `counts` (answers,); result (cues,).
    """
    n = np.ones(len(cues)) if counts is None else counts
    centre = n @ cues / n.sum()
    spread = np.sqrt(n @ (cues - centre) ** 2 / n.sum())
    spread = np.where(spread > 1e-9, spread, 1.0)
    x = np.column_stack([(cues - centre) / spread, np.ones(len(cues))])
    precision = np.diag([*np.full(cues.shape[1], _RIDGE), _LEAST_PRECISION])
    y, start = right.astype(np.float64), np.zeros(x.shape[1])
    beta = fit_logistic(x, y, start, precision, n, n_positive=cues.shape[1])
    weights = beta[:-1] / spread
    return weights, float(beta[-1] - weights @ centre)


def calibrate(
    z: FloatArray,
    logits: FloatArray,
    target: FloatArray,
    centre: FloatArray | None = None,
    information: FloatArray | None = None,
) -> FloatArray:
    """Logistic regression of presence on evidence and the prior's logit.

    Shapes: `z`, `logits`, `target` (n, words); `centre`, result (3,); `information` (3, 3).
    """
    x = np.stack([z.ravel(), logits.ravel(), np.ones(z.size)], axis=1)
    start = np.array([1.0, 1.0, 0.0]) if centre is None else np.asarray(centre, dtype=np.float64)
    precision = _LEAST_PRECISION * np.eye(3) + (0.0 if information is None else information)
    beta = fit_logistic(x, target.ravel().astype(np.float64), start, precision)
    beta[0] = max(beta[0], 0.05)
    return beta


def separate(present: FloatArray, absent: FloatArray) -> float:
    """Threshold of largest balanced accuracy; NaN if one of the arrays is empty.

    Of several equally good thresholds, the middle one is returned. It lies between two observed
    values.

    Shapes: `present`, `absent` (queries,).

    >>> separate(np.array([0.9, 0.7, 0.4]), np.array([0.1, 0.5]))
    0.6
    """
    if not len(present) or not len(absent):
        return float("nan")
    values = np.unique(np.concatenate([present, absent]))
    middles = (values[:-1] + values[1:]) / 2.0
    middles = np.where(middles > values[:-1], middles, values[1:])  # where rounding gives the lower
    between = np.concatenate([values[:1], middles])
    accuracy = np.array([np.mean(present >= t) + np.mean(absent < t) for t in between])
    best = np.flatnonzero(accuracy >= accuracy.max() - 1e-12)
    return float(between[best[len(best) // 2]])
