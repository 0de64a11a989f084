"""Learn where in a take each word is shown, from captions without times.

A caption of a whole take says which actions happen somewhere in it. The times of the actions are
hidden. They are estimated together with a linear map from the motion of a segment to words:

    y_iw    probability that word w is shown at segment i (hidden; 1 where a caption of one action
            describes the segment),
    z_iw    (x_i . u_w + c_w) / sd_w, by ridge regression from the vector x_i of the segment to
            y_iw - mean(y_w), with sd_w = (mean (1 - mean))^(1/4); the prediction for each take
            uses the regression without this take.

Each round fits the map and then aligns the actions of each caption with the segments of its take in
two ways. The ordered alignment keeps the caption's order
(:mod:`motiondb.words.maps.ordered_alignment`); its log-likelihood ratios are ``SHARPNESS``
sqrt(seconds of the segment) times the mean z of the action's words. The unordered one is a softmax
over the actions and none of them. y is a mixture of both, and each round keeps the share
``DAMPING`` of the former y. Words of other captions of the same take keep equal shares. Where a
caption describes an interval, it gives y of its words there (``ListedTakes.labelled``), and its
words compete with the listed actions of takes that do not list them.

The map estimates where a word is shown. Whether a take shows the word at all is estimated by the
word map (:mod:`motiondb.words.maps.word_map`), because here each segment is a row, and most rows
belong to a few long takes.

Source: multiple-instance learning in the manner of connectionist temporal classification (Graves
et al., 2006). The use of the order was measured on four long takes with true segments: the right
interval came first for .54 of 24 questions with the order, for .25 with the actions shuffled, and
for .29 with the order reversed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.words.maps.ordered_alignment import align_in_order

RIDGE = 0.03
"""Ridge of the regression. Larger values reduce the differences within a take. Of .01 to .3, the
values .03 and .1 were the best on joined real captures (32 to 40 questions a draw, four draws: .52
and .53, a difference within chance)."""
SHARPNESS = 6.0
"""Nats per unit of z in one second. The values 6, 10 and 20 give similar results on joined real
captures: .52, .51, .50."""
ORDERED = 0.7
"""Share of the ordered alignment in the mixture, from a first prototype; 1 was worse by .01."""
LABELLED = 20.0
"""Nats for an action where a person labelled it; more than the evidence of any motion against it.
Chosen by hand; not tuned."""
ROUNDS = 8
DAMPING = 0.5
"""Number of rounds, and the share of the former y that each round keeps. After eight rounds y
hardly changes. Chosen by hand; not tuned."""
SPREAD_POWER = 0.25
"""Power of the variance in sd_w, as in the word map. At 0.5, rare words outweigh common ones."""


@dataclass(frozen=True, eq=False)
class ListedTakes:
    """Takes with the actions that their captions list.

    Attributes
    ----------
    vectors : array (rows, columns)
        Vector of the motion around each segment, of length 1. The rows are the segments of all
        takes.
    seconds : array (rows,)
        Duration of each segment.
    owners : array (rows,)
        Number of the take of each segment, rising from 0 without gaps.
    actions : sequence of sequence of sequence of int
        For each take its listed actions in order, each as the numbers of its words; never empty.
    further : sequence of sequence of int
        For each take the words of its other captions, without an order.
    n_words : int
        Size of the vocabulary.
    labelled : array (rows, words), optional
        y where people labelled an interval: 1 where a word is shown, 0 if it is not, NaN if
        there is no label. None if there are no labels.
    """

    vectors: FloatArray
    seconds: FloatArray
    owners: IntArray
    actions: Sequence[Sequence[Sequence[int]]]
    further: Sequence[Sequence[int]]
    n_words: int
    labelled: FloatArray | None = None

    def rows(self) -> list[slice]:
        """Return the rows of each take."""
        ends = np.searchsorted(self.owners, np.arange(1, len(self.actions) + 1))
        return [slice(int(a), int(b)) for a, b in zip(np.concatenate([[0], ends]), ends)]


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Linear map from the motion around a segment to evidence that a word is shown there.

    Attributes
    ----------
    weights : array (columns, words)
        Slopes u_w of the regression.
    offsets : array (words,)
        Constants c_w of the regression.
    spreads : array (words,)
        Scales sd_w, as defined in the module's docstring.
    """

    weights: FloatArray
    offsets: FloatArray
    spreads: FloatArray

    def evidence(self, vectors: FloatArray) -> FloatArray:
        """Return the evidence for each word, in nats per second: array (rows, words)."""
        return np.asarray(SHARPNESS * (vectors @ self.weights + self.offsets) / self.spreads)


