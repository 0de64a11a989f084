"""Learn where in a take each word is shown, from captions without times.

A caption of a whole take says which actions happen somewhere in it. Their places are estimated
together with a linear map from the motion of a segment to words:

    y_iw    probability that word w is shown at segment i (hidden; 1 where a caption of one action
            describes the segment),
    z_iw    (x_i . u_w + c_w) / sd_w, by ridge regression from the vector x_i of the segment to
            y_iw - mean(y_w), with sd_w = (mean (1 - mean))^(1/4); the prediction for each take
            uses the regression without this take.

Each round fits the map, takes e_iw = ``SHARPNESS`` z_iw as the evidence for words, and aligns the
actions of each caption with the segments of its take; it keeps the share ``DAMPING`` of the former
y. Where a caption describes an interval, it gives y of its words there (``ListedTakes.labelled``).
Whether a take shows a word at all is estimated by the word map, because here each segment is a row,
and most rows belong to a few long takes.

**Where an action is likely.** Let e_ik be the mean of e_iw over the words of action k, and p_k the
largest e_ik of the take. The log-likelihood ratio of action k against none of the actions is

    r_ik = sqrt(seconds of the segment) (e_ik - HALF max(p_k, 0)),

so that an action with a little evidence everywhere is shown where there is most of it. Labels of
intervals add ``LABELLED`` nats for or against an action. y is a mixture of two posteriors: the
ordered one below, and a softmax over the actions and none of them. Words of other captions of the
same take keep equal shares. In takes that list several actions, labelled actions of other takes
compete with the listed ones, and get y by the unordered posterior: if it were 0, segments that move
like the labelled ones would be examples against the label's words.

**The ordered posterior.** The hidden sequence has one state for each action, in the order of the
caption, and one *blank* (ratio 0) before, between and after them:

    blank_0, action_1, blank_1, action_2, ..., action_m, blank_m.

It stays in its state, moves to the next state, or from an action to the next one without a blank.
An action may be left out, with the log-weight ``SKIP``. The blanks on both sides of it are
different states: where n segments lie between its neighbours, all blank, n + 1 sequences leave it
out, with a log-weight of SKIP + ln(n + 1) together. A run of segments of one action that lasts D
seconds has the log-weight

    -min(1/2 (ln(D / mu) / SPREAD)^2, MOST_COST),
    mu = (seconds of the take) / (number of actions):

otherwise an action with a little evidence everywhere absorbs the segments of actions for which
there is none yet. Forward and backward sums over runs take time and memory quadratic in the
segments; longer takes than MOST_SEGMENTS are aligned without durations, by running sums.

Source: Graves, Fernandez, Gomez and Schmidhuber (2006), Connectionist temporal classification; for
runs with durations, hidden semi-Markov models (Yu, 2010). Leaving actions out is added here,
because captions list actions that are not performed. On four long takes with true segments the
right interval came first for .50 of 24 questions with the order, for .41 with the actions shuffled
and for .33 with the order reversed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.regression import Fitted, prepare, together
from motiondb.meaning.word_map import word_spreads
from motiondb.records import Float32Array, FloatArray, IntArray

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


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Linear map from the motion around a segment to evidence that a word is shown there."""

    weights: FloatArray  # (columns, words): slopes u_w of the regression
    offsets: FloatArray  # (words,): constants c_w of the regression
    spreads: FloatArray  # (words,): scales sd_w, as defined in the module's docstring

    def evidence(self, vectors: FloatArray) -> FloatArray:
        """Return the evidence for each word, in nats per second: array (rows, words)."""
        return np.asarray(SHARPNESS * (vectors @ self.weights + self.offsets) / self.spreads)


def find_shown(takes: ListedTakes, *, overwrite: bool = False) -> FloatArray:
    """Estimate the hidden places of listed actions: array (rows, words), y of the module.

    `overwrite`: Whether the vectors of the takes may be.
    """
    rows = takes.rows()
    shown = even_shares(takes, rows)
    weights = take_weights(takes.seconds, takes.owners)
    regression = prepare(takes.vectors, weights, RIDGE, overwrite=overwrite)
    apart = [regression.apart(inside) for inside in rows]
    labels = _labels(takes)
    for _ in range(ROUNDS):
        fitted = FittedPlaces(regression.fit(shown))
        for some, inside in together(rows):  # in place: y of hours is large
            evidence = fitted.left_out(rows[some], apart[some])
            placed = place_actions(takes.part(some, inside), evidence, labels)
            shown[inside] *= DAMPING
            shown[inside] += (1.0 - DAMPING) * placed
    return shown


