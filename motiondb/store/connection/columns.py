"""Write NumPy columns to DuckDB and read them: one INSERT for a table, one SELECT for arrays.

DuckDB reads a dict of one-dimensional arrays as a table. A list column is an object array that
holds one array per row (measured: 7 ms for 400 rows of 87 floats, against 36 ms for parameters).
A NaN is stored as NULL and loaded as NaN, in flat columns and inside lists.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.store.connection.statements import Connection

Column = NDArray[Any] | Sequence[Any]


def to_rows(matrix: NDArray[Any]) -> NDArray[np.object_]:
    """Make a list column of an array (rows, ...): every row flattened, in C order.

    >>> to_rows(np.eye(2))[1]
    array([0., 1.])
    """
    flat = np.ascontiguousarray(matrix).reshape(len(matrix), -1) if len(matrix) else matrix
    column = np.empty(len(matrix), dtype=object)
    for row, numbers in enumerate(flat):
        column[row] = numbers
    return column


def from_rows(
    column: NDArray[Any], shape: tuple[int, ...], dtype: type = np.float64
) -> NDArray[Any]:
    """Make an array (rows, *shape) of a list column; the inverse of :func:`to_rows`.

    Shapes: `column` (rows,) of arrays.
    """
    if not len(column):
        return np.zeros((0, *shape), dtype=dtype)
    filled = [
        np.ma.filled(numbers, np.nan) if np.ma.isMA(numbers) else numbers for numbers in column
    ]
    return np.concatenate(filled).astype(dtype, copy=False).reshape(len(column), *shape)


def insert(connection: Connection, table: str, **columns: Column) -> None:
    """Append rows to a table."""
    arrays = {name: _as_column(values) for name, values in columns.items()}
    if not len(next(iter(arrays.values()))):
        return
    names = ", ".join(arrays)
    connection.register("_rows", arrays)
    try:
        connection.execute(f"INSERT INTO {table} ({names}) SELECT {names} FROM _rows")
    finally:
        connection.unregister("_rows")


def fetch(
    connection: Connection,
    query: str,
    parameters: Sequence[Any] | Mapping[str, Any] = (),
) -> dict[str, NDArray[Any]]:
    """Ask, and give the answer as arrays by column name; missing floats are NaN."""
    answer: Mapping[str, NDArray[Any]] = connection.execute(query, parameters).fetchnumpy()
    return {
        name: np.ma.filled(values, np.nan)
        if np.ma.isMA(values) and values.dtype.kind == "f"
        else values
        for name, values in answer.items()
    }


def _as_column(values: Column) -> NDArray[Any]:
    if isinstance(values, np.ndarray):
        return np.ascontiguousarray(values)
    if any(isinstance(value, str) for value in values) or any(value is None for value in values):
        return np.array(values, dtype=object)
    return np.array(values)
