"""Evidence of words in takes: log-odds by motion and captions, and upper bounds for questions.

The word map gives the log-odds v of each word in a window around each segment of a capture, and in
the whole capture; the caption map (:mod:`motiondb.meaning.caption_map`) adds the likeness of each
word to the whole capture. Words in captions of the capture are evidence in addition to the motion.

**Upper bounds of the log-odds of a question, for all captures at once.**
``by_question.search_take`` places the parts of a question in one capture, which takes some 0.1 ms.
Most captures need not be looked at: the log-odds of a requested action are at most

those of its words (:func:`action_log_odds`), each with

    1/2 (largest v at any segment) + 1/2 v of the whole capture;

those of an excluded action are at least the same with the smallest v, and the log-odds of all
statements together rise with those of requested and fall with those of excluded actions. Captures
are searched in the order of their bounds until no bound reaches the answers that there are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from motiondb.language.question.readings import Reading
from motiondb.meaning.caption_map import CaptionMap
from motiondb.meaning.counting import Described
from motiondb.meaning.limb_sides import without_sides
from motiondb.meaning.score_vectors import Rows, window_vectors_of
from motiondb.meaning.word_map import WordMap
from motiondb.records import Float32Array, FloatArray, IntArray, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread

T = TypeVar("T")
WRITTEN = 4.0  # Log-odds added by a word written about the interval: captions are rarely wrong
UNWRITTEN = -1.0  # Log-odds added by a word missing from a caption: captions are rarely complete
KEPT = 256  # Captures whose evidence is kept: some 3 MB of captions, and 3 MB with the motion
WINDOW_MARGIN = 22  # Frames (0.75 s) by which a window extends beyond its segment on both sides


@dataclass(frozen=True, eq=False)
class TakeScores:
    """Log-odds of the vocabulary in one capture."""

    starts: IntArray  # (segments,): first frame of each segment
    ends: IntArray  # (segments,): one past the last frame of each segment
    windows: FloatArray  # (segments, words): log-odds in the window around each segment
    whole: FloatArray  # (words,): log-odds of the whole capture


@dataclass(frozen=True, eq=False)
class Heard:
    """Log-odds of all words in captures, from the motion alone."""

    # (segments + captures, words): the rows of a capture are those of its segments and, behind
    # them, that of the whole
    odds: FloatArray
    likeness: FloatArray  # (captures, words): that of the caption map, which ``odds`` has too
    meanings: Float32Array  # (captures, axes): meanings that the motion suggests (``caption_map``)

    def by_capture(self, rows: Mapping[int, slice]) -> Mapping[int, FloatArray]:
        """Log-odds of the captures with these rows of the table: arrays (segments + 1, words)."""
        ends = np.cumsum([part.stop - part.start + 1 for part in rows.values()]).tolist()
        inside = {c: slice(a, b) for c, a, b in zip(rows, [0, *ends], ends)}
        return WhenAsked(rows, lambda capture: self.odds[inside[capture]])


def hear_takes(
    fit: WordMap,
    captions: CaptionMap,
    standardised: Rows,
    table: SegmentTable,
    rows: Mapping[int, slice],
) -> Heard:
    """Log-odds of all words from the motion alone; `rows` are those of the captures."""
    parts = list(rows.values())
    ends = np.cumsum([0, *(part.stop - part.start + 1 for part in parts)])
    odds = np.empty((ends[-1], len(fit.offsets)))
    wholes = np.empty((len(parts), standardised.shape[1]))
    with one_blas_thread():  # many small products
        for some, vectors in window_vectors_of(standardised, table, parts, WINDOW_MARGIN):
            first, last = ends[some.start], ends[some.stop]
            odds[first:last] = fit.log_odds(vectors)[: last - first]
            wholes[some] = vectors[ends[some.start + 1 : some.stop + 1] - first - 1]
    suggested = captions.suggest(wholes)
    likeness, meanings = suggested.likeness(), suggested.meanings.astype(np.float32)
    return Heard(with_likeness(odds, likeness, ends[1:] - 1), likeness, meanings)


def with_likeness(
    odds: FloatArray, likeness: FloatArray, wholes: int | IntArray = -1
) -> FloatArray:
    """Log-odds (rows, words) with the likeness of captures as a whole, whose rows are given.

    An action's log-odds are half those of the whole capture, so that twice the likeness adds it
    once.
    """
    odds[wholes] += 2.0 * likeness
    return odds


class WhenAsked(Mapping[int, T]):
    """Values by capture that are made when they are asked for.

    Those that were made last are kept, up to a number.
    """

    def __init__(self, captures: Iterable[int], make: Callable[[int], T], n_kept: int = 0) -> None:
        self._captures, self._make = dict.fromkeys(captures), make
        self._n_kept, self._kept = n_kept, dict[int, T]()

    def __getitem__(self, capture: int) -> T:
        if capture not in self._captures:
            raise KeyError(capture)
        if not self._n_kept:
            return self._make(capture)
        value = self._kept.get(capture)
        if value is None:
            value = self._kept[capture] = self._make(capture)
            for old in list(self._kept)[: -self._n_kept]:
                self._kept.pop(old, None)
        return value

    def __contains__(self, capture: object) -> bool:
        return capture in self._captures

    def __iter__(self) -> Iterator[int]:
        return iter(self._captures)

    def __len__(self) -> int:
        return len(self._captures)


@dataclass(frozen=True, eq=False)
class TakeEvidence:
    """Evidence of all words in all captures, from the motion and from captions."""

    table: SegmentTable
    rows: Mapping[int, slice]  # Capture number -> its rows of the table
    # Capture number -> array (segments + 1, words): log-odds by the motion alone, the last row of
    # the whole capture
    odds: Mapping[int, FloatArray]
    # Capture number -> array (segments, words): log-odds that captions add; captures that have any
    written: Mapping[int, FloatArray]
    ready: TakeExtremes | None = None  # The extremes of ``takes``, where they were computed before

    @cached_property
    def by_motion(self) -> TakeEvidence:
        """The evidence of the motion alone."""
        return TakeEvidence(self.table, self.rows, self.odds, {})

    @cached_property
    def takes(self) -> Mapping[int, TakeScores]:
        """Log-odds of all words in every capture, from the motion and the captions."""
        return WhenAsked(self.odds, self._take, KEPT)

    def _take(self, capture: int) -> TakeScores:
        inside, odds, said = self.rows[capture], self.odds[capture], self.written.get(capture)
        windows, whole = odds[:-1], odds[-1]
        if said is not None:
            windows, whole = windows + said, whole + said.max(axis=0)
        return TakeScores(self.table.starts[inside], self.table.ends[inside], windows, whole)

    @cached_property
    def extremes(self) -> TakeExtremes:
        """The largest and smallest log-odds of all words in every capture of ``takes``."""
        return self.ready or take_extremes(self.takes)

    def with_columns(self, added: TakeEvidence) -> TakeEvidence:
        """The evidence of further words behind that of the words here; nothing written adds 0."""

        def odds(capture: int) -> FloatArray:
            return np.concatenate([self.odds[capture], added.odds[capture]], axis=1)

        def written(capture: int) -> FloatArray:
            parts = []
            for each in (self, added):
                n_segments, n_words = np.subtract(each.odds[capture].shape, (1, 0))
                parts.append(each.written.get(capture, np.zeros((n_segments, n_words))))
            return np.concatenate(parts, axis=1)

        return TakeEvidence(
            self.table,
            self.rows,
            WhenAsked(self.odds, odds),
            WhenAsked([*self.written, *added.written], written, KEPT),
            self.extremes.with_columns(added.extremes),
        )

    def mixed(
        self, shares: FloatArray, likeness: Mapping[int, FloatArray], standing: NDArray[np.bool_]
    ) -> TakeEvidence:
        """The evidence of words whose log-odds are means of those of the words here.

        What captions say of the words here counts for mixed words that are `standing` in for them.
        The extremes are bounds: the largest mean is at most the mean of the largest.

        Shapes: `shares` (words, mixed words); `likeness` of each capture and `standing` (mixed
        words,).
        """
        of_written = shares * standing

        def odds(capture: int) -> FloatArray:
            return with_likeness(self.odds[capture] @ shares, likeness[capture])

        def written(capture: int) -> FloatArray:
            return np.asarray(self.written[capture] @ of_written)

        heard, extremes = np.flatnonzero(shares.any(axis=1)), self.extremes
        highest, lowest, whole = (
            array[:, heard] @ shares[heard]
            for array in (extremes.highest, extremes.lowest, extremes.whole)
        )
        unsaid = np.where(standing, 0.0, -UNWRITTEN)  # what captions can have taken away
        alike = np.array([likeness[capture] for capture in extremes.captures.tolist()])
        bounds = TakeExtremes(
            extremes.captures,
            highest + unsaid,
            lowest - 2.0 * (WRITTEN - UNWRITTEN),  # also where ``whole`` is too large
            whole + unsaid + 2.0 * alike.reshape(whole.shape),
        )
        return TakeEvidence(
            self.table,
            self.rows,
            WhenAsked(self.odds, odds),
            WhenAsked(self.written, written),
            bounds,
        )


def written_evidence(
    n_segments: int,
    spans: Sequence[tuple[int, int, NDArray[Any]]],
    starts: IntArray,
    ends: IntArray,
    n_words: int,
) -> FloatArray:
    """Log-odds added by captions: array (segments, words).

    Shapes: `spans` each (said words,): numbers of the words; `starts`, `ends` (segments,).
    """
    evidence = np.zeros((n_segments, n_words))
    # the segments that an interval [low, high) meets, which follow one another
    inside = [
        slice(int(ends.searchsorted(low, "right")), int(starts.searchsorted(high, "left")))
        for low, high, _ in spans
    ]
    for rows in inside:
        evidence[rows] = UNWRITTEN
    for rows, (*_, words) in zip(inside, spans):
        evidence[rows, words] = WRITTEN
    return evidence


def action_log_odds(of_words: FloatArray | Sequence[float]) -> FloatArray:
    """Log-odds of an action: the odds against it are the sum of those against its words: (...).

    `of_words` (words, ...), nats. The result is below the least of them.

    >>> round(math.exp(action_log_odds(np.log([3.0, 6.0]))), 6)  # 1 / (1/3 + 1/6)
    2.0
    """
    if len(of_words) == 1:
        return np.asarray(of_words[0])
    log_odds = np.asarray(of_words, dtype=np.float64)
    return np.asarray(-np.logaddexp.reduce(-log_odds, axis=0))


def all_hold(log_odds: Sequence[FloatArray]) -> FloatArray:
    """Log-odds that independent statements all hold, element by element.

    `log_odds`: Log-odds of each statement, of one shape; at least one. A single one is returned as
    it is.
    """
    if len(log_odds) == 1:
        return log_odds[0]
    log_p = -np.logaddexp(0.0, -np.stack(log_odds)).sum(axis=0)
    log_p = np.minimum(log_p, -1e-300)  # certain, up to floating point
    joint: FloatArray = log_p - np.log(-np.expm1(log_p))
    return joint


def joint_log_odds(log_odds: Sequence[float]) -> float:
    """Log-odds that several independent statements all hold; 0 of none, of which nothing is known.

    >>> joint_log_odds([0.25])
    0.25
    >>> round(joint_log_odds([0.0, 0.0]), 6)  # 1/2 * 1/2 = 1/4, whose log-odds are -ln 3
    -1.098612
    """
    if len(log_odds) < 2:
        return float(log_odds[0]) if len(log_odds) else 0.0
    log_p = -float(np.logaddexp(0.0, -np.asarray(log_odds)).sum())
    return log_p - math.log(-math.expm1(log_p))


SLACK = 1e-4
"""Nats that a bound may be too low by rounding. Chosen by hand, far below what separates answers.
It is above the rounding of single precision, in which extremes are kept, for log-odds below some
1,000 nats."""


@dataclass(frozen=True, eq=False)
class TakeExtremes:
    """The largest and smallest log-odds of every word in every capture."""

    captures: IntArray  # (captures,): numbers of the captures
    highest: FloatArray  # (captures, words): largest log-odds over the segments of the capture
    lowest: FloatArray  # (captures, words): smallest log-odds over its segments
    whole: FloatArray  # (captures, words): log-odds of the whole capture

    def with_columns(self, added: TakeExtremes) -> TakeExtremes:
        """The extremes of further words behind those of the words here, of the same captures."""
        pairs = (
            (self.highest, added.highest),
            (self.lowest, added.lowest),
            (self.whole, added.whole),
        )
        joined = (np.concatenate([own, more.astype(own.dtype)], axis=1) for own, more in pairs)
        return TakeExtremes(self.captures, *joined)


def take_extremes(takes: Mapping[int, TakeScores]) -> TakeExtremes:
    """Return the extremes of captures, each of which has at least one segment."""
    n_words = len(next(iter(takes.values())).whole) if takes else 0
    captures = np.array(list(takes), dtype=np.int64)
    highest, lowest, wholes = (np.empty((len(takes), n_words)) for _ in range(3))
    for n, take in enumerate(takes.values()):
        np.maximum.reduce(take.windows, axis=0, out=highest[n])
        np.minimum.reduce(take.windows, axis=0, out=lowest[n])
        wholes[n] = take.whole
    return TakeExtremes(captures, highest, lowest, wholes)


def upper_bounds(
    extremes: TakeExtremes,
    readings: Sequence[Reading],
    number: Mapping[str, int],
) -> FloatArray:
    """Return what the log-odds of a question are at most in each capture: array (captures,)."""
    bounds = np.full(len(extremes.captures), -np.inf)
    for reading in readings:
        np.maximum(bounds, _of_reading(extremes, reading, number), out=bounds)
    return bounds


def _of_reading(extremes: TakeExtremes, reading: Reading, number: Mapping[str, int]) -> FloatArray:
    asked = [
        _of_action(extremes.highest, extremes.whole, action, number, 0.5)
        for first in sorted({part.repeat_of for part in reading.parts})
        for action in reading.parts[first].actions
    ]
    elsewhere = {word for part in reading.parts for action in part.actions for word in action}
    excluded = [
        -all_hold(
            [
                _of_action(
                    extremes.lowest,
                    extremes.whole,
                    action,
                    number,
                    1.0 if elsewhere.issuperset(action) else 0.5,
                )
                for action in exclusion.actions
            ]
        )
        for exclusion in reading.exclusions
    ]
    stated = [*asked, *excluded]
    return all_hold(stated) if stated else np.zeros(len(extremes.captures))


def _of_action(
    near: FloatArray,
    whole: FloatArray,
    action: tuple[str, ...],
    number: Mapping[str, int],
    share: float,
) -> FloatArray:
    columns = [number[word] for word in without_sides(action)]
    inside, outside = (x[:, columns].T.astype(np.float64) for x in (near, whole))
    return action_log_odds(share * inside + (1.0 - share) * outside)


def caption_evidence(
    described: Sequence[Described],
    table: SegmentTable,
    rows: Mapping[int, slice],
    number: Mapping[str, int],
) -> Mapping[int, FloatArray]:
    """Log-odds that captions add, for captures that have any: arrays (segments, words)."""
    spans: dict[int, list[tuple[int, int, IntArray]]] = {}
    for d in described:
        said = np.array([number[w] for w in d.words if w in number], dtype=np.int64)
        spans.setdefault(d.capture_id, []).append((int(d.start), int(d.end), said))

    def make(capture: int) -> FloatArray:
        inside = rows[capture]
        starts, ends = table.starts[inside], table.ends[inside]
        return written_evidence(len(starts), spans[capture], starts, ends, len(number))

    return WhenAsked([capture for capture in rows if capture in spans], make, KEPT)
