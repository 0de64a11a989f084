"""Score vectors of whole captures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motiondb.meaning.score_vectors import Rows, interval_vector
from motiondb.records import FloatArray, SegmentTable


def whole_vectors(standardised: Rows, table: SegmentTable, rows: Mapping[int, slice]) -> FloatArray:
    """Score vectors of whole captures, in their order: array (captures, columns).

    Shapes: `standardised` (segments, columns).
    """
    starts, ends = table.starts, table.ends
    vectors = np.zeros((len(rows), standardised.shape[1]))  # also of no captures at all
    for vector, r in zip(vectors, rows.values()):
        vector[:] = interval_vector(standardised[r], starts[r], ends[r], 0, ends[r][-1])
    return vectors
