"""Combine what is learned from own captions with the start of a database.

Notation: n the number of own described intervals, w = 1 / (1 + n / TRUST) the weight of the start.
Everything that is learned from captions is a sum over captions: moments of the word map, expected
counts of the association, numbers of words and shapes. The joint sum is that of the own captions
plus w times that of the start. The transitions of symbols are joined in the same way with n the
number of own captures.

A caption is no evidence about a word that its authors do not use: if no own caption has "sprint",
an own capture may still show one. Every word is therefore fitted to the intervals of those sources
alone whose captions hold the word anywhere: both sources, the start or own captions.

**Ridge and calibration of the joint word map** are chosen as in :mod:`motiondb.meaning.word_map`,
with predictions for own intervals by the joint map of the start and the other groups. The
calibration is the start's, moved by the own predictions: the Fisher information of the start's
calibration, times the weight of the start, represents its data.

A learned model also gets other counts here, when captures and words change.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motiondb.language.translation import explanation
from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn.knowledge import Started
from motiondb.learn.learned_model import LearnedModel
from motiondb.meaning.counting import Counted, publish_association
from motiondb.meaning.regression import Certainty, calibrate
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import (
    RIDGES,
    CaptionMoments,
    WordMap,
    WordMoments,
    largest_good_ridge,
    logit,
    solve_word_map,
    word_moments,
    word_spreads,
)
from motiondb.records import Association, FloatArray, IntArray, SegmentTable

Model = TypeVar("Model", bound=LearnedModel)

TRUST = 10.0
"""Own captions (captures, for transitions) at which the start weighs half. Chosen among 3, 10 and
30 by docs/measured/start.md, on captures of both studios."""
TRUSTED_SEGMENTS = 300.0
"""Own segments at which the standardisation of the start weighs half. Chosen among 0, 30, 100, 300,
1,000 and never on captures of both studios without captions (docs/measured/start.md)."""
STRANGE = 0.2
"""Share of the own motion that the symbols of the start may explain worse than the background.
Chosen by hand between 0.00 (CMU symbols, Bandai-Namco motion) and 0.62 (the other way)."""
ENOUGH = 100
"""Number of own described intervals at which a start whose symbols do not fit is set aside: with
more, it lowered the rank of true words on CMU captures (docs/measured/start.md)."""
N_FOLDS = 5  # Folds of groups that are held out in turn
LEAST_INTERVALS = 10  # Own intervals below which ridge and calibration are the start's


@dataclass(frozen=True, eq=False)
class Published:
    """The fields of the learned model that follow from counts."""

    # t and a; ``counts`` are those of own captions plus w times the start's, at least 1
    association: Association
    transition_counts: FloatArray  # (symbols + 1, symbols + 1): joint counts
    lengths: Mapping[tuple[int, int], int]  # (symbols l, words m) -> number of described intervals
    fitted_word_map: WordMap | None


def start_weight(n_own: float) -> float:
    """w of the module's docstring.

    >>> start_weight(0), start_weight(10), round(start_weight(190), 3)
    (1.0, 0.5, 0.05)
    """
    return 1.0 / (1.0 + max(n_own, 0.0) / TRUST)


def strange_share(table: SegmentTable) -> float:
    """Share of the frames whose segment the best symbol explains worse than the background does."""
    frames = (table.ends - table.starts).astype(np.float64)
    strange = table.log_likelihoods < table.backgrounds
    return float(frames[strange].sum() / max(frames.sum(), 1.0))


def fits(table: SegmentTable) -> bool:
    """Whether the symbols of the start explain nearly all of the own motion."""
    return strange_share(table) <= STRANGE


def is_set_aside(table: SegmentTable, n_own: float) -> bool:
    """Whether own captures are learned from alone, because the start's symbols do not fit them."""
    return n_own >= ENOUGH and not fits(table)


def join_vocabulary(own_words: tuple[str, ...], started: Started) -> tuple[str, ...]:
    """Words of own captions and of the start, sorted."""
    return tuple(sorted({*own_words, *started.names}))


def adapt_score_space(started: Started, own_space: ScoreSpace, n_segments: int) -> ScoreSpace:
    """Standardisation for own captures: means and variances of both, weighted."""
    share = n_segments / (TRUSTED_SEGMENTS + n_segments)
    first = started.knowledge.score_space
    variance = (1.0 - share) * first.spread**2 + share * own_space.spread**2
    return ScoreSpace((1.0 - share) * first.mean + share * own_space.mean, np.sqrt(variance))


