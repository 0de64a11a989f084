"""A linear map from score vectors to words, calibrated to probabilities.

Notation: v the score vector of an interval of motion (:mod:`.score_vectors`), y_w = 1 where word
w was written about it. The evidence for w is z_w = v . u_w + c_w, by ridge regression of
y - mean(y) on v. It is additive over symbols and over segments, so that every score can be
decomposed exactly. The ridge is the largest one whose ranking of held-out groups, of words for
intervals and of intervals for words, is nearly as good as the best. (The squared error would select
a larger ridge, under which rare words become indistinguishable.) One logistic map for all words,
because a rare word has too few examples for its own, turns held-out predictions into probabilities:

    P(w) = sigmoid(a z_w / sd_w + b logit(prior_w) + c),    sd_w = (prior_w (1 - prior_w))^(1/4).

It is fitted to predictions without the whole group (performer) and to predictions with other
captures of the group, half and half, because queries of both kinds occur; only to words of two or
more groups, as a word of a single performer cannot be learned from the others.

**Sums from which a capture can be removed.** Ridge regression needs n, sum v, sum y, sum v v' and
sum v y' only. The values of v are rounded to multiples of 2^-16, so that their products are
multiples of 2^-32 and every sum over up to two million intervals is exact in floating point: adding
a capture and removing it, in any order, restores exactly the same sums.

Source: ridge regression was chosen in early experiments; ``docs/measured/quality.md`` compares it
with other maps ("Words to motion"); Platt (1999) for the logistic map.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.regression import (
    Additive,
    Sums,
    calibrate,
    fit_ridge,
    left_out,
    probability,
    shared_words,
)
from motiondb.records import LARGEST, Axes, FloatArray, IntArray, Within

RIDGES = (0.1, 0.3, 1.0)  # Ridges to choose from; vectors have length 1
SPREAD_POWER = 0.25
"""Power of a word's variance by which its evidence is divided. 0.5 would give all words evidence of
equal spread, which ranks rare words too high."""
TOLERANCE = 0.06
"""The largest ridge whose precision is within this share of the best is taken.
``docs/measured/quality.md`` ("Words to motion") describes the comparison of ridges."""


@dataclass(frozen=True, eq=False)
class WordMap:
    """A calibrated linear map from vectors to words."""

    weights: FloatArray  # (symbols, words): u
    offsets: FloatArray  # (words,): c
    priors: FloatArray  # (words,): share of the described intervals with each word
    spreads: FloatArray  # (words,): sd
    calibration: FloatArray  # (3,): a, b and c of the logistic map
    ridge: float = field(default=1.0, kw_only=True)  # The ridge of the fit

    def with_words(
        self, weights: FloatArray, offsets: FloatArray, priors: FloatArray, spreads: FloatArray
    ) -> WordMap:
        """The map with further words behind those that it has."""
        return WordMap(
            np.concatenate([self.weights, weights], axis=1),
            np.concatenate([self.offsets, offsets]),
            np.concatenate([self.priors, priors]),
            np.concatenate([self.spreads, spreads]),
            self.calibration,
            ridge=self.ridge,
        )

    def evidence(self, vectors: FloatArray) -> FloatArray:
        """Evidence z (n, words) of score vectors (n, symbols), before calibration."""
        return vectors @ self.weights + self.offsets

    def log_odds(self, vectors: FloatArray) -> FloatArray:
        """Calibrated log-odds (n, words) that the captions of each interval have a word."""
        a, b, c = self.calibration
        return a * self.evidence(vectors) / self.spreads + b * logit(self.priors) + c

    def linear(self, word: int) -> tuple[FloatArray, float]:
        """Slope (symbols,) and constant of one word: log-odds = vector . slope + constant."""
        a, b, c = self.calibration
        scale = float(a / self.spreads[word])
        prior = float(b * logit(self.priors[word : word + 1])[0] + c)
        return scale * self.weights[:, word], scale * float(self.offsets[word]) + prior

    def probabilities(self, vectors: FloatArray) -> FloatArray:
        """Calibrated probabilities (n, words)."""
        return probability(self.log_odds(vectors))


def fit_word_map(vectors: FloatArray, presence: NDArray[np.bool_], groups: IntArray) -> WordMap:
    """Fit the map and its calibration, and choose the ridge.

    Shapes: `vectors` (n, symbols); `presence` (n, words); `groups` (n,).
    """
    return map_words(vectors, presence, *choose_ridge_and_calibration(vectors, presence, groups))


def choose_ridge_and_calibration(
    vectors: FloatArray, presence: NDArray[np.bool_], groups: IntArray
) -> tuple[float, FloatArray]:
    """Ridge and calibration (3,) of the map; parameters as of :func:`fit_word_map`."""
    target = presence.astype(np.float64)
    priors = word_priors(target)
    if len(np.unique(groups)) < 2:
        groups = np.arange(len(vectors)) % 5
    held_out = dict(zip(RIDGES, left_out(vectors, target, groups, RIDGES)))
    shared = shared_words(presence, groups)
    ridge = largest_good_ridge(held_out, presence, shared)
    spreads = word_spreads(priors)
    (known_group,) = left_out(vectors, target, np.arange(len(vectors)) % 10, [ridge])
    both = np.concatenate([held_out[ridge], known_group])[:, shared] - target.mean(axis=0)[shared]
    twice = np.concatenate([target, target])[:, shared]
    logits = np.broadcast_to(logit(priors[shared]), both.shape)
    return ridge, calibrate(both / spreads[shared], logits, twice)


def largest_good_ridge(
    predicted: Mapping[float, FloatArray], presence: NDArray[np.bool_], which: NDArray[np.bool_]
) -> float:
    """The largest ridge whose predictions (n, words) of some words rank nearly best."""
    reached = {r: precision(z[:, which], presence[:, which]) for r, z in predicted.items()}
    return max(r for r, p in reached.items() if p >= (1.0 - TOLERANCE) * max(reached.values()))


def map_words(
    vectors: FloatArray, presence: NDArray[np.bool_], ridge: float, calibration: FloatArray
) -> WordMap:
    """Fit the map with a given ridge and calibration.

    Shapes: `vectors` (n, symbols); `presence` (n, words); `calibration` (3,).
    """
    target = presence.astype(np.float64)
    weights, offsets = fit_ridge(vectors, target, ridge)
    priors = word_priors(target)
    return WordMap(
        weights,
        offsets - target.mean(axis=0),
        priors,
        word_spreads(priors),
        calibration,
        ridge=ridge,
    )


def word_priors(target: FloatArray) -> FloatArray:
    """Share of the intervals (rows) with each word, kept away from 0 and 1."""
    least = 0.5 / max(len(target), 1)
    return np.asarray(np.clip(target.mean(axis=0), least, 1.0 - least))


def word_spreads(priors: FloatArray) -> FloatArray:
    """sd_w of the module's docstring."""
    return np.asarray((priors * (1.0 - priors)) ** SPREAD_POWER)


