"""Where in a take a word happens, learned from captions that only say that it happens.

A caption of a whole take says which actions happen somewhere in it. The times at which they happen
are hidden. They are found together with a linear map from the motion of a segment to words:

    y_iw    probability that word w is shown at segment i (hidden; 1 where a caption of one action
            describes the segment),
    z_iw    (x_i . u_w + c_w) / sd_w, ridge regression from the vector x_i of the segment to
            y_iw - mean(y_w), sd_w = (mean (1 - mean))^(1/4); predicted for each take by the
            regression without it.

Each round fits the map and then lays the actions of every caption over the segments of its take:
in the caption's order (:mod:`motiondb.words.ordered_alignment`), with log-likelihood ratios of
``SHARPNESS`` sqrt(seconds of the segment) times the mean z of the action's words; and without any
order, by a softmax over the actions and none of them. y is the mixture of both, and moves half of
the way in each round. Words that other captions of the same take say keep an even share. Where a
caption describes an interval, y of its words is given there (``ListedTakes.labelled``).

The map says where. Whether a take shows the word at all is the word map's business
(:mod:`motiondb.words.word_map`): there is one row a segment here, and most of them belong to a few
long takes.

Source: multiple-instance learning in the manner of connectionist temporal classification (Graves
et al., 2006). That order does the work was measured on four long takes with true segments: the
right interval came first for .54 of 24 questions with it, .25 with the actions shuffled, .29 with
the order reversed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.words.ordered_alignment import align_in_order

RIDGE = 0.03
"""Larger ones level the differences within a take. Of .01 to .3, .03 and .1 were the best on joined
real captures (32 to 40 questions a draw, four draws: .52 and .53, within chance)."""
SHARPNESS = 6.0
"""Nats a unit of z in one second. 6, 10 and 20 are alike on joined real captures: .52, .51, .50."""
ORDERED = 0.7
"""Share of the ordered alignment in the mixture, as in a first prototype; 1 was .01 below it."""
LABELLED = 20.0
"""Nats for an action where a person said that it is shown; more than any motion speaks against it.
Chosen by hand; not tuned."""
ROUNDS = 8
DAMPING = 0.5
"""Rounds, and the share of the former y that each keeps; after eight rounds y hardly moves."""
SPREAD_POWER = 0.25
"""As in the word map; 0.5 lets rare words shout down common ones."""


@dataclass(frozen=True, eq=False)
class ListedTakes:
    """Takes with the actions that their captions list.

    Attributes
    ----------
    vectors : array (rows, columns)
        Vector of the motion around each segment, of length 1; all segments of a take together.
    seconds : array (rows,)
        How long each segment lasts.
    owners : array (rows,)
        Number of the take that each segment belongs to, rising from 0 without gaps.
    actions : sequence of sequence of sequence of int
        Per take its listed actions in order, each the numbers of its words; never empty.
    further : sequence of sequence of int
        Per take the words that its other captions say, without an order.
    n_words : int
        Size of the vocabulary.
    labelled : array (rows, words), optional
        y where people said it of an interval: 1 where a word is shown, 0 where it is not, NaN where
        nobody said. None: nobody said anything of any interval.
    """

    vectors: FloatArray
    seconds: FloatArray
    owners: IntArray
    actions: Sequence[Sequence[Sequence[int]]]
    further: Sequence[Sequence[int]]
    n_words: int
    labelled: FloatArray | None = None

    def rows(self) -> list[slice]:
        """Rows of every take."""
        ends = np.searchsorted(self.owners, np.arange(1, len(self.actions) + 1))
        return [slice(int(a), int(b)) for a, b in zip(np.concatenate([[0], ends]), ends)]


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Linear map from the motion around a segment to evidence that a word is shown there.

    Attributes
    ----------
    weights : array (columns, words)
    offsets : array (words,)
    spreads : array (words,)
        sd_w of the module's docstring.
    """

    weights: FloatArray
    offsets: FloatArray
    spreads: FloatArray

    def evidence(self, vectors: FloatArray) -> FloatArray:
        """Evidence (rows, words) in nats a second; larger where the word is likelier shown."""
        return np.asarray(SHARPNESS * (vectors @ self.weights + self.offsets) / self.spreads)


@dataclass(frozen=True, eq=False)
class PlacedWords:
    """What :func:`fit_place_map` finds.

    Attributes
    ----------
    fit : PlaceMap
        The map of all takes.
    shown : array (rows, words)
        y of the module's docstring.
    """

    fit: PlaceMap
    shown: FloatArray


