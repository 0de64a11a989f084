"""Learn where in a take each word is shown, from captions without times.

A caption of a whole take says which actions happen somewhere in it. The times of the actions are
hidden. They are estimated together with a linear map from the motion of a segment to words:

    y_iw    probability that word w is shown at segment i (hidden; 1 where a caption of one action
            describes the segment),
    z_iw    (x_i . u_w + c_w) / sd_w, by ridge regression from the vector x_i of the segment to
            y_iw - mean(y_w), with sd_w = (mean (1 - mean))^(1/4); the prediction for each take
            uses the regression without this take.

Each round fits the map and then aligns the actions of each caption with the segments of its take
(:mod:`motiondb.meaning.listed_takes`), with ``SHARPNESS`` z as the evidence for a word. Each
round keeps the share ``DAMPING`` of the former y. Where a caption describes an interval, it gives y
of its words there (``ListedTakes.labelled``).

The map estimates where a word is shown. Whether a take shows the word at all is estimated by the
word map (:mod:`motiondb.meaning.word_map`), because here each segment is a row, and most rows
belong to a few long takes.

Source: multiple-instance learning in the manner of connectionist temporal classification (Graves
et al., 2006). The use of the order was measured on four long takes with true segments: the right
interval came first for .50 of 24 questions with the order, for .41 with the actions shuffled (mean
of four draws, .29 to .54), and for .33 with the order reversed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.listed_takes import ListedTakes, even_shares, place_actions
from motiondb.records import FloatArray, IntArray

RIDGE = 0.03
"""Ridge of the regression. Larger values reduce the differences within a take. Of .01 to .3, the
values .03 and .1 were the best on joined real captures (32 to 40 questions a draw, four draws: .52
and .53, a difference within chance)."""
SHARPNESS = 6.0
"""Nats per unit of z in one second. The values 6, 10 and 20 give similar results on joined real
captures: .52, .51, .50."""
ROUNDS = 8
DAMPING = 0.5
"""Number of rounds, and the share of the former y that each round keeps. After eight rounds y
hardly changes."""
SPREAD_POWER = 0.25
"""Power of the variance in sd_w, as in the word map. At 0.5, rare words outweigh common ones."""


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Linear map from the motion around a segment to evidence that a word is shown there."""

    weights: FloatArray  # (columns, words): slopes u_w of the regression
    offsets: FloatArray  # (words,): constants c_w of the regression
    spreads: FloatArray  # (words,): scales sd_w, as defined in the module's docstring

    def evidence(self, vectors: FloatArray) -> FloatArray:
        """Return the evidence for each word, in nats per second: array (rows, words)."""
        return np.asarray(SHARPNESS * (vectors @ self.weights + self.offsets) / self.spreads)


@dataclass(frozen=True, eq=False)
class PlacedWords:
    """Result of :func:`fit_place_map`."""

    fit: PlaceMap  # The map, fitted to all takes
    shown: FloatArray  # (rows, words): probability y that each word is shown at each segment


def fit_place_map(takes: ListedTakes) -> PlacedWords:
    """Estimate the hidden places of listed actions, and the map from motion to words."""
    rows = takes.rows()
    weights = take_weights(takes)
    shown = even_shares(takes, rows)
    left_out = _prepare(takes.vectors, weights, rows)
    for _ in range(ROUNDS):
        evidence = left_out.evidence(shown)
        shown = DAMPING * shown + (1.0 - DAMPING) * place_actions(takes, rows, evidence)
    return PlacedWords(map_places(takes.vectors, shown, weights), shown)


@dataclass(frozen=True, eq=False)
class FittedPlaces:
    """The regression of :func:`map_places`, in a form from which rows can be removed."""

    # (rows, columns): vectors less their weighted mean, times the square roots of the weights
    centred: FloatArray
    # (rows, words): residuals of the regression with all rows, times the square roots of the
    # weights
    residuals: FloatArray
    slopes: FloatArray  # (columns, words): slopes of the regression with all rows
    # (columns, columns): inverse of the sum of products of ``centred`` with the ridge added
    inverse: FloatArray
    centre: FloatArray  # (columns,): weighted mean of the vectors
    spreads: FloatArray  # (words,): scales sd_w, as defined in the module's docstring

    def without(self, rows: IntArray) -> PlaceMap:
        """Return the map without the rows of these numbers; the means stay those of all rows."""
        removed = self.centred[rows]
        if len(rows) > removed.shape[1]:  # the smaller system
            gram = np.linalg.inv(self.inverse) - removed.T @ removed
            slopes = self.slopes - np.linalg.solve(gram, removed.T @ self.residuals[rows])
        else:
            block = removed @ self.inverse @ removed.T
            error = np.linalg.solve(np.eye(len(rows)) - block, self.residuals[rows])
            slopes = self.slopes - self.inverse @ (removed.T @ error)
        return PlaceMap(np.asarray(slopes), np.asarray(-self.centre @ slopes), self.spreads)


