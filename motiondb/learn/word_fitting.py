"""Words from segments and captions: association, word map, counts and certainties.

Expectation-maximisation and ridge regression run once, when the database learns; the models for
questions are computed from the counts (:mod:`motiondb.meaning.counting`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.language.translation import association
from motiondb.learn import joining
from motiondb.learn.checking import LEAST_CHECKING, carry, join_certainties
from motiondb.learn.joining import OwnRows, Published
from motiondb.learn.knowledge import Started
from motiondb.meaning import asked_certainty, counting, score_vectors
from motiondb.meaning.asked_certainty import fit_certainties
from motiondb.meaning.counting import Counted, Described
from motiondb.meaning.description_map import fit_description_calibration
from motiondb.meaning.regression import Certainties
from motiondb.meaning.score_vectors import StandardisedRows
from motiondb.meaning.word_map import choose_ridge_and_calibration
from motiondb.records import Caption, FloatArray, IntArray, SegmentTable


@dataclass(frozen=True, eq=False)
class TaughtWords:
    """The captions of the captures to learn from."""

    captions: Mapping[int, tuple[Caption, ...]]  # Capture number -> captions
    synonyms: Mapping[str, str]  # Lemma -> canonical lemma
    performers: Mapping[int, str]  # Capture number -> performer

    @cached_property
    def lemmas(self) -> dict[str, str]:
        """Lemmas that the dictionary gives for the words of the captions."""
        return counting.dictionary_lemmas(self.captions)

    def described(self, table: SegmentTable) -> list[Described]:
        """The captions with motion words, and the segments that they describe."""
        return counting.described_intervals(table, self.captions, self.synonyms, self.lemmas)


@dataclass(frozen=True, eq=False)
class FittedWords:
    """The models of words."""

    published: Published  # The models for questions, with those of the start
    described: list[Described]
    score_space: score_vectors.ScoreSpace
    certainties: Certainties
    counted: Counted
    # (2,) or None: calibration of the words told of a motion; None without captions and with a
    # start
    description_calibration: FloatArray | None = None

    @property
    def numbers(self) -> dict[str, int]:
        """Word -> its number."""
        return {word: n for n, word in enumerate(self.published.association.words)}


@dataclass(frozen=True, eq=False)
class _Rows:
    """Described intervals as rows: vectors, words present, captures and performers."""

    vectors: FloatArray
    presence: NDArray[np.bool_]
    captures: IntArray
    performers: IntArray


def fit_words(
    table: SegmentTable, taught: TaughtWords, started: Started | None = None
) -> FittedWords:
    """Learn the association of words and symbols, and the certainty of answers.

    With a start, its words are joined with those of the captions, if there are any.
    """
    scores = score_vectors.fit_score_space(table.scores, table.ends - table.starts, table.movement)
    described = taught.described(table)
    words: Sequence[str] = vocabulary.count_words([d.words for d in described])[0]
    if started is not None:
        scores = joining.adapt_score_space(started, scores, len(table.symbols))
        words = joining.join_vocabulary(tuple(words), started)
    reference = _fit_reference(table, taught, described, words, scores, started)
    counts = counting.count(table, taught.captions, taught.synonyms, reference)
    counted = Counted(counts, reference)
    ridge, calibration, certainties, told = None, None, Certainties(), None
    if started is not None:
        ridge, calibration = started.taught.ridge, started.taught.calibration
    if described:
        number = {word: n for n, word in enumerate(words)}
        rows = _training_rows(table, described, scores, number, taught.performers)
        if started is None:
            ridge, calibration = choose_ridge_and_calibration(
                rows.vectors, rows.presence, rows.performers
            )
            if counts.moments.n >= LEAST_CHECKING:
                certainties = _certainties(
                    table, described, rows, scores, words, ridge, calibration
                )
            told = fit_description_calibration(rows.vectors, rows.presence, rows.performers)
        else:
            mine = OwnRows(rows.vectors, rows.presence, rows.performers, tuple(words), started)
            ridge, calibration = joining.choose_ridge_and_calibration(mine)
            own = _certainties(table, described, rows, scores, words, ridge, calibration, mine)
            certainties = join_certainties(own, carry(started.taught.certainties), counts.moments.n)
    published = joining.publish(counted, started, ridge, calibration)
    return FittedWords(published, described, scores, certainties, counted, told)


def _fit_reference(
    table: SegmentTable,
    taught: TaughtWords,
    described: Sequence[Described],
    words: Sequence[str],
    scores: score_vectors.ScoreSpace,
    started: Started | None,
) -> counting.Reference:
    """The reference for counting own captions: the association of these and of the start."""
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, table.scores.shape[1], words)
    shapes: Mapping[tuple[int, int], float] = Counter((len(s), len(spoken)) for s, spoken in pairs)
    alone = counting.make_reference(fitted, shapes, scores, taught.lemmas)
    if started is None:
        return alone
    expected = counting.count(table, taught.captions, taught.synonyms, alone).expected
    joint = joining.join_reference(fitted, expected, started)
    all_shapes = {shape: float(n) for shape, n in started.taught.shapes.items()}
    for shape, n in shapes.items():
        all_shapes[shape] = all_shapes.get(shape, 0.0) + n
    return counting.make_reference(joint, all_shapes, scores, taught.lemmas)


def _training_rows(
    table: SegmentTable,
    described: list[Described],
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
    described: Sequence[Described],
    rows: _Rows,
    scores: score_vectors.ScoreSpace,
    words: Sequence[str],
    ridge: float,
    calibration: FloatArray,
    own_rows: OwnRows | None = None,
) -> Certainties:
    """Certainties of answers, from questions whose answers are known from the captions.

    With a start, ``own_rows`` fits the word map without some rows.
    """
    if len(rows.captures) < len(rows.performers):  # one row, doubled
        return Certainties()
    intervals, _ = counting.merged_intervals(described, {word: n for n, word in enumerate(words)})
    fit_without, join = None, None
    if own_rows is not None:
        join = partial(joining.join_moments, words=own_rows.words, started=own_rows.started)
        fit_without = partial(own_rows.without, ridge=ridge, calibration=calibration)
    return fit_certainties(
        asked_certainty.Written(
            vectors=rows.vectors,
            presence=rows.presence,
            names=words,
            captures=rows.captures,
            starts=np.array([d.start for d in intervals]),
            ends=np.array([d.end for d in intervals]),
            groups=rows.performers,
            table=table,
            standardised=StandardisedRows.of_table(scores, table),
            ridge=ridge,
            calibration=calibration,
            n_posture_and_travel=score_vectors.count_posture_and_travel(table.movement.shape[1]),
            fit_without=fit_without,
            join=join,
        )
    )
