"""The feature space of the symbols: recognition features, centred, rotated and whitened (PCA).

Gaussians with diagonal covariances need uncorrelated dimensions of equal variance. The projection
is learned by each ``learn`` and stored, so that later queries are projected into the same space.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from motiondb.records import Axes, Float32Array, FloatArray
from motiondb.symbols.hmm_jobs import one_blas_thread

N_DIMENSIONS = 24  # Principal axes that are kept
_CLIP = 8.0  # standard deviations: a broken frame cannot dominate a segment. By hand.
_BLOCK = 65_536  # Frames that are projected together: bounds memory
_MOST_FRAMES = 900  # frames (60 s) of a capture that count. By hand.


@dataclass(frozen=True, eq=False)
class FeatureSpace:
    """A whitening projection."""

    mean: Annotated[FloatArray, Axes("features")]  # Mean of the recognition features
    # Principal axes as columns, each divided by the standard deviation along it
    projection: Annotated[FloatArray, Axes("features", "dimensions")]

    def project(self, features: Float32Array) -> Float32Array:
        """Features (frames, 130) -> whitened array (frames, dimensions), float32."""
        # In double precision: products differ in their last bits between processors, and in single
        # precision that would be enough to change which symbol wins a segment.
        blocks = (features[a : a + _BLOCK] for a in range(0, max(len(features), 1), _BLOCK))
        parts = ((block - self.mean) @ self.projection for block in blocks)
        with one_blas_thread():  # captures are small: a second thread takes ten times as long
            return np.concatenate([np.clip(p, -_CLIP, _CLIP).astype(np.float32) for p in parts])


def fit_feature_space(
    captures: Iterable[Float32Array], n_dimensions: int = N_DIMENSIONS
) -> FeatureSpace:
    """Whitened principal axes, largest first; a capture counts as 60 seconds at most.

    `captures` are gone through more than once.
    """
    shapes = [c.shape for c in captures]
    weights = [min(length, _MOST_FRAMES) / max(length, 1) for length, _ in shapes]
    total = sum(w * length for w, (length, _) in zip(weights, shapes))
    if total < 2:
        n = shapes[0][1] if shapes else 0
        return FeatureSpace(np.zeros(n), np.eye(n)[:, : min(n, n_dimensions)])
    mean = sum(w * c.sum(axis=0, dtype=np.float64) for w, c in zip(weights, captures)) / total
    covariance = np.zeros((len(mean), len(mean)))
    for weight, features in zip(weights, captures):
        centred = (features - mean).astype(np.float64)
        covariance += weight * (centred.T @ centred)
    values, vectors = np.linalg.eigh(covariance / total)
    order = np.argsort(values)[::-1][:n_dimensions]
    vectors, values = vectors[:, order], np.maximum(values[order], 1e-6 * values.max() + 1e-12)
    signs = np.sign(vectors[np.argmax(np.abs(vectors), axis=0), np.arange(len(order))])
    return FeatureSpace(mean, vectors * signs / np.sqrt(values))
