"""Search by example: stored intervals that move like a motion, with certainties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.errors import StoreError
from motiondb.language import vocabulary
from motiondb.learn.checking import NO_EXAMPLES_CHECKED
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import FramePool, Recognised, recognise
from motiondb.meaning import by_motion, extents, regression, score_vectors
from motiondb.meaning.resemblance import MeaningSpace, emphasis_of, resemblance
from motiondb.meaning.word_evidence import WhenAsked
from motiondb.meaning.word_map import clearest
from motiondb.records import Float32Array, FloatArray, IntArray, Match, Motion
from motiondb.search.asked_words import learned_words
from motiondb.search.chances import NOTHING, reaches, why_unchecked
from motiondb.search.matches import mark_generated, match_rows, to_seconds
from motiondb.search.seen_frames import Frames
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.tabled import Tabled


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
    read_as : str
        How the words beside a path or a rhythm were read; "" without.
    """

    matches: tuple[Match, ...]
    strength: float | None = None
    threshold: float | None = None
    unchecked: str = ""
    read_as: str = ""

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


def search_motion(
    learned: Learned,
    frames: Frames,
    motion: Motion,
    allowed: Sequence[int],
    limit: int = 10,
    meaning: bool | None = None,
) -> ExampleAnswer:
    """The stored intervals that move like a motion, best first.

    ``limit`` and ``meaning`` are those of ``MotionDB.like``.
    """
    by_words = learned.has_words if meaning is None else meaning
    with one_blas_thread():  # the matrices of one query are too small to gain from two threads
        seen = recognise(learned, motion)
        query = _query(seen, learned.meaning_space if by_words else None)
        found = _find(learned, frames.pool, query, np.array(allowed, dtype=np.int64))
        if motion.n_frames >= FEATURE_STEP * extents.LEAST_EXAMPLE:
            found = _whole_activities(learned, frames, seen.raw, motion.n_frames, found, limit)
        found = found[:limit]
        sure = _how_sure(learned, query, found)
        # what ranks is not what is calibrated: no answer is more probable than one before it
        chances = np.minimum.accumulate([chance for _, chance in sure]).tolist()
        matches = tuple(
            Match(
                rank,
                learned.captures[c.capture].name,
                *to_seconds(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
                c.score,
                _words_of_interval(learned, c),
                "; ".join(filter(None, (_same(c), mark_generated(learned, c.capture)))),
                chances[rank - 1] if sure else None,
            )
            for rank, c in enumerate(found, start=1)
        )
    known = learned.example_certainty
    return ExampleAnswer(
        matches,
        max((alike for alike, _ in sure), default=None),
        None if known is None or np.isnan(known.threshold) else known.threshold,
        _why_no_probabilities(learned),
    )


def _query(seen: Recognised, meaning: MeaningSpace | None) -> by_motion.Query:
    """An example, segmented and recognised as the captures were."""
    starts, ends = seen.starts, seen.ends
    weights = (ends - starts) / max(int((ends - starts).sum()), 1)
    vector = score_vectors.interval_vector(seen.standardised, starts, ends, 0, len(seen.features))
    return by_motion.Query(seen.features, seen.symbols, weights, vector, meaning)


def _find(
    learned: Learned, pool: FramePool, query: by_motion.Query, captures: IntArray
) -> list[by_motion.Candidate]:
    """Intervals of captures that move like an example, best first."""
    ids = learned.segments.capture_ids  # rising
    bounds = np.column_stack([np.searchsorted(ids, captures, side) for side in ("left", "right")])
    there = bounds[:, 0] < bounds[:, 1]
    takes = by_motion.Takes(captures[there], bounds[there], learned.compared)

    def frames_of(intervals: Sequence[tuple[int, int, int]]) -> Sequence[Float32Array]:
        return [pool.whitened(*interval) for interval in intervals]

    candidates = by_motion.find_candidates(query, takes, learned.distances, frames_of=frames_of)
    return by_motion.refine(query, candidates, pool.whitened)


def _why_no_probabilities(learned: Learned) -> str:
    """The reason why answers to examples have no probabilities; "" where they have."""
    if learned.example_certainty is not None:
        return ""
    reason = why_unchecked(learned_words(learned), ())
    return reason or (NO_EXAMPLES_CHECKED if learned.has_words else "")


def _how_sure(
    learned: Learned, query: by_motion.Query, candidates: Sequence[by_motion.Candidate]
) -> list[tuple[float, float]]:
    """Resemblance of every answer, and the calibrated probability that it shows the same action.

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


def _whole_activities(
    learned: Learned,
    frames: Frames,
    example: Float32Array,
    n_frames: int,
    candidates: Sequence[by_motion.Candidate],
    limit: int,
) -> list[by_motion.Candidate]:
    """Extend answers in long captures to the whole activity (``motiondb.meaning.extents``).

    Those whose motion is kept elsewhere and cannot be read stay as they are.

    `example`: Recognition features (frames, 130) of a motion of `n_frames`.
    """
    some = candidates[: 2 * limit]
    lengths = {c.capture: learned.captures[c.capture].motion_frames for c in some}
    long = [capture for capture, n in lengths.items() if n >= extents.LONG * n_frames]

    def view(capture: int) -> FloatArray | None:
        try:
            return frames.of(learned, capture).contexts
        except StoreError:
            return None

    contexts = learned.context_space.view(example)
    return by_motion.to_activities(contexts, some, WhenAsked(long, view), limit)


def _same(answer: by_motion.Candidate) -> str:
    """Whether an answer is the example itself or a copy of it, in words."""
    return "the same motion" if answer.warp < by_motion.SAME else ""


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