def fit_place_map(takes: ListedTakes) -> PlacedWords:
    """Find the hidden places of listed actions, and the map from motion to words.

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
    """The regression of :func:`map_places` in the form from which rows are taken out.

    Attributes
    ----------
    centred : array (rows, columns)
        Vectors less their weighted mean, times the roots of the weights.
    residuals : array (rows, words)
        Of the regression with all rows, times the roots of the weights.
    slopes : array (columns, words)
    inverse : array (columns, columns)
        Inverse of the ridged sum of products.
    centre : array (columns,)
        Weighted mean of the vectors.
    spreads : array (words,)
    """

    centred: FloatArray
    residuals: FloatArray
    slopes: FloatArray
    inverse: FloatArray
    centre: FloatArray
    spreads: FloatArray

    def without(self, rows: IntArray) -> PlaceMap:
        """The map of all other rows, means kept."""
        taken = self.centred[rows]
        if len(rows) > taken.shape[1]:  # the smaller system
            gram = np.linalg.inv(self.inverse) - taken.T @ taken
            slopes = self.slopes - np.linalg.solve(gram, taken.T @ self.residuals[rows])
        else:
            block = taken @ self.inverse @ taken.T
            error = np.linalg.solve(np.eye(len(rows)) - block, self.residuals[rows])
            slopes = self.slopes - self.inverse @ (taken.T @ error)
        return PlaceMap(np.asarray(slopes), np.asarray(-self.centre @ slopes), self.spreads)


def fit_places(takes: ListedTakes, shown: FloatArray) -> FittedPlaces:
    """The regression, places given; :meth:`FittedPlaces.without` takes rows out of it.

    Parameters
    ----------
    takes : ListedTakes
    shown : array (rows, words)
        Probability that each word is shown at each segment.
    """
    centre, mean, centred, target = _centred(takes.vectors, shown, take_weights(takes))
    inverse = np.asarray(np.linalg.inv(_gram(centred)), dtype=np.float64)
    slopes = inverse @ (centred.T @ target)
    residuals = target - centred @ slopes
    return FittedPlaces(centred, residuals, slopes, inverse, centre, spreads_of(mean))


def map_places(vectors: FloatArray, shown: FloatArray, weights: FloatArray) -> PlaceMap:
    """The map, places given.

    Parameters
    ----------
    vectors : array (rows, columns)
    shown : array (rows, words)
        Probability that each word is shown at each segment.
    weights : array (rows,)
        Weight of each row.
    """
    centre, mean, centred, target = _centred(vectors, shown, weights)
    slopes = np.linalg.solve(_gram(centred), centred.T @ target)
    return PlaceMap(np.asarray(slopes), np.asarray(-centre @ slopes), spreads_of(mean))


def left_out_evidence(takes: ListedTakes, shown: FloatArray) -> FloatArray:
    """Evidence (rows, words) for each take by the map of all the others.

    The evidence of a map that was fitted to the take itself follows the take's own ``shown`` and
    says less about where its words are: on four long takes .42 to .46 of the questions were placed
    right by it, .50 to .54 without the take.

    Parameters
    ----------
    takes : ListedTakes
    shown : array (rows, words)
        Probability that each word is shown at each segment.
    """
    return _prepare(takes.vectors, take_weights(takes), takes.rows()).evidence(shown)


def take_weights(takes: ListedTakes) -> FloatArray:
    """Weight of every row: its seconds by the square root of its take's.

    Long takes count more than short ones, but less than in proportion.
    """
    total = np.bincount(takes.owners, weights=takes.seconds)
    return np.asarray(takes.seconds / np.sqrt(total[takes.owners]))


def spreads_of(mean: FloatArray) -> FloatArray:
    """sd_w of the module's docstring, means kept away from 0 and 1."""
    kept = np.clip(mean, 1e-4, 0.999)
    return np.asarray((kept * (1.0 - kept)) ** SPREAD_POWER)


def _even_shares(takes: ListedTakes, rows: Sequence[slice]) -> FloatArray:
    """Each listed action is shown for an equal part of its take, nobody knows which."""
    shown = np.zeros((len(takes.vectors), takes.n_words))
    for inside, actions, further in zip(rows, takes.actions, takes.further):
        words = sorted({word for action in actions for word in action} | set(further))
        shown[inside, words] = 1.0 / len(actions)
    return _as_labelled(takes, shown)


