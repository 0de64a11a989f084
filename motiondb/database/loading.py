"""What questions need, loaded from the store: the learned model, features, nearby words."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from importlib import resources
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from motiondb import store
from motiondb.body.features import (
    FEATURE_STEP,
    N_FEATURES,
    features_of_motions,
    recognition_features,
)
from motiondb.errors import NotLearnedError
from motiondb.language.nearby.table import NearbyTable, read_table
from motiondb.learn.checking import given_certainties
from motiondb.learn.joining import with_segments
from motiondb.learn.learned import PREPARED, Learned, Prepared, prepare
from motiondb.learn.learned_model import LearnedModel, from_stored
from motiondb.learn.recognition import FeaturePool, describe_segments, recognise_capture
from motiondb.meaning.counting import capture_rows, join_tables, take_rows
from motiondb.meaning.word_evidence import WhenAsked
from motiondb.records import Float32Array, Motion, SegmentTable
from motiondb.workers import HERE, Workers, is_array, runs, trusted

TABLE = "words.table"  # The shipped table of nearby words
FEATURE_SECONDS = 1e-5  # Time of one processor for a frame; decides only how work is divided
SEGMENTS = "segments"  # Name of scores and movement of all segments in that cache
PLACES = "places"  # Name of the fitted maps of places there
FEATURES = "features"  # Name of the features of all captures in the cache of the database


def load_without_rows(opened: store.Store) -> Learned:
    """The learned model and the catalogue, without scores and movement of segments.

    Neither motions nor scores are looked at, which may lie elsewhere.
    """
    with store.reading(opened):
        if not store.is_learned(opened):
            raise NotLearnedError(
                f"{opened.path}: expected a database that has learned, found only captures. "
                "Run motiondb learn first."
            )
        model = from_stored(store.load_learning(opened, scores=False))
        certainties = given_certainties(model.certainties, model.counted)
        infos = {info.capture_id: info for info in store.load_captures(opened) if info.has_body}
        return Learned(
            **{**vars(model), "certainties": certainties},
            captures=infos,
            captions={n: said for n, said in store.load_captions(opened).items() if n in infos},
            synonyms=store.load_synonyms(opened),
            source=str(opened.path),
        )


def load_learned(opened: store.Store, model: Learned, pool: Callable[[], FeaturePool]) -> Learned:
    """Load the data that questions need, all of one revision.

    `model`: That of :func:`load_without_rows`.

    `pool`: Gives the features; captures that it lacks, whose motions cannot be read, are left out.
    """
    with store.reading(opened):
        features = pool()
        held = _segment_rows(opened, model, features.of_capture)
        lacking = set(model.segments.capture_ids.tolist()) - set(held.capture_ids.tolist())
        lacking |= model.captures.keys() - features.places.keys()
        damaged = {n: info.name for n, info in model.captures.items() if n in lacking}
        if damaged:
            sound = ~np.isin(model.segments.capture_ids, list(damaged))
            model = with_segments(model, take_rows(model.segments, sound))
        return replace(
            model,
            segments=_with_rows(model, held),
            captures={n: info for n, info in model.captures.items() if n not in damaged},
            captions={n: said for n, said in model.captions.items() if n not in damaged},
            damaged=damaged,
        )


def _segment_rows(
    opened: store.Store,
    model: LearnedModel,
    features_of: Callable[[int], Float32Array],
    ready: Mapping[int, store.Made] = MappingProxyType({}),
) -> store.CaptureRows:
    """Scores and movement of the segments of a model, side by side, from the cache."""
    make = partial(_make_segment_rows, opened, model, features_of)
    return store.cached_segment_rows(opened, SEGMENTS, make, ready)


def _with_rows(model: LearnedModel, held: store.CaptureRows) -> SegmentTable:
    """The segments of a model with their scores and movement, of which more may be held."""
    table, n_symbols = model.segments, model.symbols.n_symbols
    parts = ((0, n_symbols), (n_symbols, held.rows.shape[1]))
    scores, movement = (cast(Float32Array, held.rows.columns(*part)) for part in parts)
    which = np.isin(held.capture_ids, table.capture_ids)
    if not which.all():  # without those of captures that are damaged
        inside = np.repeat(which, np.diff(held.bounds))
        scores, movement = scores[inside], movement[inside]
    return replace(table, scores=scores, movement=movement)


def _make_segment_rows(
    opened: store.Store,
    model: LearnedModel,
    features_of: Callable[[int], Float32Array],
    captures: Sequence[int],
) -> dict[int, store.Made]:
    """Scores and movement of the segments of some captures, side by side."""
    rows, table = capture_rows(model.segments), model.segments
    made: dict[int, store.Made] = {}
    for capture, scores in store.load_scores(opened, captures).items():
        try:
            features = features_of(capture)
        except KeyError:  # of a motion that cannot be read
            continue
        starts, ends = table.starts[rows[capture]], table.ends[rows[capture]]
        cut = starts // FEATURE_STEP, -(-ends // FEATURE_STEP)
        moving = describe_segments(model.feature_space.project(features), features, *cut)
        made[capture] = np.concatenate([scores, moving], axis=1), 0.0
    return made


def segments_of(
    opened: store.Store, model: LearnedModel, captures: Collection[int]
) -> SegmentTable:
    """The segments of some captures with scores and movement, also within a transaction.

    Without those whose motion is damaged and whose rows are not in the cache.
    """

    def features_of(capture: int) -> Float32Array:
        return recognition_features(dict(store.readable_motions(opened, [capture]))[capture])

    make = partial(_make_segment_rows, opened, model, features_of)
    found = store.cached_segment_rows(opened, SEGMENTS, make, only=captures)
    table = take_rows(model.segments, np.isin(model.segments.capture_ids, found.capture_ids))
    n_columns = model.symbols.n_symbols
    none = np.zeros((0, len(model.score_space.mean)), dtype=np.float32)
    rows = found.rows[:] if len(found.rows) else none
    return replace(table, scores=rows[:, :n_columns], movement=rows[:, n_columns:])


def keep_what_follows(opened: store.Store, model: LearnedModel) -> None:
    """Put into the cache what follows from a model that was just saved, until the next ``learn``.

    These are scores and movement of its segments, and the fitted maps of places.
    """
    table, rows = model.segments, capture_rows(model.segments)

    def of_capture(capture: int) -> store.Made:
        inside = rows[capture]
        return np.concatenate([table.scores[inside], table.movement[inside]], axis=1), 0.0

    with store.reading(opened):
        if store.load_learning_size(opened).run_id == model.run_id:
            pool = load_features(opened)
            _segment_rows(opened, model, pool.of_capture, WhenAsked(rows, of_capture))
            learned = load_learned(opened, load_without_rows(opened), lambda: pool)
            _place_arrays(opened, learned)


FeaturesMade = tuple[NDArray[Any], float]
"""Features (frames, 130) of a capture, and the length of its motion in frames."""


def load_features(
    opened: store.Store,
    ready: Mapping[int, FeaturesMade] = MappingProxyType({}),
    workers: Workers = HERE,
) -> FeaturePool:
    """Features of all motions; computed once, then memory-mapped from the cache of the database.

    `ready`: Features that were computed already, by number of the capture.
    """
    held = store.cached_rows(opened, FEATURES, partial(_made_by, workers), ready)
    none = np.zeros((0, N_FEATURES), dtype=np.float32)
    features = cast(Float32Array, held.rows) if len(held.rows) else none
    return FeaturePool(held.capture_ids, held.bounds, features, held.values.astype(np.int64))


def make_features(motions: Sequence[Motion]) -> list[FeaturesMade]:
    """Features and length of some motions, in their order."""
    parts = features_of_motions(motions)
    return [(part, float(motion.n_frames)) for part, motion in zip(parts, motions)]


def _made_by(workers: Workers, motions: Sequence[Motion]) -> list[FeaturesMade]:
    """As :func:`make_features`, by workers."""
    pieces = runs(motions, workers.n_pieces(FEATURE_SECONDS * sum(m.n_frames for m in motions)))
    parts = trusted(workers, _are_features, make_features, pieces)
    return [made for _, part in parts for made in part]


def _are_features(found: Sequence[FeaturesMade], motions: Sequence[Motion]) -> bool:
    """Whether features and lengths can be those of motions."""
    return all(
        is_array(features, (-(-motion.n_frames // FEATURE_STEP), N_FEATURES))
        and length == motion.n_frames
        for (features, length), motion in zip(found, motions, strict=True)
    )


def _with_generated(opened: store.Store, learned: Learned) -> Learned:
    """The learned model, with segments of the generated captures if there are any."""
    generated = sorted(i.capture_id for i in learned.captures.values() if i.kind == "generated")
    if not generated:
        return learned
    tables = [recognise_capture(learned, c, store.load_motion(opened, c)) for c in generated]
    return replace(learned, segments=join_tables(learned.segments, *tables))


def searchable(opened: store.Store, learned: Learned) -> Learned:
    """The learned model with the generated captures, and what questions need of all captures."""
    every = _with_generated(opened, learned)
    return learned if every is learned else _prepared(opened, every, "searched")


def load_prepared(opened: store.Store, model: Learned, pool: Callable[[], FeaturePool]) -> Learned:
    """The learned model with the catalogue of the same revision, ready for questions."""
    return _prepared(opened, load_learned(opened, model, pool))


def _prepared(opened: store.Store, learned: Learned, kind: str = "evidence") -> Learned:
    """The learned model with arrays of all captures from the cache of the database."""
    mark = f"{PREPARED} {store.learning_mark(opened)}{sorted(learned.damaged) or ''}"
    evidence = store.cached_arrays(opened, kind, lambda: prepare(learned), mark)
    places = _place_arrays(opened, learned)
    return replace(learned, prepared=Prepared(learned, evidence, places))


def _place_arrays(opened: store.Store, learned: Learned) -> Mapping[str, NDArray[Any]]:
    """The fitted maps of places from the cache; they stay when other captures are added."""
    if learned.places is None:
        return {}
    make, mark = (lambda: learned.place_arrays), learned.places_digest
    return store.cached_arrays(opened, PLACES, make, mark, False)


@lru_cache(maxsize=1)
def nearby_table() -> NearbyTable:
    """The table that is shipped with motiondb; read once."""
    file = resources.files("motiondb.language.nearby").joinpath(TABLE)
    return read_table(file.read_bytes(), TABLE)
