"""What an interval of motion shows: what all symbols say of it, and how it moves.

A segment's scores are its log-likelihoods under every symbol, nats per frame. Their mean over the
symbols says how usual the motion is and is taken off; what is left is standardised per symbol over
all segments and clipped. An interval's vector is the mean over its segments, weighted by how long
each lasts inside the interval, scaled to length 1. Compared with the best symbol alone this keeps
what a performer unseen in training shares with *several* symbols; measured on real captures it is
the one choice that matters most.

Beside the symbols stand the columns of :mod:`motiondb.search.movement` and
:mod:`motiondb.search.bearing`, standardised and clipped in the same way; each of their five blocks
is weighed so that it counts as much as the symbols do, travel half as much again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.search.movement import block_sizes, block_weight

CLIP = 3.0


@dataclass(frozen=True, eq=False)
class ScoreSpace:
    """mean, spread: arrays (symbols + columns of movement,), over segments; of the symbols, of the
    scores less their mean over symbols. A space without movement has no columns of it."""

    mean: FloatArray
    spread: FloatArray

    def standardise(self, scores: Float32Array, movement: Float32Array | None = None) -> FloatArray:
        """Standardised, clipped and weighed rows (segments, symbols + columns).

        Parameters
        ----------
        scores : array (segments, symbols)
            Nats per frame.
        movement : array (segments, columns)
            Those beyond the space's columns are left out (a space that was learned before there
            were posture and travel has none of them).
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
    """Mean and spread over segments (weighted by their length in frames)."""
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
    """Vectors (intervals, symbols) of length 1 for intervals [low, high) of one capture.

    Parameters
    ----------
    standardised : array (segments, symbols)
        Of one capture, in order.
    starts : array (segments,)
        Frames; they tile the capture.
    ends : array (segments,)
        Frames; they tile the capture.
    low : array (intervals,)
        Frames.
    high : array (intervals,)
        Frames.
    """
    inside = np.minimum(ends, high[:, None]) - np.maximum(starts, low[:, None])
    weights = np.maximum(inside, 0.0)
    return unit(weights @ standardised)


def unit(vectors: FloatArray) -> FloatArray:
    """Rows scaled to length 1 (a zero row stays zero)."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
