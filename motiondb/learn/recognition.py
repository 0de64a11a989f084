"""Recognition of motions by the learned symbols; words as symbols, questions as trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.language.question.known import KnownQuestion, hold_to_known
from motiondb.language.question.parse import parse
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.symbol_fitting import FeaturePool, describe_segments, segment_table
from motiondb.meaning import score_vectors
from motiondb.meaning.by_words import WINDOW_MARGIN
from motiondb.records import (
    Association,
    Float32Array,
    FloatArray,
    IntArray,
    Motion,
    SegmentTable,
)

LONGEST_DECODED = 12  # Largest number of symbols of a decoded sequence of up to 6 words


@dataclass(frozen=True, eq=False)
class Recognised:
    """A motion, cut and scored by the learned symbols."""

    features: Float32Array  # (frames, dimensions), float32: whitened features, 15 a second
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
    from motiondb.symbols import acquisition, hmm  # compiled code, which a search does without

    plain = recognition_features(motion)
    features = learned.feature_space.project(plain)
    bounds = np.array([0, len(features)])
    cutting = acquisition.recut(features, bounds, learned.symbols, learned.cutting)
    lengths = (cutting.ends - cutting.starts)[:, None]
    scores = hmm.score(learned.symbols, features, cutting.starts, cutting.ends) / lengths
    moving = describe_segments(features, plain, cutting.starts, cutting.ends)
    standardised = learned.score_space.standardise(scores.astype(np.float32), moving)
    return Recognised(
        features, cutting.starts, cutting.ends, np.argmax(scores, axis=1), standardised
    )


def recognise_capture(learned: LearnedModel, capture_id: int, motion: Motion) -> SegmentTable:
    """Segments of a capture, computed as at the end of ``learn``."""
    from motiondb.symbols import acquisition

    features = recognition_features(motion)
    bounds = np.array([0, len(features)])
    frames = learned.feature_space.project(features)
    pool = FeaturePool(np.array([capture_id]), bounds, features, np.array([motion.n_frames]))
    cutting = acquisition.recut(frames, bounds, learned.symbols, learned.cutting)
    return segment_table(frames, pool, learned.symbols, cutting)


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


def understand(
    learned: Learned, text: str, added: Mapping[str, int] | None = None
) -> KnownQuestion:
    """Understand a question in the words that the database knows.

    `added`: words that are known to this question although they were not learned -> their counts.
    """
    counted = zip(learned.association.words, learned.association.counts)
    counts = {word: int(count) for word, count in counted if count > 0} | dict(added or {})
    return hold_to_known(parse(text, learned.synonyms, learned.lemmas), counts)
