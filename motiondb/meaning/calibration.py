"""Calibrated probabilities of answers, and the threshold below which nothing matches.

Cues x_1 ... x_n of an answer (such as its similarity) give the probability that it is right by

    P(right) = sigmoid(w . x + c),    every w >= 0,

logistic regression on answers that are known to be right or wrong. A ridge on w, in units of the
cues' standard deviations, gives weight 0 to a cue without information; no cue lowers the
probability. With a single cue the order of the answers is that of the cue.

*No match*: the same queries are repeated with all right answers removed. The threshold is the
value of the best answer that separates the two cases with the largest balanced accuracy.

Source: Platt, Probabilistic outputs for support vector machines (1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from motiondb.records import Axes, FloatArray, MayBeUnknown, Sizes

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
        odds: FloatArray = cues @ self.weights + self.constant
        return odds


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
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(log_odds, -50.0, 50.0))))


def answer_probability(
    sure: Certainty,
    asked: Sequence[tuple[float, float]],
    excluded: Sequence[Sequence[tuple[float, float]]],
) -> float:
    """Calibrated probability that an answer shows all requested actions and no excluded one.

    The product over the asked actions of the probability that each is shown, and over the
    exclusions of one minus the probability that all of their actions are.

    `asked`: For each action its log-odds, and the part of them that captions add, which is not
    calibrated.

    >>> sure = Certainty(np.array([1.0]), 0.0, 0.0)
    >>> answer_probability(sure, [(0.0, 0.0)], [[(0.0, 0.0)]])
    0.25
    """

    def shown(actions: Sequence[tuple[float, float]]) -> float:
        result = 1.0
        for log_odds, said in actions:
            by_motion = float(sure.log_odds(np.array([log_odds - said])))
            result *= float(probability(by_motion + said))
        return result

    result = shown(asked)
    for actions in excluded:
        result *= 1.0 - shown(actions)
    return result


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
        p = probability(x @ beta)
        gradient = x.T @ (n * (y - p)) - precision @ (beta - start)
        free = ~(positive & (beta <= 0.0) & (gradient <= 0.0))
        curvature = (x[:, free] * (n * p * (1.0 - p))[:, None]).T @ x[:, free]
        step = np.zeros_like(beta)
        step[free] = np.linalg.solve(curvature + precision[np.ix_(free, free)], gradient[free])
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
