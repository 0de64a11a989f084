"""Counts, and the models that are computed from counts.

From the captures come counts: transitions of symbols, words in captions, shapes (symbols l, words
m) of described intervals, expected counts of the association, moments of the word map. All are
integers or multiples of 2^-32, so sums are exact: subtracting a capture's counts gives the same
numbers as if it had never been counted.

Expected counts need a t and an a to share each word out among the symbols: the *reference*, which
expectation-maximisation found when the database learned, smoothed slightly so that new pairs of
symbols and words can be counted. It stays the same until the next ``learn``; so do the symbols, the
vocabulary, the standardisation of scores and the calibration. The models for questions are the
M-step of the counts.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.language.lemmas import dictionary_forms
from motiondb.language.translation import explanation, transition
from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.meaning import score_vectors
from motiondb.meaning.regression import Additive
from motiondb.meaning.word_map import WordMoments, word_moments
from motiondb.records import Association, Caption, FloatArray, IntArray, SegmentTable

REFERENCE_SHARE = 0.01
"""Share of every t of the reference that is spread evenly (see ``explanation.smoothed``). Chosen by
hand; not tuned: any value above 0 makes new pairs possible."""
REFERENCE_PAIRS = 0.1  # Weight of the diagonal relative to each learned alignment of the reference


@dataclass(frozen=True, eq=False)
class Described:
    """An interval of a capture with a caption."""

    capture_id: int  # Number of the capture
    low: int  # First row of the segment table
    high: int  # Last row + 1
    start: float  # First frame, 30 a second
    end: float  # Last frame + 1
    words: tuple[str, ...]  # Motion words in order
    n_actions: int  # Number of actions that the words name


@dataclass(frozen=True, eq=False)
class Reference:
    """The reference of the counts; constant between two runs of ``learn``."""

    association: Association  # Smoothed t and a that share each word out among the symbols
    scores: score_vectors.ScoreSpace
    # Lemmas that the dictionary gave for the words of captions
    lemmas: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Counts(Additive):
    """The contribution of some captures to all counts."""

    # (symbols + 1, symbols + 1): how often symbol column - 1 follows symbol row - 1; row 0 is the
    # begin, column 0 the end
    transitions: FloatArray
    said: IntArray  # (words,): number of captions with each word
    shapes: Counter[tuple[int, int]]  # (symbols l, words m) -> number of described intervals
    expected: ExpectedCounts
    moments: WordMoments  # Of the word map


@dataclass(frozen=True, eq=False)
class Counted:
    """The counts with their reference."""

    counts: Counts  # Sums over all counted captures
    # The reference with which the counts were made; it is constant from one ``learn`` to the next
    reference: Reference


def symbol_sequences(table: SegmentTable) -> list[IntArray]:
    """The symbol sequence of every capture, in order of capture number."""
    return [table.symbols[rows] for rows in capture_rows(table).values()]


def capture_rows(table: SegmentTable) -> dict[int, slice]:
    """Capture number -> its rows of the segment table."""
    new = np.flatnonzero(np.diff(table.capture_ids, prepend=-1))
    ends = [*new[1:], len(table.symbols)]
    return {int(table.capture_ids[a]): slice(int(a), int(b)) for a, b in zip(new, ends)}


def take_rows(table: SegmentTable, which: NDArray[np.bool_]) -> SegmentTable:
    """The rows of a segment table for which ``which`` is true."""
    return SegmentTable(**{name: column[which] for name, column in vars(table).items()})


def join_tables(*tables: SegmentTable) -> SegmentTable:
    """The rows of segment tables of different captures, in order of capture number."""
    filled = [table for table in tables if len(table.capture_ids)] or list(tables[:1])
    order = np.argsort(np.concatenate([table.capture_ids for table in filled]), kind="stable")
    columns = zip(*(vars(table).values() for table in filled))
    return SegmentTable(*(np.concatenate(column)[order] for column in columns))


def described_intervals(
    table: SegmentTable,
    captions: Mapping[int, tuple[Caption, ...]],
    synonyms: Mapping[str, str],
    known_lemmas: Mapping[str, str] | None = None,
) -> list[Described]:
    """Captions with at least one motion word, and the segments they describe.

    The segments of a capture are in order and do not overlap.
    """
    intervals = []

    @cache  # many captures have the same words
    def split(said: str) -> tuple[tuple[str, ...], int]:
        actions = vocabulary.split_actions(said, synonyms, known_lemmas)
        return tuple(word for action in actions for word in action), len(actions)

    rows = capture_rows(table)
    starts, ends = table.starts.tolist(), table.ends.tolist()
    for capture_id, said in sorted(captions.items()):
        if capture_id not in rows:
            continue
        first, last = rows[capture_id].start, rows[capture_id].stop
        for caption in said:
            words, n_actions = split(caption.words)
            start = (caption.start or 0.0) * 30.0
            end = float(ends[last - 1]) if caption.end is None else caption.end * 30.0
            low = bisect_right(ends, start, first, last)
            high = bisect_left(starts, end, first, last)
            if words and low < high:
                intervals.append(Described(capture_id, low, high, start, end, words, n_actions))
    return intervals


def known_only(described: Sequence[Described], number: Mapping[str, int]) -> list[Described]:
    """Described intervals with the words of the vocabulary only; without any they are left out."""
    known = [replace(d, words=tuple(w for w in d.words if w in number)) for d in described]
    return [d for d in known if d.words]


def merged_intervals(
    described: Sequence[Described], number: Mapping[str, int]
) -> tuple[list[Described], NDArray[np.bool_]]:
    """One caption of every interval, and the words of all of them: array (intervals, words)."""
    merged: dict[tuple[int, float, float], tuple[Described, set[str]]] = {}
    for d in described:
        merged.setdefault((d.capture_id, d.start, d.end), (d, set()))[1].update(d.words)
    presence = np.zeros((len(merged), len(number)), dtype=bool)
    for row, (_, words) in enumerate(merged.values()):
        presence[row, [number[w] for w in words]] = True
    return [d for d, _ in merged.values()], presence


def training_rows(
    table: SegmentTable,
    described: Sequence[Described],
    scores: score_vectors.ScoreSpace,
    number: Mapping[str, int],
) -> tuple[FloatArray, NDArray[np.bool_], IntArray]:
    """Vectors, words present and capture numbers, one row per described interval.

    Every capture is computed from its own rows alone, so its vectors do not depend on other
    captures, to the last bit.
    """
    intervals, presence = merged_intervals(described, number)
    rows = score_vectors.StandardisedRows.of_table(scores, table)
    vectors = np.empty((len(intervals), len(scores.mean)))
    for row, d in enumerate(intervals):
        part = slice(d.low, d.high)
        vectors[row] = score_vectors.interval_vector(
            rows[part], table.starts[part], table.ends[part], d.start, d.end
        )
    return vectors, presence, np.array([d.capture_id for d in intervals], dtype=np.int64)


def make_reference(
    fitted: Association,
    shapes: Mapping[tuple[int, int], float],
    scores: score_vectors.ScoreSpace,
    known_lemmas: Mapping[str, str] | None = None,
) -> Reference:
    """The reference from the fitted association, smoothed so that no new pair is impossible."""
    smooth = explanation.smoothed(
        fitted, shapes, share=REFERENCE_SHARE, pseudo_pairs=REFERENCE_PAIRS
    )
    return Reference(smooth, scores, known_lemmas or {})


def count(
    table: SegmentTable,
    captions: Mapping[int, tuple[Caption, ...]],
    synonyms: Mapping[str, str],
    reference: Reference,
) -> Counts:
    """The counts of all captures of a table; words outside the vocabulary are not counted."""
    words, n_symbols = reference.association.words, table.scores.shape[1]
    number = {word: n for n, word in enumerate(words)}
    described = known_only(described_intervals(table, captions, synonyms, reference.lemmas), number)
    said = np.zeros(len(words), dtype=np.int64)
    expected = ExpectedCounts(np.zeros((n_symbols + 1, len(words))))
    shapes: Counter[tuple[int, int]] = Counter()
    for d in described:
        spoken = np.array([number[w] for w in d.words])
        said[np.unique(spoken)] += 1
        shapes[d.high - d.low, len(spoken)] += 1
        symbols = table.symbols[d.low : d.high]
        expected = expected + explanation.pair_counts(reference.association, symbols, spoken)
    vectors, presence, _ = training_rows(table, described, reference.scores, number)
    return Counts(
        transition.count_transitions(symbol_sequences(table), n_symbols),
        said,
        shapes,
        expected,
        word_moments(vectors, presence),
    )


def publish_association(counts: Counts, reference: Reference) -> Association:
    """Association of the counts; symbols without counted words have rows of zeros."""
    empty = replace(
        reference.association,
        translation=np.zeros_like(reference.association.translation),
        counts=counts.said,
    )
    return explanation.with_counts(empty, counts.expected)


def dictionary_lemmas(captions: Mapping[int, tuple[Caption, ...]]) -> dict[str, str]:
    """The lemmas that only the dictionary knows, for all words of some captions."""
    forms = {f for rows in captions.values() for c in rows for f in vocabulary.forms_of(c.words)}
    return dictionary_forms(forms)
