"""Open the file: create it if it is missing, migrate it, wait for the process that holds it.

One process may write, or several may read. A new database is built under another name and moved
into place, so that a kill in between never leaves half a file under the name the user gave.

DuckDB names the number of one process that holds a lock on the file. The rest is asked of the
system: ``/proc`` on Linux, ``ps`` elsewhere. Locks of the file system are those of this host.

Fair turns: a process that waits for a database says so, and one that holds it can see that.

A server that answers one request after the other would never let go of the file. A process that
waits for it holds a shared lock on an empty file ``.NAME.waits`` beside the database. The system
ends the lock with the process, however that ends. Where no such file can be made, or where the
system has no such locks, nothing is announced, and the process waits by trying again alone.
"""

from __future__ import annotations

import glob
import os
import re
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import duckdb

from motiondb.errors import HeldError, StoreError
from motiondb.files import safe_files
from motiondb.files.text import cut
from motiondb.store.connection import migrations
from motiondb.store.connection.faults import OtherModeError, first_sentence, is_damage
from motiondb.store.connection.handle import KEEP_GROUPS, LARGE, Store

_CONFIG: dict[str, Any] = {
    # Extensions are fetched at run time from a server; motiondb uses none.
    "autoinstall_known_extensions": False,
    "autoload_known_extensions": False,
}
_FIRST_PAUSE, _LONGEST_PAUSE = 0.01, 0.2
"""Seconds between two attempts to get the file; they double. The first is shorter than any command,
the longest is not noticed."""
_HELD = ("Could not set lock", "File is already open in", "used by another process")
"""What DuckDB says of a file that another process holds: on POSIX; on Windows, in any language; on
Windows where the process is not known."""
_HOLDER = re.compile(r"(?:held|open) in\s+(\S.*?) \(PID (\d+)\)")
_NO_WRITING = ("Permission denied", "Read-only file system")
_LONGEST_COMMAND = 120  # Letters of a command that are shown: one or two lines of a terminal


def open_store(
    path: str | Path,
    *,
    read_only: bool = False,
    create: bool = True,
    wait: float = 0.0,
    is_others: bool = False,
) -> Store:
    """Open the database file at ``path``; one of an earlier version is brought up to date.

    `is_others`: Whether the file is only read whatever its version: what it holds is then brought
    up to date in memory.
    """
    path = Path(path)
    safe_files.check_file_name(path)
    path = safe_files.link_target(path)  # so that there is one log, and one draft, by whatever name
    if not path.exists() or (path.is_file() and path.stat().st_size == 0):
        if read_only or not create:
            actual = "an empty file" if path.exists() else "no such file"
            raise StoreError(
                f"{path}: expected a database of motiondb, found {actual}. "
                f"Make one: motiondb add FOLDER --db {path}."
            )
        _create(path)
    names = safe_files.count_names(path)
    if names > 1 and not read_only:
        raise StoreError(
            f"{path}: expected a database with one name, found a file with {names} (hard links), "
            "each of which would have a log of its own. Copy the file, or remove the other names."
        )
    notes: list[str] = []
    connected = partial(_connect_current, path, wait, is_others, notes)
    return checked(Store(path, connected, read_only, notes))


def _connect_current(
    path: Path,
    usual_wait: float,
    is_others: bool,
    notes: list[str],
    read_only: bool,
    wait: float | None,
) -> duckdb.DuckDBPyConnection:
    """A connection to a database that has the schema of today."""
    wait = usual_wait if wait is None else wait
    connection = connect(path, read_only, wait=wait)
    try:
        version = migrations.schema_version(connection, str(path))
        if version < migrations.newest_version():
            _refuse_programs(path, connection.execute(_MACROS).fetchall())  # a migration calls them
            if read_only:
                connection.close()
                if is_others:
                    return _in_memory(path, version)
                _bring_up_to_date(path, wait, notes, version)
                return _connect_current(path, usual_wait, is_others, notes, True, wait)
            migrations.migrate(connection, version)
            notes.append(
                f"{path}: brought up to date from schema {version} to "
                f"{migrations.newest_version()}; earlier versions of motiondb cannot read it now"
            )
        if is_others:
            return connection
        safe_files.sweep_drafts(path.parent, re.escape(safe_files.draft_stem(path)))
        if not read_only:
            _limit_joining(connection, path)
            for left in path.parent.glob(
                f"{glob.escape(safe_files.beside(path, safe_files.COPY).name)}*"
            ):
                safe_files.delete_all(
                    left
                )  # a copy of a killed ``compact``; none can run beside a writer
            _sweep_spilled(path)
            somebody_waits(path)  # removes the note of a process that was killed while it waited
    except duckdb.Error as error:
        connection.close()
        raise StoreError(_unreadable(path, error)) from error
    except BaseException:
        connection.close()
        raise
    return connection


