"""How sure an answer is: a calibrated probability, and where "nothing here matches" begins.

Cues x_1 ... x_n of an answer (how alike, how clear) become the probability that it is right by

    P(right) = sigmoid(w . x + c),    every w >= 0,

logistic regression on answers of which it is known whether they were right, with a ridge on w in
units of the cues' spread, so that a cue that helps nobody gets no weight and none can count against
an answer. A probability never orders answers otherwise than a single cue does.

*Not here*: the same questions are asked again of what is left when everything right is taken out.
The threshold is the value of the best answer that tells the two apart with the largest balanced
accuracy: the mean of the shares of questions that are answered rightly, with and without.

Source: Platt, Probabilistic outputs for support vector machines (1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray
from motiondb.words.word_map import WordMap

_RIDGE = 1.0
_ROUNDS = 100


@dataclass(frozen=True, eq=False)
class Certainty:
    """weights : array (cues,), at least 0. constant : c of the module. threshold : value of the
    best answer below which nothing matches; NaN where it could not be told."""

    weights: FloatArray
    constant: float
    threshold: float

    def log_odds(self, cues: FloatArray) -> FloatArray:
        """Calibrated log-odds (...,) of cues (..., cues)."""
        found: FloatArray = cues @ self.weights + self.constant
        return found

    def pack(self) -> FloatArray:
        """One array: weights, constant, threshold; :func:`unpack` is the inverse."""
        return np.concatenate([self.weights, [self.constant, self.threshold]])


def unpack(numbers: FloatArray) -> Certainty:
    """The certainty that :meth:`Certainty.pack` wrote down."""
    return Certainty(np.asarray(numbers[:-2]), float(numbers[-2]), float(numbers[-1]))


def probability(log_odds: FloatArray | float) -> FloatArray:
    """The probability of log-odds.

    >>> probability(np.array([0.0, np.log(3.0)])).round(3).tolist()
    [0.5, 0.75]
    """
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(log_odds, -50.0, 50.0))))


def answer_probability(
    sure: Certainty,
    asked: Sequence[tuple[float, float]],
    excluded: Sequence[Sequence[tuple[float, float]]],
) -> float:
    """Calibrated probability that an answer shows all that is asked and nothing that is excluded.

    The product over the asked actions of the probability that each is shown, and over the
    exclusions of one minus the probability that all of their actions are.

    Parameters
    ----------
    sure : Certainty
        Of answers to words.
    asked : sequence of (float, float)
        Per action its log-odds, and what of them people's words add: these are not calibrated.
    excluded : sequence of sequences of (float, float)
        The same for the actions of every exclusion.

    >>> sure = Certainty(np.array([1.0]), 0.0, 0.0)
    >>> answer_probability(sure, [(0.0, 0.0)], [[(0.0, 0.0)]])
    0.25
    """

    def shown(actions: Sequence[tuple[float, float]]) -> float:
        result = 1.0
        for log_odds, said in actions:
            heard = float(sure.log_odds(np.array([log_odds - said])))
            result *= float(probability(heard + said))
        return result

    result = shown(asked)
    for actions in excluded:
        result *= 1.0 - shown(actions)
    return result


def fit_probability(cues: FloatArray, right: NDArray[np.bool_]) -> tuple[FloatArray, float]:
    """Weights and constant of the module's formula, by projected Newton steps.

    Parameters
    ----------
    cues : array (answers, cues). right : array (answers,).

    Returns
    -------
    weights : array (cues,), at least 0. constant : where no cue helps, the answers' own log-odds.
    """
    spread = cues.std(axis=0)
    spread = np.where(spread > 1e-9, spread, 1.0)
    centre = cues.mean(axis=0)
    x = np.column_stack([(cues - centre) / spread, np.ones(len(cues))])
    y = right.astype(np.float64)
    ridge = np.append(np.full(cues.shape[1], _RIDGE), 1e-3)
    beta = np.zeros(x.shape[1])
    for _ in range(_ROUNDS):
        p = probability(x @ beta)
        gradient = x.T @ (y - p) - ridge * beta
        held = np.append((beta[:-1] <= 0.0) & (gradient[:-1] <= 0.0), False)
        free = ~held
        hessian = (x[:, free] * (p * (1.0 - p))[:, None]).T @ x[:, free] + np.diag(ridge[free])
        step = np.zeros_like(beta)
        step[free] = np.linalg.solve(hessian, gradient[free])
        step /= max(1.0, float(np.abs(step).max()))
        new = np.append(np.maximum(beta[:-1] + step[:-1], 0.0), beta[-1] + step[-1])
        if np.abs(new - beta).max() < 1e-9:
            break
        beta = new
    weights = beta[:-1] / spread
    return weights, float(beta[-1] - weights @ centre)


def separate(present: FloatArray, absent: FloatArray) -> float:
    """The threshold of largest balanced accuracy; NaN where one of the two is empty.

    Of several that are as good the middle one; it lies between two values that occur.

    >>> separate(np.array([0.9, 0.7, 0.4]), np.array([0.1, 0.5]))
    0.6
    """
    if not len(present) or not len(absent):
        return float("nan")
    values = np.unique(np.concatenate([present, absent]))
    between = np.concatenate([values[:1], (values[:-1] + values[1:]) / 2.0])
    found = np.array([np.mean(present >= t) + np.mean(absent < t) for t in between])
    best = np.flatnonzero(found >= found.max() - 1e-12)
    return float(between[best[len(best) // 2]])


def clearest(words: WordMap, vector: FloatArray, which: NDArray[np.bool_]) -> float:
    """Log-odds of the likeliest of some words (which, array (words,)) in one vector (columns,)."""
    if not which.any():
        return 0.0
    return float(np.max(words.log_odds(vector[None])[0][which]))


def usual(words: WordMap) -> FloatArray:
    """Log-odds of every word where nothing speaks for or against it: array (words,)."""
    _, share, constant = words.calibration
    odds: FloatArray = share * (np.log(words.priors) - np.log1p(-words.priors)) + constant
    return odds
