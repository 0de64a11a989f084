"""Learning as a whole: from features and captions to everything that ``learn`` derives.

The evidence at single frames (:mod:`motiondb.meaning.edge_map`), which says where actions begin and
end, is fitted to the places of words: a frame takes the y of its segment.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, floor

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
    fit_words_with_start,
)
from motiondb.meaning import counting, extents
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.edge_map import EdgeMap, FrameTake, fit_edge_map
from motiondb.meaning.motion_judge import MotionJudge, fit_judge, pool_windows, said_words
from motiondb.meaning.place_certainty import learn_certainty
from motiondb.meaning.place_fitting import Places, Written, find_places
from motiondb.meaning.regression import Certainties
from motiondb.meaning.resemblance import PooledMap, fit_pooled_map, pooled_statistics
from motiondb.records import Float32Array, MotionSymbols, SegmentTable, SymbolSpace
from motiondb.symbols import acquisition, feature_space
from motiondb.symbols import space as symbol_spaces
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.symbols.settings import RecutSettings
from motiondb.workers import HERE, Workers

NEARLY = 1e-6  # Feature frames by which the rounding of seconds may move the end of an interval


def fit_edges(
    frames: Float32Array, pool: FeaturePool, table: SegmentTable, places: Places, n_words: int
) -> EdgeMap:
    """Fit the evidence for words at each frame; `frames` (rows, D)."""
    rows = capture_rows(table)
    bounds = zip(pool.capture_ids.tolist(), pool.bounds[:-1], pool.bounds[1:])
    takes = []
    for capture, first, last in bounds:
        if capture not in places.words:
            continue
        middles = FEATURE_STEP * (np.arange(last - first) + 0.5)
        ends = table.ends[rows[capture]]
        segments = np.minimum(np.searchsorted(ends, middles, side="right"), len(ends) - 1)
        shown = places.shown[capture][segments]
        takes.append(FrameTake(frames[first:last], places.words[capture], shown))
    with one_blas_thread():  # sums of several threads differ in their last bits
        return fit_edge_map(takes, n_words)


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
    parts = [pool.features[a:b] for a, b in pairwise(pool.bounds)]
    space = feature_space.fit_feature_space(parts)
    frames = space.project(np.asarray(pool.features))
    acquired = acquire_symbols(frames, pool, rng, settings, tell, workers)
    tell("scoring", 0.0)
    table = segment_table(frames, pool, acquired.symbols, acquired.cutting, workers)
    tell("symbol space", 0.0)
    symbol_space = symbol_spaces.build_space(acquired.symbols, rng)
    tell("words", 0.0)
    n_symbols = acquired.symbols.n_symbols
    words = fit_words(table, taught, n_symbols)
    contexts = extents.fit_context_space(parts)
    of_symbols = _Symbols(acquired.symbols, symbol_space, space, contexts, settings.acquisition)
    return replace(
        _fit_rest(of_symbols, frames, pool, table, (taught, words), rng),
        description_lengths=np.array(acquired.description_lengths),
        pooled=_fit_pooled(frames, pool, table, (taught, words)),
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
    said: tuple[TaughtWords, FittedWords],
    rng: np.random.Generator,
) -> LearnedModel:
    """The learned model from its symbols, segments and words."""
    taught, words = said
    places, certainties = _fit_places(table, taught, words, rng)
    return LearnedModel(
        run_id=0,
        **vars(of_symbols),
        segments=table,
        association=words.association,
        transition_counts=words.transitions,
        score_space=words.score_space,
        fitted_word_map=words.word_map,
        certainties=certainties,
        lengths=words.lengths,
        counted=words.counted,
        lemmas=words.counted.reference.lemmas,
        drift_baseline=drift.fit_baseline(table),
        places=places,
        judge=_fit_judge(frames, pool, table, said, rng),
        edges=_fit_edges(frames, pool, table, places, words),
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
    frames = first.feature_space.project(np.asarray(pool.features))
    cutting = acquisition.recut(frames, pool.bounds, first.symbols, first.cutting, workers)
    tell("scoring", 0.0)
    table = segment_table(frames, pool, first.symbols, cutting, workers)
    lemmas = counting.dictionary_lemmas(taught.captions)
    described = counting.described_intervals(table, taught.captions, taught.synonyms, lemmas)
    if joining.is_set_aside(table, len(described)):
        return None
    tell("words", 0.0)
    words = fit_words_with_start(table, taught, started)
    of_symbols = _Symbols(
        first.symbols, first.space, first.feature_space, first.context_space, first.cutting
    )
    rest = _fit_rest(of_symbols, frames, pool, table, (taught, words), rng)
    return replace(rest, started=started)


def _fit_places(
    table: SegmentTable, taught: TaughtWords, words: FittedWords, rng: np.random.Generator
) -> tuple[Places | None, Certainties]:
    """Where the actions of captions happen, and certainties with that of places."""
    numbers = {word: number for number, word in enumerate(words.association.words)}
    standardised = words.score_space.standardise(table.scores, table.movement)
    lemmas = words.counted.reference.lemmas
    written = Written(taught.captions, taught.synonyms, lemmas, numbers)
    places = find_places(table, standardised, written)
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
    words: FittedWords,
) -> EdgeMap | None:
    """Evidence for words at each frame; None where no places were found."""
    if places is None:
        return None
    return fit_edges(frames, pool, table, places, len(words.association.words))


def _fit_pooled(
    frames: Float32Array,
    pool: FeaturePool,
    table: SegmentTable,
    said: tuple[TaughtWords, FittedWords],
) -> PooledMap | None:
    """Second opinion on the words of intervals; None if no words were written."""
    taught, words = said
    numbers = {word: number for number, word in enumerate(words.association.words)}
    merged: dict[tuple[int, float, float], set[str]] = {}
    for d in counting.described_intervals(
        table, taught.captions, taught.synonyms, words.counted.reference.lemmas
    ):
        merged.setdefault((d.capture_id, d.start, d.end), set()).update(d.words)
    if not merged:
        return None
    bounds = dict(zip(pool.capture_ids.tolist(), pairwise(pool.bounds.tolist())))
    presence = np.zeros((len(merged), len(numbers)), dtype=bool)
    rows = []
    for row, ((capture, start, end), spoken) in enumerate(merged.items()):
        first, last = bounds[capture]
        low = min(first + floor(start / FEATURE_STEP + NEARLY), last - 1)
        high = min(max(first + ceil(end / FEATURE_STEP - NEARLY), low + 1), last)
        rows.append(pooled_statistics(frames[low:high]))
        presence[row, [numbers[word] for word in spoken]] = True
    with one_blas_thread():  # sums of several threads differ in their last bits
        return fit_pooled_map(np.stack(rows), presence)


def _fit_judge(
    frames: Float32Array,
    pool: FeaturePool,
    table: SegmentTable,
    said: tuple[TaughtWords, FittedWords],
    rng: np.random.Generator,
) -> MotionJudge | None:
    """The judge of generated motion; None if no words were written."""
    taught, words = said
    numbers = {word: number for number, word in enumerate(words.association.words)}
    described = counting.described_intervals(
        table, taught.captions, taught.synonyms, words.counted.reference.lemmas
    )
    if not described:
        return None
    windows = {
        int(capture): pool_windows(frames[a:b])
        for capture, (a, b) in zip(pool.capture_ids, pairwise(pool.bounds))
    }
    return fit_judge(windows, said_words(described, numbers), len(numbers), taught.performers, rng)