def precision(predicted: FloatArray, presence: NDArray[np.bool_]) -> float:
    """Mean average precision of the ranking of intervals for words and of words for intervals.

    Rows and columns without a true pair are left out; the result is 0 if all are.

    Shapes: `predicted`, `presence` (n, words).

    >>> said = np.array([[True, False], [True, False]])
    >>> round(precision(np.array([[0.1, 0.9], [0.3, 0.2]]), said), 3)
    0.875
    """
    means = []
    for scores, said in ((predicted, presence), (predicted.T, presence.T)):
        order = np.argsort(-scores, axis=0, kind="stable")
        hits = np.take_along_axis(said, order, axis=0)
        running = np.cumsum(hits, axis=0) / np.arange(1, len(hits) + 1)[:, None]
        n_said = hits.sum(axis=0)
        each = (running * hits).sum(axis=0)[n_said > 0] / n_said[n_said > 0]
        means.append(float(each.mean()) if len(each) else 0.0)
    return float(np.mean(means))


def calibration_information(fit: WordMap, vectors: FloatArray) -> FloatArray:
    """Fisher information of the calibration over some intervals and all words: array (3, 3).

    Shapes: `vectors` (n, symbols).
    """
    z = fit.evidence(vectors) / fit.spreads
    logits = np.broadcast_to(logit(fit.priors), z.shape)
    x = np.stack([z.ravel(), logits.ravel(), np.ones(z.size)], axis=1)
    p = fit.probabilities(vectors).ravel()
    information: FloatArray = (x * (p * (1.0 - p))[:, None]).T @ x
    return information


