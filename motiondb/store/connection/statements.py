"""A thread's connection to DuckDB: statements, tables written and read as arrays, errors.

Another thread may release the file at any moment (``handle.released``), and DuckDB then closes
every connection to it. Two rules keep a thread from meeting a closed connection:

* a statement, and the fetching of its answer, each keep the file open while they run;
* a statement that ran outside a block that keeps the file open, and whose answer is not yet fetched
  when the file is released, is run again on the reopened file.

Nothing is done twice: changes of the database run in a transaction, which keeps the file open
from its first statement to its last.

Tables are written and read by columns: DuckDB reads a dict of one-dimensional arrays as a table. A
list column is an object array that holds one array per row (measured: 7 ms for 400 rows of 87
floats, against 36 ms for parameters). A NaN is stored as NULL and loaded as NaN, in flat columns
and inside lists.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import fields
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import duckdb
import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError
from motiondb.store.connection.faults import ABORTED, first_sentence, is_damage, translate

T = TypeVar("T")
Parameters = Sequence[Any] | Mapping[str, Any]
_SCALAR = str | float | int | np.generic
Column = NDArray[Any] | Sequence[Any] | str | float | bool
"""A column of a table, or the value of every row."""


class Connection:
    """The connection of one thread; its errors are motiondb's."""

    def __init__(
        self,
        path: Path,
        cursor: Callable[[], duckdb.DuckDBPyConnection],
        keep_open: Callable[[], AbstractContextManager[bool]],
    ) -> None:
        self.path = path
        self._cursor = cursor
        self._keep_open = keep_open
        self._asked: tuple[duckdb.DuckDBPyConnection, str, Parameters] | None = None
        self._ran_on: duckdb.DuckDBPyConnection | None = None  # what holds the last answer
        self._first_error: duckdb.Error | None = None

    def execute(self, query: str, parameters: Parameters = ()) -> Connection:
        """Run statements; the answer is fetched from the object returned."""
        with self._keep_open() as is_alone:
            raw = self._run(query, parameters)
        self._ran_on = raw
        self._asked = (raw, query, parameters) if is_alone else None
        if query in ("BEGIN", "COMMIT", "ROLLBACK"):
            self._first_error = None
        return self

    def fetchall(self) -> list[tuple[Any, ...]]:
        """All rows of the answer."""
        return self._fetch(lambda raw: raw.fetchall())

    def fetchone(self) -> tuple[Any, ...] | None:
        """The first row or None; all are fetched: an open answer keeps DuckDB from writing."""
        return next(iter(self.fetchall()), None)

    def column(self, query: str, parameters: Parameters = ()) -> list[Any]:
        """The first column of the answer to a query."""
        return [row[0] for row in self.execute(query, parameters).fetchall()]

    def value(self, query: str, parameters: Parameters = ()) -> Any:  # noqa: ANN401  of any type
        """The first value of the answer to a query; None if it has no rows."""
        return next(iter(self.column(query, parameters)), None)

    def select(self, query: str) -> tuple[list[str], list[tuple[Any, ...]]]:
        """Names of the columns, and rows, of a question of a user, which is one SELECT."""
        with self._keep_open():
            raw = self._cursor()
            try:
                kinds = [each.type for each in raw.extract_statements(query)]
                if kinds != [duckdb.StatementType.SELECT]:
                    raise QueryError("sql: expected one SELECT, found another statement. Ask once.")
                raw.execute(query)
                return [column[0] for column in raw.description or ()], raw.fetchall()
            except duckdb.Error as error:
                if is_damage(error) or isinstance(error, duckdb.OutOfMemoryException):
                    self._fail(error)
                raise QueryError(
                    f"sql: expected a question that DuckDB answers, found: {first_sentence(error)} "
                    "schema/README.md lists tables and columns; other files are not read."
                ) from None

    def insert_row(self, table: str, *values: object) -> None:
        """Append a row to a table; it has a value for every column, in their order."""
        self.execute(f"INSERT INTO {table} VALUES ({', '.join('?' * len(values))})", list(values))

    def insert(self, table: str, **columns: Column) -> None:
        """Append rows to a table; a column that is one value has it in every row."""
        self._insert("INSERT", table, columns)

    def insert_or_replace(self, table: str, **columns: Column) -> None:
        """Append rows to a table, each in the place of the one with its primary key."""
        self._insert("INSERT OR REPLACE", table, columns)

    def _insert(self, how: str, table: str, columns: Mapping[str, Column]) -> None:
        (n,) = {
            len(c) for c in columns.values() if not isinstance(c, str | float | int | np.generic)
        }
        if not n:
            return
        arrays = {name: _as_column(values, n) for name, values in columns.items()}
        names = ", ".join(arrays)
        self._register("_rows", arrays)
        try:
            self.execute(f"{how} INTO {table} ({names}) SELECT {names} FROM _rows")
        finally:
            self._unregister("_rows")

    def arrays(self, query: str, parameters: Parameters = ()) -> dict[str, NDArray[Any]]:
        """Run a query; its answer as arrays by column name, missing floats as NaN."""
        answer = self.execute(query, parameters)._fetch(lambda raw: raw.fetchnumpy())
        return {
            name: np.ma.filled(values, np.nan)
            if np.ma.isMA(values) and values.dtype.kind == "f"
            else values
            for name, values in answer.items()
        }

    def _register(self, name: str, table: object) -> None:
        """Make arrays visible to this connection as a table."""
        with self._keep_open():
            try:
                self._cursor().register(name, table)
            except duckdb.Error as error:
                self._fail(error)

    def _unregister(self, name: str) -> None:
        """Undo :meth:`_register`."""
        with self._keep_open():
            try:
                self._cursor().unregister(name)
            except duckdb.Error:  # the transaction is aborted: the view goes with it
                return

    def _run(self, query: str, parameters: Parameters) -> duckdb.DuckDBPyConnection:
        """Run statements on the connection of DuckDB, which is returned."""
        raw = self._cursor()
        try:
            raw.execute(query, parameters)
        except duckdb.Error as error:
            self._fail(error)
        return raw

    def _fetch(self, fetch: Callable[[duckdb.DuckDBPyConnection], T]) -> T:
        """Fetch from the last answer; run its statement again if its connection was closed."""
        with self._keep_open():
            raw = self._cursor()
            if self._ran_on is not raw:
                if self._asked is None:  # a new connection would give an answer without rows
                    self._fail(duckdb.InvalidInputException("No open result set"))
                self._asked = (self._run(*self._asked[1:]), *self._asked[1:])
                self._ran_on = raw
            try:
                return fetch(raw)
            except duckdb.Error as error:
                self._fail(error)

    def _fail(self, error: duckdb.Error) -> NoReturn:
        """Raise motiondb's error; that of the first in the transaction, where that is why."""
        if ABORTED in str(error) and self._first_error is not None:
            error = self._first_error
        self._first_error = error
        raise translate(self.path, error) from error