def fit_places(takes: ListedTakes, shown: FloatArray) -> FittedPlaces:
    """Fit the regression to given places; :meth:`FittedPlaces.without` removes rows from it.

    Shapes: `shown` (rows, words).
    """
    centre, mean, centred, target = _centred(takes.vectors, shown, take_weights(takes))
    inverse = np.asarray(np.linalg.inv(_gram(centred)), dtype=np.float64)
    slopes = inverse @ (centred.T @ target)
    residuals = target - centred @ slopes
    return FittedPlaces(centred, residuals, slopes, inverse, centre, spreads_of(mean))


def map_places(vectors: FloatArray, shown: FloatArray, weights: FloatArray) -> PlaceMap:
    """Fit the map to given places.

    Shapes: `vectors` (rows, columns); `shown` (rows, words); `weights` (rows,).
    """
    centre, mean, centred, target = _centred(vectors, shown, weights)
    slopes = np.linalg.solve(_gram(centred), centred.T @ target)
    return PlaceMap(np.asarray(slopes), np.asarray(-centre @ slopes), spreads_of(mean))


def left_out_evidence(takes: ListedTakes, shown: FloatArray) -> FloatArray:
    """Return the evidence (rows, words; nats per second) for each take by the map of the others.

    The evidence of a map that was fitted to the take itself follows the take's own ``shown``, and
    is less informative about the places of its words. On four long takes it placed .42 to .46 of
    the questions right; without the take .50 to .54 were placed right.

    Shapes: `shown` (rows, words).
    """
    return _prepare(takes.vectors, take_weights(takes), takes.rows()).evidence(shown)


def take_weights(takes: ListedTakes) -> FloatArray:
    """Return the weight of each row: its seconds divided by the square root of the take's seconds.

    Long takes weigh more than short ones, but less than in proportion to their duration.
    """
    total = np.bincount(takes.owners, weights=takes.seconds)
    return np.asarray(takes.seconds / np.sqrt(total[takes.owners]))


def spreads_of(mean: FloatArray) -> FloatArray:
    """Return the scales sd_w of the module's docstring; means are kept away from 0 and 1."""
    kept = np.clip(mean, 1e-4, 0.999)
    return np.asarray((kept * (1.0 - kept)) ** SPREAD_POWER)


def _centred(
    vectors: FloatArray, shown: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the weighted means of both, and both centred and scaled by the root weights."""
    root = np.sqrt(weights)[:, None]
    centre = weights @ vectors / weights.sum()
    mean = weights @ shown / weights.sum()
    return centre, mean, (vectors - centre) * root, (shown - mean) * root


def _gram(centred: FloatArray) -> FloatArray:
    """Return the sum of products with the ridge added."""
    return np.asarray(centred.T @ centred + RIDGE * np.eye(centred.shape[1]))


@dataclass(frozen=True, eq=False)
class _LeftOut:
    """Parts of the regression that all rounds share; they depend on vectors and weights only.

    With H the block of the hat matrix of a take's rows, the residuals without the take are
    (I - H)^-1 times those with it.
    """

    weights: FloatArray
    centred: FloatArray
    inverse: FloatArray
    rows: Sequence[slice]
    without: Sequence[FloatArray]

    def predict(self, shown: FloatArray) -> FloatArray:
        """Return predictions (rows, words) for each take by the regression without it."""
        root = np.sqrt(self.weights)[:, None]
        mean = self.weights @ shown / self.weights.sum()
        target = (shown - mean) * root
        residuals = target - self.centred @ (self.inverse @ (self.centred.T @ target))
        predicted = np.empty_like(target)
        for inside, without in zip(self.rows, self.without):
            predicted[inside] = target[inside] - without @ residuals[inside]
        return np.asarray(predicted / root + mean)

    def evidence(self, shown: FloatArray) -> FloatArray:
        """Return the evidence (rows, words) for each take by the regression without it."""
        mean = self.weights @ shown / self.weights.sum()
        return np.asarray(SHARPNESS * (self.predict(shown) - mean) / spreads_of(mean))


def _prepare(vectors: FloatArray, weights: FloatArray, rows: Sequence[slice]) -> _LeftOut:
    """Compute the parts of the regression that all rounds share."""
    root = np.sqrt(weights)[:, None]
    centred = (vectors - weights @ vectors / weights.sum()) * root
    inverse = np.asarray(np.linalg.inv(_gram(centred)), dtype=np.float64)
    without = [
        np.linalg.inv(np.eye(len(block)) - block)
        for block in (centred[inside] @ inverse @ centred[inside].T for inside in rows)
    ]
    return _LeftOut(weights, centred, inverse, rows, without)