def logit(p: FloatArray) -> FloatArray:
    """Log-odds of probabilities."""
    return np.log(p) - np.log1p(-p)


_GRAIN = 2.0**16  # vectors are rounded to multiples of its reciprocal, see the module


@dataclass(frozen=True, eq=False)
class CaptionMoments(Additive):
    """Sums over described intervals for :mod:`motiondb.meaning.caption_map`."""

    words: Annotated[
        FloatArray, Axes("words")
    ]  # Sum of t, the words of an interval as a vector of length 1
    cross: Annotated[FloatArray, Axes("columns", "words")]  # Sum of v t'


@dataclass(frozen=True, eq=False)
class WordMoments(Additive):
    """Sums over described intervals."""

    n: Annotated[float, Within(1, LARGEST, "at least one described interval")]
    vectors: Annotated[FloatArray, Axes("columns")]  # Sum of v
    words: Annotated[FloatArray, Axes("words")]  # Sum of y
    gram: Annotated[FloatArray, Axes("columns", symmetric=True)]  # Sum of v v'
    cross: Annotated[FloatArray, Axes("columns", "words")]  # Sum of v y'
    captions: CaptionMoments  # For whole captions

    def of_words(self, which: IntArray | NDArray[np.bool_]) -> WordMoments:
        """The sums of some words alone."""
        captions = CaptionMoments(self.captions.words[which], self.captions.cross[:, which])
        return replace(self, words=self.words[which], cross=self.cross[:, which], captions=captions)

    def solve(
        self, of: WordMoments | CaptionMoments, ridge: float
    ) -> tuple[FloatArray, FloatArray]:
        """Slopes (columns, words) of the regression of y, or of t, on v, and mean v . slopes."""
        n = max(self.n, 1.0)
        return Sums(n, self.vectors, of.words, self.gram, of.cross).solve(ridge)


def word_moments(vectors: FloatArray, presence: NDArray[np.bool_]) -> WordMoments:
    """Compute the sums over some intervals; `vectors` (n, symbols); `presence` (n, words).

    >>> m = word_moments(np.array([[0.6, 0.8]]), np.array([[True, False]]))
    >>> m.n, m.cross.round(3).tolist()
    (1.0, [[0.6, 0.0], [0.8, 0.0]])
    """
    v = np.round(np.asarray(vectors, dtype=np.float64) * _GRAIN) / _GRAIN
    y = presence.astype(np.float64)
    length = np.sqrt(np.maximum(y.sum(axis=1, keepdims=True), 1.0))
    t = np.round(y / length * _GRAIN) / _GRAIN
    return WordMoments(
        float(len(v)),
        v.sum(axis=0),
        y.sum(axis=0),
        v.T @ v,
        v.T @ y,
        CaptionMoments(t.sum(axis=0), v.T @ t),
    )


def solve_word_map(moments: WordMoments, ridge: float, calibration: FloatArray) -> WordMap:
    """Word map from sums, with a given ridge and `calibration` (3,)."""
    n = max(moments.n, 1.0)
    mean_y: FloatArray = moments.words / n
    weights, shift = moments.solve(moments, ridge)
    priors = np.clip(mean_y, 0.5 / n, 1.0 - 0.5 / n)
    spreads = word_spreads(priors)
    return WordMap(weights, -shift, priors, spreads, calibration, ridge=ridge)


def clearest(words: WordMap, vector: FloatArray, which: NDArray[np.bool_]) -> float:
    """Largest log-odds among some words for one vector; 0 if there are no words.

    Shapes: `vector` (columns,); `which` (words,).
    """
    if not which.any():
        return 0.0
    return float(np.max(words.log_odds(vector[None])[0][which]))


def usual(words: WordMap) -> FloatArray:
    """Log-odds of every word without evidence from motion: array (words,)."""
    _, share, constant = words.calibration
    odds: FloatArray = share * logit(words.priors) + constant
    return odds
