"""Move motions and original files out of the database into Parquet files, and back.

A Parquet file holds the captures of some hours: their numbers and names, packed motions
(:mod:`motiondb.store.poses`) and original files (zlib). It is written, read back and compared
before the database, in the same transaction, keeps where the values stand in place of them. What is
interrupted leaves the captures whose file was finished moved, and the others as they were; the same
command then goes on.

Parquet files are never deleted once the database has relied on them: a copy of it may still.
"""

from __future__ import annotations

import hashlib
import json
import mmap
import uuid
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import astuple, replace
from pathlib import Path
from typing import BinaryIO

from motiondb.errors import StoreError
from motiondb.files.safe_files import delete_all, draft_of
from motiondb.store.catalogue.parquet_files import (
    ParquetFile,
    Part,
    advice,
    is_whole,
    load_parquet_files,
)
from motiondb.store.catalogue.places import digest_of, open_place, place_name, read_pieces, told
from motiondb.store.catalogue.runs import finish_run, start_run
from motiondb.store.connection.faults import DamagedFileError
from motiondb.store.connection.handle import Store, bounded_memory
from motiondb.store.connection.transactions import transaction

IN_DATABASE = "here"
"""In place of a folder or URL: the database itself."""
Progress = Callable[[str, int, int], None]
"""Called with the name of the step, the number done, and the total number."""

_MOVED = {"motion": ("capture_id", ("poses",)), "source": ("sha256", ("data", "skeleton_data"))}
"""Table -> its key, and its columns of which the values are moved."""
_PART = "STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT)"
_FRAMES, _FILE_BYTES = 216_000, 2**27
"""Frames of the captures of a file, two hours, and about how large it is with their originals."""
_CAPTURES = 1000  # At most in a file; DuckDB finds so many rows by their index
_UNTOLD = "unused_parquet_files"  # Key in ``meta`` of a list in JSON
_ROOM = "Nothing of it was moved. Look at the folder or URL, its permissions and its room."


def find_place(to: str) -> str:
    """How a place is kept; it is refused if nothing can lie there. ``IN_DATABASE`` is one, too."""
    if to == IN_DATABASE:
        return to
    name = place_name(to)
    with told(name, _ROOM):
        open_place(name).check()
    return name


def move_motions(store: Store, to: str, progress: Progress | None = None) -> int:
    """Move all motions and originals to a folder or URL, or into the database (``IN_DATABASE``).

    Returns the number of captures that were moved. DamagedFileError at the end names those that
    could not be read.
    """
    tell = progress or (lambda _what, _done, _total: None)
    place = find_place(to)
    files = [file for file in load_parquet_files(store) if file.place != place]
    if not files and (place == IN_DATABASE or not any(_batches(store))):
        return 0
    run_id = start_run(store, "move", {"to": place})
    moved, lost = 0, list[str]()
    with bounded_memory(store, _FILE_BYTES):
        for done, file in enumerate(files):
            tell("moving motions", done, len(files))
            n_moved, damaged = _move_file(store, file, place)
            moved += n_moved
            lost += damaged
        batches = [] if place == IN_DATABASE else list(_batches(store))
        total = len(files) + len(batches)
        for done, batch in enumerate(batches, start=len(files)):
            tell("moving motions", done, total)
            moved += _move_out(store, batch, place)
    tell("moving motions", total, total)
    finish_run(store, run_id)
    if lost:
        raise DamagedFileError(
            f"{store.path}: expected motions and originals as they were written, found others of "
            f"the captures {', '.join(lost)}, which stay where they are. Those of {moved} captures "
            "were moved. Put a copy of the damaged files in their place, or remove these captures."
        )
    return moved


def forget_unused(store: Store) -> None:
    """Forget the Parquet files of which nothing is needed any more; their paths wait to be told."""
    used = " UNION ".join(
        f"SELECT {column}_at.file_id FROM {table} WHERE {column}_at IS NOT NULL"
        for table, (_, columns) in _MOVED.items()
        for column in columns
    )
    numbers = set(store.connection.column(used))
    for file in load_parquet_files(store):
        if file.file_id not in numbers:
            _forget(store, file)