def _in_memory(path: Path, version: int) -> duckdb.DuckDBPyConnection:
    """A connection to a copy in memory of an older file, brought up to date."""
    connection = duckdb.connect(":memory:", config=_CONFIG)
    try:
        connection.execute(f"SET temp_directory = '{_quoted(tempfile.gettempdir())}'")
        connection.execute(f"ATTACH '{_quoted(safe_files.plain_name(path))}' AS older (READ_ONLY)")
        connection.execute("COPY FROM DATABASE older TO memory")
        connection.execute("DETACH older")
        connection.execute("SET enable_external_access = false")
        migrations.migrate(connection, version)
    except BaseException:
        connection.close()
        raise
    return connection


def _quoted(text: str) -> str:
    """A text as it stands between quotes in SQL."""
    return text.replace("'", "''")


def _bring_up_to_date(path: Path, wait: float, notes: list[str], version: int) -> None:
    """Migrate a file that was opened for reading."""
    try:
        _connect_current(path, wait, False, notes, False, wait).close()
    except StoreError as error:
        if not any(reason in str(error.__cause__) for reason in _NO_WRITING):
            raise
        raise StoreError(
            f"{path}: expected a schema of version {migrations.newest_version()}, found one of "
            f"version {version}, which this user may not bring up to date. Open it once with the "
            "right to write to it and its folder, or copy it."
        ) from error


SPILLED = ".tmp"  # Ending of the folder of rows that DuckDB has no memory for
MOST_GROUPS = 64  # Row groups of a table that grows with every change, before they join; by hand


