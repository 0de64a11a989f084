"""Learning: from the catalogue to symbols, their space, and their words; saved as a whole or not.

Steps: features of all captures (cached), feature space, first segmentation, competitive learning,
scores, symbol space, association of symbols and words, transitions, word map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from motiondb import store
from motiondb.errors import MotionDBError
from motiondb.pose.features import FEATURE_STEP, recognition_features
from motiondb.records import (
    Association,
    Caption,
    Float32Array,
    FloatArray,
    IntArray,
    Learning,
    MotionSymbols,
    SegmentTable,
)
from motiondb.search import score_vectors
from motiondb.symbols import acquisition, feature_space, hmm, segmentation
from motiondb.symbols import space as symbol_spaces
from motiondb.words import association, transition, vocabulary, word_map

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class LearnSettings:
    """Everything that decides what is learned; ``n_symbols`` None lets the data choose."""

    n_symbols: int | None = None
    seed: int = 0
    first_cut: segmentation.SegmentationSettings = field(
        default_factory=segmentation.SegmentationSettings
    )
    acquisition: acquisition.AcquisitionSettings = field(
        default_factory=acquisition.AcquisitionSettings
    )


@dataclass(frozen=True, eq=False)
class FeaturePool:
    """Recognition features of all captures, end to end.

    capture_ids : array (captures,). bounds : array (captures + 1,), rows of ``features``.
    features : array (rows, 130), float32, 15 a second. lengths : array (captures,), frames at 30.
    """

    capture_ids: IntArray
    bounds: IntArray
    features: Float32Array
    lengths: IntArray


def load_features(database: store.Store) -> FeaturePool:
    """Features of every captured motion; computed once, then mapped from the cache."""

    def build() -> dict[str, np.ndarray]:
        pool = store.load_motion_pool(database)
        parts = [recognition_features(pool.motion(int(c))) for c in pool.capture_ids]
        bounds = np.concatenate([[0], np.cumsum([len(p) for p in parts])]).astype(np.int64)
        joined = np.concatenate(parts) if parts else np.zeros((0, 130), dtype=np.float32)
        lengths = np.diff(pool.offsets)
        return {
            "capture_ids": pool.capture_ids, "bounds": bounds, "features": joined,
            "lengths": lengths,
        }  # fmt: skip

    return FeaturePool(**store.cached_arrays(database, "features", build))


def learn(
    database: store.Store, settings: LearnSettings, progress: Progress | None = None
) -> Learning:
    """Derive everything from the captures that were captured (not generated), and save it.

    Raises
    ------
    MotionDBError
        when the database holds no captures, or fewer segments than symbols asked for.
    """
    tell = progress or (lambda _what, _share: None)
    captured = {i.capture_id: i for i in store.load_captures(database) if i.kind == "captured"}
    if not captured:
        raise MotionDBError(
            f"{database.path}: expected captures to learn from, found none. "
            "Add some first: motiondb add FOLDER."
        )
    tell("features", 0.0)
    pool = _captured_only(load_features(database), set(captured))
    rng = np.random.default_rng(settings.seed)
    space = feature_space.fit_feature_space(
        [pool.features[a:b] for a, b in zip(pool.bounds[:-1], pool.bounds[1:])]
    )
    frames = space.project(np.asarray(pool.features))
    acquired = _acquire(frames, pool, rng, settings, tell)
    tell("scoring", 0.0)
    table = _segment_table(frames, pool, acquired.symbols, acquired.cutting)
    tell("symbol space", 0.0)
    symbol_space = symbol_spaces.build_space(acquired.symbols, rng)
    tell("words", 0.0)
    captions = {c: v for c, v in store.load_captions(database).items() if c in captured}
    groups = {c: info.tags.get("performer", f"#{c}") for c, info in captured.items()}
    words, parameters = _associate(
        table, captions, groups, store.load_synonyms(database), acquired.symbols.n_symbols
    )
    parameters |= {
        "feature_mean": space.mean,
        "feature_projection": space.projection,
        "description_lengths": np.array(acquired.description_lengths),
    }
    return _save(database, settings, acquired.symbols, table, symbol_space, words, parameters, tell)


def _save(database, settings, symbols, table, space, words, parameters, tell):  # type: ignore[no-untyped-def]
    tell("saving", 0.0)
    with store.transaction(database):
        run_id = store.start_run(database, "learn", asdict(settings), settings.seed)
        learning = Learning(
            run_id=run_id,
            symbols=symbols,
            segments=table,
            space=space,
            association=words,
            transition_counts=transition.count_transitions(
                symbol_sequences(table), symbols.n_symbols
            ),
            parameters=parameters,
        )
        store.save_learning(database, learning)
        store.finish_run(database, run_id)
    return learning


def _captured_only(pool: FeaturePool, wanted: set[int]) -> FeaturePool:
    """The pool without generated captures."""
    keep = np.array([int(c) in wanted for c in pool.capture_ids], dtype=bool)
    if keep.all():
        return pool
    sizes = np.diff(pool.bounds)
    rows = np.repeat(keep, sizes)
    bounds = np.concatenate([[0], np.cumsum(sizes[keep])])
    return FeaturePool(pool.capture_ids[keep], bounds, pool.features[rows], pool.lengths[keep])


def _acquire(
    frames: Float32Array,
    pool: FeaturePool,
    rng: np.random.Generator,
    settings: LearnSettings,
    tell: Progress,
) -> acquisition.Acquired:
    starts, ends = [], []
    for low, high in zip(pool.bounds[:-1], pool.bounds[1:]):
        for part in segmentation.segment(frames[low:high].astype(np.float64), settings.first_cut):
            starts.append(low + part.start)
            ends.append(low + part.end)
    chosen = replace(settings.acquisition, n_symbols=settings.n_symbols)
    return acquisition.acquire(
        frames, pool.bounds, np.array(starts), np.array(ends), rng, chosen, tell
    )


def _segment_table(
    frames: Float32Array,
    pool: FeaturePool,
    symbols: MotionSymbols,
    cutting: acquisition.Cutting,
) -> SegmentTable:
    owner = np.searchsorted(pool.bounds, cutting.starts, side="right") - 1
    first = pool.bounds[owner]
    per_frame = (cutting.ends - cutting.starts).astype(np.float64)
    scores = hmm.score(symbols, frames, cutting.starts, cutting.ends) / per_frame[:, None]
    best = np.argmax(scores, axis=1)
    return SegmentTable(
        capture_ids=np.asarray(pool.capture_ids)[owner],
        starts=(cutting.starts - first) * FEATURE_STEP,
        ends=np.minimum((cutting.ends - first) * FEATURE_STEP, np.asarray(pool.lengths)[owner]),
        symbols=best,
        log_likelihoods=scores[np.arange(len(best)), best].astype(np.float64),
        backgrounds=background(frames, cutting.starts, cutting.ends),
        scores=scores.astype(np.float32),
    )


def background(frames: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Log-likelihood per frame under the background model: the whitened features' N(0, 1)."""
    each = -0.5 * (
        np.sum(frames.astype(np.float64) ** 2, axis=1) + frames.shape[1] * np.log(2 * np.pi)
    )
    sums = np.concatenate([[0.0], np.cumsum(each)])
    return (sums[ends] - sums[starts]) / (ends - starts)