@dataclass(frozen=True, eq=False)
class FittedPlaces:
    """The regression of :func:`map_places`, in a form from which rows can be removed."""

    fitted: Fitted

    def without(self, rows: IntArray) -> PlaceMap:
        """Return the map without the rows of these numbers; the means stay those of all rows."""
        slopes = self.fitted.without(rows) if len(rows) else self.fitted.slopes
        offsets = -self.fitted.regression.centre @ slopes
        return PlaceMap(slopes, np.asarray(offsets), spreads_of(self.fitted.mean))

    def of_others(self, rows: slice | IntArray, apart: FloatArray | None = None) -> FloatArray:
        """Return the evidence (rows, words) for some rows by the map without them."""
        fitted = self.fitted
        predicted = fitted.of_others(rows, apart) / fitted.regression.roots[rows]
        return np.asarray(SHARPNESS * predicted / spreads_of(fitted.mean))

    def left_out(
        self, rows: Sequence[slice], apart: Sequence[FloatArray | None] | None = None
    ) -> FloatArray:
        """The evidence (rows, words; nats per second) for each take by the map of others.

        That of a map fitted to the take itself follows its own places: on four long takes it placed
        .42 to .46 of the questions right, without the take .50 to .54.
        """
        fitted = self.fitted
        evidence = fitted.left_out(rows, apart)
        roots = fitted.regression.roots[rows[0].start : rows[-1].stop]
        evidence *= SHARPNESS / (roots * spreads_of(fitted.mean))
        return evidence


def take_weights(seconds: FloatArray, owners: IntArray) -> FloatArray:
    """Weight of each row: its seconds by the root of those of its take; `owners`: take numbers."""
    total = np.bincount(owners, weights=seconds)
    return np.asarray(seconds / np.sqrt(total[owners]))


def spreads_of(mean: FloatArray) -> FloatArray:
    """The scales sd_w of the module's docstring; means are kept away from 0 and 1."""
    return word_spreads(np.clip(mean, 1e-4, 0.999))


SKIP = -10.0
"""Log-weight of leaving one listed action out, in nats. At -3 one action absorbs its neighbours: 6
of 13 questions about words of the takes' own captions were placed right. From -6 down to forbidding
it, 9 or 10 were. Leaving actions out must remain possible for takes with fewer segments than
actions."""
SPREAD = 0.5
"""Standard deviation of the logarithm of a duration. On takes that were joined from Bandai-Namco
captures, with a fifth of the actions unlisted, .58 of 243 questions about listed actions were
placed right with 1, .65 with .5 and .35. On joined CMU captures it made no difference."""
MOST_COST = -SKIP / 2.0
"""Largest cost of a duration, in nats; reached at a fifth of mu and at five times mu. Half of the
cost of leaving an action out, so that a short action with clear evidence is not left out for its
duration alone: without a bound, 1 second in a take of 60 that lists two actions would cost 23 nats.
Not tuned on tables."""
MOST_SEGMENTS = 500
"""Largest number of segments that are aligned with durations. Bounds the time of a call (0.05 s for
10 actions) and its memory (2 MB an array);"""


def align_in_order(log_ratios: FloatArray, seconds: FloatArray | None = None) -> FloatArray:
    """Return the posterior probability of each action at each segment.

    Shapes: `log_ratios`, result (segments, actions); `seconds` (segments,).

    The first and the last segment both look like the second action. The order decides.

    >>> ratios = np.array([[0.0, 5.0], [5.0, 0.0], [0.0, 5.0]])
    >>> align_in_order(ratios).round(2).tolist()
    [[0.5, 0.0], [0.99, 0.0], [0.0, 1.0]]

    Two segments look like either action. Durations divide them.

    >>> align_in_order(np.full((4, 2), 3.0), np.ones(4)).round(2).tolist()
    [[0.98, 0.0], [0.81, 0.18], [0.18, 0.81], [0.0, 0.98]]
    """
    n_segments, n_actions = log_ratios.shape
    weights = None
    if seconds is not None and n_segments <= MOST_SEGMENTS:
        weights = _run_weights(n_actions, seconds)
    totals = np.concatenate([np.zeros((1, n_actions)), np.cumsum(log_ratios, axis=0)])
    forward = np.zeros((n_actions, n_segments + 1))
    for k in range(n_actions - 1):
        ended = _ended(totals[:, k], weights, forward[k])
        forward[k + 1] = np.logaddexp.accumulate(np.logaddexp(ended, forward[k] + SKIP))
    posteriors = np.empty((n_segments, n_actions))
    backward = np.zeros(n_segments + 1)
    for k in range(n_actions - 1, -1, -1):
        begun, inside = _begun(totals[:, k], weights, forward[k], backward)
        begun = np.logaddexp(begun, SKIP + backward)
        total = _log_sum(forward[k] + begun, axis=0)
        posteriors[:, k] = np.clip(np.exp(inside - total), 0.0, 1.0)
        backward = np.logaddexp.accumulate(begun[::-1])[::-1]
    return posteriors