@dataclass(frozen=True, eq=False)
class PlacedWords:
    """Result of :func:`fit_place_map`.

    Attributes
    ----------
    fit : PlaceMap
        The map, fitted to all takes.
    shown : array (rows, words)
        Probability y that each word is shown at each segment.
    """

    fit: PlaceMap
    shown: FloatArray


def fit_place_map(takes: ListedTakes) -> PlacedWords:
    """Estimate the hidden places of listed actions, and the map from motion to words.

    Parameters
    ----------
    takes : ListedTakes
        At least one take.
    """
    rows = takes.rows()
    weights = take_weights(takes)
    shown = _even_shares(takes, rows)
    left_out = _prepare(takes.vectors, weights, rows)
    for _ in range(ROUNDS):
        evidence = left_out.evidence(shown)
        shown = DAMPING * shown + (1.0 - DAMPING) * _place(takes, rows, evidence)
    return PlacedWords(map_places(takes.vectors, shown, weights), shown)


@dataclass(frozen=True, eq=False)
class FittedPlaces:
    """The regression of :func:`map_places`, in a form from which rows can be removed.

    Attributes
    ----------
    centred : array (rows, columns)
        Vectors less their weighted mean, times the square roots of the weights.
    residuals : array (rows, words)
        Residuals of the regression with all rows, times the square roots of the weights.
    slopes : array (columns, words)
        Slopes of the regression with all rows.
    inverse : array (columns, columns)
        Inverse of the sum of products of ``centred`` with the ridge added.
    centre : array (columns,)
        Weighted mean of the vectors.
    spreads : array (words,)
        Scales sd_w, as defined in the module's docstring.
    """

    centred: FloatArray
    residuals: FloatArray
    slopes: FloatArray
    inverse: FloatArray
    centre: FloatArray
    spreads: FloatArray

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

    Parameters
    ----------
    takes : ListedTakes
        At least one take.
    shown : array (rows, words)
        Probability that each word is shown at each segment.
    """
    centre, mean, centred, target = _centred(takes.vectors, shown, take_weights(takes))
    inverse = np.asarray(np.linalg.inv(_gram(centred)), dtype=np.float64)
    slopes = inverse @ (centred.T @ target)
    residuals = target - centred @ slopes
    return FittedPlaces(centred, residuals, slopes, inverse, centre, spreads_of(mean))


def map_places(vectors: FloatArray, shown: FloatArray, weights: FloatArray) -> PlaceMap:
    """Fit the map to given places.

    Parameters
    ----------
    vectors : array (rows, columns)
        Vector of the motion around each segment.
    shown : array (rows, words)
        Probability that each word is shown at each segment.
    weights : array (rows,)
        Weight of each row.
    """
    centre, mean, centred, target = _centred(vectors, shown, weights)
    slopes = np.linalg.solve(_gram(centred), centred.T @ target)
    return PlaceMap(np.asarray(slopes), np.asarray(-centre @ slopes), spreads_of(mean))


def left_out_evidence(takes: ListedTakes, shown: FloatArray) -> FloatArray:
    """Return the evidence (rows, words; nats per second) for each take by the map of the others.

    The evidence of a map that was fitted to the take itself follows the take's own ``shown``, and
    is less informative about the places of its words. On four long takes it placed .42 to .46 of
    the questions right; without the take .50 to .54 were placed right.

    Parameters
    ----------
    takes : ListedTakes
        The takes.
    shown : array (rows, words)
        Probability that each word is shown at each segment.
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