def _forget(store: Store, file: ParquetFile) -> None:
    with transaction(store) as connection:
        connection.execute("DELETE FROM parquet_file WHERE file_id = ?", [file.file_id])
        _note_unused(store, file.path)


def _note_unused(store: Store, path: str) -> None:
    """Keep the path of a file that is no longer relied on, until it has been told."""
    paths = json.dumps([*untold_files(store), path])
    with transaction(store) as connection:
        connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", [_UNTOLD, paths])


def untold_files(store: Store) -> list[str]:
    """Paths of Parquet files that the database no longer relies on, and nobody has been told."""
    noted = store.connection.value("SELECT value FROM meta WHERE key = ?", [_UNTOLD])
    used = {file.path for file in load_parquet_files(store)}
    return [path for path in json.loads(noted or "[]") if path not in used]


def forget_untold(store: Store) -> None:
    """Forget the paths of :func:`untold_files` once they have been told."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM meta WHERE key = ?", [_UNTOLD])


def _batches(store: Store) -> Iterator[list[tuple[int, str]]]:
    """Number and digest of captures whose motions are in the database, some hours at a time.

    Generated ones stay: they are few, and every question reads them.
    """
    query = (
        "SELECT capture_id, sha256, motion_frames FROM capture JOIN motion USING (capture_id) "
        "WHERE poses_at IS NULL AND kind = 'captured' ORDER BY capture_id"
    )
    batch, n_frames = list[tuple[int, str]](), 0
    for number, sha256, length in store.connection.execute(query).fetchall():
        if batch and (n_frames + length > _FRAMES or len(batch) == _CAPTURES):
            yield batch
            batch, n_frames = [], 0
        batch.append((number, sha256))
        n_frames += length
    if batch:
        yield batch


def _move_out(store: Store, batch: Sequence[tuple[int, str]], where: str) -> int:
    """Move some captures into a new Parquet file, in one transaction; how many."""
    name = f"motions-{uuid.uuid4().hex}.parquet"
    with _draft_beside(store) as draft, transaction(store) as connection:
        _write_parquet(store, batch, draft)
        number = int(connection.value("SELECT coalesce(max(file_id), 0) + 1 FROM parquet_file"))
        with (
            draft.open("rb") as opened,
            mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ) as whole,
        ):
            file = ParquetFile(number, where, name, len(whole), hashlib.sha256(whole).hexdigest())
            _note_parts(store, batch, file, whole)
        connection.execute("INSERT INTO parquet_file VALUES (?, ?, ?, ?, ?)", [*astuple(file)])
        _put(file, draft)
    return len(batch)


@contextmanager
def _draft_beside(store: Store) -> Iterator[Path]:
    """The name of a draft beside the database; one that a kill leaves goes at the next opening."""
    draft = draft_of(store.path)
    try:
        yield draft
    except OSError as error:
        raise StoreError(
            f"{store.path}: expected room for a draft beside it, found: {error.strerror or error}. "
            "What was moved before stays moved. Make room and run the command again."
        ) from error
    finally:
        delete_all(draft)


def _put(file: ParquetFile, draft: Path) -> None:
    """Copy a file to its place and compare what stands there."""
    place = open_place(file.place)
    try:
        with told(file.path, _ROOM):
            place.write(file.name, draft)
            found = digest_of(place, file.name)
        if found != file.sha256:
            raise StoreError(
                f"{file.path}: expected the bytes that were copied there, found others. {_ROOM}"
            )
    except BaseException:
        with suppress(Exception):  # the first error is the cause
            # a whole file stays: another process may have put it there, for a copy of the database
            if digest_of(place, file.name) != file.sha256:
                place.delete(file.name)
        raise


def _write_parquet(store: Store, batch: Sequence[tuple[int, str]], path: Path) -> None:
    """Write captures as a Parquet file, in which values stand as they are."""
    store.connection.execute(
        "COPY (SELECT capture_id, c.name, m.n_frames, poses, sha256, s.format, file_name, data, "
        "skeleton_name, skeleton_data FROM capture c "
        f"JOIN (FROM motion WHERE {_chosen(batch, 'capture_id')}) m USING (capture_id) "
        f"JOIN (FROM source WHERE {_chosen(batch, 'sha256')}) s USING (sha256) "
        f"ORDER BY capture_id) TO {_quoted(path)} (FORMAT parquet, COMPRESSION uncompressed)"
    )


def _quoted(path: Path) -> str:
    return "'" + str(path).replace("'", "''") + "'"


def _chosen(batch: Sequence[tuple[int, str]], key: str) -> str:
    """The condition for the rows of some captures, by their number or their digest."""
    keys = (str(n) if key == "capture_id" else f"'{sha256}'" for n, sha256 in batch)
    return f"{key} IN ({', '.join(keys)})"


def _note_parts(
    store: Store, batch: Sequence[tuple[int, str]], file: ParquetFile, whole: mmap.mmap
) -> None:
    """Keep where the values of captures stand in a Parquet file, in place of the values."""
    for table, (key, columns) in _MOVED.items():
        keys = [sha256 if key == "sha256" else number for number, sha256 in batch]
        found = []
        for column in columns:
            query = f"SELECT {key}, {column} FROM {table} WHERE {_chosen(batch, key)}"
            values = dict(store.connection.execute(query).fetchall())
            found.append(_find([values[of_row] for of_row in keys], file, whole))
        rows = ", ".join(
            f"({of_row!r}, {', '.join(parts)})" for of_row, *parts in zip(keys, *found)
        )
        left = ", ".join(
            f"CASE WHEN {c} IS NOT NULL THEN ''::BLOB END AS {c}, p.{c}_at AS {c}_at"
            for c in columns
        )
        _rewrite(
            store,
            table,
            f"SELECT t.* REPLACE ({left}) FROM {table} t "
            f"JOIN (VALUES {rows}) p({key}, {', '.join(f'{c}_at' for c in columns)}) USING ({key})",
        )


def _find(values: Sequence[bytes | None], file: ParquetFile, whole: mmap.mmap) -> list[str]:
    """Where values stand in a file, as SQL; they are in the order of the file."""
    parts, starts, end = list[str](), dict[bytes, int](), 0
    for value in values:
        if not value:  # it was left out, or there is none
            parts.append(f"NULL::{_PART}")
            continue
        if value not in starts:  # values that are the same may stand there once
            start = whole.find(value, end)
            if start < 0:
                raise StoreError(
                    f"{file.path}: expected values as they are in the database, found others. "
                    f"{_ROOM}"
                )
            starts[value], end = start, start + len(value)
        part = [file.file_id, starts[value], len(value), zlib.crc32(value)]
        parts.append(f"row({', '.join(map(str, part))})::{_PART}")
    return parts


def _rewrite(store: Store, table: str, rows: str) -> None:
    """Put the rows of a query in place of those of the same keys."""
    # UPDATE would keep the replaced values in memory, and write rows beside them anew
    run, key = store.connection.execute, _MOVED[table][0]
    run(f"CREATE TEMP TABLE rewritten AS {rows}")
    run(f"DELETE FROM {table} WHERE {key} IN (SELECT {key} FROM rewritten)")
    run(f"INSERT INTO {table} FROM rewritten")
    run("DROP TABLE rewritten")


def _move_file(store: Store, file: ParquetFile, where: str) -> tuple[int, list[str]]:
    """Move what a Parquet file holds; how many captures, and the names of damaged ones.

    Of a damaged file, what can be read comes into the database, from where it can be moved.
    """
    new = replace(file, place=where)
    is_there = where != IN_DATABASE and _is_copy(new)
    if not is_there:
        with _draft_beside(store) as draft:
            digest = _fetch(store, file, draft)
            if where == IN_DATABASE or digest != file.sha256:
                n_moved, damaged = _bring_back(store, file, draft)
                return (n_moved if where == IN_DATABASE else 0), damaged
            _put(new, draft)
    with transaction(store) as connection:
        connection.execute(
            "UPDATE parquet_file SET place = ? WHERE file_id = ?", [where, file.file_id]
        )
        if is_there:  # the former path may be another name of the same file
            return 0, []
        _note_unused(store, file.path)
    return int(
        store.connection.value(
            "SELECT count(*) FROM motion WHERE poses_at.file_id = ?", [file.file_id]
        )
    ), []


def _bring_back(store: Store, file: ParquetFile, draft: Path) -> tuple[int, list[str]]:
    """Move captures of a file into the database, in one transaction, from a copy of the file.

    Returns how many, and the names of those of which a value is damaged, which stay.
    """
    with transaction(store), draft.open("rb") as opened:
        whole, damaged = _readable(store, file, opened)
        if whole:
            for table in _MOVED:
                _bring_values(store, table, whole, opened)
        if not damaged:
            _forget(store, file)
    return len(whole), damaged


def _readable(
    store: Store, file: ParquetFile, opened: BinaryIO
) -> tuple[list[tuple[int, str]], list[str]]:
    """Number and digest of the captures of which a file holds all values, names of the others."""
    rows = store.connection.execute(
        "SELECT capture_id, sha256, c.name, poses_at, data_at, skeleton_data_at FROM capture c "
        "JOIN motion USING (capture_id) JOIN source USING (sha256) WHERE list_contains("
        "[poses_at.file_id, data_at.file_id, skeleton_data_at.file_id], ?) ORDER BY capture_id",
        [file.file_id],
    ).fetchall()
    whole, damaged = list[tuple[int, str]](), list[str]()
    for number, sha256, name, *parts in rows:
        if all(is_whole(_read_value(opened, at), at) for at in parts if at):
            whole.append((number, sha256))
        else:
            damaged.append(name)
    return whole, damaged


def _bring_values(
    store: Store, table: str, batch: Sequence[tuple[int, str]], opened: BinaryIO
) -> None:
    """Put the values of captures, which an open file holds, into their rows of a table."""
    key, columns = _MOVED[table]
    chosen = _chosen(batch, key)
    places = ", ".join(f"{c}_at" for c in columns)
    rows = store.connection.execute(f"SELECT {key}, {places} FROM {table} WHERE {chosen}")
    of_file = rows.fetchall()
    store.connection.execute(
        f"CREATE TEMP TABLE back AS SELECT {key}, {', '.join(columns)} FROM {table} LIMIT 0"
    )
    marks = ", ".join("?" * (1 + len(columns)))
    for of_row, *parts in of_file:
        values = [at and _read_value(opened, at) for at in parts]
        store.connection.execute(f"INSERT INTO back VALUES ({marks})", [of_row, *values])
    back = ", ".join(f"coalesce(b.{c}, t.{c}) AS {c}, NULL::{_PART} AS {c}_at" for c in columns)
    _rewrite(store, table, f"SELECT t.* REPLACE ({back}) FROM {table} t JOIN back b USING ({key})")
    store.connection.execute("DROP TABLE back")


def _read_value(opened: BinaryIO, at: Part) -> bytes:
    opened.seek(at["start"])
    return opened.read(at["n_bytes"])


def _fetch(store: Store, file: ParquetFile, draft: Path) -> str:
    """Copy a file to this machine; its digest."""
    counted, pieces = hashlib.sha256(), read_pieces(open_place(file.place), file.name)
    with draft.open("wb") as written:
        while True:
            with told(file.path, advice(store)):  # of the place; the draft's errors are others
                piece = next(pieces, b"")
            if not piece:
                return counted.hexdigest()
            counted.update(piece)
            written.write(piece)


def _is_copy(file: ParquetFile) -> bool:
    """Whether a file stands at its place already; one of other content is refused."""
    with told(file.path, _ROOM):
        try:
            found = digest_of(open_place(file.place), file.name)
        except FileNotFoundError:
            return False
    if found != file.sha256:
        raise StoreError(
            f"{file.path}: expected no such file or a copy of it, found another one. {_ROOM}"
        )
    return True
