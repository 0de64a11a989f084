"""Vectors that describe an interval of motion: scores under all symbols, and movement.

The scores of a segment are its log-likelihoods under every symbol, nats per frame. Their mean over
the symbols, which measures how usual the motion is, is subtracted; the result is standardised per
symbol over all segments, and clipped. The vector of an interval is the mean over its segments,
weighted by their duration inside the interval, scaled to length 1. Unlike the best symbol alone it
keeps the similarity of a new performer to *several* symbols. On real captures no other choice had a
larger effect.

The columns of :mod:`motiondb.meaning.movement` follow, standardised and clipped in the same way.
Each of their five blocks is scaled to the weight of all symbols together, travel to one and a half
times that.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from motiondb.meaning.movement import block_sizes, block_weight
from motiondb.records import LARGEST, Axes, Float32Array, FloatArray, IntArray, Within


def unit(vectors: FloatArray) -> FloatArray:
    """Scale rows to length 1; zero rows stay zero; `vectors` (..., columns)."""
    length = np.sqrt(np.add.reduce(vectors * vectors, axis=-1, keepdims=True))
    length[~(length > 0.0)] = 1.0
    return vectors / length


CLIP = 3.0  # Standard deviations beyond which a value is clipped


@dataclass(frozen=True, eq=False)
class ScoreSpace:
    """Means and standard deviations over segments."""

    # Means; those of the symbols are of the scores less their mean over symbols
    mean: Annotated[FloatArray, Axes("columns")]
    # Standard deviations
    spread: Annotated[
        FloatArray, Axes("columns"), Within(1e-12, LARGEST, "spreads of scores above 0")
    ]

    def standardise(self, scores: Float32Array, movement: Float32Array | None = None) -> FloatArray:
        """Standardised, clipped and weighted rows (segments, symbols + columns).

        Shapes: `scores` (segments, symbols); `movement` (segments, columns).
        """
        relative = _relative(scores)
        n_symbols = relative.shape[1]
        sizes = block_sizes(len(self.mean) - n_symbols)
        if sizes and movement is not None:
            relative = np.concatenate([relative, movement[:, : sum(sizes)]], axis=1)
        weights = [block_weight(n) * np.sqrt(n_symbols / size) for n, size in enumerate(sizes)]
        weight = np.repeat([1.0, *weights], [n_symbols, *sizes])
        return weight * np.clip((relative - self.mean) / self.spread, -CLIP, CLIP)


def fit_score_space(
    scores: Float32Array, lengths: IntArray, movement: Float32Array | None = None
) -> ScoreSpace:
    """Mean and standard deviation over segments, weighted by their length.

    Shapes: `scores` (segments, symbols); `lengths` (segments,); `movement` (segments, columns).
    """
    weights = lengths / lengths.sum()
    blocks = [_relative(scores)] if movement is None else [_relative(scores), movement]
    means, spreads = [], []
    for block in blocks:
        mean = weights @ block
        spread = np.sqrt(weights @ (block - mean) ** 2)
        means.append(mean)
        spreads.append(np.maximum(spread, 1e-6 + 0.01 * spread.max(initial=0.0)))
    return ScoreSpace(np.concatenate(means), np.concatenate(spreads))


def _relative(scores: Float32Array) -> FloatArray:
    return scores - scores.mean(axis=1, keepdims=True, dtype=np.float64)


def interval_vectors(
    standardised: FloatArray,
    starts: IntArray,
    ends: IntArray,
    low: FloatArray | IntArray,
    high: FloatArray | IntArray,
) -> FloatArray:
    """Vectors of length 1 of intervals [low, high) of one capture: array (intervals, columns).

    Shapes: `standardised` (segments, symbols); `starts`, `ends` (segments,); `low`, `high`
    (intervals,).
    """
    inside = np.minimum(ends, high[:, None]) - np.maximum(starts, low[:, None])
    weights = np.maximum(inside, 0.0)
    return unit(weights @ standardised)