def symbol_sequences(table: SegmentTable) -> list[IntArray]:
    """The symbol sequence of every capture, in order of capture number."""
    new = np.flatnonzero(np.diff(table.capture_ids, prepend=-1))
    return [table.symbols[a:b] for a, b in zip(new, [*new[1:], len(table.symbols)])]


@dataclass(frozen=True, eq=False)
class Described:
    """An interval of a capture that somebody wrote about: rows [low, high) of the segment table,
    frames ``start`` to ``end``; ``words`` in order, of ``n_actions`` actions."""

    capture_id: int
    low: int
    high: int
    start: float
    end: float
    words: tuple[str, ...]
    n_actions: int


def described_intervals(
    table: SegmentTable,
    captions: Mapping[int, tuple[Caption, ...]],
    synonyms: Mapping[str, str],
) -> list[Described]:
    """Captions with at least one motion word, and the segments they speak of."""
    found = []
    for capture_id, rows in sorted(captions.items()):
        first, last = np.searchsorted(table.capture_ids, [capture_id, capture_id + 1])
        for caption in rows:
            actions = vocabulary.split_actions(caption.words, synonyms)
            words = tuple(word for action in actions for word in action)
            if not words or first == last:
                continue
            start = (caption.start or 0.0) * 30.0
            end = float(table.ends[last - 1]) if caption.end is None else caption.end * 30.0
            inside = (table.starts[first:last] < end) & (table.ends[first:last] > start)
            if inside.any():
                which = first + np.flatnonzero(inside)
                rows_of = (int(which[0]), int(which[-1]) + 1)
                found.append(Described(capture_id, *rows_of, start, end, words, len(actions)))
    return found


def _associate(
    table: SegmentTable,
    captions: Mapping[int, tuple[Caption, ...]],
    groups: Mapping[int, str],
    synonyms: Mapping[str, str],
    n_symbols: int,
) -> tuple[Association, dict[str, FloatArray]]:
    scores = score_vectors.fit_score_space(table.scores, table.ends - table.starts)
    parameters = {"score_mean": scores.mean, "score_spread": scores.spread}
    described = described_intervals(table, captions, synonyms)
    words, counts = vocabulary.count_words([d.words for d in described])
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, n_symbols, words)
    parameters["length_counts"] = length_counts(pairs)
    if described:
        vectors, presence, who = _training_rows(table, described, scores, number, groups)
        fit = word_map.fit_word_map(vectors, presence, who)
        parameters |= {f"word_{k}": v for k, v in vars(fit).items()}
    return replace(fitted, counts=counts), parameters


def length_counts(pairs: list[tuple[IntArray, IntArray]]) -> FloatArray:
    """Rows (words m, symbols l) of all pairs: array (pairs, 2)."""
    return np.array([(len(w), len(s)) for s, w in pairs], dtype=float).reshape(-1, 2)


def _training_rows(
    table: SegmentTable,
    described: list[Described],
    scores: score_vectors.ScoreSpace,
    number: Mapping[str, int],
    groups: Mapping[int, str],
) -> tuple[FloatArray, np.ndarray, IntArray]:
    """One row per described interval (captions of the same interval are one)."""
    standardised = scores.standardise(table.scores)
    merged: dict[tuple[int, float, float], tuple[Described, set[str]]] = {}
    for d in described:
        merged.setdefault((d.capture_id, d.start, d.end), (d, set()))[1].update(d.words)
    vectors = np.empty((len(merged), table.scores.shape[1]))
    presence = np.zeros((len(merged), len(number)), dtype=bool)
    for row, (d, words) in enumerate(merged.values()):
        part = slice(d.low, d.high)
        vectors[row] = score_vectors.interval_vectors(
            standardised[part], table.starts[part], table.ends[part],
            np.array([d.start]), np.array([d.end]),
        )[0]  # fmt: skip
        presence[row, [number[w] for w in words]] = True
    who = np.unique([groups[d.capture_id] for d, _ in merged.values()], return_inverse=True)[1]
    if len(merged) == 1:  # twice, so that something is left when the map leaves one out
        return vectors.repeat(2, axis=0), presence.repeat(2, axis=0), np.arange(2)
    return vectors, presence, who
