"""Words from segments and captions: association, word map, counts and certainties.

Expectation-maximisation and ridge regression run once, when the database learns; the models for
questions are computed from the counts (:mod:`motiondb.meaning.counting`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.language.translation import association
from motiondb.learn import joining
from motiondb.learn.checking import LEAST_CHECKING, carry, join_certainties
from motiondb.learn.joining import OwnRows, choose_ridge_and_calibration
from motiondb.learn.knowledge import Started
from motiondb.meaning import asked_certainty, counting, score_vectors, word_map
from motiondb.meaning.asked_certainty import fit_certainties
from motiondb.meaning.counting import Counted
from motiondb.meaning.description_map import fit_description_calibration
from motiondb.meaning.regression import Certainties
from motiondb.records import Association, Caption, FloatArray, IntArray, SegmentTable


@dataclass(frozen=True, eq=False)
class TaughtWords:
    """The captions of the captures to learn from."""

    captions: Mapping[int, tuple[Caption, ...]]  # Capture number -> captions
    synonyms: Mapping[str, str]  # Lemma -> canonical lemma
    performers: Mapping[int, str]  # Capture number -> performer


@dataclass(frozen=True, eq=False)
class FittedWords:
    """The models of words."""

    association: Association  # t and a that follow from the counts
    score_space: score_vectors.ScoreSpace
    # Map from score vectors to words; None if no words were written
    word_map: word_map.WordMap | None
    certainties: Certainties
    counted: Counted
    # (symbols + 1, symbols + 1): transitions of symbols, with those of the start
    transitions: FloatArray
    # (symbols l, words m) -> number of described intervals, with those of the start
    lengths: Mapping[tuple[int, int], int]
    # (2,) or None: calibration of the words told of a motion; None without captions and with a
    # start
    description_calibration: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class _Rows:
    """Described intervals as rows: vectors, words present, captures and performers."""

    vectors: FloatArray
    presence: NDArray[np.bool_]
    captures: IntArray
    performers: IntArray


def fit_words(table: SegmentTable, taught: TaughtWords, n_symbols: int) -> FittedWords:
    """Learn the association of words and symbols, and the certainty of answers."""
    scores = score_vectors.fit_score_space(table.scores, table.ends - table.starts, table.movement)
    known = counting.dictionary_lemmas(taught.captions)
    described = counting.described_intervals(table, taught.captions, taught.synonyms, known)
    words, _ = vocabulary.count_words([d.words for d in described])
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, n_symbols, words)
    shapes = Counter((len(symbols), len(spoken)) for symbols, spoken in pairs)
    reference = counting.make_reference(fitted, shapes, scores, known)
    counts = counting.count(table, taught.captions, taught.synonyms, reference)
    ridge, calibration, certainties, told = None, None, Certainties(), None
    if described:
        rows = _training_rows(table, described, scores, number, taught.performers)
        fit = word_map.fit_word_map(rows.vectors, rows.presence, rows.performers)
        ridge, calibration = fit.ridge, fit.calibration
        if counts.moments.n >= LEAST_CHECKING:
            certainties = _certainties(table, described, rows, scores, fit)
        told = fit_description_calibration(rows.vectors, rows.presence, rows.performers)
    return FittedWords(
        counting.publish_association(counts, reference),
        scores,
        counting.publish_word_map(counts, ridge, calibration),
        certainties,
        Counted(counts, reference),
        counts.transitions,
        dict(counts.shapes),
        told,
    )


def fit_words_with_start(table: SegmentTable, taught: TaughtWords, started: Started) -> FittedWords:
    """Learn words from own captions, if any, joined with those of a start."""
    own_space = score_vectors.fit_score_space(
        table.scores, table.ends - table.starts, table.movement
    )
    scores = joining.adapt_score_space(started, own_space, len(table.symbols))
    known = counting.dictionary_lemmas(taught.captions)
    described = counting.described_intervals(table, taught.captions, taught.synonyms, known)
    written, _ = vocabulary.count_words([d.words for d in described])
    words = joining.join_vocabulary(tuple(written), started)
    reference = _joint_reference(table, taught, started, scores, known)
    counts = counting.count(table, taught.captions, taught.synonyms, reference)
    number = {word: n for n, word in enumerate(words)}
    ridge, calibration = started.taught.ridge, started.taught.calibration
    certainties = Certainties()  # nothing is checked before there are own captions
    if described:
        rows = _training_rows(table, described, scores, number, taught.performers)
        mine = OwnRows(rows.vectors, rows.presence, rows.performers, words, started)
        ridge, calibration = choose_ridge_and_calibration(mine)
        fit = mine.without(np.zeros(len(rows.vectors), dtype=bool), ridge, calibration)
        learned = _certainties(table, described, rows, scores, fit, mine)
        first = carry(started.taught.certainties)
        certainties = join_certainties(learned, first, counts.moments.n)
    joint = joining.publish(counts, reference, started, ridge, calibration)
    return FittedWords(
        joint.association,
        scores,
        joint.word_map,
        certainties,
        Counted(counts, reference),
        joint.transitions,
        joint.lengths,
    )


def _joint_reference(
    table: SegmentTable,
    taught: TaughtWords,
    started: Started,
    scores: score_vectors.ScoreSpace,
    known: Mapping[str, str],
) -> counting.Reference:
    """The reference for counting own captions: the association of own captions and the start."""
    described = counting.described_intervals(table, taught.captions, taught.synonyms, known)
    written, _ = vocabulary.count_words([d.words for d in described])
    words = joining.join_vocabulary(tuple(written), started)
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, table.scores.shape[1], words)
    shapes = Counter((len(symbols), len(spoken)) for symbols, spoken in pairs)
    alone = counting.make_reference(fitted, shapes, scores, known)
    expected = counting.count(table, taught.captions, taught.synonyms, alone).expected
    joint = joining.join_reference(fitted, expected, started)
    all_shapes = {shape: float(n) for shape, n in started.taught.shapes.items()}
    for shape, n in shapes.items():
        all_shapes[shape] = all_shapes.get(shape, 0.0) + n
    return counting.make_reference(joint, all_shapes, scores, known)


def _training_rows(
    table: SegmentTable,
    described: list[counting.Described],
    scores: score_vectors.ScoreSpace,
    number: Mapping[str, int],
    performers: Mapping[int, str],
) -> _Rows:
    vectors, presence, captures = counting.training_rows(table, described, scores, number)
    who = np.unique([performers[int(c)] for c in captures], return_inverse=True)[1]
    if len(vectors) == 1:  # doubled, so that a row is left when the map leaves one out
        vectors, presence, who = vectors.repeat(2, 0), presence.repeat(2, 0), np.arange(2)
    return _Rows(vectors, presence, captures, who)


def _certainties(
    table: SegmentTable,
    described: Sequence[counting.Described],
    rows: _Rows,
    scores: score_vectors.ScoreSpace,
    fit: word_map.WordMap,
    own_rows: OwnRows | None = None,
) -> Certainties:
    """Certainties of answers, from questions whose answers are known from the captions.

    With a start, ``own_rows`` fits the word map without some rows.
    """
    if len(rows.captures) < len(rows.performers):  # one row, doubled
        return Certainties()
    starts, ends = asked_certainty.intervals_of(described)
    names: Sequence[str] = vocabulary.count_words([d.words for d in described])[0]
    fit_without, join = None, None
    if own_rows is not None:
        names = own_rows.words
        join = partial(joining.join_moments, words=names, started=own_rows.started)
        fit_without = partial(own_rows.without, ridge=fit.ridge, calibration=fit.calibration)
    return fit_certainties(
        asked_certainty.Written(
            vectors=rows.vectors,
            presence=rows.presence,
            names=names,
            captures=rows.captures,
            starts=starts,
            ends=ends,
            groups=rows.performers,
            table=table,
            standardised=scores.standardise(table.scores, table.movement),
            ridge=fit.ridge,
            calibration=fit.calibration,
            n_posture_and_travel=score_vectors.count_posture_and_travel(table.movement.shape[1]),
            fit_without=fit_without,
            join=join,
        )
    )
