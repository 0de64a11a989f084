"""What all symbols say of an interval of motion: its score vector.

A segment's scores are its log-likelihoods under every symbol, nats per frame. Their mean over the
symbols says how usual the motion is and is taken off; what is left is standardised per symbol over
all segments and clipped. An interval's vector is the mean over its segments, weighted by how long
each lasts inside the interval, scaled to length 1. Compared with the best symbol alone this keeps
what a performer unseen in training shares with *several* symbols; measured on real captures it is
the one choice that matters most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray

CLIP = 3.0


@dataclass(frozen=True, eq=False)
class ScoreSpace:
    """mean, spread: arrays (symbols,), of the scores less their mean over symbols."""

    mean: FloatArray
    spread: FloatArray

    def standardise(self, scores: Float32Array) -> FloatArray:
        """Scores (segments, symbols), nats per frame -> standardised and clipped, same shape."""
        relative = scores - scores.mean(axis=1, keepdims=True, dtype=np.float64)
        return np.clip((relative - self.mean) / self.spread, -CLIP, CLIP)


def fit_score_space(scores: Float32Array, lengths: IntArray) -> ScoreSpace:
    """Mean and spread over segments (weighted by their length in frames)."""
    relative = scores - scores.mean(axis=1, keepdims=True, dtype=np.float64)
    weights = lengths / lengths.sum()
    mean = weights @ relative
    spread = np.sqrt(weights @ (relative - mean) ** 2)
    return ScoreSpace(mean, np.maximum(spread, 1e-6 + 0.01 * spread.max()))


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
    standardised : array (segments, symbols) of one capture, in order.
    starts, ends : arrays (segments,), frames; they tile the capture.
    low, high : arrays (intervals,), frames.
    """
    inside = np.minimum(ends, high[:, None]) - np.maximum(starts, low[:, None])
    weights = np.maximum(inside, 0.0)
    return unit(weights @ standardised)


def unit(vectors: FloatArray) -> FloatArray:
    """Rows scaled to length 1 (a zero row stays zero)."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
