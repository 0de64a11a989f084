"""Motion symbols from the features of all captures, and motions recognised by them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import LearnedModel
from motiondb.meaning import score_vectors
from motiondb.meaning.limb_sides import speeds_of_limbs
from motiondb.meaning.word_evidence import WINDOW_MARGIN
from motiondb.records import (
    Association,
    Float32Array,
    FloatArray,
    IntArray,
    Motion,
    MotionSymbols,
    SegmentTable,
)
from motiondb.symbols.settings import AcquisitionSettings, SegmentationSettings
from motiondb.symbols.spread import Captures, Frames, are_segments, as_spread, frames_of
from motiondb.workers import trusted

if TYPE_CHECKING:  # compiled code, which a search does without
    from motiondb.symbols.acquisition import Acquired, Cutting

FIRST_CUT_SECONDS = 3e-6  # Processor time of a frame, measured; decides only how work is divided
Progress = Callable[[str, float], None]
"""Called with the step and the share of it that is done, 0 to 1."""


@dataclass(frozen=True)
class LearnSettings:
    """The settings of learning.

    Attributes
    ----------
    n_symbols : int or None
        Number of symbols; None: the number with the shortest description length.
    seed : int
        Seed of the random generator.
    first_cut : SegmentationSettings
        First segmentation, by change and rest.
    acquisition : AcquisitionSettings
        Competitive learning of the symbols.
    """

    n_symbols: int | None = None
    seed: int = 0
    first_cut: SegmentationSettings = field(default_factory=SegmentationSettings)
    acquisition: AcquisitionSettings = field(default_factory=AcquisitionSettings)


@dataclass(frozen=True, eq=False)
class _Pool:
    """Where the rows of captures lie that stand end to end."""

    capture_ids: IntArray  # (captures,): numbers of the captures, rising
    bounds: IntArray  # (captures + 1,): first row of each, and the end of the last

    @cached_property
    def places(self) -> dict[int, int]:
        """Number of a capture -> its place."""
        return {int(number): place for place, number in enumerate(self.capture_ids)}

    def rows_of(self, capture_id: int) -> slice:
        """The rows of one capture."""
        place = self.places[capture_id]
        return slice(self.bounds[place], self.bounds[place + 1])


@dataclass(frozen=True, eq=False)
class FeaturePool(_Pool):
    """Recognition features of all captures, end to end."""

    features: Float32Array  # (rows, 130), float32: recognition features, 15 a second
    lengths: IntArray  # (captures,): lengths of the motions in frames, 30 a second

    @property
    def room(self) -> Callable[[tuple[int, int], type], Float32Array]:
        """Makes an array for rows that are large, in the file of the features if they lie in one.

        Such an array has rows at slices, and at arrays of numbers, and is written at slices.
        """
        return getattr(self.features, "beside", np.empty)

    def of_capture(self, capture_id: int) -> Float32Array:
        """Features of one capture: array (frames, 130), 15 a second."""
        return self.features[self.rows_of(capture_id)]

    def __iter__(self) -> Iterator[Float32Array]:
        """Features of each capture in turn: array (frames, 130)."""
        return (self.features[a:b] for a, b in pairwise(self.bounds.tolist()))


LIMB_COLUMNS = slice(-10, -4)  # Of a row of frames: what ``speeds_of_limbs`` returns


def frame_rows(learned: LearnedModel, features: Float32Array) -> Float32Array:
    """What questions look at in each frame: array (frames, dimensions + 10).

    These are the whitened features, squared speeds of limbs, and velocity and turning of the
    pelvis, as the features hold them. `features` (frames, 130): recognition features.
    """
    parts = learned.feature_space.project(features), speeds_of_limbs(features), features[:, -4:]
    return np.concatenate(parts, axis=1, dtype=np.float32)


@dataclass(frozen=True, eq=False)
class FramePool(_Pool):
    """What questions look at in the frames of all captures, end to end, 15 a second."""

    rows: Float32Array  # (rows, dimensions + 10), as ``frame_rows`` makes them
    # Recognition features (frames, 130) of a capture by its number, made from its motion;
    # StoreError where that is away
    features: Callable[[int], Float32Array]

    def of_capture(self, capture_id: int) -> Float32Array:
        """Rows of one capture: array (frames, dimensions + 10)."""
        return self.rows[self.rows_of(capture_id)]

    def whitened(self, capture_id: int, first: int = 0, end: int | None = None) -> Float32Array:
        """Whitened features of some frames of one capture: array (frames, dimensions)."""
        return self.of_capture(capture_id)[first:end, : LIMB_COLUMNS.start].copy()


def acquire_symbols(
    frames: Frames,
    pool: FeaturePool,
    rng: np.random.Generator,
    settings: LearnSettings,
    tell: Progress,
) -> Acquired:
    """Fit motion symbols: first segmentation, then competitive learning.

    Shapes: `frames` (rows, dimensions), float32.
    """
    from motiondb.symbols import acquisition

    held = as_spread(frames)
    pieces = held.captures(pool.bounds, FIRST_CUT_SECONDS)
    cuts = trusted(held.workers, _are_cuts, _first_cuts, pieces, settings.first_cut)
    parts = np.array([part for _, of_piece in cuts for part in of_piece], dtype=np.int64)
    starts, ends = parts.reshape(-1, 2).T
    chosen = replace(settings.acquisition, n_symbols=settings.n_symbols)
    return acquisition.acquire(held, pool.bounds, starts, ends, rng, chosen, tell)


def _are_cuts(found: list[tuple[int, int]], piece: Captures, _: object) -> bool:
    """Whether segments can be those of some captures."""
    return are_segments(np.array(found, dtype=np.int64).reshape(-1, 2).T, piece)


def _first_cuts(piece: Captures, settings: SegmentationSettings) -> list[tuple[int, int]]:
    """First segments of some captures."""
    from motiondb.symbols import segmentation

    return [
        (low + part.start, low + part.end)
        for low, frames in frames_of(piece)
        for part in segmentation.segment(frames.astype(np.float64), settings)
    ]


def segment_table(
    frames: Frames,
    pool: FeaturePool,
    symbols: MotionSymbols,
    cutting: Cutting,
    totals: Float32Array | None = None,
) -> SegmentTable:
    """Score every segment of a cutting under every symbol; `frames` (rows, dimensions), float32.

    `totals`: What :func:`motiondb.symbols.hmm.score` gives for them, where it is known.
    """
    from motiondb.symbols import hmm

    held = as_spread(frames)
    owner = np.searchsorted(pool.bounds, cutting.starts, side="right") - 1
    first = pool.bounds[owner]
    per_frame = (cutting.ends - cutting.starts).astype(np.float64)
    if totals is None:
        totals = hmm.score(symbols, held, cutting.starts, cutting.ends)
    scores, best = np.empty_like(totals), np.empty(len(totals), dtype=np.int64)
    likeliest = np.empty(len(totals))
    for low in range(0, len(totals), _SEGMENTS_AT_ONCE):
        some = slice(low, low + _SEGMENTS_AT_ONCE)
        exact = totals[some] / per_frame[some, None]
        scores[some], best[some] = exact, np.argmax(exact, axis=1)
        likeliest[some] = exact.max(axis=1)
    return SegmentTable(
        capture_ids=np.asarray(pool.capture_ids)[owner],
        starts=(cutting.starts - first) * FEATURE_STEP,
        ends=np.minimum((cutting.ends - first) * FEATURE_STEP, np.asarray(pool.lengths)[owner]),
        symbols=best,
        log_likelihoods=likeliest,
        backgrounds=background(held.frames, cutting.starts, cutting.ends),
        scores=scores,
        movement=_movement(held.frames, pool, cutting),
    )


def _movement(
    frames: FloatArray | Float32Array, pool: FeaturePool, cutting: Cutting
) -> Float32Array:
    """Movement of every segment, capture by capture: array (segments, columns)."""
    bounds = pool.bounds
    first, last = (np.searchsorted(cutting.starts, b) for b in (bounds[:-1], bounds[1:]))
    made: Float32Array | None = None
    for a, b, low, high in zip(first, last, bounds[:-1], bounds[1:]):
        rows = describe_segments(
            frames[low:high],
            pool.features[low:high],
            cutting.starts[a:b] - low,
            cutting.ends[a:b] - low,
        )
        if made is None:
            made = pool.room((len(cutting.starts), rows.shape[1]), np.float32)
        made[a:b] = rows
    assert made is not None
    return made


def describe_segments(
    frames: FloatArray | Float32Array, features: Float32Array, starts: IntArray, ends: IntArray
) -> Float32Array:
    """Movement, posture and travel of the segments of one capture: array (segments, columns).

    Shapes: `frames` (frames, dimensions), float32; `features` (frames, 130), float32; `starts`,
    `ends` (segments,).
    """
    moving = score_vectors.describe_movement(frames, starts, ends)
    return np.concatenate(
        [moving, score_vectors.describe_posture_and_travel(features, starts, ends)], axis=1
    )


_AT_ONCE = 2**16  # Frames that are looked at together: bounds memory
_SEGMENTS_AT_ONCE = 2**11  # Segments whose scores are divided together


def background(frames: FloatArray | Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Log-likelihood per frame under the background model: the whitened features' N(0, 1)."""
    squares = np.empty(len(frames))
    for first in range(0, len(frames), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        squares[some] = np.sum(frames[some].astype(np.float64) ** 2, axis=1)
    each = -0.5 * (squares + frames.shape[1] * np.log(2 * np.pi))
    sums = np.concatenate([[0.0], np.cumsum(each)])
    return (sums[ends] - sums[starts]) / (ends - starts)


LONGEST_DECODED = 12  # Largest number of symbols of a decoded sequence of up to 6 words


@dataclass(frozen=True, eq=False)
class Recognised:
    """A motion, cut and scored by the learned symbols."""

    raw: Float32Array  # (frames, 130), float32: recognition features, 15 a second
    features: Float32Array  # (frames, dimensions), float32: the same, whitened
    starts: IntArray  # (segments,): first feature frames
    ends: IntArray  # (segments,): last feature frames + 1
    symbols: IntArray  # (segments,): likeliest symbol of every segment
    standardised: FloatArray  # (segments, symbols + columns): standardised scores and movement

    def window_vectors(self) -> FloatArray:
        """Score vectors of every segment with its surroundings: array (segments, columns)."""
        margin = WINDOW_MARGIN // FEATURE_STEP
        return score_vectors.interval_vectors(
            self.standardised, self.starts, self.ends, self.starts - margin, self.ends + margin
        )


def recognise(learned: LearnedModel, motion: Motion) -> Recognised:
    """Cut and score a motion by the learned symbols, as the captures were."""
    raw, frames, cutting, table = _cut_and_score(learned, 0, motion)
    standardised = learned.score_space.standardise(table.scores, table.movement)
    return Recognised(raw, frames, cutting.starts, cutting.ends, table.symbols, standardised)


def recognise_capture(learned: LearnedModel, capture_id: int, motion: Motion) -> SegmentTable:
    """Segments of a capture, computed as at the end of ``learn``."""
    return _cut_and_score(learned, capture_id, motion)[-1]


def _cut_and_score(
    learned: LearnedModel, capture_id: int, motion: Motion
) -> tuple[Float32Array, Float32Array, Cutting, SegmentTable]:
    """Features, the same whitened, their cutting and the segments of one motion."""
    from motiondb.symbols import acquisition  # compiled code, which a search does without

    features = recognition_features(motion)
    bounds = np.array([0, len(features)])
    frames = learned.feature_space.project(features)
    pool = FeaturePool(np.array([capture_id]), bounds, features, np.array([motion.n_frames]))
    cutting = acquisition.recut(frames, bounds, learned.symbols, learned.cutting)
    return features, frames, cutting, segment_table(frames, pool, learned.symbols, cutting)


@dataclass(frozen=True)
class ChainEnds:
    """What comes before and after a decoded sequence of symbols."""

    after: int | None = None  # Symbol that the sequence follows
    # Without ``after``: whether the sequence begins a capture. If not, it may begin with any
    # symbol, with the symbol's relative frequency as probability
    first: bool = True
    last: bool = True  # Whether the sequence ends a capture. If not, it may end with any symbol


WHOLE_CAPTURE = ChainEnds()  # The ends of a sequence that begins and ends a capture


def decode(
    learned: Learned,
    words: Sequence[str],
    clustered: bool = True,
    ends: ChainEnds = WHOLE_CAPTURE,
    length: int | None = None,
    association: Association | None = None,
) -> decoding.Decoding | None:
    """Decode known words to the most probable symbols.

    See :mod:`motiondb.language.translation.decoding`.

    `clustered`: Whether to mix in the clustered bigram, so that pairs never seen may follow one
    another.
    """
    log_transitions = learned.log_transitions[clustered].copy()
    if ends.after is not None:
        log_transitions[0] = log_transitions[ends.after + 1]
        log_transitions[0, 0] = -np.inf
    elif not ends.first:
        count = np.bincount(learned.segments.symbols, minlength=learned.symbols.n_symbols)
        log_transitions[0, 1:] = np.log((count + 0.5) / (count + 0.5).sum())
        log_transitions[0, 0] = -np.inf
    if not ends.last:
        log_transitions[1:, 0] = 0.0
    if length is None:
        longest = max(LONGEST_DECODED, 2 * len(words))
        lengths = decoding.log_length_prior(learned.shapes, len(words), longest)
    else:
        lengths = np.full(length + 1, -np.inf)
        lengths[length] = 0.0
    return decoding.decode_words(
        [learned.word_numbers[w] for w in words],
        association or learned.smoothed_association,
        log_transitions,
        lengths,
    )
