"""The space in which symbols live: recognition features, centred, rotated and whitened (PCA).

Diagonal Gaussians need uncorrelated dimensions of like size. The projection is learned once per
``learn`` and kept with it, so that later queries are seen in the same space.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray

N_DIMENSIONS = 24


@dataclass(frozen=True, eq=False)
class FeatureSpace:
    """mean: array (130,); projection: array (130, dimensions), columns divided by their spread."""

    mean: FloatArray
    projection: FloatArray

    def project(self, features: Float32Array) -> Float32Array:
        """Features (frames, 130) -> whitened array (frames, dimensions), float32."""
        centred = features - self.mean.astype(np.float32)
        return np.clip(centred @ self.projection.astype(np.float32), -8.0, 8.0)


def fit_feature_space(
    captures: Sequence[Float32Array], n_dimensions: int = N_DIMENSIONS
) -> FeatureSpace:
    """Whitened principal axes of all frames of all captures, largest first, signs fixed.

    A capture of n frames counts with weight n, but no more than 60 seconds' worth, so that one
    endless take does not decide the space.
    """
    limit = 900
    weights = [min(len(c), limit) / max(len(c), 1) for c in captures]
    total = sum(w * len(c) for w, c in zip(weights, captures))
    if total < 2:
        n = captures[0].shape[1] if captures else 0
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
