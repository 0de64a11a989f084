"""Learning: from the catalogue to symbols, their space, and their words; saved as a whole or not.

Steps: features of all captures (cached), feature space, first segmentation, competitive learning,
scores, symbol space, association of symbols and words, transitions, word map.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise

import numpy as np

from motiondb import store
from motiondb.database.learn import asked_certainty, captures_drift, counting
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
from motiondb.search import bearing, extents, movement, score_vectors
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
    acquired = acquire_symbols(frames, pool, rng, settings, tell)
    tell("scoring", 0.0)
    table = segment_table(frames, pool, acquired.symbols, acquired.cutting)
    tell("symbol space", 0.0)
    symbol_space = symbol_spaces.build_space(acquired.symbols, rng)
    tell("words", 0.0)
    captions = {c: v for c, v in store.load_captions(database).items() if c in captured}
    groups = {c: info.tags.get("performer", f"#{c}") for c, info in captured.items()}
    words, parameters = _associate(
        table, captions, groups, store.load_synonyms(database), acquired.symbols.n_symbols
    )
    contexts = extents.fit_context_space([pool.features[a:b] for a, b in pairwise(pool.bounds)])
    parameters |= {f"context_{name}": value for name, value in vars(contexts).items()}
    parameters |= {
        "feature_mean": space.mean,
        "feature_projection": space.projection,
        "description_lengths": np.array(acquired.description_lengths),
        **captures_drift.baseline(table),
        "recut": np.array([settings.acquisition.switch_cost, settings.acquisition.shortest]),
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
                counting.symbol_sequences(table), symbols.n_symbols
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


def acquire_symbols(
    frames: Float32Array,
    pool: FeaturePool,
    rng: np.random.Generator,
    settings: LearnSettings,
    tell: Progress,
) -> acquisition.Acquired:
    """First segmentation and competitive learning; ``frames`` are the pool's, whitened."""
    starts, ends = [], []
    for low, high in zip(pool.bounds[:-1], pool.bounds[1:]):
        for part in segmentation.segment(frames[low:high].astype(np.float64), settings.first_cut):
            starts.append(low + part.start)
            ends.append(low + part.end)
    chosen = replace(settings.acquisition, n_symbols=settings.n_symbols)
    return acquisition.acquire(
        frames, pool.bounds, np.array(starts), np.array(ends), rng, chosen, tell
    )


def recut_settings(parameters: Mapping[str, FloatArray]) -> acquisition.AcquisitionSettings:
    """How symbols cut a motion, as they did when they were learned."""
    defaults = acquisition.AcquisitionSettings()
    stored = parameters.get("recut", np.array([defaults.switch_cost, defaults.shortest]))
    return replace(defaults, switch_cost=float(stored[0]), shortest=int(stored[1]))


def segment_table(
    frames: Float32Array,
    pool: FeaturePool,
    symbols: MotionSymbols,
    cutting: acquisition.Cutting,
) -> SegmentTable:
    """What every symbol says of every segment of a cutting; frames as in ``pool.bounds``."""
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
        movement=_movement(frames, pool, cutting),
    )


def _movement(
    frames: Float32Array, pool: FeaturePool, cutting: acquisition.Cutting
) -> Float32Array:
    """How every segment moves, capture by capture: array (segments, columns)."""
    bounds = pool.bounds
    first, last = (np.searchsorted(cutting.starts, b) for b in (bounds[:-1], bounds[1:]))
    return np.concatenate(
        [
            describe_segments(
                frames[low:high], pool.features[low:high],
                cutting.starts[a:b] - low, cutting.ends[a:b] - low,
            )
            for a, b, low, high in zip(first, last, bounds[:-1], bounds[1:])
        ]
    )  # fmt: skip


def describe_segments(
    frames: Float32Array, features: Float32Array, starts: IntArray, ends: IntArray
) -> Float32Array:
    """How the segments of one capture move and how the body bears itself: (segments, columns).

    frames, features : of the capture, whitened and plain. starts, ends : feature frames.
    """
    moving = movement.describe_movement(frames, starts, ends)
    return np.concatenate([moving, bearing.describe_bearing(features, starts, ends)], axis=1)


def background(frames: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Log-likelihood per frame under the background model: the whitened features' N(0, 1)."""
    each = -0.5 * (
        np.sum(frames.astype(np.float64) ** 2, axis=1) + frames.shape[1] * np.log(2 * np.pi)
    )
    sums = np.concatenate([[0.0], np.cumsum(each)])
    return (sums[ends] - sums[starts]) / (ends - starts)


def _associate(
    table: SegmentTable,
    captions: Mapping[int, tuple[Caption, ...]],
    groups: Mapping[int, str],
    synonyms: Mapping[str, str],
    n_symbols: int,
) -> tuple[Association, dict[str, FloatArray]]:
    """Symbols and words by EM and ridge regression, then published from their counts."""
    scores = score_vectors.fit_score_space(table.scores, table.ends - table.starts, table.movement)
    described = counting.described_intervals(table, captions, synonyms)
    words, _ = vocabulary.count_words([d.words for d in described])
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, n_symbols, words)
    shapes = Counter((len(symbols), len(spoken)) for symbols, spoken in pairs)
    reference = counting.make_reference(fitted, shapes, scores)
    counts = counting.count(table, captions, synonyms, reference)
    ridge, calibration, sure = None, None, {}
    if described:
        vectors, presence, owners = counting.training_rows(table, described, scores, number)
        who = np.unique([groups[int(c)] for c in owners], return_inverse=True)[1]
        if len(vectors) == 1:  # twice, so that something is left when the map leaves one out
            vectors, presence, who = vectors.repeat(2, 0), presence.repeat(2, 0), np.arange(2)
        fit = word_map.fit_word_map(vectors, presence, who)
        ridge, calibration = fit.ridge, fit.calibration
        sure = _certainties(table, described, (vectors, presence, owners, who), scores, words, fit)
    parameters = {"score_mean": scores.mean, "score_spread": scores.spread, **sure}
    parameters |= counting.publish_parameters(counts, ridge, calibration)
    parameters |= counting.pack(counts, reference)
    parameters["dictionary_forms"] = counting.pack_forms(captions)
    return counting.publish_association(counts, reference), parameters


def _certainties(table, described, rows, scores, names, fit):  # type: ignore[no-untyped-def]
    """How sure answers are (``database.certainty``); ``rows`` as the word map was fitted to."""
    vectors, presence, owners, who = rows
    if len(owners) < len(who):
        return {}
    starts, ends = asked_certainty.intervals_of(described)
    standardised = scores.standardise(table.scores, table.movement)
    return asked_certainty.fit_certainties(
        asked_certainty.Written(
            vectors, presence, names, owners, starts, ends, who, table, standardised,
            fit.ridge, fit.calibration,
            n_bearing=movement.count_bearing(table.movement.shape[1]),
        )
    )  # fmt: skip
