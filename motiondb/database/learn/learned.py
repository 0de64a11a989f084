"""What was learned, held in memory for questions: :class:`Learned`, and what every question needs.

It is loaded once and dropped when the database learns or changes, so that an open database answers
in milliseconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from motiondb import store
from motiondb.database.learn.counting import capture_rows, described_intervals, unpack_forms
from motiondb.database.learn.learning import (
    FeaturePool,
    describe_segments,
    load_features,
    recut_settings,
)
from motiondb.errors import NotLearnedError
from motiondb.pose.features import recognition_features
from motiondb.records import (
    Association,
    CaptureInfo,
    Float32Array,
    FloatArray,
    IntArray,
    Motion,
    MotionSymbols,
    SegmentTable,
)
from motiondb.search import by_words, certainty, extents, movement, score_vectors
from motiondb.search.by_words import WINDOW_MARGIN
from motiondb.symbols import acquisition, feature_space, hmm
from motiondb.words import decoding, explanation, lemmas, transition, word_map

LONGEST_DECODED = 12


@dataclass(frozen=True, eq=False)
class Learned:
    """What questions need: symbols, segments, space, words, in memory."""

    database: store.Store
    symbols: MotionSymbols
    segments: SegmentTable
    association: Association
    parameters: Mapping[str, FloatArray]
    captures: Mapping[int, CaptureInfo]
    synonyms: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def rows(self) -> dict[int, slice]:
        """capture -> its rows of the segment table."""
        return capture_rows(self.segments)

    @cached_property
    def score_space(self) -> score_vectors.ScoreSpace:
        """Standardisation of scores."""
        return score_vectors.ScoreSpace(
            self.parameters["score_mean"], self.parameters["score_spread"]
        )

    @cached_property
    def standardised(self) -> FloatArray:
        """Standardised scores and movement of all segments (segments, symbols + columns)."""
        return self.score_space.standardise(self.segments.scores, self.segments.movement)

    @cached_property
    def n_bearing(self) -> int:
        """How many of the last columns of vectors are posture and travel."""
        return movement.count_bearing(len(self.score_space.mean) - self.symbols.n_symbols)

    @cached_property
    def feature_space(self) -> feature_space.FeatureSpace:
        """The projection of recognition features."""
        return feature_space.FeatureSpace(
            self.parameters["feature_mean"], self.parameters["feature_projection"]
        )

    @cached_property
    def context_space(self) -> extents.ContextSpace | None:
        """How activities look; None where the database learned before there was such a thing."""
        names = ("context_features", "context_mean", "context_projection")
        if any(name not in self.parameters for name in names):
            return None
        return extents.ContextSpace(*(self.parameters[name] for name in names))

    def contexts(self, capture_id: int) -> FloatArray:
        """Contexts of a stored capture, 15 a second: array (frames, axes)."""
        if self.context_space is None:
            raise NotLearnedError(
                f"{self.database.path}: expected contexts of activities, found none. "
                "Run motiondb learn again."
            )
        pool = self.feature_pool
        place = int(np.searchsorted(pool.capture_ids, capture_id))
        return self.context_space.view(pool.features[pool.bounds[place] : pool.bounds[place + 1]])

    @cached_property
    def word_map(self) -> word_map.WordMap:
        """The calibrated map from score vectors to words."""
        names = ("weights", "offsets", "priors", "spreads", "calibration")
        if "word_weights" not in self.parameters:
            raise NotLearnedError(
                f"{self.database.path}: expected captures with words, found none when it learned. "
                'Add words (motiondb words set CAPTURE "...") and run motiondb learn again.'
            )
        return word_map.WordMap(*(self.parameters[f"word_{n}"] for n in names))

    @cached_property
    def word_certainty(self) -> certainty.Certainty | None:
        """How sure an answer to words is; None where there was too little to tell."""
        return self._certainty("certainty_words")

    @cached_property
    def example_certainty(self) -> certainty.Certainty | None:
        """How sure an answer to an example is; None where there was too little to tell."""
        return self._certainty("certainty_example")

    def _certainty(self, name: str) -> certainty.Certainty | None:
        if name not in self.parameters or not self.has_words:
            return None
        return certainty.unpack(self.parameters[name])

    @cached_property
    def has_words(self) -> bool:
        """Whether words were learned, and some capture is still described."""
        return "word_weights" in self.parameters and bool(self.association.counts.any())

    @cached_property
    def distances(self) -> FloatArray:
        """Distances between symbols."""
        return store.load_space(self.database).distances

    @cached_property
    def clusters(self) -> IntArray:
        """The cluster of every symbol."""
        return store.load_space(self.database).clusters

    @cached_property
    def log_transitions(self) -> dict[bool, FloatArray]:
        """Plain bigram (False), and mixed with the clustered one (True), log-probabilities."""
        counts = store.load_transition_counts(self.database)
        return {
            True: transition.log_interpolated_bigram(counts, self.clusters),
            False: transition.log_bigram(counts),
        }

    @cached_property
    def seen_takes(self) -> dict[int, by_words.TakeScores]:
        """Log-odds of all words in every capture, from the motion alone."""
        starts, ends = self.segments.starts, self.segments.ends
        return {
            capture: by_words.TakeScores(starts[rows], ends[rows], odds[:-1], odds[-1])
            for capture, odds in self.heard.items()
            for rows in [self.rows[capture]]
        }

    @cached_property
    def shapes(self) -> dict[tuple[int, int], float]:
        """(symbols l, words m) -> how many described captures have this shape."""
        shapes: dict[tuple[int, int], float] = {}
        for m, length in self.parameters["length_counts"].astype(int):
            shapes[length, m] = shapes.get((length, m), 0.0) + 1.0
        return shapes

    @cached_property
    def smoothed_association(self) -> Association:
        """t and a that trust few examples less; what decoding uses."""
        return explanation.smoothed(self.association, self.shapes)

    @cached_property
    def heard(self) -> dict[int, FloatArray]:
        """What motion alone says: log-odds (segments + 1, words) per capture, last row: whole."""
        starts, ends, fit = self.segments.starts, self.segments.ends, self.word_map
        return {
            capture: by_words.heard(
                fit, self.standardised[rows], starts[rows], ends[rows], WINDOW_MARGIN
            )
            for capture, rows in self.rows.items()
        }

    @cached_property
    def takes(self) -> dict[int, by_words.TakeScores]:
        """Log-odds of all words in every capture, written words included."""
        written = self.written
        takes = {}
        for capture, rows in self.rows.items():
            odds = self.heard[capture]
            evidence = written.get(capture)
            if evidence is not None:
                odds = odds + np.concatenate([evidence, evidence.max(axis=0, keepdims=True)])
            takes[capture] = by_words.TakeScores(
                self.segments.starts[rows], self.segments.ends[rows], odds[:-1], odds[-1]
            )
        return takes

    @cached_property
    def known_words(self) -> tuple[str, ...]:
        """Words that some description holds; those whose captures are all gone are not known."""
        pairs = zip(self.association.words, self.association.counts)
        return tuple(word for word, count in pairs if count > 0)

    @cached_property
    def segment_probabilities(self) -> FloatArray:
        """Probability of every word at every segment, from the motion alone: (segments, words)."""
        odds = np.concatenate([self.heard[c][:-1] for c in self.rows])
        return 1.0 / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0)))

    @cached_property
    def feature_pool(self) -> FeaturePool:
        """Recognition features of all captures."""
        return load_features(self.database)

    def features(self, capture_id: int) -> Float32Array:
        """Whitened features of a stored capture, 15 a second."""
        pool = self.feature_pool
        place = int(np.searchsorted(pool.capture_ids, capture_id))
        return self.feature_space.project(
            pool.features[pool.bounds[place] : pool.bounds[place + 1]]
        )

    @cached_property
    def written(self) -> dict[int, FloatArray]:
        """Log-odds (segments, words) that people's words add, for captures that have any."""
        captions = store.load_captions(self.database)
        number = {word: n for n, word in enumerate(self.association.words)}
        spans: dict[int, list[tuple[int, int, FloatArray]]] = {}
        for d in described_intervals(self.segments, captions, self.synonyms):
            said = np.zeros(len(number))
            said[[number[w] for w in d.words if w in number]] = 1.0
            spans.setdefault(d.capture_id, []).append((int(d.start), int(d.end), said))
        return {
            capture: by_words.written_evidence(
                rows.stop - rows.start,
                spans[capture],
                self.segments.starts[rows],
                self.segments.ends[rows],
                len(number),
            )
            for capture, rows in self.rows.items()
            if capture in spans
        }