def to_rows(matrix: NDArray[Any]) -> NDArray[np.object_]:
    """Make a list column of an array (rows, ...): every row flattened, in C order.

    >>> to_rows(np.eye(2))[1]
    array([0., 1.])
    """
    flat = np.ascontiguousarray(matrix).reshape(len(matrix), -1) if len(matrix) else matrix
    return ragged(flat)


def ragged(rows: Sequence[Any] | NDArray[Any]) -> NDArray[np.object_]:
    """Make a list column of arrays that may differ in length."""
    column = np.empty(len(rows), dtype=object)
    for number, row in enumerate(rows):
        column[number] = row
    return column


def columns_of(kind: type, records: Sequence[Any]) -> dict[str, list[Any]]:
    """Columns of a table that are called as the fields of a record are."""
    return {field.name: [getattr(r, field.name) for r in records] for field in fields(kind)}


def from_rows(column: NDArray[Any], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Make an array (rows, *shape) of a list column (rows,); the inverse of :func:`to_rows`."""
    if not len(column):
        return np.zeros((0, *shape))
    filled = [
        np.ma.filled(numbers, np.nan) if np.ma.isMA(numbers) else numbers for numbers in column
    ]
    return np.concatenate(filled).astype(np.float64, copy=False).reshape(len(column), *shape)


def _as_column(values: Column, n: int) -> NDArray[Any]:
    if isinstance(values, _SCALAR):
        return np.full(n, values, dtype=object if isinstance(values, str) else None)
    if isinstance(values, np.ndarray):
        return np.ascontiguousarray(values)
    if any(value is None or isinstance(value, str | bytes) for value in values):
        return np.array(values, dtype=object)
    return np.array(values)