def _as_labelled(takes: ListedTakes, shown: FloatArray) -> FloatArray:
    """y with what people said of intervals in place of what was computed."""
    said = takes.labelled
    return shown if said is None else np.where(np.isnan(said), shown, said)


def _place(takes: ListedTakes, rows: Sequence[slice], evidence: FloatArray) -> FloatArray:
    """y of one round: array (rows, words)."""
    shown = np.zeros_like(evidence)
    for inside, actions, further in zip(rows, takes.actions, takes.further):
        shown[inside, list(further)] = 1.0 / len(actions)
        said = evidence[inside]
        ratios = np.stack([said[:, list(action)].mean(axis=1) for action in actions], axis=1)
        ratios *= np.sqrt(takes.seconds[inside])[:, None]
        if takes.labelled is not None:
            ratios += _labelled_ratios(takes.labelled[inside], actions)
        placed = _mixture(ratios)
        for k, action in enumerate(actions):
            for word in action:
                column = shown[inside, word]
                np.maximum(column, placed[:, k], out=column)
    return _as_labelled(takes, shown)


def _labelled_ratios(labelled: FloatArray, actions: Sequence[Sequence[int]]) -> FloatArray:
    """Nats that labels of intervals add to the actions of the same take: (segments, actions)."""
    said = np.nan_to_num(2.0 * labelled - 1.0)  # 1 shown, -1 not shown, 0 not said
    return LABELLED * np.stack([said[:, list(action)].mean(axis=1) for action in actions], axis=1)


def _mixture(ratios: FloatArray) -> FloatArray:
    """Ordered and unordered posteriors mixed; a single action is everywhere."""
    if ratios.shape[1] == 1:
        return np.ones_like(ratios)
    top = np.maximum(ratios.max(axis=1, keepdims=True), 0.0)
    odds = np.exp(ratios - top)
    unordered = odds / (odds.sum(axis=1, keepdims=True) + np.exp(-top))
    return ORDERED * align_in_order(ratios) + (1.0 - ORDERED) * unordered


def _centred(
    vectors: FloatArray, shown: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Weighted means of both, and both centred and scaled by the roots of the weights."""
    root = np.sqrt(weights)[:, None]
    centre = weights @ vectors / weights.sum()
    mean = weights @ shown / weights.sum()
    return centre, mean, (vectors - centre) * root, (shown - mean) * root


def _gram(centred: FloatArray) -> FloatArray:
    return np.asarray(centred.T @ centred + RIDGE * np.eye(centred.shape[1]))


def _predict_left_out(
    vectors: FloatArray, shown: FloatArray, weights: FloatArray, rows: Sequence[slice]
) -> FloatArray:
    """Predictions (rows, words) for each take by the regression without it, means kept."""
    return _prepare(vectors, weights, rows).predict(shown)


@dataclass(frozen=True, eq=False)
class _LeftOut:
    """What all rounds share: it depends on the vectors and the weights only.

    With H the block of the hat matrix of a take's rows, the residuals without the take are
    (I - H)^-1 times those with it.
    """

    weights: FloatArray
    centred: FloatArray
    inverse: FloatArray
    rows: Sequence[slice]
    without: Sequence[FloatArray]

    def predict(self, shown: FloatArray) -> FloatArray:
        """Predictions (rows, words) for each take without it."""
        root = np.sqrt(self.weights)[:, None]
        mean = self.weights @ shown / self.weights.sum()
        target = (shown - mean) * root
        residuals = target - self.centred @ (self.inverse @ (self.centred.T @ target))
        predicted = np.empty_like(target)
        for inside, without in zip(self.rows, self.without):
            predicted[inside] = target[inside] - without @ residuals[inside]
        return np.asarray(predicted / root + mean)

    def evidence(self, shown: FloatArray) -> FloatArray:
        """Evidence (rows, words) for each take without it."""
        mean = self.weights @ shown / self.weights.sum()
        return np.asarray(SHARPNESS * (self.predict(shown) - mean) / spreads_of(mean))


def _prepare(vectors: FloatArray, weights: FloatArray, rows: Sequence[slice]) -> _LeftOut:
    root = np.sqrt(weights)[:, None]
    centred = (vectors - weights @ vectors / weights.sum()) * root
    inverse = np.asarray(np.linalg.inv(_gram(centred)), dtype=np.float64)
    without = [
        np.linalg.inv(np.eye(len(block)) - block)
        for block in (centred[inside] @ inverse @ centred[inside].T for inside in rows)
    ]
    return _LeftOut(weights, centred, inverse, rows, without)
