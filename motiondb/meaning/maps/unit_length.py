"""Vectors of length 1."""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray


def unit(vectors: FloatArray) -> FloatArray:
    """Scale rows to length 1; zero rows stay zero; `vectors` (..., columns)."""
    length = np.sqrt(np.add.reduce(vectors * vectors, axis=-1, keepdims=True))
    length[~(length > 0.0)] = 1.0
    return vectors / length
