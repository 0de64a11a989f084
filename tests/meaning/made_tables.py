"""Captures to search by example, made by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.meaning import by_motion
from motiondb.meaning.resemblance import MeaningSpace
from motiondb.meaning.windows import compared_segments
from motiondb.records import FloatArray

Made = tuple[int, Sequence[int], Sequence[int], Sequence[int], FloatArray]
"""Number, starts, ends and symbols of segments, and their standardised rows."""


def takes_of(*captures: Made, space: MeaningSpace | None = None) -> by_motion.Takes:
    """Captures as one table."""
    numbers, starts, ends, symbols, rows = zip(*captures, strict=True)
    last = np.cumsum([len(each) for each in starts])
    frames = np.stack([np.concatenate([np.asarray(e) for e in each]) for each in (starts, ends)], 1)
    segments = compared_segments(
        frames, np.concatenate([np.asarray(e) for e in symbols]), np.concatenate(rows), space
    )
    bounds = np.stack([np.concatenate([[0], last[:-1]]), last], axis=1)
    return by_motion.Takes(np.array(numbers), bounds, segments)
