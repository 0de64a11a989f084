"""Quality of a grouping of segments: repetition R, error E', and the objective F of both.

Notation: segments s_i of L(s_i) frames tile T frames; group k has the medoid s_k^c.

    R  = (1 / T) sum_k L(s_k^c)                                 in [0, 1], 1 exactly when n = K
    E' = (1 / d_max) sum_k sum_{i in k} L(s_i) / T D(s_i, s_k^c)    in [0, 1]
    F  = 1 / (w R + (1 - w) E')

R is low if few frames represent all, that is, if terminals repeat. E' is low if segments that share
a terminal are alike. Both fall when segments become shorter, so F alone would cut to the least
length that is allowed; ``shortest`` and the number of segments N work against that.

Source: Park, Lee and Lee (2011), equations 3 to 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.records import FloatArray, IntArray

REPETITION_WEIGHT = 0.1
"""w, the share of R in the objective. Chosen on one take of each sample grammar."""


@dataclass(frozen=True)
class Score:
    """R, E' and F of a grouping."""

    repetition: float
    error: float
    objective: float


def score(
    lengths: IntArray,
    medoids: IntArray,
    to_medoid: FloatArray,
    largest: float,
    weight: float = REPETITION_WEIGHT,
) -> Score:
    """Compute R, E' and F.

    Shapes: `lengths`, `to_medoid` (segments,); `medoids` (K,).

    `largest`: d_max. Where it is 0 all poses are the same, and E' is 0.

    >>> import numpy as np
    >>> ends = np.array([2, 2, 4])
    >>> score(ends, np.array([0, 2]), np.array([0.0, 0.5, 0.0]), 1.0, 0.5)
    Score(repetition=0.75, error=0.125, objective=2.2857142857142856)
    """
    n_frames = int(lengths.sum())
    repetition = float(lengths[medoids].sum()) / n_frames
    error = float(lengths @ to_medoid) / n_frames / largest if largest > 0.0 else 0.0
    return Score(repetition, error, objective(repetition, error, weight))


def objective(repetition: float, error: float, weight: float = REPETITION_WEIGHT) -> float:
    """Return F = 1 / (w R + (1 - w) E'), infinite if both are 0."""
    total = weight * repetition + (1.0 - weight) * error
    return 1.0 / total if total > 0.0 else float("inf")