def _run_weights(n_actions: int, seconds: FloatArray) -> FloatArray:
    """Return the log-weights of the runs of segments [i, j): array (segments + 1, segments + 1)."""
    bounds = np.arange(len(seconds) + 1)
    ends = np.concatenate([[0.0], np.cumsum(seconds)])
    shares = np.maximum(ends[None, :] - ends[:, None], 1e-9) * n_actions / ends[-1]
    costs = np.minimum(0.5 * (np.log(shares) / SPREAD) ** 2, MOST_COST)
    return np.where(bounds[:, None] < bounds, -costs, -np.inf)


def _ended(totals: FloatArray, weights: FloatArray | None, before: FloatArray) -> FloatArray:
    """Return log-sums over the runs of one action that end at each bound: array (segments + 1,).

    The run of segments [i, j), i < j, weighs totals[j] - totals[i] + weights[i, j]; without
    ``weights``, the last term is 0.

    Shapes: `totals`, `before` (segments + 1,); `weights` (segments + 1, segments + 1) or None.
    """
    if weights is None:
        starts = np.logaddexp.accumulate(before - totals)[:-1]
        return np.concatenate([[-np.inf], starts + totals[1:]])
    return _log_sum((before - totals)[:, None] + weights, axis=0) + totals


def _begun(
    totals: FloatArray, weights: FloatArray | None, before: FloatArray, behind: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Log-sums over the runs of one action that start at, or hold, each segment.

    Parameters as of :func:`_ended`; `behind` (segments + 1,): log-weight of all that is behind a
    run that ends at each bound.
    """
    if weights is None:
        starts = np.logaddexp.accumulate(before - totals)[:-1]
        stops = np.logaddexp.accumulate((totals + behind)[::-1])[::-1][1:]
        return np.concatenate([stops - totals[:-1], [-np.inf]]), starts + stops
    ways = weights + (totals + behind)
    begun = _log_sum(ways, axis=1) - totals
    joint = ways + (before - totals)[:, None]
    top = float(joint.max())
    shares = np.exp(joint - top)
    held = np.cumsum(shares.sum(axis=1) - shares.sum(axis=0))[:-1]
    with np.errstate(divide="ignore"):
        return begun, np.log(np.maximum(held, 0.0)) + top


def _log_sum(values: FloatArray, axis: int) -> FloatArray:
    """Return the logarithm of the sum of exponentials; -inf where all values are."""
    top = np.maximum(values.max(axis=axis, keepdims=True), -1e300)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.exp(values - top).sum(axis=axis)) + top.squeeze(axis))


ORDERED = 0.7
"""Share of the ordered alignment in the mixture, from a first prototype; 1 was worse by .01."""
LABELLED = 20.0
"""Nats for an action where a person labelled it; more than the evidence of any motion against
it."""
HALF = 0.5
"""Share of an action's largest evidence in a take from which it is likelier than none, as where
intervals of answers end (``by_question.grow``). On joined Bandai-Namco captures .65 of 243
questions about listed actions were placed right with it, .58 with 0 and .59 with .3; on joined CMU
captures there was no difference."""


@dataclass(frozen=True, eq=False)
class ListedTakes:
    """Takes with the actions that their captions list."""

    # (rows, columns): vector of the motion around each segment, of length 1. The rows are the
    # segments of all takes
    vectors: FloatArray | Float32Array
    seconds: FloatArray  # (rows,): duration of each segment
    owners: IntArray  # (rows,): number of the take of each segment, rising from 0 without gaps
    # For each take its listed actions in order, each as the numbers of its words; never empty
    actions: Sequence[Sequence[Sequence[int]]]
    # For each take the words of its other captions, without an order
    further: Sequence[Sequence[int]]
    n_words: int  # Size of the vocabulary
    # (rows, words): y where people labelled an interval: 1 where a word is shown, 0 if it is not,
    # NaN if there is no label. None if there are no labels
    labelled: FloatArray | None = None

    def rows(self) -> list[slice]:
        """Return the rows of each take."""
        ends = np.searchsorted(self.owners, np.arange(1, len(self.actions) + 1))
        return [slice(int(a), int(b)) for a, b in zip(np.concatenate([[0], ends]), ends)]

    def part(self, takes: slice, rows: slice) -> ListedTakes:
        """Some of the takes, which have these rows; the vectors stay those of all."""
        return ListedTakes(
            self.vectors,
            self.seconds[rows],
            self.owners[rows] - takes.start,
            self.actions[takes],
            self.further[takes],
            self.n_words,
            None if self.labelled is None else self.labelled[rows],
        )


def even_shares(takes: ListedTakes, rows: Sequence[slice]) -> FloatArray:
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


def place_actions(
    takes: ListedTakes, evidence: FloatArray, labels: Sequence[tuple[int, ...]]
) -> FloatArray:
    """y of one round before damping: array (rows, words); `labels`: those of all takes."""
    shown = np.zeros_like(evidence)
    for inside, actions, further in zip(takes.rows(), takes.actions, takes.further):
        shown[inside, list(further)] = 1.0 / len(actions)
        take_words = {word for action in actions for word in action} | set(further)
        unlisted = [label for label in labels if not take_words.issuperset(label)]
        if len(actions) == 1:
            unlisted, placed = [], np.ones((inside.stop - inside.start, 1))
        else:
            every = [*actions, *unlisted]
            said = None if takes.labelled is None else takes.labelled[inside]
            ratios = _ratios(evidence[inside], takes.seconds[inside], every, said)
            placed = _mixture(ratios, len(actions), takes.seconds[inside])
        for k, action in enumerate([*actions, *unlisted]):
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


def _ratios(
    evidence: FloatArray,
    seconds: FloatArray,
    actions: Sequence[Sequence[int]],
    labelled: FloatArray | None,
) -> FloatArray:
    """Return the log-likelihood ratios of actions against none of them, in nats.

    Shapes: `evidence` (segments, words); `seconds` (segments,); `labelled` (segments, words) or
    None; result (segments, actions).
    """
    values = np.stack([evidence[:, list(action)].mean(axis=1) for action in actions], axis=1)
    if labelled is None:
        said = np.zeros_like(values)
    else:
        said = np.stack([_said(labelled[:, list(action)]) for action in actions], axis=1)
    peaks = np.where(said < 0.0, 0.0, values).max(axis=0)
    ratios = (values - HALF * np.maximum(peaks, 0.0)) * np.sqrt(seconds)[:, None]
    return np.asarray(ratios + LABELLED * said)


def _said(labelled: FloatArray) -> FloatArray:
    """Return 1 where labels say all words of an action, -1 where none: array (segments,).

    Words without a label do not count; 0 where no word has one.
    """
    known = ~np.isnan(labelled)
    signed = np.where(known, 2.0 * np.nan_to_num(labelled) - 1.0, 0.0)
    return np.asarray(signed.sum(axis=1) / np.maximum(known.sum(axis=1), 1))


def _mixture(ratios: FloatArray, n_listed: int, seconds: FloatArray) -> FloatArray:
    """Mix the ordered and unordered posteriors: array (segments, actions).

    The first ``n_listed`` actions are listed in order. The others have unordered posteriors only.
    Where the likeliest of them has a positive ratio, it takes the place of "none of the listed
    actions".
    """
    top = np.maximum(ratios.max(axis=1, keepdims=True), 0.0)
    odds = np.exp(ratios - top)
    placed = odds / (odds.sum(axis=1, keepdims=True) + np.exp(-top))
    none = np.max(ratios[:, n_listed:], axis=1, keepdims=True, initial=0.0)
    ordered = align_in_order(ratios[:, :n_listed] - none, seconds)
    placed[:, :n_listed] = ORDERED * ordered + (1.0 - ORDERED) * placed[:, :n_listed]
    return np.asarray(placed)
