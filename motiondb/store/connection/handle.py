"""The open database: one connection to DuckDB for each thread that uses it.

A DuckDB connection runs one statement at a time and belongs to one transaction. Threads that share
one would mix their results. A :class:`Store` therefore keeps a root connection and gives every
thread its own cursor with its own transaction: a thread sees committed data and its own changes.

The root can be closed and opened again while the :class:`Store` stays (:func:`released`). It is
closed only when no thread runs a statement or a
block that needs it (:meth:`Store.in_use`); cursors of an earlier root are replaced.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import ClassVar

import duckdb

from motiondb.errors import StoreError
from motiondb.files.safe_files import COPY, LOGS, HeldFile, beside, is_file, log_of
from motiondb.store.connection import log_mark
from motiondb.store.connection.faults import OtherModeError, translate
from motiondb.store.connection.statements import Connection

_READERS = 2.0  # Seconds that the first change waits for threads that read; chosen by hand
_LETTING_GO, _PAUSE = 10.0, 0.02
"""Seconds to wait until DuckDB has closed a file, and between two attempts. A thread that ends at
that moment holds its connection a little longer."""
_OTHER_STORE = 1.0  # Seconds after which the file counts as open in another store of this process
_TAKE_BACK = 300.0
"""Seconds to wait for the file when a computation has ended: losing results of minutes is worse
than waiting for other commands, which take seconds."""
_LAST_BLOCKS = 5.0  # Seconds for which closing waits for running operations of other threads


def _close(connection: duckdb.DuckDBPyConnection) -> None:
    """Close a connection; while another thread uses it, DuckDB refuses, so try for 10 s."""
    for _ in range(1000):
        try:
            connection.close()
        except duckdb.Error:
            time.sleep(0.01)
        else:
            return
    connection.close()


@dataclass(frozen=True)
class Block:
    """Some bytes of a Parquet file that were read together."""

    file_id: int
    start: int
    data: bytes

    @property
    def stop(self) -> int:
        """The byte after the last one."""
        return self.start + len(self.data)


class ThreadState(threading.local):
    """The state of a store for each thread: its connection and its transaction."""

    connection: Connection | None = None
    cursor: duckdb.DuckDBPyConnection | None = None
    opening = -1  # the root that the cursor belongs to
    in_transaction = False
    depth = 0  # of blocks that need the root to stay
    snapshot_revision: int | None = None  # that a block for reading sees; None outside of one
    block: Block | None = None  # the last one that was read

    def __init__(self) -> None:
        self.changed: set[str] = set()  # marks in ``meta`` that the transaction will renew


class Store:
    """An open database file, which threads may share: one at a time writes."""

    changes_saved: ClassVar[int] = 0  # Transactions that this process has saved, in all stores

    def __init__(
        self,
        path: Path,
        connect: Callable[[bool, float | None], duckdb.DuckDBPyConnection],
        read_only: bool,
        notes: list[str] | None = None,
    ) -> None:
        self.path = path
        self.read_only = read_only
        self.write_lock = threading.RLock()
        self._connect = connect
        self.local = ThreadState()
        self._turn = threading.Condition()
        self._opening = 0
        self._users = 0
        self._is_swapping = False
        self._is_closed = False
        self._is_lent = False
        self._is_writing = False
        self._is_marked = False  # Whether the file says that there is a log beside it
        self._is_fixed = False  # Whether nobody can change the file while the root is open
        self._fixed_revision = -1, 0  # The opening for which it was loaded, and the revision
        self._process = os.getpid()
        _refuse_forked(path)
        self.lacked_log = False
        self.notes = [] if notes is None else notes  # What was done or met beside what was asked
        self._writable = [beside(path, COPY)]  # What one who reads may make nevertheless
        self._root: duckdb.DuckDBPyConnection | None = connect(read_only, None)
        self._shut(self._root)
        self._held = HeldFile.hold(path)
        _OPENED.add(self)
        self.lacked_log = log_mark.is_log_missing(self.connection)

    @property
    def connection(self) -> Connection:
        """The connection of the current thread."""
        local = self.local
        if local.connection is None:
            local.connection = Connection(self.path, self._cursor, self.in_use)
        return local.connection

    @property
    def in_transaction(self) -> bool:
        """Whether the current thread is changing the database."""
        return self.local.in_transaction

    @property
    def log_note(self) -> str:
        """What to say of the log: that it was missing at opening, or stays after closing; or ""."""
        if not self._is_closed:
            return log_mark.missing_sentence(self.path) if self.lacked_log else ""
        return log_mark.left_sentence(self.path) if is_file(log_of(self.path)) else ""

    @property
    def loss_note(self) -> str:
        """That saved changes are missing with the log, or were lost with it; or ""."""
        return self.log_note if self.lacked_log else log_mark.lost_sentence(self.connection)

    def tell(self, sentence: str) -> None:
        """Note what the user should know, once."""
        if sentence not in self.notes:
            self.notes.append(sentence)

    def mark_log(self) -> None:
        """See to it, before a change, that the file says that there is a log beside it.

        What other threads read keeps DuckDB from writing the file. They end first, and new ones
        wait, for ``_READERS`` seconds at most; then the change goes without the mark.
        """
        deadline = time.monotonic() + _READERS
        while not self._is_marked:
            with self._turn:
                self._is_swapping = True
                try:
                    left = deadline - time.monotonic()
                    self._turn.wait_for(lambda: self._users <= bool(self.local.depth), left)
                    self._is_marked = log_mark.set_mark(
                        self._open_root(), self.path, self.lacked_log
                    )
                finally:
                    self._is_swapping = False
                    self._turn.notify_all()
            if time.monotonic() > deadline:
                return
            if not self._is_marked:  # an answer of this thread is still open
                time.sleep(_PAUSE)

    def stand_in_for_log(self) -> None:
        """See to it that a kill during the next commit is not taken for the loss of the log."""
        if self._is_marked:
            log_mark.stand_in(self.path)

    def keep_log(self) -> None:
        """See to it, after a change, that there is a log where the file says so."""
        if self._is_marked:
            with self._turn:
                log_mark.keep_log(self._open_root(), self.path)

    @contextmanager
    def in_use(self) -> Iterator[bool]:
        """Keep the root open while the block runs; gives whether this is the outermost block."""
        if self._process != os.getpid():
            raise _forked(self.path, self._process)
        local = self.local
        if not local.depth:
            with self._turn:
                self._turn.wait_for(lambda: not self._is_swapping)
                self._users += 1
        local.depth += 1
        try:
            yield local.depth == 1
        finally:
            local.depth -= 1
            if not local.depth:
                with self._turn:
                    self._users -= 1
                    self._turn.notify_all()

    @contextmanager
    def may_make(self, file: Path) -> Iterator[None]:
        """Let DuckDB make another database while the block runs, also for one who only reads."""
        if not (self.read_only or self._is_lent):
            yield
            return
        self._writable.append(file)
        self._open_anew()
        try:
            yield
        finally:
            self._writable.remove(file)
            self._open_anew()

    def _open_anew(self) -> None:
        """Open the file anew at the next use."""
        with self.write_lock:
            self._swap_root(self._is_lent)

    def _shut(self, root: duckdb.DuckDBPyConnection) -> None:
        """Keep DuckDB from all other files where it only reads this one.

        Motions and originals that lie elsewhere are not read by DuckDB.
        """
        mode = root.execute("SELECT current_setting('access_mode')").fetchall()
        self._is_fixed = mode == [("read_only",)]
        if not self._is_fixed:  # also where it shares the file with a store that writes
            return
        names = [str(Path.cwd() / file).partition("?") for file in self._writable]
        # what follows a question mark stays the end: DuckDB takes it for that of a URL
        files = [f"{a}{log}{mark}{b}" for a, mark, b in names for log in ("", *LOGS)]
        listed = ", ".join("'" + file.replace("'", "''") + "'" for file in files)
        with suppress(duckdb.InvalidInputException):  # another store of this process has shut it
            root.execute(f"SET allowed_paths = [{listed}]")
            root.execute("SET enable_external_access = false")

    def lend(self) -> None:
        """Close the file once no block needs it; a question meanwhile opens it for reading."""
        with self.write_lock:  # a transaction that has begun keeps the mode that it found
            self._swap_root(is_lent=True)

    def take_back(self, wait: float | None = None) -> None:
        """Open the file again as it was, waiting at most ``wait`` seconds for other processes."""
        with self.write_lock:
            self._swap_root(is_lent=False)
            with self._turn:
                self._open_root(wait)

    def take_back_later(self) -> None:
        """Open the file again in the same mode at the next use."""
        with self.write_lock:
            self._swap_root(is_lent=False)

    @contextmanager
    def open_for_writing(self) -> Iterator[None]:
        """Take a lent file back while the block runs; the caller holds ``write_lock``."""
        if not self._is_lent or self.local.depth:
            yield
            return
        self._is_writing = True
        try:
            self._swap_root(is_lent=self._is_lent)
            yield
        finally:
            self._is_writing = False
            self._swap_root(is_lent=self._is_lent)

    def close(self) -> None:
        """Close the file; a second call does nothing.

        Blocks of other threads that have begun may end first, for ``_LAST_BLOCKS`` seconds at most;
        later requests are refused. In a forked process the file is left to the one that opened it.
        """
        if self._process != os.getpid():
            return
        with self._turn:
            self._is_closed = True
            self._turn.wait_for(lambda: self._users <= bool(self.local.depth), _LAST_BLOCKS)
            if self._root is not None:
                self._close_root(self._root)
                self._root = None

    def __del__(self) -> None:
        with suppress(Exception):  # opening it may have failed
            self.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def fixed_revision(self, load: Callable[[], int]) -> int | None:
        """The revision, loaded once, of a file that DuckDB only reads; None where it may change.

        Called in a block that keeps the root open.
        """
        self._cursor()  # opens it
        if not self._is_fixed:
            return None
        opening, known = self._fixed_revision
        if opening != self._opening:
            known = load()
            self._fixed_revision = self._opening, known
        return known

    def _swap_root(self, is_lent: bool) -> None:
        with self._turn:
            self._is_swapping = True  # new blocks wait, so that the running ones come to an end
            try:
                self._turn.wait_for(lambda: self._users <= bool(self.local.depth))
                self._is_lent = is_lent
                if self._root is not None and not self._is_closed:
                    self._close_root(self._root)
                    self._root = None
                    self._opening += 1
            finally:
                self._is_swapping = False
                self._turn.notify_all()

    def _close_root(self, root: duckdb.DuckDBPyConnection) -> None:
        if not self.read_only and (self._is_marked or not self.lacked_log):
            log_mark.clear_mark(root)  # the mark of a missing log stays, so that the log still fits
        self._is_marked = False
        try:
            _close(root)
        finally:
            self._held.let_go()

    def _cursor(self) -> duckdb.DuckDBPyConnection:
        """The cursor of the current thread, which is in a block that keeps the root open."""
        local = self.local
        if local.cursor is None or local.opening != self._opening or self._root is None:
            with self._turn:
                try:
                    local.cursor = self._open_root().cursor()
                    # it would stand in what a command prints where a query takes two seconds
                    local.cursor.execute("SET enable_progress_bar = false")
                except duckdb.Error as error:
                    raise translate(self.path, error) from error
                local.opening = self._opening
        return local.cursor

    def _open_root(self, wait: float | None = None) -> duckdb.DuckDBPyConnection:
        if self._is_closed:
            raise StoreError(
                f"{self.path}: expected an open database, found it closed. "
                "Open it again with motiondb.open."
            )
        if self._root is None:
            is_lent = self._is_lent and not self._is_writing
            self._root = self._reopen(self.read_only or is_lent, wait)
            self._shut(self._root)
            self._held = HeldFile.hold(self.path)
        return self._root

    def _reopen(self, read_only: bool, wait: float | None) -> duckdb.DuckDBPyConnection:
        """Connect again; DuckDB may need time to close the file in its former mode."""
        is_reader = self._is_lent and read_only
        deadline = time.monotonic() + (_OTHER_STORE if is_reader else _LETTING_GO)
        while True:
            try:
                return self._connect(read_only, wait)
            except OtherModeError:
                if time.monotonic() > deadline:
                    if not is_reader:
                        raise
                    return self._connect(False, wait)  # as another store of this process
            time.sleep(_PAUSE)


_OPENED: weakref.WeakSet[Store] = weakref.WeakSet()


def _forked(path: Path, process: int) -> StoreError:
    return StoreError(
        f"{path}: expected to be used in the process that opened it ({process}), found it in "
        f"another ({os.getpid()}) that was forked from it. Close the database before the fork and "
        "open it again in each process, or start processes by the method 'spawn'."
    )


def _refuse_forked(path: Path) -> None:
    """Refuse a file that the process from which this one was forked had open: DuckDB shares it."""
    real = os.path.realpath(path)  # DuckDB, too, knows the file by any spelling of its path
    for store in list(_OPENED):
        is_foreign = store._process != os.getpid() and not store._is_closed
        if is_foreign and os.path.realpath(store.path) == real:
            raise _forked(path, store._process)


def _close_all() -> None:
    """Close what a program left open: DuckDB would do so, but leave the mark of the log."""
    for store in list(_OPENED):
        if not store.read_only:
            store.close()


atexit.register(_close_all)


def _leave_to_parent() -> None:
    """Keep a forked process from closing the files of its parent when it ends, which crashes it."""
    for store in list(_OPENED):
        if store._root is not None:
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(store._root))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


@contextmanager
def released(store: Store) -> Iterator[Callable[[], None]]:
    """Release the file while the block computes, and open it again at its end.

    Other processes may read and write meanwhile. A load in the block, by any thread, opens the file
    for reading, so that others can read but not write; the function that the block is given
    releases it again. Whether the loaded data are still current must be checked afterwards, by
    comparing them or :func:`~motiondb.store.connection.transactions.revision`. Not within a
    transaction or a ``reading`` block of this thread.
    """
    if store.in_transaction:
        yield lambda: None
        return
    store.lend()
    try:
        yield store.lend
    except BaseException:
        store.take_back_later()
        raise
    store.take_back(_TAKE_BACK)


_LEAST_BOUND = 2**30
"""Bytes to which the memory of DuckDB is bounded. Measured on 480 MB of files and motions in 20
batches: closing took 490 MiB under a bound of 250 MB, and more than twice as much as the data
without one."""
_PEAK = 3  # Memory that DuckDB takes for joining rows, as a multiple of these; measured, 2.6 to 3.3
LARGE = 2**26
"""Bytes of a file from which on DuckDB does not join row groups at every change; by hand."""
KEEP_GROUPS = "SET max_vacuum_tasks = 0; SET checkpoint_threshold = '64MB'"
"""Whatever is added stays a row group of its own; a long ``add`` has one for each checkpoint."""
_ROWS_AT_ONCE = 2048  # Rows that DuckDB reads at once; what they hold is in memory together
_USED = (
    "SELECT used_blocks * block_size, (SELECT max(run) / max(total) FROM (SELECT "
    f"sum(n_frames) OVER (ORDER BY capture_id ROWS {_ROWS_AT_ONCE - 1} PRECEDING) AS run, "
    "sum(n_frames) OVER () AS total FROM capture)) FROM pragma_database_size() "
    "WHERE database_name = current_database()"
)


@contextmanager
def bounded_memory(store: Store, n_bytes: int) -> Iterator[None]:
    """Bound the memory of DuckDB while captures are added, then close the file until its next use.

    `n_bytes`: Size of the captures. Where they and the file are small, nothing is done.
    """
    if not limit_memory(store, n_bytes):
        yield
        return
    try:
        yield
    finally:
        store.lend()
        store.take_back_later()


def limit_memory(store: Store, n_bytes: int = 0) -> bool:
    """Bound the memory of DuckDB until the file is closed, unless it and what is added are small.

    Where it joins the rows that were added with older ones, DuckDB reads and writes motions and
    files of hours, and would keep all of them in memory. What does not fit within the bound lies
    in a folder beside the file meanwhile, ``NAME.tmp``. The bound is twice what the captures take
    that are read at once, since without room for these DuckDB fails. A file that becomes large is
    not joined at all: written anew when it is closed, four hours took twice their size.
    """
    ((used, share),) = store.connection.execute(_USED).fetchall()
    if used < LARGE <= used + n_bytes:  # one that is large already was limited when it was opened
        store.connection.execute(KEEP_GROUPS)
    if _PEAK * (used + n_bytes) < _LEAST_BOUND:
        return False
    bound = max(_LEAST_BOUND, int(2 * used * (share or 0.0)), 4 * n_bytes)
    with suppress(StoreError):  # other threads hold more at this moment
        store.connection.execute(f"SET memory_limit = '{bound}B'")
    return True
