"""A thread's connection to DuckDB: statements and their answers, with motiondb's errors.

Another thread may release the file at any moment (:mod:`motiondb.store.connection.sharing`), and
DuckDB then closes every connection to it. Two rules keep a thread from meeting a closed connection:

* a statement, and the fetching of its answer, each keep the file open while they run;
* a statement that ran outside a block that keeps the file open, and whose answer is not yet fetched
  when the file is released, is run again on the reopened file.

Nothing is done twice: changes of the database run in a transaction, which keeps the file open
from its first statement to its last.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import duckdb
from numpy.typing import NDArray

from motiondb.store.connection.faults import ABORTED, translate

T = TypeVar("T")
Parameters = Sequence[Any] | Mapping[str, Any]


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
        self._first_error: duckdb.Error | None = None

    def execute(self, query: str, parameters: Parameters = ()) -> Connection:
        """Run statements; the answer is fetched from the object returned."""
        with self._keep_open() as is_alone:
            raw = self._run(query, parameters)
        self._asked = (raw, query, parameters) if is_alone else None
        if query in ("BEGIN", "COMMIT", "ROLLBACK"):
            self._first_error = None
        return self

    def fetchall(self) -> list[tuple[Any, ...]]:
        """All rows of the answer."""
        return self._fetch(lambda raw: raw.fetchall())

    def fetchone(self) -> tuple[Any, ...] | None:
        """The next row of the answer; None after the last."""
        return self._fetch(lambda raw: raw.fetchone())

    def fetchnumpy(self) -> Mapping[str, NDArray[Any]]:
        """The answer as arrays by column name."""
        return self._fetch(lambda raw: raw.fetchnumpy())

    def register(self, name: str, table: object) -> None:
        """Make arrays visible to this connection as a table."""
        with self._keep_open():
            try:
                self._cursor().register(name, table)
            except duckdb.Error as error:
                self._fail(error)

    def unregister(self, name: str) -> None:
        """Undo :meth:`register`."""
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
            if self._asked is not None and self._asked[0] is not raw:
                self._asked = (self._run(*self._asked[1:]), *self._asked[1:])
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
