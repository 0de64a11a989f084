"""Search by example: stored intervals that move like a motion, with certainties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.language import vocabulary
from motiondb.learn.checking import NO_EXAMPLES_CHECKED
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import FeaturePool, recognise
from motiondb.meaning import by_motion, extents, regression, score_vectors
from motiondb.meaning.resemblance import emphasis_of, resemblance
from motiondb.meaning.word_map import clearest
from motiondb.records import Float32Array, Match, Motion
from motiondb.search.asked_words import learned_words
from motiondb.search.by_words import mark_generated, to_seconds
from motiondb.search.chances import NOTHING, reaches, why_unchecked
from motiondb.symbols.hmm_jobs import one_blas_thread

TOGETHER = 32  # Intervals that are projected at once: as many as fit the processor's cache


@dataclass(frozen=True, eq=False)
class ExampleAnswer(Sequence[Match]):
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

    def __len__(self) -> int:
        return len(self.matches)

    @overload
    def __getitem__(self, index: int) -> Match: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Match, ...]: ...

    def __getitem__(self, index: int | slice) -> Match | tuple[Match, ...]:
        return self.matches[index]


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
    allowed = [capture for capture in allowed if capture in learned.rows]
    query = make_query(learned, motion, learned.has_words if meaning is None else meaning)
    with one_blas_thread():  # the matrices of one query are too small to gain from two threads
        refined = _find_motion(learned, pool, query, allowed)
        refined = _whole_activities(learned, pool, motion, refined[: 2 * limit])[:limit]
        sure = _how_sure(learned, query, refined)
    matches = tuple(
        Match(
            rank,
            learned.captures[c.capture].name,
            *to_seconds(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
            c.score,
            _words_of_interval(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
            mark_generated(learned, c.capture),
            sure[rank - 1][1] if sure else None,
        )
        for rank, c in enumerate(refined, start=1)
    )
    known = learned.example_certainty
    return ExampleAnswer(
        matches,
        max((alike for alike, _ in sure), default=None),
        None if known is None or np.isnan(known.threshold) else known.threshold,
        _why_no_probabilities(learned),
    )


def _why_no_probabilities(learned: Learned) -> str:
    """The reason why answers to examples have no probabilities; "" where they have."""
    if learned.example_certainty is not None:
        return ""
    reason = why_unchecked(learned_words(learned), ())
    return reason or (NO_EXAMPLES_CHECKED if learned.has_words else "")


def _how_sure(
    learned: Learned, query: by_motion.Query, candidates: Sequence[by_motion.Candidate]
) -> list[tuple[float, float]]:
    """Resemblance of every match, and the calibrated probability that it shows the same action.

    Empty if the probability was not learned.
    """
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


def _find_motion(
    learned: Learned, pool: FeaturePool, query: by_motion.Query, allowed: Sequence[int]
) -> list[by_motion.Candidate]:
    rows = [learned.rows[capture] for capture in allowed]
    takes = by_motion.Takes(
        np.array(allowed, dtype=np.int64),
        np.array([(each.start, each.stop) for each in rows], dtype=np.int64).reshape(-1, 2),
        learned.compared,
    )

    def frames_of(intervals: Sequence[tuple[int, int, int]]) -> Sequence[Float32Array]:
        raw = [pool.of_capture(capture)[first:end] for capture, first, end in intervals]
        projected: list[Float32Array] = []
        for at in range(0, len(raw), TOGETHER):
            some = raw[at : at + TOGETHER]
            frames = learned.feature_space.project(np.concatenate(some))
            projected += np.split(frames, np.cumsum([len(part) for part in some[:-1]]))
        return projected

    candidates = by_motion.find_candidates(query, takes, learned.distances, frames_of=frames_of)
    features = {
        capture: learned.feature_space.project(pool.of_capture(capture))
        for capture in {c.capture for c in candidates}
    }
    return by_motion.refine(query, candidates, features)


def _whole_activities(
    learned: Learned, pool: FeaturePool, motion: Motion, candidates: list[by_motion.Candidate]
) -> list[by_motion.Candidate]:
    """Extend answers in long captures to the whole activity (``motiondb.meaning.extents``)."""
    contexts = learned.context_space
    if motion.n_frames < FEATURE_STEP * extents.LEAST_EXAMPLE:
        return candidates
    example = contexts.view(recognition_features(motion))
    lengths = {c.capture: learned.captures[c.capture].motion_frames for c in candidates}
    takes = {
        capture: contexts.view(pool.of_capture(capture))
        for capture, length in lengths.items()
        if length >= extents.LONG * motion.n_frames
    }
    return by_motion.to_activities(example, candidates, takes)


def make_query(learned: Learned, motion: Motion, meaning: bool = False) -> by_motion.Query:
    """Segment and recognise an example as the captures were; see :func:`search_motion`."""
    seen = recognise(learned, motion)
    starts, ends = seen.starts, seen.ends
    weights = (ends - starts) / max(int((ends - starts).sum()), 1)
    n = len(seen.features)
    vector = score_vectors.interval_vector(seen.standardised, starts, ends, 0, n)
    space = learned.meaning_space if meaning else None
    return by_motion.Query(seen.features, seen.symbols, weights, vector, space)


def _words_of_interval(learned: Learned, capture: int, start: int, end: int) -> tuple[str, ...]:
    """The likeliest words of a stored interval whose probabilities own captions have checked."""
    if learned.fitted_word_map is None:
        return ()
    take = learned.evidence.takes[capture]
    inside = (take.starts < end) & (take.ends > start)
    given = learned.is_known() & learned.checked
    odds = np.where(given, take.windows[inside].mean(axis=0), -np.inf)
    order = np.argsort(-odds, kind="stable")[:3]
    return tuple(learned.association.words[w] for w in order if odds[w] > -1.0)
