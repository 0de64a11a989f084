"""Words from segments and captions: association, word map, counts and certainties.

Expectation-maximisation and ridge regression run once, when the database learns; what is published
follows from the counts (:mod:`motiondb.learning.counting`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.learning import counting
from motiondb.learning.certainty import asked_certainty
from motiondb.learning.certainty.asked_certainty import Certainties
from motiondb.learning.learned import Counted
from motiondb.records import Association, Caption, FloatArray, IntArray, SegmentTable
from motiondb.search.vectors import movement, score_vectors
from motiondb.words.lexicon import vocabulary
from motiondb.words.maps import word_map
from motiondb.words.translation import association


@dataclass(frozen=True, eq=False)
class TaughtWords:
    """What people wrote about the captures to learn from.

    Attributes
    ----------
    captions : dict
        Capture number -> captions.
    synonyms : dict
        Lemma -> canonical lemma.
    performers : dict
        Capture number -> who performs.
    """

    captions: Mapping[int, tuple[Caption, ...]]
    synonyms: Mapping[str, str]
    performers: Mapping[int, str]


@dataclass(frozen=True, eq=False)
class FittedWords:
    """What is learned about words.

    Attributes
    ----------
    association : Association
        t and a that follow from the counts.
    score_space : ScoreSpace
        Standardisation of scores.
    word_map : WordMap or None
        Map from score vectors to words; None where no words were written.
    certainties : Certainties
        How sure answers are.
    counted : Counted
        The counts.
    """

    association: Association
    score_space: score_vectors.ScoreSpace
    word_map: word_map.WordMap | None
    certainties: Certainties
    counted: Counted


@dataclass(frozen=True, eq=False)
class _Rows:
    """Described intervals as rows: vectors, words present, captures and performers."""

    vectors: FloatArray
    presence: NDArray[np.bool_]
    captures: IntArray
    performers: IntArray


def fit_words(table: SegmentTable, taught: TaughtWords, n_symbols: int) -> FittedWords:
    """Learn how words and symbols belong together, and how sure answers are."""
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
    ridge, calibration, certainties = None, None, Certainties()
    if described:
        rows = _training_rows(table, described, scores, number, taught.performers)
        fit = word_map.fit_word_map(rows.vectors, rows.presence, rows.performers)
        ridge, calibration = fit.ridge, fit.calibration
        certainties = _certainties(table, described, rows, scores, fit)
    return FittedWords(
        counting.publish_association(counts, reference),
        scores,
        counting.publish_word_map(counts, ridge, calibration),
        certainties,
        Counted(counts, reference),
    )


def _training_rows(
    table: SegmentTable,
    described: list[counting.Described],
    scores: score_vectors.ScoreSpace,
    number: Mapping[str, int],
    performers: Mapping[int, str],
) -> _Rows:
    vectors, presence, captures = counting.training_rows(table, described, scores, number)
    who = np.unique([performers[int(c)] for c in captures], return_inverse=True)[1]
    if len(vectors) == 1:  # twice, so that something is left when the map leaves one out
        vectors, presence, who = vectors.repeat(2, 0), presence.repeat(2, 0), np.arange(2)
    return _Rows(vectors, presence, captures, who)


def _certainties(
    table: SegmentTable,
    described: Sequence[counting.Described],
    rows: _Rows,
    scores: score_vectors.ScoreSpace,
    fit: word_map.WordMap,
) -> Certainties:
    """How sure answers are, from questions whose answers the captions give."""
    if len(rows.captures) < len(rows.performers):  # one row, doubled
        return Certainties()
    starts, ends = asked_certainty.intervals_of(described)
    names, _ = vocabulary.count_words([d.words for d in described])
    return asked_certainty.fit_certainties(
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
            n_posture_and_travel=movement.count_posture_and_travel(table.movement.shape[1]),
        )
    )
