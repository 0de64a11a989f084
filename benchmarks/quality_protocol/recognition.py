"""The product's own way from features to vectors and words, on arrays in place of a store."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_STEP
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.learn.recognition import (
    FeaturePool,
    LearnSettings,
    acquire_symbols,
    segment_table,
)
from motiondb.meaning import score_vectors, word_evidence
from motiondb.meaning.caption_map import CaptionMap, solve_caption_map
from motiondb.meaning.score_vectors import block_sizes
from motiondb.meaning.word_map import WordMap, word_moments
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols, SegmentTable
from motiondb.symbols import acquisition, feature_space
from quality_protocol.captures import Capture
from quality_protocol.kept import kept
from quality_protocol.whole_vectors import whole_vectors


@dataclass(frozen=True, eq=False)
class Recognised:
    """Captures as learned symbols see them.

    Attributes
    ----------
    symbols : learned. table : segments; ``capture_ids`` are places in the list of captures.
    whitened : per capture array (frames, dimensions).
    rows : array (segments, columns), standardised as the product does.
    vectors : array (captures, columns), of whole captures.
    """

    symbols: MotionSymbols
    table: SegmentTable
    whitened: tuple[Float32Array, ...]
    rows: FloatArray
    vectors: FloatArray

    def part(self, capture: int) -> slice:
        """A capture's rows of the table."""
        first, last = np.searchsorted(self.table.capture_ids, [capture, capture + 1])
        return slice(int(first), int(last))

    def captions(
        self, train: IntArray, words: NDArray[np.bool_], names: Sequence[str]
    ) -> CaptionMap:
        """The caption map of captures ``train`` whose captions hold ``words`` (train, words)."""
        moments = word_moments(self.vectors[train], words)
        return solve_caption_map(moments, word_vectors().of(names))

    def hear(
        self, fit: WordMap, captions: CaptionMap, captures: Sequence[int] | IntArray
    ) -> list[word_evidence.TakeScores]:
        """Log-odds of all words in captures that are searched together, from their motion alone."""
        rows = {int(capture): self.part(int(capture)) for capture in captures}
        heard = word_evidence.hear_takes(fit, captions, self.rows, self.table, rows)
        odds = heard.by_capture(rows)
        starts, ends = self.table.starts, self.table.ends
        return [
            word_evidence.TakeScores(starts[part], ends[part], odds[c][:-1], odds[c][-1])
            for c, part in rows.items()
        ]


def recognise(captures: Sequence[Capture], known: NDArray[np.bool_], seed: int) -> Recognised:
    """Learn feature space, symbols, standardisation on the ``known`` captures; see all by them.

    Symbols and segments are kept on disk (``quality_protocol.kept``).
    """
    lengths = np.array([c.motion.n_frames for c in captures])
    features = [c.features for c in captures]
    symbols, table, whitened = kept(
        "recognised", [f"seed {seed}", known, lengths, *features],
        lambda: _segment(captures, known, seed),
    )  # fmt: skip
    return _standardised(symbols, table, whitened, known)


def _segment(
    captures: Sequence[Capture], known: NDArray[np.bool_], seed: int
) -> tuple[MotionSymbols, SegmentTable, tuple[Float32Array, ...]]:
    """Symbols learned on the known captures, segments and whitened features of all."""
    space = feature_space.fit_feature_space([c.features for c, k in zip(captures, known) if k])
    whitened = tuple(space.project(c.features) for c in captures)
    settings, rng = LearnSettings(seed=seed), np.random.default_rng(seed)
    pool = _pool([c for c, k in zip(captures, known) if k])
    frames = np.concatenate([w for w, k in zip(whitened, known) if k])
    symbols = acquire_symbols(frames, pool, rng, settings, lambda _what, _share: None).symbols
    everything = _pool(captures)
    joined = np.concatenate(whitened)
    cutting = acquisition.recut(joined, everything.bounds, symbols, settings.acquisition)
    return symbols, segment_table(joined, everything, symbols, cutting), whitened


def seen_without(seen: Recognised, n_blocks: int) -> Recognised:
    """All captures known, by the same symbols, with the first blocks of movement alone.

    n_blocks : 0: the symbols' scores; 3: those and places, joint and rhythm
        (``motiondb.meaning.score_vectors``).
    """
    sizes = block_sizes(seen.table.movement.shape[1])
    rows = seen.rows.copy()
    rows[:, seen.table.scores.shape[1] + sum(sizes[:n_blocks]) :] = 0.0
    parts = {capture: seen.part(capture) for capture in range(len(seen.whitened))}
    vectors = whole_vectors(rows, seen.table, parts)
    return replace(seen, rows=rows, vectors=vectors)


def _standardised(
    symbols: MotionSymbols,
    table: SegmentTable,
    whitened: tuple[Float32Array, ...],
    known: NDArray[np.bool_],
) -> Recognised:
    features = known[table.capture_ids]
    moving = table.movement if table.movement.shape[1] else None
    space = score_vectors.fit_score_space(
        table.scores[features],
        (table.ends - table.starts)[features],
        None if moving is None else moving[features],
    )
    rows = space.standardise(table.scores, moving)
    n_captures = len(whitened)
    vectors = np.zeros((n_captures, rows.shape[1]))
    for capture in range(n_captures):
        part = slice(*np.searchsorted(table.capture_ids, [capture, capture + 1]))
        ends = table.ends[part]
        vectors[capture] = score_vectors.interval_vectors(
            rows[part], table.starts[part], ends, np.zeros(1), ends[-1:]
        )[0]
    return Recognised(symbols, table, whitened, rows, vectors)


def _pool(captures: Sequence[Capture]) -> FeaturePool:
    bounds: IntArray = np.cumsum([0, *(len(c.features) for c in captures)])
    lengths = np.array([min(c.motion.n_frames, len(c.features) * FEATURE_STEP) for c in captures])
    features = np.concatenate([c.features for c in captures])
    return FeaturePool(np.arange(len(captures)), bounds, features, lengths)