def join_word_map(
    own_moments: WordMoments,
    words: tuple[str, ...],
    started: Started,
    ridge: float,
    calibration: FloatArray,
) -> WordMap:
    """The word map of own captions and the start; `calibration` (3,)."""
    chosen = started.columns(words)
    n, first = started.taught.moments.n, started.taught.moments.words @ chosen
    in_start = np.asarray(chosen.any(axis=0), dtype=bool)
    in_own = np.asarray(own_moments.words > 0, dtype=bool)
    joint = join_moments(own_moments, words, started)
    weights = started.word_map.weights @ chosen  # linear in the words, so that synonyms add up
    offsets = started.word_map.offsets @ chosen
    priors = np.clip(first / n, 0.5 / n, 1.0 - 0.5 / n)
    for which, moments in ((in_start & in_own, joint), (~in_start, own_moments)):
        if which.any():
            fit = solve_word_map(moments.of_words(which), ridge, calibration)
            weights[:, which], offsets[which] = fit.weights, fit.offsets
            priors[which] = fit.priors
    return WordMap(weights, offsets, priors, word_spreads(priors), calibration, ridge=ridge)


def join_moments(own_moments: WordMoments, words: tuple[str, ...], started: Started) -> WordMoments:
    """Sums over own captions plus w times those of the start, over the joint vocabulary."""
    chosen, taught = started.columns(words), started.taught.moments
    weight = start_weight(own_moments.n)
    first = WordMoments(
        weight * taught.n,
        weight * taught.vectors,
        weight * (taught.words @ chosen),
        weight * taught.gram,
        weight * (taught.cross @ chosen),
        CaptionMoments(
            weight * (taught.captions.words @ chosen), weight * (taught.captions.cross @ chosen)
        ),
    )
    return first + own_moments


def join_expected(
    own_counts: ExpectedCounts, words: tuple[str, ...], started: Started
) -> ExpectedCounts:
    """Expected counts of own captions plus w times those of the start; no longer exact."""
    weight, taught = start_weight(own_counts.n_pairs), started.taught.expected
    alignment = {shape: weight * table for shape, table in taught.alignment.items()}
    for shape, table in own_counts.alignment.items():
        alignment[shape] = table + alignment.get(shape, 0.0)
    translation = own_counts.translation + weight * taught.translation @ started.columns(words)
    return ExpectedCounts(translation, alignment, own_counts.n_pairs + taught.n_pairs)


def publish(
    counted: Counted, started: Started | None, ridge: float | None, calibration: FloatArray | None
) -> Published:
    """The models for questions, from own counts and those of a start; `calibration` (3,).

    Without ridge and calibration there is no word map.
    """
    counts, reference = counted.counts, counted.reference
    if started is None or ridge is None or calibration is None:
        word_map = None
        if ridge is not None and calibration is not None:
            word_map = solve_word_map(counts.moments, ridge, calibration)
        association = publish_association(counts, reference)
        return Published(association, counts.transitions, dict(counts.shapes), word_map)
    words, taught = reference.association.words, started.taught
    weight = start_weight(counts.moments.n)
    joint = replace(counts, expected=join_expected(counts.expected, words, started))
    association = replace(
        publish_association(joint, reference), counts=join_said(counts.said, words, started, weight)
    )
    lengths = Counter(counts.shapes)
    lengths.update({shape: round(weight * n) for shape, n in taught.shapes.items()})
    n_captures = float(counts.transitions[0].sum())
    return Published(
        association,
        counts.transitions + start_weight(n_captures) * taught.transitions,
        {shape: n for shape, n in lengths.items() if n > 0},
        join_word_map(counts.moments, words, started, ridge, calibration),
    )


def join_said(
    own_said: NDArray[np.int64], words: tuple[str, ...], started: Started, weight: float
) -> NDArray[np.int64]:
    """Numbers of captions of every word: own ones plus w times the start's, at least 1 of these."""
    start_said = started.taught.said @ started.columns(words)
    joint = own_said + np.where(start_said > 0, np.maximum(np.rint(weight * start_said), 1.0), 0.0)
    return np.asarray(joint, dtype=np.int64)


def join_certainty(
    own_certainty: Certainty | None, first: Certainty | None, n_own: float
) -> Certainty | None:
    """Return the mean of both certainties, the start's with weight w; if one is None, the other."""
    if own_certainty is None or first is None or len(own_certainty.weights) != len(first.weights):
        return first if own_certainty is None else own_certainty
    share = start_weight(n_own)
    threshold = own_certainty.threshold
    if np.isnan(threshold):
        threshold = first.threshold
    elif not np.isnan(first.threshold):
        threshold = share * first.threshold + (1.0 - share) * threshold
    return Certainty(
        share * first.weights + (1.0 - share) * own_certainty.weights,
        share * first.constant + (1.0 - share) * own_certainty.constant,
        threshold,
    )


