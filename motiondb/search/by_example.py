"""Search by example: stored intervals that move like a motion, with certainties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Generic, overload

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.language import vocabulary
from motiondb.learn.checking import NO_EXAMPLES_CHECKED
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import FeaturePool, recognise
from motiondb.meaning import by_motion, extents, regression, score_vectors
from motiondb.meaning.resemblance import emphasis_of, resemblance
from motiondb.meaning.windows import ComparedSegments
from motiondb.meaning.word_map import clearest
from motiondb.records import Float32Array, Match, Motion
from motiondb.search.asked_words import learned_words
from motiondb.search.chances import NOTHING, reaches, why_unchecked
from motiondb.search.matches import mark_generated, match_rows, to_seconds
from motiondb.search.steps import Asked, Place, Steps, Value, answer_here, take
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.tabled import Tabled

TOGETHER = 32  # Intervals that are projected at once: as many as fit the processor's cache


@dataclass(frozen=True, eq=False, repr=False)
class ExampleAnswer(Tabled, Sequence[Match]):
    """The matches of an example, best first, as a sequence.

    Attributes
    ----------
    matches : tuple of Match
        Best first.
    strength : float or None
        Largest resemblance of a match (``motiondb.meaning.extents``), 1 for the same motion.
    threshold : float or None
        Strength of the best answer below which nothing in the database matches. Both are None if
        too little was written about the captures to learn them.
    unchecked : str
        Why the answers carry no probabilities, where captions have not sufficed to learn or to
        check them (``motiondb.learn.checking``); otherwise "".
    """

    matches: tuple[Match, ...]
    strength: float | None = None
    threshold: float | None = None
    unchecked: str = ""

    @property
    def matches_anything(self) -> bool | None:
        """Whether anything in the database moves like the example; None if this is not known."""
        return reaches(self.matches, self.strength, self.threshold)

    @property
    def nothing(self) -> str:
        """That nothing matches; "" if something may."""
        return NOTHING if self.matches_anything is False else ""

    def _rows(self) -> tuple[str, list[dict[str, object]]]:
        return self.nothing or f"{len(self)} intervals that move alike", match_rows(self.matches)

    def __len__(self) -> int:
        return len(self.matches)

    @overload
    def __getitem__(self, index: int) -> Match: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Match, ...]: ...

    def __getitem__(self, index: int | slice) -> Match | tuple[Match, ...]:
        return self.matches[index]


@dataclass(frozen=True, eq=False)
class Example:
    """A motion that is compared with captures."""

    query: by_motion.Query  # Without the space of words, which belongs to the model
    by_words: bool  # Whether the words of the query are compared, too
    features: Float32Array  # Recognition features (frames, 130)
    n_frames: int  # Of the motion, 30 a second


class AskedExample:
    """An example beside the captures of one place; what was computed of them is kept.

    `compared`: The segments that are compared; the first of them has the number `first`.
    """

    def __init__(
        self, learned: Learned, example: Example, compared: ComparedSegments, first: int = 0
    ) -> None:
        self.learned, self.example = learned, example
        space = learned.meaning_space if example.by_words else None
        self.query = replace(example.query, meaning=space)
        self._compared, self._first = compared, first
        self._comparison: by_motion.Comparison | None = None

    def comparison(self, place: Place) -> by_motion.Comparison:
        """The example beside the captures of the place, which is always the same one."""
        if self._comparison is None:
            rows = [self.learned.rows[capture] for capture in place.captures]
            bounds = [(each.start - self._first, each.stop - self._first) for each in rows]
            takes = by_motion.Takes(
                np.array(list(place.captures), dtype=np.int64),
                np.array(bounds, dtype=np.int64).reshape(-1, 2),
                self._compared,
            )
            frames_of = partial(self._frames_of, place)
            self._comparison = by_motion.Comparison(
                self.query, takes, self.learned.distances, frames_of
            )
        return self._comparison

    def _frames_of(
        self, place: Place, intervals: Sequence[tuple[int, int, int]]
    ) -> Sequence[Float32Array]:
        """Whitened features of intervals: capture, first frame, end."""
        raw = [features_of(place, capture)[first:end] for capture, first, end in intervals]
        projected: list[Float32Array] = []
        for at in range(0, len(raw), TOGETHER):
            some = raw[at : at + TOGETHER]
            frames = self.learned.feature_space.project(np.concatenate(some))
            projected += np.split(frames, np.cumsum([len(part) for part in some[:-1]]))
        return projected


def features_of(place: Place, capture: int) -> Float32Array:
    """Recognition features of a capture of a place where frames are looked at."""
    assert place.features is not None
    return place.features(capture)


def search_motion(
    learned: Learned,
    pool: FeaturePool,
    motion: Motion,
    allowed: Sequence[int],
    limit: int = 10,
    meaning: bool | None = None,
) -> ExampleAnswer:
    """The stored intervals that move like a motion, best first.

    ``limit`` and ``meaning`` are those of ``MotionDB.like``.
    """
    place = Place([capture for capture in allowed if capture in learned.rows], pool.of_capture)
    with one_blas_thread():  # the matrices of one query are too small to gain from two threads
        example = make_example(learned, motion, learned.has_words if meaning is None else meaning)
        asked = AskedExample(learned, example, learned.compared)
        return answer_here(example_steps(learned, asked, len(place.captures), limit), place)


def example_steps(
    learned: Learned, asked: Asked, n_captures: int, limit: int
) -> Steps[Asked, ExampleAnswer]:
    """Answer an example.

    `asked`: The example as places take it. `n_captures`: Number of captures of all places.
    """
    right = yield from take(asked, _FindAlike())
    candidates = yield from take(asked, _FindCandidates(tuple(right), n_captures))
    refined = by_motion.separate((yield from take(asked, _CompareFrames(tuple(candidates)))))
    placed = yield from take(asked, _PlaceActivities(tuple(refined[: 2 * limit])))
    kept = by_motion.without_overlaps([candidate for _, candidate in placed])[:limit]
    answers = yield from take(asked, _SayAnswers(tuple(kept)))
    matches = tuple(
        Match(
            rank,
            learned.captures[c.capture].name,
            *to_seconds(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
            c.score,
            answer.words,
            mark_generated(learned, c.capture),
            answer.chance,
        )
        for rank, (c, (_, answer)) in enumerate(zip(kept, answers), start=1)
    )
    known = learned.example_certainty
    return ExampleAnswer(
        matches,
        max((each.alike for _, each in answers if each.alike is not None), default=None),
        None if known is None or np.isnan(known.threshold) else known.threshold,
        _why_no_probabilities(learned),
    )


@dataclass(frozen=True, eq=False)
class _FindAlike:
    """The captures that resemble an example most."""

    def tell(self, asked: AskedExample, place: Place) -> list[by_motion.Alike]:
        return asked.comparison(place).most_alike()

    def join(self, told: Sequence[list[by_motion.Alike]]) -> list[by_motion.Alike]:
        return sorted(chain(*told), key=lambda each: (-each.resemblance, each.capture))


@dataclass(frozen=True, eq=False)
class _FindCandidates:
    """Intervals that are alike by symbols, scores and words."""

    right: tuple[by_motion.Alike, ...]  # The captures that resemble the example most
    n_captures: int  # That are asked

    def tell(self, asked: AskedExample, place: Place) -> list[by_motion.Candidate]:
        return asked.comparison(place).candidates(self.right, self.n_captures)

    def join(self, told: Sequence[list[by_motion.Candidate]]) -> list[by_motion.Candidate]:
        return by_motion.best_candidates([*chain(*told)])


@dataclass(frozen=True, eq=False)
class _CompareFrames:
    """Exact intervals and scores of candidates."""

    candidates: tuple[by_motion.Candidate, ...]

    def tell(self, asked: AskedExample, place: Place) -> list[by_motion.Candidate]:
        compared = by_motion.compared_by_frames(asked.query, self.candidates)
        own = [c for c in compared if c.capture in place.captures]
        frames = {
            capture: asked.learned.feature_space.project(features_of(place, capture))
            for capture in {c.capture for c in own}
        }
        return by_motion.refine(asked.query, own, frames)

    def join(self, told: Sequence[list[by_motion.Candidate]]) -> list[by_motion.Candidate]:
        return [*chain(*told)]


@dataclass(frozen=True, eq=False)
class _OfAnswers(Generic[Value]):
    """What is told of answers, one by one."""

    answers: tuple[by_motion.Candidate, ...]  # Best first

    def join(self, told: Sequence[list[tuple[int, Value]]]) -> list[tuple[int, Value]]:
        """Number of each answer, and what is told of it, in the order of the answers."""
        return sorted(chain(*told), key=lambda each: each[0])

    def _own(self, place: Place) -> tuple[list[int], list[by_motion.Candidate]]:
        """Numbers and answers of the captures of a place."""
        own = [(n, c) for n, c in enumerate(self.answers) if c.capture in place.captures]
        return [n for n, _ in own], [c for _, c in own]


class _PlaceActivities(_OfAnswers[by_motion.Candidate]):
    """Answers as whole activities."""

    def tell(self, asked: AskedExample, place: Place) -> list[tuple[int, by_motion.Candidate]]:
        """Those of a place, with their numbers."""
        numbers, own = self._own(place)
        return list(zip(numbers, _whole_activities(asked, place, own)))


@dataclass(frozen=True)
class _Said:
    """What is said of an answer."""

    # Its resemblance, and the calibrated probability that it shows the same action; None if this
    # was not learned
    alike: float | None
    chance: float | None
    words: tuple[str, ...]


class _SayAnswers(_OfAnswers[_Said]):
    """Probabilities and words of answers."""

    def tell(self, asked: AskedExample, place: Place) -> list[tuple[int, _Said]]:
        """Those of a place, with the numbers of the answers."""
        numbers, own = self._own(place)
        sure: Sequence[tuple[float | None, float | None]] = _how_sure(asked, own)
        sure = sure or [(None, None)] * len(own)
        words = [_words_of_interval(asked.learned, c) for c in own]
        return [(n, _Said(*s, w)) for n, s, w in zip(numbers, sure, words)]


def _why_no_probabilities(learned: Learned) -> str:
    """The reason why answers to examples have no probabilities; "" where they have."""
    if learned.example_certainty is not None:
        return ""
    reason = why_unchecked(learned_words(learned), ())
    return reason or (NO_EXAMPLES_CHECKED if learned.has_words else "")


def _how_sure(
    asked: AskedExample, candidates: Sequence[by_motion.Candidate]
) -> list[tuple[float, float]]:
    """Resemblance of every answer, and the calibrated probability that it shows the same action.

    Empty if the probability was not learned.
    """
    learned, query = asked.learned, asked.query
    sure = learned.example_certainty
    if sure is None:
        return []
    actions = np.array([w not in vocabulary.MODIFIERS for w in learned.association.words])
    clear = clearest(learned.word_map, query.vector, actions & learned.is_known())
    vectors, table = np.zeros((len(candidates), len(query.vector))), learned.segments
    for vector, c in zip(vectors, candidates):
        rows, low, high = learned.rows[c.capture], c.start * FEATURE_STEP, c.end * FEATURE_STEP
        vector[:] = score_vectors.interval_vector(
            learned.segment_rows[rows], table.starts[rows], table.ends[rows], low, high
        )
    alike = resemblance(
        query.vector,
        vectors,
        learned.word_map,
        n_posture_and_travel=learned.n_posture_and_travel,
        emphasis=emphasis_of(learned.association.words),
    )
    log_odds = sure.log_odds(np.column_stack([alike, np.full(len(alike), clear)]))
    chances = regression.probability(log_odds)
    return [
        (by_motion.same_motion(float(a), c.warp), by_motion.same_motion(float(chance), c.warp))
        for c, a, chance in zip(candidates, alike, chances)
    ]


def _whole_activities(
    asked: AskedExample, place: Place, candidates: list[by_motion.Candidate]
) -> list[by_motion.Candidate]:
    """Extend answers in long captures to the whole activity (``motiondb.meaning.extents``)."""
    learned, n_frames = asked.learned, asked.example.n_frames
    contexts = learned.context_space
    if n_frames < FEATURE_STEP * extents.LEAST_EXAMPLE:
        return candidates
    example = contexts.view(asked.example.features)
    lengths = {c.capture: learned.captures[c.capture].motion_frames for c in candidates}
    takes = {
        capture: contexts.view(features_of(place, capture))
        for capture, length in lengths.items()
        if length >= extents.LONG * n_frames
    }
    return by_motion.to_activities(example, candidates, takes)


def make_example(learned: Learned, motion: Motion, by_words: bool = False) -> Example:
    """Segment and recognise an example as the captures were; see :func:`search_motion`."""
    seen = recognise(learned, motion)
    starts, ends = seen.starts, seen.ends
    weights = (ends - starts) / max(int((ends - starts).sum()), 1)
    n = len(seen.features)
    vector = score_vectors.interval_vector(seen.standardised, starts, ends, 0, n)
    query = by_motion.Query(seen.features, seen.symbols, weights, vector)
    return Example(query, by_words, seen.raw, motion.n_frames)


def _words_of_interval(learned: Learned, answer: by_motion.Candidate) -> tuple[str, ...]:
    """The likeliest words of a stored interval whose probabilities own captions have checked."""
    if learned.fitted_word_map is None:
        return ()
    take, start, end = (
        learned.evidence.takes[answer.capture],
        answer.start * FEATURE_STEP,
        answer.end * FEATURE_STEP,
    )
    inside = (take.starts < end) & (take.ends > start)
    given = learned.is_known() & learned.checked
    odds = np.where(given, take.windows[inside].mean(axis=0), -np.inf)
    order = np.argsort(-odds, kind="stable")[:3]
    return tuple(learned.association.words[w] for w in order if odds[w] > -1.0)