def _even_shares(takes: ListedTakes, rows: Sequence[slice]) -> FloatArray:
    """Return the initial y: each listed action has an equal share of each segment of its take."""
    shown = np.zeros((len(takes.vectors), takes.n_words))
    for inside, actions, further in zip(rows, takes.actions, takes.further):
        words = sorted({word for action in actions for word in action} | set(further))
        shown[inside, words] = 1.0 / len(actions)
    return _as_labelled(takes, shown)


def _as_labelled(takes: ListedTakes, shown: FloatArray) -> FloatArray:
    """Return y, with the labels of intervals in place of computed values."""
    said = takes.labelled
    return shown if said is None else np.where(np.isnan(said), shown, said)


def _place(takes: ListedTakes, rows: Sequence[slice], evidence: FloatArray) -> FloatArray:
    """Return y of one round before damping: array (rows, words)."""
    shown = np.zeros_like(evidence)
    labels = _labels(takes)
    for inside, actions, further in zip(rows, takes.actions, takes.further):
        shown[inside, list(further)] = 1.0 / len(actions)
        said = evidence[inside]
        ratios = np.stack([said[:, list(action)].mean(axis=1) for action in actions], axis=1)
        take_words = {word for action in actions for word in action} | set(further)
        ratios -= _unlisted(said, [label for label in labels if not take_words.issuperset(label)])
        ratios *= np.sqrt(takes.seconds[inside])[:, None]
        if takes.labelled is not None:
            ratios += _labelled_ratios(takes.labelled[inside], actions)
        placed = _mixture(ratios)
        for k, action in enumerate(actions):
            for word in action:
                column = shown[inside, word]
                np.maximum(column, placed[:, k], out=column)
    return _as_labelled(takes, shown)


def _labels(takes: ListedTakes) -> list[tuple[int, ...]]:
    """Return the different sets of words that label a segment of any take."""
    if takes.labelled is None:
        return []
    shown = takes.labelled == 1.0
    return sorted({tuple(np.flatnonzero(row).tolist()) for row in shown[shown.any(axis=1)]})


def _unlisted(evidence: FloatArray, labels: Sequence[tuple[int, ...]]) -> FloatArray:
    """Return the evidence for the likeliest unlisted label, at least 0: array (segments, 1).

    A take may show an action that none of its captions lists. If a label in another take has taught
    what the action looks like, it competes with the listed actions.
    """
    none = np.zeros((len(evidence), 1))
    each = [evidence[:, list(label)].mean(axis=1, keepdims=True) for label in labels]
    return np.asarray(np.max([none, *each], axis=0))


def _labelled_ratios(labelled: FloatArray, actions: Sequence[Sequence[int]]) -> FloatArray:
    """Return the nats that labels of intervals add to each action: array (segments, actions)."""
    said = np.nan_to_num(2.0 * labelled - 1.0)  # 1 shown, -1 not shown, 0 not labelled
    return LABELLED * np.stack([said[:, list(action)].mean(axis=1) for action in actions], axis=1)


def _mixture(ratios: FloatArray) -> FloatArray:
    """Mix the ordered and unordered posteriors; a single action is shown at all segments."""
    if ratios.shape[1] == 1:
        return np.ones_like(ratios)
    top = np.maximum(ratios.max(axis=1, keepdims=True), 0.0)
    odds = np.exp(ratios - top)
    unordered = odds / (odds.sum(axis=1, keepdims=True) + np.exp(-top))
    return ORDERED * align_in_order(ratios) + (1.0 - ORDERED) * unordered


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
