"""Takes with the actions that their captions list, and y, where each action is likely.

Let e_iw be the evidence for word w at segment i, from the motion alone, e_ik the mean over the
words of action k, and p_k the largest e_ik of the take. The log-likelihood ratio of action k
against none of the actions is

    r_ik = sqrt(seconds of the segment) (e_ik - HALF max(p_k, 0)),

so that an action with a little evidence everywhere is shown where there is most of it. Labels of
intervals add ``LABELLED`` nats for or against an action. The ratios give two posteriors. The
ordered one keeps the caption's order (:mod:`motiondb.meaning.maps.ordered_alignment`). The
unordered
one is a softmax over the actions and none of them. y is a mixture of both. Words of other captions
of the same take keep equal shares.

A take may show an action that none of its captions lists, and a label in another take may have
taught what this action looks like. In takes that list several actions, such unlisted actions
compete with the listed ones, and get y by the unordered posterior. If y were 0 there, segments that
move like the labelled ones would be examples against the label's words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.maps.ordered_alignment import align_in_order
from motiondb.records import FloatArray, IntArray

ORDERED = 0.7
"""Share of the ordered alignment in the mixture, from a first prototype; 1 was worse by .01."""
LABELLED = 20.0
"""Nats for an action where a person labelled it; more than the evidence of any motion against
it."""
HALF = 0.5
"""Share of an action's largest evidence in a take from which it is likelier than none, as where
intervals of answers end (``search.questions.by_words.grow``). On joined Bandai-Namco captures .65
of 243 questions about listed actions were placed right with it, .58 with 0 and .59 with .3; on
joined CMU captures there was no difference."""


@dataclass(frozen=True, eq=False)
class ListedTakes:
    """Takes with the actions that their captions list."""

    # (rows, columns): vector of the motion around each segment, of length 1. The rows are the
    # segments of all takes
    vectors: FloatArray
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


def place_actions(takes: ListedTakes, rows: Sequence[slice], evidence: FloatArray) -> FloatArray:
    """Return y of one round before damping: array (rows, words)."""
    shown = np.zeros_like(evidence)
    labels = _labels(takes)
    for inside, actions, further in zip(rows, takes.actions, takes.further):
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