def load_learned(database: store.Store) -> Learned:
    """Load what questions need.

    Raises
    ------
    NotLearnedError
        when the database has not learned.
    """
    if not store.is_learned(database):
        raise NotLearnedError(
            f"{database.path}: expected a database that has learned, found only captures. "
            "Run motiondb learn first."
        )
    parameters = store.load_parameters(database)
    if "dictionary_forms" in parameters:
        lemmas.recall(unpack_forms(parameters["dictionary_forms"]))
    return Learned(
        database=database,
        symbols=store.load_symbols(database),
        segments=store.load_segments(database),
        association=store.load_association(database),
        parameters=parameters,
        captures={info.capture_id: info for info in store.load_captures(database)},
        synonyms=store.load_synonyms(database),
    )


def decode(
    learned: Learned,
    words: Sequence[str],
    clustered: bool = True,
    after: int | None = None,
    first: bool = True,
    last: bool = True,
    length: int | None = None,
    association: Association | None = None,
) -> decoding.Decoding | None:
    """The symbols that most likely lie behind known words (see ``words.decoding``).

    Parameters
    ----------
    clustered : mix in the clustered bigram, so that pairs never seen may follow one another.
    after : the symbol that the sequence follows.
    first : without ``after``, whether the sequence begins a capture; otherwise it may begin with
        any symbol, as probable as it is frequent.
    last : whether the sequence ends a capture; otherwise it may end with any symbol.
    length : number of symbols; None: any, as likely as the described captures make it.
    association : t and a in place of the learned ones.
    """
    number = {word: n for n, word in enumerate(learned.association.words)}
    log_transitions = learned.log_transitions[clustered].copy()
    if after is not None:
        log_transitions[0] = log_transitions[after + 1]
        log_transitions[0, 0] = -np.inf
    elif not first:
        count = np.bincount(learned.segments.symbols, minlength=learned.symbols.n_symbols)
        log_transitions[0, 1:] = np.log((count + 0.5) / (count + 0.5).sum())
        log_transitions[0, 0] = -np.inf
    if not last:
        log_transitions[1:, 0] = 0.0
    if length is None:
        longest = max(LONGEST_DECODED, 2 * len(words))
        lengths = decoding.log_length_prior(learned.shapes, len(words), longest)
    else:
        lengths = np.full(length + 1, -np.inf)
        lengths[length] = 0.0
    return decoding.decode_words(
        [number[w] for w in words],
        association or learned.smoothed_association,
        log_transitions,
        lengths,
    )


def recognise(
    learned: Learned, motion: Motion
) -> tuple[Float32Array, IntArray, IntArray, IntArray, FloatArray]:
    """Whitened features, segment starts and ends (feature frames), symbols, standardised rows."""
    plain = recognition_features(motion)
    features = learned.feature_space.project(plain)
    bounds = np.array([0, len(features)])
    settings = recut_settings(learned.parameters)
    cutting = acquisition.recut(features, bounds, learned.symbols, settings)
    lengths = (cutting.ends - cutting.starts)[:, None]
    scores = hmm.score(learned.symbols, features, cutting.starts, cutting.ends) / lengths
    moving = describe_segments(features, plain, cutting.starts, cutting.ends)
    standardised = learned.score_space.standardise(scores.astype(np.float32), moving)
    return features, cutting.starts, cutting.ends, np.argmax(scores, axis=1), standardised
