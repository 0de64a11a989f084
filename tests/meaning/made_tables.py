"""Captures to search by example, made by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.meaning import by_motion
from motiondb.records import FloatArray

Made = tuple[int, Sequence[int], Sequence[int], Sequence[int], FloatArray]
"""Number, starts, ends and symbols of segments, and their standardised rows."""


def takes_of(*captures: Made) -> by_motion.Takes:
    """Captures as one table."""
    numbers, starts, ends, symbols, rows = zip(*captures, strict=True)
    last = np.cumsum([len(each) for each in starts])
    columns = (np.concatenate([np.asarray(e) for e in each]) for each in (starts, ends, symbols))
    first = np.concatenate([[0], last[:-1]])
    return by_motion.Takes(np.array(numbers), first, last, *columns, np.concatenate(rows))
