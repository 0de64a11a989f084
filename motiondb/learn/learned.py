"""The learned model for questions.

A :class:`Learned` is frozen, holds no store and is complete: the model
(:mod:`motiondb.learn.learned_model`), the catalogue and the captions, all of one revision.
Values that depend only on these are computed at first use and kept.

**The performer of captures for which none is given.** If every capture counted as a separate
performer, near copies (repeats of one exercise, cuts of one take) would be used to predict one
another wherever performers are left out. Captures without a given performer therefore count as one
performer if they are in one folder or, if all of them are in the same folder, if their names are
the same up to the last number (``14_06`` and ``14_20``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_STEP
from motiondb.errors import NotLearnedError
from motiondb.language.translation import explanation, transition
from motiondb.language.vocabulary import split_actions, words_of
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.learn.checking import checked_words
from motiondb.learn.codec import to_values
from motiondb.learn.joining import join_moments
from motiondb.learn.learned_model import LearnedModel
from motiondb.meaning import (
    description_map,
    place_fitting,
    regression,
    score_vectors,
    word_evidence,
)
from motiondb.meaning.caption_map import CaptionMap, solve_caption_map
from motiondb.meaning.counting import Described, capture_rows, described_intervals
from motiondb.meaning.description_map import DescriptionMap
from motiondb.meaning.motion_judge import Said, said_words
from motiondb.meaning.place_fitting import (
    Written,
)
from motiondb.meaning.resemblance import MeaningSpace, emphasis_of, meaning_space
from motiondb.meaning.word_map import WordMap
from motiondb.records import (
    Association,
    Caption,
    CaptureInfo,
    Float32Array,
    FloatArray,
    IntArray,
)

if TYPE_CHECKING:
    from motiondb.meaning.nearest_captures import CaptureSegments
    from motiondb.meaning.windows import ComparedSegments

_LAST_NUMBER = re.compile(r"[ _-]*\d+$")


def performers_of(captures: Mapping[int, CaptureInfo]) -> dict[int, str]:
    """Performer of every capture of a catalogue, from its tag or its name."""
    said = {c: i.tags["performer"] for c, i in captures.items() if "performer" in i.tags}
    return group_performers({c: info.name for c, info in captures.items()}, said)


def group_performers(names: Mapping[int, str], performers: Mapping[int, str]) -> dict[int, str]:
    """Performer of every capture, as given or from its name.

    >>> group_performers({1: "a/x_1", 2: "a/y_1", 3: "b/x_1", 4: "c/x"}, {4: "ana"})
    {1: '#a/', 2: '#a/', 3: '#b/', 4: 'ana'}
    >>> group_performers({1: "14_06", 2: "14_20", 3: "16_01"}, {})
    {1: '#14', 2: '#14', 3: '#16'}
    """
    unsaid = {capture: name for capture, name in names.items() if capture not in performers}
    folders = {capture: name.rpartition("/")[0] for capture, name in unsaid.items()}
    if len(set(folders.values())) > 1:
        groups = {capture: f"#{folder}/" for capture, folder in folders.items()}
    else:
        groups = {capture: f"#{family_of(name)}" for capture, name in unsaid.items()}
    return {capture: performers.get(capture, groups.get(capture, "")) for capture in names}


def family_of(name: str) -> str:
    """A name up to its last number; a name that is only a number is not changed.

    >>> family_of("cmu/14_06"), family_of("walk"), family_of("12")
    ('cmu/14', 'walk', '12')
    """
    stem = _LAST_NUMBER.sub("", name)
    return stem if stem and not stem.endswith("/") else name


Value = TypeVar("Value")
MOST_KEPT = 256  # Captures of which whitened features and words are kept: some 5 MB
LEAST_ALIKE = 0.5  # Smallest cosine of a caption and what motion suggests, to be named


HEARD = ("odds", "likeness", "meanings")  # Arrays of ``Learned.heard``
PREPARED = (*HEARD, "extremes")  # Arrays that :func:`prepare` gives
FOLLOWED = (
    *("segments", "score_space", "fitted_word_map", "counted", "started", "association"),
    *("captions", "synonyms", "lemmas", "places"),
)  # Fields from which the prepared arrays follow


@dataclass(frozen=True, eq=False)
class Prepared:
    """Arrays that questions need of all captures, which may be memory-mapped."""

    source: Learned  # From whose fields they follow; keeps what else follows from them
    # Those of :func:`prepare`, ``Learned.place_arrays`` and ``Learned.map_arrays``; empty where
    # they are not there yet
    evidence: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    places: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    maps: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class DescribedSegments:
    """The segments of the described captures and their words."""

    segments: CaptureSegments
    captures: IntArray  # (captures,): numbers of the captures
    # (captures, words): 1/sqrt(actions) where its captions say a word among that many actions
    says: Float32Array


@dataclass(frozen=True, eq=False)
class Learned(LearnedModel):
    """The data for questions: the learned model, with the catalogue of the same revision."""

    # Capture number -> row of the catalogue, of all captures
    captures: Mapping[int, CaptureInfo] = field(default_factory=dict)
    # Capture number -> captions
    captions: Mapping[int, tuple[Caption, ...]] = field(default_factory=dict)
    synonyms: Mapping[str, str] = field(default_factory=dict)  # Lemma -> canonical lemma
    source: str = ""  # Path of the database file, for messages
    # Names by number of the captures that are left out, since their motions cannot be read
    damaged: Mapping[int, str] = field(default_factory=dict)
    prepared: Prepared | None = None  # What was computed from all captures before

    def __repr__(self) -> str:
        words = len(self.association.words)
        return (
            f"Learned({self.symbols.n_symbols} symbols, {words} words, {len(self.rows)} captures)"
        )

    @cached_property
    def rows(self) -> dict[int, slice]:
        """Capture number -> its rows of the segment table."""
        return capture_rows(self.segments)

    @cached_property
    def places_in_rows(self) -> dict[int, int]:
        """Capture number -> its place among ``rows``, as in arrays over captures."""
        return {capture: place for place, capture in enumerate(self.rows)}

    @cached_property
    def segment_rows(self) -> score_vectors.Rows:
        """Standardised rows of all segments, computed where they are looked at."""
        return score_vectors.StandardisedRows.of_table(self.score_space, self.segments)

    @cached_property
    def _ready(self) -> Prepared | None:
        """The prepared arrays, None if a field from which they follow was replaced."""
        if self.prepared is None:
            return None
        mine, theirs = vars(self), vars(self.prepared.source)
        return self.prepared if all(mine[name] is theirs[name] for name in FOLLOWED) else None

    @cached_property
    def _kept(self) -> dict[str, dict[int, Any]]:
        """What was computed of captures, by its name; those asked for last at the end."""
        return {}

    def kept(self, name: str, capture: int, make: Callable[[], Value]) -> Value:
        """A value of a capture that is computed once while it is one of the last asked for."""
        kept = self._kept.setdefault(name, {})
        value = kept.pop(capture, None)  # at once: other threads ask, too
        kept[capture] = value = make() if value is None else value
        for old in list(kept)[:-MOST_KEPT]:
            kept.pop(old, None)
        return cast(Value, value)

    @cached_property
    def n_posture_and_travel(self) -> int:
        """Number of the last columns of score vectors that are posture and travel."""
        columns = len(self.score_space.mean) - self.symbols.n_symbols
        return score_vectors.count_posture_and_travel(columns)

    @property
    def word_map(self) -> WordMap:
        """Calibrated map from score vectors to words."""
        if self.fitted_word_map is None:
            raise NotLearnedError(
                f"{self.source}: expected captures with words, found none when it learned. "
                'Add words (motiondb words set CAPTURE "...") and run motiondb learn again, or '
                "take over words of other captures (motiondb learn --start cmu)."
            )
        return self.fitted_word_map

    @cached_property
    def meaning_space(self) -> MeaningSpace:
        """What captures are compared with an example by; NotLearnedError without words."""
        last, emphasis = self.n_posture_and_travel, emphasis_of(self.association.words)
        return meaning_space(self.word_map, last, emphasis, self.pooled)

    @cached_property
    def bearing(self) -> Float32Array:
        """Posture and travel of all segments, in their usual spreads: array (segments, columns)."""
        last = self.score_space.standardise_last(self.segments.movement, self.n_posture_and_travel)
        last /= last.std(axis=0, dtype=np.float64) + 1e-9
        return last

    @cached_property
    def compared(self) -> ComparedSegments:
        """The segments of all captures, as examples are compared with them."""
        from motiondb.meaning.windows import compared_segments  # compiled code

        table, space = self.segments, None if self.fitted_word_map is None else self.meaning_space
        frames = np.stack([table.starts // FEATURE_STEP, -(-table.ends // FEATURE_STEP)], axis=1)
        return compared_segments(frames, table.symbols, self.segment_rows, space)

    @cached_property
    def has_words(self) -> bool:
        """Whether words were learned, and some capture still has words."""
        return self.fitted_word_map is not None and bool(self.association.counts.any())

    @property
    def word_certainty(self) -> regression.Certainty | None:
        """Certainty of an answer to words; None if it could not be learned."""
        return self.certainties.words if self.has_words else None

    @property
    def example_certainty(self) -> regression.Certainty | None:
        """Certainty of an answer to an example; None if it could not be learned."""
        return self.certainties.example if self.has_words else None

    @cached_property
    def checked(self) -> NDArray[np.bool_]:
        """Which words' probabilities own captions have checked: (words,).

        See :mod:`motiondb.learn.checking`.
        """
        return checked_words(self.association, self.started, self.counted, self.word_certainty)

    @property
    def distances(self) -> FloatArray:
        """Distances between symbols: array (symbols, symbols), nats per frame."""
        return self.space.distances

    @property
    def clusters(self) -> IntArray:
        """Cluster of every symbol: array (symbols,)."""
        return self.space.clusters

    @cached_property
    def word_numbers(self) -> dict[str, int]:
        """Word -> its number in the vocabulary."""
        return {word: number for number, word in enumerate(self.association.words)}

    @cached_property
    def known_words(self) -> tuple[str, ...]:
        """Words of the vocabulary that some caption holds now."""
        pairs = zip(self.association.words, self.association.counts)
        return tuple(word for word, count in pairs if count > 0)

    @cached_property
    def described(self) -> tuple[Described, ...]:
        """Captions with at least one motion word, and the segments they describe."""
        if self._ready is not None:
            return self._ready.source.described
        return tuple(described_intervals(self.segments, self.captions, self.synonyms, self.lemmas))

    @cached_property
    def log_transitions(self) -> dict[bool, FloatArray]:
        """Log-probabilities of transitions: plain bigram (False) or mixed with clusters (True)."""
        interpolated = transition.log_interpolated_bigram(self.transition_counts, self.clusters)
        return {True: interpolated, False: transition.log_bigram(self.transition_counts)}

    @cached_property
    def shapes(self) -> dict[tuple[int, int], float]:
        """(symbols l, words m) -> number of described intervals of this shape."""
        return {shape: float(count) for shape, count in self.lengths.items()}

    @cached_property
    def smoothed_association(self) -> Association:
        """Association for decoding: t and a, smoothed where examples are few."""
        return explanation.smoothed(self.association, self.shapes)

    @property
    def heard(self) -> word_evidence.Heard:
        """Log-odds of all words in all captures, from the motion alone."""
        if self._ready is None or not self._ready.evidence:
            return self._heard
        return word_evidence.Heard(*(self._ready.evidence[name] for name in HEARD))

    @cached_property
    def _heard(self) -> word_evidence.Heard:
        fit, table, rows = self.word_map, self.segments, self.rows
        return word_evidence.hear_takes(fit, self.caption_map, self.segment_rows, table, rows)

    @cached_property
    def evidence(self) -> word_evidence.TakeEvidence:
        """Evidence of all words in all captures, from the motion and from captions."""
        numbers, rows, table = self.word_numbers, self.rows, self.segments
        written = word_evidence.caption_evidence(self.described, table, rows, numbers)
        ready = None
        if self._ready is not None and self._ready.evidence:
            captures, extremes = np.array(list(rows)), self._ready.evidence["extremes"]
            ready = word_evidence.TakeExtremes(captures, *extremes)
        odds = self.heard.by_capture(rows)
        return word_evidence.TakeEvidence(table, rows, odds, written, ready)

    @cached_property
    def caption_map(self) -> CaptionMap:
        """Map from score vectors to whole captions, of own captions and those of the start."""
        ready = self._ready_map("caption")
        if ready:
            return CaptionMap(**ready)
        words, moments = self.association.words, self.counted.counts.moments
        if self.started is not None:
            moments = join_moments(moments, words, self.started)
        return solve_caption_map(moments, word_vectors().of(words))

    @property
    def likeness(self) -> FloatArray:
        """Likeness of every word to what every capture suggests: array (captures, words), nats."""
        return self.heard.likeness

    @cached_property
    def _caption_meanings(self) -> tuple[list[tuple[int, str]], FloatArray]:
        """Captions of captures with their capture, and their vectors (captions, axes)."""
        said = {
            (capture, row.words): words_of(row.words, self.synonyms, self.lemmas)
            for capture, rows in self.captions.items()
            for row in rows
        }
        words = sorted({word for each in said.values() for word in each})
        vectors, number = word_vectors().of(words), {word: n for n, word in enumerate(words)}
        # in one order, so that captions with the same words have the same vector
        means = [vectors[sorted(number[w] for w in each)].sum(axis=0) for each in said.values()]
        return list(said), score_vectors.unit(np.reshape(means, (len(said), vectors.shape[1])))

    def captions_like(self, capture: int, limit: int = 3) -> tuple[str, ...]:
        """Captions of other captures near in meaning to what the motion of one suggests."""
        captions, meanings = self._caption_meanings
        suggested = self.heard.meanings[self.places_in_rows[capture]]
        cosines = np.einsum("ij,j->i", meanings, suggested)  # the same for the same vectors
        order = np.argsort(-cosines, kind="stable")
        nearest = order[cosines[order] >= LEAST_ALIKE]
        texts = (captions[n][1] for n in nearest if captions[n][0] != capture)
        return tuple(islice(dict.fromkeys(texts), limit))

    @cached_property
    def description_map(self) -> DescriptionMap | None:
        """Map from score vectors to the words told of a motion; None if it was not calibrated."""
        if self.description_calibration is None:
            return None
        ready = self._ready_map("description")
        if ready:
            return DescriptionMap(**ready)
        rows = self.segments, self.described, self.score_space, self.word_numbers
        return description_map.map_descriptions(*rows, self.performers)

    @property
    def map_arrays(self) -> dict[str, NDArray[Any]]:
        """What ``caption_map`` and ``description_map`` are restored from."""
        maps = {"caption": self.caption_map, "description": self.description_map}
        return {
            f"{name} {part}": array
            for name, each in maps.items()
            if each is not None
            for part, array in vars(each).items()
        }

    def _ready_map(self, name: str) -> dict[str, NDArray[Any]]:
        """The prepared arrays of a map by their own names."""
        every = {} if self._ready is None else self._ready.maps
        start = f"{name} "
        return {part.removeprefix(start): every[part] for part in every if part.startswith(start)}

    @cached_property
    def segment_probabilities(self) -> FloatArray:
        """Probability of every word at every segment, from the motion alone: (segments, words)."""
        odds = [self.evidence.odds[capture][:-1] for capture in self.rows]
        return regression.probability(np.concatenate(odds))

    @cached_property
    def _said_words(self) -> Said:
        return said_words(self.described, self.word_numbers)

    @cached_property
    def place_arrays(self) -> Mapping[str, NDArray[Any]]:
        """What ``placed`` and ``unplaced`` are restored from; empty if no places were learned."""
        if self._ready is not None and self._ready.places:
            return self._ready.places
        if self.places is None:
            return {}
        n_words = len(self.word_numbers)
        rows = self.segments, self.segment_rows
        return place_fitting.fit_arrays(self.places, *rows, n_words, self._said_words)

    @property
    def places_digest(self) -> str:
        """A digest of all that ``place_arrays`` follow from, of a model that learned places.

        Of the captures, these are only those whose places were learned: it stays when others are
        added. Scores and movement of segments stand for themselves by symbols, feature space and
        log-likelihoods, in which any two motions differ.
        """
        assert self.places is not None
        places, table = self.places, self.segments
        words = self.association.words, self.synonyms, self.lemmas
        said = [
            [(one.words, one.start, one.end) for one in self.captions.get(capture, ())]
            for capture in places.words
        ]
        digest = sha256(repr((words, said, places.words, places.inferred)).encode())
        for y in (*places.shown.values(), *places.inferred_shown.values()):
            digest.update(y.tobytes())
        for name in ("symbols", "feature_space", "score_space"):
            for part, value in to_values(getattr(self, name), name=name).items():
                digest.update(f"{part} {np.shape(value)}".encode() + np.asarray(value).tobytes())
        which = np.isin(table.capture_ids, list(places.words))
        for name in ("capture_ids", "starts", "ends", "log_likelihoods", "backgrounds"):
            digest.update(getattr(table, name)[which].tobytes())
        return digest.hexdigest()

    @cached_property
    def placed(self) -> place_fitting.PlaceEvidence | None:
        """Evidence for the places of words, from the motion alone; None if none were learned."""
        if self.places is None:
            return None
        rows, n_words = (self.segments, self.segment_rows), len(self.word_numbers)
        arrays = self.place_arrays
        return place_fitting.place_evidence(self.places, *rows, n_words, self.performers, arrays)

    @cached_property
    def performers(self) -> dict[int, str]:
        """Capture number -> performer, as given or from the name of the capture."""
        return performers_of(self.captures)

    @cached_property
    def unplaced(self) -> place_fitting.LeftOut | None:
        """Evidence for words by a map that ignores places and is fitted without the take itself."""
        known = self.placed
        return None if known is None else known.unplaced(self._said_words, self.place_arrays)

    @cached_property
    def listed_actions(self) -> dict[int, list[frozenset[int]]]:
        """Recorded capture -> the actions that its captions list, each by numbers of its words."""
        written = Written(self.captions, self.synonyms, self.lemmas, self.word_numbers)
        actions_of = cache(lambda said: [frozenset(a) for a in written.actions(Caption(said))])
        listed = {
            capture: [
                action
                for caption in self.captions.get(capture, ())
                for action in actions_of(caption.words)  # many captures have the same words
            ]
            for capture in self.rows
            if self.captures[capture].kind == "captured"
        }
        return {capture: actions for capture, actions in listed.items() if actions}

    @cached_property
    def _said_actions(self) -> dict[int, tuple[tuple[str, ...], ...]]:
        """Actions of captions by capture, of those that were asked for."""
        return {}

    def said_actions(self, capture: int) -> tuple[tuple[str, ...], ...]:
        """The actions that the captions of a capture say, each by its words."""
        said = self._said_actions.get(capture)
        if said is None:
            said = self._said_actions[capture] = tuple(
                tuple(words)
                for caption in self.captions.get(capture, ())
                for words in split_actions(caption.words, self.synonyms, self.lemmas)
            )
        return said

    @cached_property
    def described_segments(self) -> DescribedSegments:
        """The segments of the described captures, to be compared with one another."""
        from motiondb.meaning.nearest_captures import CaptureSegments

        said = self._said_words
        rows = {c: r for c, r in self.rows.items() if c in said and r.stop > r.start}
        says = np.zeros((len(rows), len(self.word_numbers)), np.float32)
        for n, capture in enumerate(rows):
            words, n_actions = said[capture]
            says[n, sorted(words)] = 1.0 / np.sqrt(max(n_actions, 1))
        bounds = np.array([(r.start, r.stop) for r in rows.values()], np.int64).reshape(-1, 2)
        captures = np.array(list(rows), np.int64)
        return DescribedSegments(CaptureSegments(self.segment_rows, bounds), captures, says)

    @cached_property
    def said_places(self) -> dict[int, FloatArray]:
        """Evidence, in nats, that captions of intervals add: arrays (segments, words)."""
        written = Written(self.captions, self.synonyms, self.lemmas, self.word_numbers)
        return place_fitting.interval_evidence(self.segments, self.rows, written)

    def is_known(self) -> NDArray[np.bool_]:
        """Which words of the vocabulary some caption holds now: array (words,)."""
        return np.asarray(self.association.counts > 0)


def prepare(learned: Learned) -> dict[str, NDArray[Any]]:
    """Evidence of words in all captures, which questions need.

    They are those of ``heard``, whose reasons add up to 1e-9, and ``extremes`` (3, captures,
    words), float32: the largest and the smallest over the segments, and those of the whole, with
    captions.
    """
    if learned.fitted_word_map is None or not learned.rows:
        return {}
    learned = replace(learned, prepared=Prepared(learned))  # what it computes is not kept
    extremes = learned.evidence.extremes
    both = [extremes.highest, extremes.lowest, extremes.whole]
    return {**vars(learned.heard), "extremes": np.stack(both, dtype=np.float32)}