def join_reference(fitted: Association, counted: ExpectedCounts, started: Started) -> Association:
    """The association that distributes words among symbols in counting."""
    weight = start_weight(counted.n_pairs)
    empty = replace(
        fitted,
        translation=np.zeros_like(fitted.translation),
        counts=join_said(np.asarray(fitted.counts), fitted.words, started, weight),
    )
    return explanation.with_counts(empty, join_expected(counted, fitted.words, started))


@dataclass(frozen=True, eq=False)
class OwnRows:
    """Own described intervals and the start."""

    vectors: FloatArray  # (rows, columns): score vectors
    # (rows, words): which words of the joint vocabulary were written about each interval
    presence: NDArray[np.bool_]
    groups: IntArray  # (rows,): performers
    words: tuple[str, ...]
    started: Started

    @cached_property
    def moments(self) -> WordMoments:
        """Sums over all rows."""
        return word_moments(self.vectors, self.presence)

    def without(self, rows: NDArray[np.bool_], ridge: float, calibration: FloatArray) -> WordMap:
        """The joint word map without some own rows."""
        left = self.moments - word_moments(self.vectors[rows], self.presence[rows])
        return join_word_map(left, self.words, self.started, ridge, calibration)


def choose_ridge_and_calibration(own_rows: OwnRows) -> tuple[float, FloatArray]:
    """Ridge and calibration of the joint word map."""
    taught = own_rows.started.taught
    if len(own_rows.vectors) < LEAST_INTERVALS:
        return taught.ridge, taught.calibration
    here = np.asarray(own_rows.presence.any(axis=0) & ~own_rows.presence.all(axis=0))
    if not here.any():
        return taught.ridge, taught.calibration
    folds = _folds(own_rows.groups)
    maps = {
        ridge: [own_rows.without(folds == k, ridge, taught.calibration) for k in np.unique(folds)]
        for ridge in RIDGES
    }
    scores = {ridge: _predict(own_rows, folds, fits) for ridge, fits in maps.items()}
    ridge = largest_good_ridge(scores, own_rows.presence, here)
    of_rows = np.searchsorted(np.unique(folds), folds)
    logits = np.stack([logit(maps[ridge][place].priors) for place in of_rows])
    calibration = calibrate(
        scores[ridge][:, here],
        logits[:, here],
        own_rows.presence[:, here].astype(np.float64),
        taught.calibration,
        start_weight(len(own_rows.vectors)) * taught.information,
    )
    return ridge, calibration


def _predict(own_rows: OwnRows, folds: IntArray, fits: list[WordMap]) -> FloatArray:
    """Evidence over spread of every word, by the map without the row's fold: (rows, words)."""
    z = np.zeros(own_rows.presence.shape)
    for fold, fit in zip(np.unique(folds), fits):
        inside = folds == fold
        z[inside] = fit.evidence(own_rows.vectors[inside]) / fit.spreads
    return z


def _folds(groups: IntArray) -> IntArray:
    """Folds of whole groups; of single rows if there is one group only."""
    names, numbers = np.unique(groups, return_inverse=True)
    if len(names) < 2:
        return np.arange(len(groups)) % min(N_FOLDS, len(groups))
    return numbers % N_FOLDS


def with_segments(model: Model, table: SegmentTable) -> Model:
    """The learned model with the segments of other captures; what was counted stays."""
    return replace(_with_captures(model, set(table.capture_ids.tolist())), segments=table)


def _with_captures(model: Model, present: set[int]) -> Model:
    """The learned model with what it knows of some captures alone; its segments stay."""
    return replace(
        model,
        places=None if model.places is None else model.places.only(present),
        judge=None if model.judge is None else model.judge.only(present),
    )


def with_counts(
    model: LearnedModel, run_id: int, present: set[int], counted: Counted
) -> LearnedModel:
    """The learned model with other counts and everything that depends on them.

    `present`: Captures that are there; the segments of the model stay.
    """
    fit = model.fitted_word_map
    model = replace(_with_captures(model, present), run_id=run_id, counted=counted)
    ridge, calibration = (None, None) if fit is None else (fit.ridge, fit.calibration)
    return replace(model, **vars(publish(counted, model.started, ridge, calibration)))
