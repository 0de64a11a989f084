"""Learning as a whole: from features and captions to everything that ``learn`` derives.

Captures have numbers in the order in which they were added, and much of learning goes through them
in order of number: random starts, sums, ties. While it learns, the captures therefore exchange
numbers: the first by name has the smallest. So learning does not depend on the order of arrival.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, floor
from typing import TypeVar

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.learn import drift, joining
from motiondb.learn.knowledge import Started
from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.recognition import (
    FeaturePool,
    LearnSettings,
    Progress,
    acquire_symbols,
    segment_table,
)
from motiondb.learn.word_fitting import (
    FittedWords,
    TaughtWords,
    fit_words,
)
from motiondb.meaning import counting, extents
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.edge_map import EdgeMap, FrameTake, fit_edge_map
from motiondb.meaning.motion_judge import MotionJudge, fit_judge, pool_windows, said_words
from motiondb.meaning.place_certainty import learn_certainty
from motiondb.meaning.place_fitting import Places, Room, Written, find_places
from motiondb.meaning.regression import Certainties
from motiondb.meaning.resemblance import PooledMap, fit_pooled_map, pooled_statistics
from motiondb.meaning.score_vectors import StandardisedRows
from motiondb.meaning.word_evidence import WhenAsked
from motiondb.records import Float32Array, IntArray, MotionSymbols, SegmentTable, SymbolSpace
from motiondb.symbols import acquisition, feature_space
from motiondb.symbols import space as symbol_spaces
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.symbols.settings import RecutSettings
from motiondb.symbols.spread import spread
from motiondb.workers import HERE, Workers

T = TypeVar("T")
NEARLY = 1e-6  # Feature frames by which the rounding of seconds may move the end of an interval


def fit_model(
    pool: FeaturePool,
    taught: TaughtWords,
    settings: LearnSettings,
    rng: np.random.Generator,
    tell: Progress,
    started: Started | None = None,
    workers: Workers = HERE,
) -> LearnedModel:
    """Learn symbols, their space and their words.

    With a start, its feature space, symbols and symbol space are taken over, and its words are
    joined with those of the captions. A start whose symbols do not fit the captures is set aside
    if there are enough captions (:func:`motiondb.learn.joining.is_set_aside`).
    """
    if started is not None:
        model = _fit_with_start(pool, taught, started, rng, tell, workers)
        if model is not None:
            return model
    space = feature_space.fit_feature_space(pool)
    frames = space.project(pool.features)
    held = spread(frames, pool.bounds, workers)
    acquired = acquire_symbols(held, pool, rng, settings, tell)
    tell("scoring", 0.0)
    table = segment_table(held, pool, acquired.symbols, acquired.cutting, acquired.scores)
    acquired = replace(acquired, scores=None)  # as large as those of the table
    tell("symbol space", 0.0)
    symbol_space = symbol_spaces.build_space(acquired.symbols, rng)
    tell("words", 0.0)
    words = fit_words(table, taught)
    contexts = extents.fit_context_space(pool)
    of_symbols = _Symbols(acquired.symbols, symbol_space, space, contexts, settings.acquisition)
    return replace(
        _fit_rest(of_symbols, frames, pool, table, taught, words, rng),
        description_lengths=np.array(acquired.description_lengths),
        pooled=_fit_pooled(frames, pool, words),
        description_calibration=words.description_calibration,
    )


@dataclass(frozen=True, eq=False)
class _Symbols:
    """The part of the learned model that is of symbols alone."""

    symbols: MotionSymbols
    space: SymbolSpace
    feature_space: feature_space.FeatureSpace
    context_space: extents.ContextSpace
    cutting: RecutSettings


def _fit_rest(
    of_symbols: _Symbols,
    frames: Float32Array,
    pool: FeaturePool,
    table: SegmentTable,
    taught: TaughtWords,
    words: FittedWords,
    rng: np.random.Generator,
) -> LearnedModel:
    """The learned model from its symbols, segments and words."""
    places, certainties = _fit_places(table, taught, words, rng, pool.room)
    return LearnedModel(
        run_id=0,
        **vars(of_symbols),
        **vars(words.published),
        segments=table,
        score_space=words.score_space,
        certainties=certainties,
        counted=words.counted,
        lemmas=words.counted.reference.lemmas,
        drift_baseline=drift.fit_baseline(table),
        places=places,
        judge=_fit_judge(frames, pool, taught, words, rng),
        edges=_fit_edges(frames, pool, table, places, len(words.numbers)),
    )


def _fit_with_start(
    pool: FeaturePool,
    taught: TaughtWords,
    started: Started,
    rng: np.random.Generator,
    tell: Progress,
    workers: Workers,
) -> LearnedModel | None:
    """The model learned with the symbols of a start; None if the start is set aside.

    Only the seed of the settings is used.
    """
    first = started.knowledge
    tell("cutting", 0.0)
    frames = first.feature_space.project(pool.features)
    held = spread(frames, pool.bounds, workers)
    cutting = acquisition.recut(held, pool.bounds, first.symbols, first.cutting)
    tell("scoring", 0.0)
    table = segment_table(held, pool, first.symbols, cutting)
    if joining.is_set_aside(table, len(taught.described(table))):
        return None
    tell("words", 0.0)
    words = fit_words(table, taught, started)
    of_symbols = _Symbols(
        first.symbols, first.space, first.feature_space, first.context_space, first.cutting
    )
    rest = _fit_rest(of_symbols, frames, pool, table, taught, words, rng)
    return replace(rest, started=started)


def _fit_places(
    table: SegmentTable,
    taught: TaughtWords,
    words: FittedWords,
    rng: np.random.Generator,
    room: Room,
) -> tuple[Places | None, Certainties]:
    """Where the actions of captions happen, and certainties with that of places."""
    standardised = StandardisedRows.of_table(words.score_space, table)
    written = Written(taught.captions, taught.synonyms, taught.lemmas, words.numbers)
    places = find_places(table, standardised, written, room)
    if places is None:
        return None, words.certainties
    sure = learn_certainty(table, standardised, written, places, taught.performers, rng)
    if sure is None:
        return places, words.certainties
    return places, replace(words.certainties, place=sure.several, single=sure.single)


def _fit_edges(
    frames: Float32Array,
    pool: FeaturePool,
    table: SegmentTable,
    places: Places | None,
    n_words: int,
) -> EdgeMap | None:
    """Evidence for words at each frame, which takes the y of its segment; None without places."""
    if places is None:
        return None
    rows = capture_rows(table)
    takes = []
    for capture, first, last in zip(pool.capture_ids.tolist(), pool.bounds[:-1], pool.bounds[1:]):
        if capture not in places.words:
            continue
        middles = FEATURE_STEP * (np.arange(last - first) + 0.5)
        ends = table.ends[rows[capture]]
        segments = np.minimum(np.searchsorted(ends, middles, side="right"), len(ends) - 1)
        shown = places.shown[capture][segments]
        takes.append(FrameTake(frames[first:last], places.words[capture], shown))
    with one_blas_thread():  # sums of several threads differ in their last bits
        return fit_edge_map(takes, n_words)


def _fit_pooled(frames: Float32Array, pool: FeaturePool, words: FittedWords) -> PooledMap | None:
    """Second opinion on the words of intervals; None if no words were written."""
    if not words.described:
        return None
    bounds = dict(zip(pool.capture_ids.tolist(), pairwise(pool.bounds.tolist())))
    intervals, presence = counting.merged_intervals(words.described, words.numbers)
    rows = []
    for d in intervals:
        first, last = bounds[d.capture_id]
        low = min(first + floor(d.start / FEATURE_STEP + NEARLY), last - 1)
        high = min(max(first + ceil(d.end / FEATURE_STEP - NEARLY), low + 1), last)
        rows.append(pooled_statistics(frames[low:high]))
    with one_blas_thread():  # sums of several threads differ in their last bits
        return fit_pooled_map(np.stack(rows), presence)


def _fit_judge(
    frames: Float32Array,
    pool: FeaturePool,
    taught: TaughtWords,
    words: FittedWords,
    rng: np.random.Generator,
) -> MotionJudge | None:
    """The judge of generated motion; None if no words were written."""
    if not words.described:
        return None
    windows = WhenAsked(pool.places, lambda capture: pool_windows(frames[pool.rows_of(capture)]))
    said = said_words(words.described, words.numbers)
    return fit_judge(windows, said, len(words.numbers), taught.performers, rng)


def numbers_by_name(names: Mapping[int, str]) -> dict[int, int]:
    """Capture number -> its number while learning, from the names by number.

    >>> numbers_by_name({3: "b", 5: "a", 9: "c"})
    {5: 3, 3: 5, 9: 9}
    """
    return dict(zip(sorted(names, key=lambda capture: names[capture]), sorted(names)))


def renumber_taught(taught: TaughtWords, numbers: Mapping[int, int]) -> TaughtWords:
    """Captions and performers under other numbers."""
    return TaughtWords(
        _renumber(taught.captions, numbers), taught.synonyms, _renumber(taught.performers, numbers)
    )


def renumber_model(model: LearnedModel, numbers: Mapping[int, int]) -> LearnedModel:
    """The learned model under other numbers of captures."""
    captures = _renumber_all(model.segments.capture_ids, numbers)
    order = np.argsort(captures, kind="stable")
    rows = {name: column[order] for name, column in vars(model.segments).items()}
    places = model.places
    return replace(
        model,
        segments=replace(model.segments, **rows | {"capture_ids": captures[order]}),
        drift_baseline=replace(
            model.drift_baseline,
            captures=np.sort(_renumber_all(model.drift_baseline.captures, numbers)),
        ),
        places=None
        if places is None
        else Places(**{name: _renumber(of_one, numbers) for name, of_one in vars(places).items()}),
    )


def _renumber_all(captures: IntArray, numbers: Mapping[int, int]) -> IntArray:
    return np.array([numbers[int(capture)] for capture in captures], dtype=np.int64)


def _renumber(values: Mapping[int, T], numbers: Mapping[int, int]) -> dict[int, T]:
    """Values by capture under other numbers, rising."""
    renamed = {numbers[capture]: value for capture, value in values.items()}
    return {capture: renamed[capture] for capture in sorted(renamed)}