def _limit_joining(connection: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Let DuckDB join the row groups of a large file seldom.

    What it joins it writes anew, also motions and files of hours: of the 4.0 GB that 40 hours took,
    1.7 GB were free. A row group of its own takes .5 to 3 MB for every change.
    """
    if path.stat().st_size < LARGE:
        return
    query = "SELECT count(DISTINCT row_group_id) FROM pragma_storage_info('run')"
    ((groups,),) = connection.execute(query).fetchall()
    if groups <= MOST_GROUPS:
        connection.execute(KEEP_GROUPS)


def _create(path: Path) -> None:
    """Build an empty database beside ``path`` and move it there, unless another was quicker."""
    if not path.parent.is_dir():
        raise StoreError(
            f"{path}: expected the folder {path.parent}, found none. Make the folder first."
        )
    try:
        with safe_files.whole_file(path) as new:
            with duckdb.connect(safe_files.plain_name(new), config=_CONFIG) as connection:
                migrations.migrate(connection, 0)
            if safe_files.log_of(new).exists():
                raise OSError("too little room on the disk.")
            if path.exists() and path.stat().st_size:
                raise FileExistsError
    except FileExistsError:  # another was quicker
        return
    except (duckdb.Error, OSError) as error:
        reason = first_sentence(error)
        raise StoreError(
            f"{path}: expected to make a new database, found: {reason} "
            "Look at the folder's permissions and at the disk."
        ) from error


def _sweep_spilled(path: Path) -> None:
    """Delete what killed processes left of the rows that DuckDB had no memory for."""
    folder = path.with_name(path.name + SPILLED)
    for left in folder.glob("duckdb_temp_*"):
        owner = re.match(r"duckdb_temp_(\d+)_", left.name)
        if owner is not None and not safe_files.is_running(int(owner[1])):
            safe_files.delete_all(left)
    with suppress(OSError):  # there is none, or it holds something else
        folder.rmdir()


def connect(path: Path, read_only: bool, wait: float = 0.0) -> duckdb.DuckDBPyConnection:
    """A connection of DuckDB, whatever is in the file."""
    safe_files.check_file_name(path)  # the folder may have been closed since
    if not (path.is_file() or path.is_dir()):  # DuckDB would make one, or wait for a pipe
        actual = "neither a file nor a folder" if path.exists() else "no such file"
        raise StoreError(
            f"{path}: expected a database of motiondb, found {actual}. Name another file with --db."
        )
    for ending in (*safe_files.LOGS, SPILLED):  # DuckDB would write through a link, or delete it
        if (found := path.with_name(path.name + ending)).is_symlink():
            what = (
                "its log {} as a file"
                if ending in safe_files.LOGS
                else "{} as a folder of DuckDB's own"
            )
            raise StoreError(
                f"{path}: expected {what.format(found.name)}, found a link. Put what it stands "
                "for in its place."
            )
    deadline, pause = time.monotonic() + wait, _FIRST_PAUSE
    with ExitStack() as waiting:
        while True:
            try:
                connection = duckdb.connect(
                    safe_files.plain_name(path), read_only=read_only, config=_CONFIG
                )
                break
            except duckdb.Error as error:
                left = deadline - time.monotonic()
                is_other_mode = "different configuration" in str(error)
                if left <= 0.0 or not (is_lock(error) or is_other_mode):
                    held = HeldError if is_lock(error) else StoreError
                    kind = OtherModeError if is_other_mode else held
                    raise kind(_unreadable(path, error, wait)) from error
            if pause == _FIRST_PAUSE:
                waiting.enter_context(announced(path))
            time.sleep(min(pause, left))
            pause = min(2.0 * pause, _LONGEST_PAUSE)
    try:
        _refuse_programs(path, connection.execute(_PROGRAMS).fetchall())
    except duckdb.Error as error:
        connection.close()
        raise StoreError(_unreadable(path, error)) from error
    except StoreError:
        connection.close()
        raise
    return connection


_PROGRAMS = (
    "SELECT 'view', view_name FROM duckdb_views() WHERE NOT internal AND NOT temporary UNION ALL "
    "SELECT 'trigger', trigger_name FROM duckdb_triggers() WHERE NOT temporary"
)  # Looked for at every connection, 1 ms
_MACROS = "SELECT 'macro', function_name FROM duckdb_functions() WHERE NOT internal"  # 20 ms


def _refuse_programs(path: Path, found: Sequence[tuple[str, str]]) -> None:
    """Refuse a file that holds more than tables: a view in a table's place may show other files."""
    for kind, name in found[:1]:
        raise StoreError(
            f"{path}: expected tables alone, found the {kind} {name!r}, which another program made:"
            " it could show other files, or change them. Restore a copy."
        )


def checked(store: Store) -> Store:
    """The same store; it is closed and refused if its file holds macros."""
    try:
        _refuse_programs(store.path, store.connection.execute(_MACROS).fetchall())
    except StoreError:
        store.close()
        raise
    return store


def _unreadable(path: Path, error: duckdb.Error, wait: float = 0.0) -> str:
    """The message for a file that cannot be opened."""
    text = str(error)
    if is_lock(error):
        return holder_sentence(path, text, wait)
    if "different configuration" in text:
        return (
            f"{path}: expected a free database, found it held by this process ({os.getpid()}) "
            "in another mode. Close it first."
        )
    if "Permission denied" in text:
        return (
            f"{path}: expected a database that this user may open, found: permission denied. "
            "Get the right to read it, and to write it and its folder for commands that change it."
        )
    is_other = path.is_file() and os.access(path, os.R_OK) and not safe_files.is_duckdb(path)
    if "not a valid DuckDB" in text or "Is a directory" in text or is_other:
        actual = "a folder" if path.is_dir() else "another kind of file"
        return (
            f"{path}: expected a database of motiondb, found {actual}. Name another file with --db."
        )
    if "WAL does not match" in text or "This WAL was created" in text:
        return (
            f"{path}: expected its log {safe_files.log_of(path).name} to fit it, found one of "
            "another database or of a former state of this one. Move the log to another folder, "
            "where its own database can find it, and open the file again."
        )
    rescue = (
        f"if it is damaged, save what is readable (motiondb rescue {path} -o NEW.duckdb) or "
        if is_damage(error)
        else "if it is damaged, "
    )
    return (
        f"{path}: expected a database that can be opened, found: {first_sentence(error)} "
        f"Look at the file's permissions and at the disk; {rescue}restore a copy."
    )


def is_lock(error: BaseException) -> bool:
    """Whether DuckDB could not open the file because another process holds it."""
    return any(sentence in str(error) for sentence in _HELD)


def holder_sentence(path: Path, message: str, waited: float = 0.0) -> str:
    """Return the process that holds the file, from DuckDB's message."""
    held = _HOLDER.search(message)
    who = "another process"
    if held:
        program = re.split(r"[\\/]", held[1])[-1]
        who = f"process {held[2]} ({program}){describe_process(int(held[2]))}"
    after = f" after {waited:g} s" if waited else ""
    return (
        f"{path}: expected a free database, found it held by {who}{after}. "
        "Wait until it has ended, or wait longer with --wait SECONDS."
    )


def describe_process(pid: int) -> str:
    """The command of a process, its host and when it began; empty if that is not known."""
    command, began = _from_proc(pid) or _from_ps(pid) or ("", "")
    if not command:
        return ""
    return f", command `{cut(command, _LONGEST_COMMAND)}`, on {socket.gethostname()} since {began}"


def _from_proc(pid: int) -> tuple[str, str] | None:
    """Command and start of a process, from Linux."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        status = Path(f"/proc/{pid}/stat").read_text(errors="replace")
        boot = re.search(r"^btime (\d+)$", Path("/proc/stat").read_text(), re.MULTILINE)
        if boot is None:
            return None
        # field 22 of stat, counted from behind the command, which may hold spaces
        ticks = int(status.rpartition(")")[2].split()[19])
        seconds = int(boot[1]) + ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return None
    command = " ".join(word.decode(errors="replace") for word in words if word)
    began = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))
    return " ".join(command.split()), began


def _from_ps(pid: int) -> tuple[str, str] | None:
    """Command and start of a process, from ``ps``."""
    try:
        answer = subprocess.run(
            ["ps", "-o", "lstart=,command=", "-p", str(pid)],
            capture_output=True,
            text=True,
            timeout=2.0,
            check=True,
        ).stdout.split()
    except (OSError, subprocess.SubprocessError):
        return None
    return (" ".join(answer[5:]), " ".join(answer[:5])) if len(answer) > 5 else None


try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]  # Windows has other locks

_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0)


@contextmanager
def announced(database: Path) -> Iterator[None]:
    """Say, while the block runs, that this process waits for a database."""
    note = _note(database)
    descriptor = _lock(note)
    try:
        yield
    finally:
        if descriptor is not None:
            with suppress(OSError):  # another process still waits
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                note.unlink()
            os.close(descriptor)


def somebody_waits(database: Path) -> bool:
    """Return whether a process waits for a database; a note without one is removed."""
    if fcntl is None:  # a note on a shared disk is of another system
        return False
    note = _note(database)
    try:
        descriptor = os.open(note, _FLAGS)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        note.unlink()
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(descriptor)
    return False


def _note(database: Path) -> Path:
    """Return the file by which waiting is announced, the same for all names of a database."""
    real = Path(os.path.realpath(database))
    return safe_files.beside(real, safe_files.WAITS)


def _lock(note: Path) -> int | None:
    """Return the note, open and with a shared lock; None if that cannot be had."""
    while fcntl is not None:
        try:
            descriptor = os.open(note, _FLAGS | os.O_CREAT, 0o644)
        except OSError:
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_SH)
            # another process may have removed it before it was locked
            if os.path.samestat(os.fstat(descriptor), note.stat()):
                return descriptor
        except FileNotFoundError:
            pass
        except OSError:
            os.close(descriptor)
            return None
        os.close(descriptor)
    return None
