"""Answers from what was learned: by words, by example, and the words of a motion.

:class:`Learned` holds everything a question needs in memory, so that an open database answers in
milliseconds; it is loaded once and dropped when the database learns or changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from motiondb import store
from motiondb.database.learning import FeaturePool, described_intervals, load_features
from motiondb.errors import NotLearnedError, QueryError
from motiondb.pose.features import FEATURE_STEP, recognition_features
from motiondb.records import (
    MOTION_FPS,
    Association,
    CaptureInfo,
    Float32Array,
    FloatArray,
    IntArray,
    Match,
    Motion,
    MotionSymbols,
    SegmentTable,
)
from motiondb.search import alignment, by_motion, by_words, score_vectors
from motiondb.symbols import acquisition, feature_space, hmm
from motiondb.words import decoding, transition, vocabulary, word_map

WINDOW_MARGIN = 22
"""Frames (0.75 s) that a window reaches beyond its segment: one segment alone is too short a look."""
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
        ids = self.segments.capture_ids
        new = np.flatnonzero(np.diff(ids, prepend=-1))
        return {int(ids[a]): slice(a, b) for a, b in zip(new, [*new[1:], len(ids)])}

    @cached_property
    def score_space(self) -> score_vectors.ScoreSpace:
        """Standardisation of scores."""
        return score_vectors.ScoreSpace(
            self.parameters["score_mean"], self.parameters["score_spread"]
        )

    @cached_property
    def standardised(self) -> FloatArray:
        """Standardised scores of all segments (segments, symbols)."""
        return self.score_space.standardise(self.segments.scores)

    @cached_property
    def feature_space(self) -> feature_space.FeatureSpace:
        """The projection of recognition features."""
        return feature_space.FeatureSpace(
            self.parameters["feature_mean"], self.parameters["feature_projection"]
        )

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
    def heard(self) -> dict[int, FloatArray]:
        """What motion alone says: log-odds (segments + 1, words) per capture, the last row whole."""
        margin, fit = WINDOW_MARGIN, self.word_map
        heard = {}
        for capture, rows in self.rows.items():
            starts, ends = self.segments.starts[rows], self.segments.ends[rows]
            low = np.concatenate([starts - margin, [0]])
            high = np.concatenate([ends + margin, [ends[-1]]])
            heard[capture] = fit.log_odds(
                score_vectors.interval_vectors(self.standardised[rows], starts, ends, low, high)
            )
        return heard

    @cached_property
    def takes(self) -> dict[int, by_words.TakeScores]:
        """Log-odds of all words in every capture, written words included."""
        written = self._written()
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
    def spoken(self) -> FloatArray:
        """Mean probability of every word at the segments of every symbol: array (symbols, words)."""
        odds = np.concatenate([self.heard[c][:-1] for c in self.rows])
        probabilities = 1.0 / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0)))
        sums = np.zeros((self.symbols.n_symbols, odds.shape[1]))
        np.add.at(sums, self.segments.symbols, probabilities)
        count = np.bincount(self.segments.symbols, minlength=len(sums))
        return sums / np.maximum(count, 1)[:, None]

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

    def _written(self) -> dict[int, FloatArray]:
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
    return Learned(
        database=database,
        symbols=store.load_symbols(database),
        segments=store.load_segments(database),
        association=store.load_association(database),
        parameters=store.load_parameters(database),
        captures={info.capture_id: info for info in store.load_captures(database)},
        synonyms=store.load_synonyms(database),
    )


@dataclass(frozen=True, eq=False)
class WordAnswer:
    """Hits, what of the question was not understood, and the decoded symbols.

    unknown : word -> nearest known words. decoding : None where no symbol sequence was found.
    """

    matches: tuple[Match, ...]
    unknown: Mapping[str, tuple[str, ...]]
    actions: tuple[tuple[str, ...], ...]
    decoding: decoding.Decoding | None = None


def search_words(
    learned: Learned,
    text: str,
    where: str = "",
    limit: int = 10,
    by_symbols: bool = False,
    written: bool = True,
) -> WordAnswer:
    """The intervals that show what a text asks for, best first.

    Parameters
    ----------
    by_symbols : as paper A: decode the words to symbols and align these with the captures.
    written : take what people wrote about the captures as evidence beside the motion.
    """
    if not text.strip():
        raise QueryError("search: expected words, found an empty question. Say what to look for.")
    query = vocabulary.parse_query(text, learned.association.words, learned.synonyms)
    allowed = _allowed(learned, where)
    if by_symbols:
        return _search_decoded(learned, query, allowed, limit)
    number = {word: n for n, word in enumerate(learned.association.words)}
    actions = [[number[w] for w in action] for action in query.actions]
    takes = learned.takes if written else learned.seen_takes
    hits = []
    for capture in allowed:
        hit = by_words.search_take(takes[capture], actions)
        if hit is not None:
            hits.append((capture, hit))
    hits.sort(key=lambda pair: (-pair[1].log_odds, pair[0]))
    matches = tuple(
        Match(
            rank,
            learned.captures[capture].name,
            *_seconds(learned, capture, hit.start, hit.end),
            hit.probability,
            _matched(takes[capture], query.actions, number),
            _reason(hit, query.actions),
        )
        for rank, (capture, hit) in enumerate(hits[:limit], start=1)
    )
    return WordAnswer(matches, query.unknown, query.actions)


def decode(
    learned: Learned,
    words: Sequence[str],
    clustered: bool = True,
    after: int | None = None,
    last: bool = True,
    length: int | None = None,
    association: Association | None = None,
) -> decoding.Decoding | None:
    """The symbols that most likely lie behind known words (see ``words.decoding``).

    Parameters
    ----------
    clustered : mix in the clustered bigram, so that pairs never seen may follow one another.
    after : the symbol that the sequence follows; None: it begins a capture.
    last : whether the sequence ends a capture; otherwise it may end with any symbol.
    length : number of symbols; None: any, as likely as the described captures make it.
    association : t and a in place of the learned ones.
    """
    number = {word: n for n, word in enumerate(learned.association.words)}
    log_transitions = learned.log_transitions[clustered].copy()
    if after is not None:
        log_transitions[0] = log_transitions[after + 1]
        log_transitions[0, 0] = -np.inf
    if not last:
        log_transitions[1:, 0] = 0.0
    if length is None:
        shapes: dict[tuple[int, int], float] = {}
        for m, n_symbols in learned.parameters["length_counts"].astype(int):
            shapes[n_symbols, m] = shapes.get((n_symbols, m), 0.0) + 1.0
        longest = max(LONGEST_DECODED, 2 * len(words))
        lengths = decoding.log_length_prior(shapes, len(words), longest)
    else:
        lengths = np.full(length + 1, -np.inf)
        lengths[length] = 0.0
    return decoding.decode_words(
        [number[w] for w in words], association or learned.association, log_transitions, lengths
    )


def _search_decoded(
    learned: Learned, query: vocabulary.ParsedQuery, allowed: Sequence[int], limit: int
) -> WordAnswer:
    decoded = decode(learned, query.words)
    if decoded is None:
        return WordAnswer((), query.unknown, query.actions, None)
    symbols = np.array(decoded.symbols)
    weights = np.full(len(symbols), 1.0 / len(symbols))
    scale = alignment.distance_scale(learned.distances)
    found = []
    for capture in allowed:
        rows = learned.rows[capture]
        score, first, last = alignment.align(
            symbols, weights, learned.segments.symbols[rows], learned.distances, scale
        )
        if last > first:
            start = int(learned.segments.starts[rows][first])
            found.append((score, capture, start, int(learned.segments.ends[rows][last - 1])))
    found.sort(key=lambda hit: (-hit[0], hit[1]))
    number = {word: n for n, word in enumerate(learned.association.words)}
    occurs = any(np.isclose(hit[0], 1.0) for hit in found)
    note = "" if occurs else "; this sequence of symbols never occurred, the nearest are given"
    matches = tuple(
        Match(
            rank,
            learned.captures[capture].name,
            *_seconds(learned, capture, start, end),
            float(score),
            _matched(learned.takes[capture], query.actions, number),
            f"symbols {' '.join(str(s) for s in decoded.symbols)}{note}",
        )
        for rank, (score, capture, start, end) in enumerate(found[:limit], start=1)
    )
    return WordAnswer(matches, query.unknown, query.actions, decoded)


def search_motion(
    learned: Learned, motion: Motion, where: str = "", limit: int = 10
) -> tuple[Match, ...]:
    """The stored intervals that move like a motion, best first."""
    query = make_query(learned, motion)
    takes = {
        capture: by_motion.Take(
            learned.segments.starts[rows] // FEATURE_STEP,
            -(-learned.segments.ends[rows] // FEATURE_STEP),
            learned.segments.symbols[rows],
            learned.standardised[rows],
        )
        for capture in _allowed(learned, where)
        for rows in [learned.rows[capture]]
    }
    candidates = by_motion.find_candidates(query, takes, learned.distances)
    features = {capture: learned.features(capture) for capture in {c.capture for c in candidates}}
    refined = by_motion.refine(query, candidates, features)
    return tuple(
        Match(
            rank,
            learned.captures[c.capture].name,
            *_seconds(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
            c.score,
            _words_of_interval(learned, c.capture, c.start * FEATURE_STEP, c.end * FEATURE_STEP),
        )
        for rank, c in enumerate(refined[:limit], start=1)
    )


def make_query(learned: Learned, motion: Motion) -> by_motion.Query:
    """Segment and recognise an example as the captures were."""
    features, starts, ends, symbols, standardised = recognise(learned, motion)
    weights = (ends - starts) / max(int((ends - starts).sum()), 1)
    vector = score_vectors.interval_vectors(
        standardised, starts, ends, np.array([0.0]), np.array([float(len(features))])
    )[0]
    return by_motion.Query(features, symbols, weights, vector)


def recognise(
    learned: Learned, motion: Motion
) -> tuple[Float32Array, IntArray, IntArray, IntArray, FloatArray]:
    """Whitened features, segment starts and ends (feature frames), symbols, standardised scores."""
    features = learned.feature_space.project(recognition_features(motion))
    bounds = np.array([0, len(features)])
    cutting = acquisition.recut(
        features, bounds, learned.symbols, acquisition.AcquisitionSettings()
    )
    lengths = (cutting.ends - cutting.starts)[:, None]
    scores = hmm.score(learned.symbols, features, cutting.starts, cutting.ends) / lengths
    standardised = learned.score_space.standardise(scores.astype(np.float32))
    return features, cutting.starts, cutting.ends, np.argmax(scores, axis=1), standardised


@dataclass(frozen=True)
class Description:
    """Words of an interval (seconds) with their probabilities, likeliest first."""

    start: float
    end: float
    words: tuple[tuple[str, float], ...]
    symbols: tuple[int, ...] = ()


def describe(learned: Learned, motion: Motion, n_words: int = 5) -> tuple[Description, ...]:
    """The words of a motion over time; neighbours with the same likeliest words are one interval."""
    _, starts, ends, symbols, standardised = recognise(learned, motion)
    margin = WINDOW_MARGIN // FEATURE_STEP
    vectors = score_vectors.interval_vectors(
        standardised, starts, ends, starts - margin, ends + margin
    )
    probabilities = learned.word_map.probabilities(vectors)
    groups: list[list[int]] = []
    for n, row in enumerate(probabilities):
        likeliest = set(np.argsort(-row)[:2])
        if groups and set(np.argsort(-probabilities[groups[-1]].mean(axis=0))[:2]) == likeliest:
            groups[-1].append(n)
        else:
            groups.append([n])
    seconds = FEATURE_STEP / MOTION_FPS
    answers = []
    for group in groups:
        mean = np.average(probabilities[group], axis=0, weights=(ends - starts)[group])
        order = np.argsort(-mean, kind="stable")[:n_words]
        answers.append(
            Description(
                round(float(starts[group[0]]) * seconds, 3),
                round(min(float(ends[group[-1]]) * seconds, motion.n_frames / MOTION_FPS), 3),
                tuple((learned.association.words[w], float(mean[w])) for w in order),
                tuple(int(s) for s in symbols[group]),
            )
        )
    return tuple(answers)


def _allowed(learned: Learned, where: str) -> list[int]:
    """Captures that a filter lets through and that were there when the database learned."""
    infos = store.load_captures(learned.database, where) if where else learned.captures.values()
    return [info.capture_id for info in infos if info.capture_id in learned.rows]


def _seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def _matched(
    take: by_words.TakeScores, actions: Sequence[Sequence[str]], number: Mapping[str, int]
) -> tuple[str, ...]:
    """Asked words that are likelier than not in the capture."""
    asked = dict.fromkeys(word for action in actions for word in action)
    top = np.maximum(take.windows.max(axis=0), take.whole)
    return tuple(word for word in asked if top[number[word]] > 0.0)


def _words_of_interval(learned: Learned, capture: int, start: int, end: int) -> tuple[str, ...]:
    """The likeliest words of a stored interval, if the database knows words at all."""
    if "word_weights" not in learned.parameters:
        return ()
    take = learned.takes[capture]
    inside = (take.starts < end) & (take.ends > start)
    odds = take.windows[inside].mean(axis=0)
    order = np.argsort(-odds, kind="stable")[:3]
    return tuple(learned.association.words[w] for w in order if odds[w] > -1.0)


def _reason(hit: by_words.Hit, actions: Sequence[Sequence[str]]) -> str:
    return "; ".join(
        f"{' '.join(words) or '?'} {start / MOTION_FPS:.2f}-{end / MOTION_FPS:.2f} s"
        for words, (start, end) in zip(actions, hit.parts)
    )
