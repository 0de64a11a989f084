"""Rows that are made when they are looked at are those of the whole array."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.meaning.regression import MadeRows

BOUNDS = np.array([0, 3, 4, 9])
WHOLE = np.arange(18.0).reshape(9, 2)


@pytest.mark.parametrize(
    "which",
    [
        slice(3, 4),
        slice(None),
        slice(2, 7),
        np.array([0, 8, 1, 4, 4]),
        np.arange(3, 9),
        np.zeros(0, dtype=np.int64),
    ],
)
def test_rows_by_an_index(which: slice | np.ndarray) -> None:
    parts = np.split(WHOLE, BOUNDS[1:-1])
    rows = MadeRows(BOUNDS, lambda groups: np.concatenate([parts[n] for n in groups]))
    np.testing.assert_array_equal(rows[which], WHOLE[which])
    np.testing.assert_array_equal(rows[:], WHOLE)
    assert len(rows) == 9
