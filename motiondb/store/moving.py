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
import mmap
import shutil
import tempfile
import uuid
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import astuple, replace
from pathlib import Path

from motiondb.errors import StoreError
from motiondb.store.catalogue.parquet_files import (
    ParquetFile,
    advice,
    check_parquet_file,
    load_parquet_files,
)
from motiondb.store.catalogue.places import digest_of, open_place, place_name, told
from motiondb.store.catalogue.runs import finish_run, start_run
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
_ROOM = "Nothing of it was moved. Look at the folder or URL, its permissions and its room."


def find_place(to: str) -> str:
    """How a place is kept; it is refused if nothing can lie there. ``IN_DATABASE`` is one, too."""
    if to == IN_DATABASE:
        return to
    name = place_name(to)
    with told(name, _ROOM):
        open_place(name).check()
    return name


def move_motions(store: Store, to: str, progress: Progress | None = None) -> tuple[int, list[str]]:
    """Move all motions and originals to a folder or URL, or into the database (``IN_DATABASE``).

    Returns the number of captures that were moved, and the paths of the Parquet files that this
    database no longer relies on.
    """
    tell = progress or (lambda _what, _done, _total: None)
    place = find_place(to)
    files = [file for file in load_parquet_files(store) if file.place != place]
    batches = [] if to == IN_DATABASE else list(_batches(store))
    if not files and not batches:
        return 0, []
    run_id = start_run(store, "move", {"to": place})
    total = len(files) + len(batches)
    moved = 0
    with bounded_memory(store, _FILE_BYTES):
        for done, file in enumerate(files):
            tell("moving motions", done, total)
            moved += (
                _bring_back(store, file) if to == IN_DATABASE else _take_along(store, file, place)
            )
        for done, batch in enumerate(batches, start=len(files)):
            tell("moving motions", done, total)
            moved += _move_out(store, batch, place)
    tell("moving motions", total, total)
    finish_run(store, run_id)
    return moved, [file.path for file in files]


def forget_unused(store: Store) -> list[str]:
    """Forget the Parquet files of which nothing is needed any more; their paths."""
    used = " UNION ".join(
        f"SELECT {column}_at.file_id AS f FROM {table}"
        for table, (_, columns) in _MOVED.items()
        for column in columns
    )
    unused = f"file_id NOT IN (SELECT f FROM ({used}) WHERE f IS NOT NULL)"
    query = f"SELECT place || '/' || name FROM parquet_file WHERE {unused} ORDER BY file_id"
    paths = store.connection.column(query)
    if paths:
        with transaction(store) as connection:
            connection.execute(f"DELETE FROM parquet_file WHERE {unused}")
    return paths


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
    with tempfile.TemporaryDirectory() as folder, transaction(store) as connection:
        draft = Path(folder) / name
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


def _put(file: ParquetFile, draft: Path) -> None:
    """Copy a file to its place and compare what stands there; after an error it is deleted."""
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
    parts, end = list[str](), 0
    for value in values:
        if not value:  # it was left out, or there is none
            parts.append(f"NULL::{_PART}")
            continue
        start = whole.find(value, end)
        if start < 0:  # values that are the same may stand there once
            start = whole.find(value)
        if start < 0:
            raise StoreError(
                f"{file.path}: expected values as they are in the database, found others. {_ROOM}"
            )
        end = start + len(value)
        part = [file.file_id, start, len(value), zlib.crc32(value)]
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


def _bring_back(store: Store, file: ParquetFile) -> int:
    """Move what a Parquet file holds into the database, in one transaction; how many captures."""
    with tempfile.TemporaryDirectory() as folder, transaction(store) as connection:
        n_captures = _count_captures(store, file)
        target = _fetch(store, file, Path(folder))
        for table, (key, columns) in _MOVED.items():
            back = ", ".join(
                f"coalesce(p.{c}, t.{c}) AS {c}, NULL::{_PART} AS {c}_at" for c in columns
            )
            held = ", ".join(f"t.{c}_at.file_id" for c in columns)
            _rewrite(
                store,
                table,
                f"SELECT t.* REPLACE ({back}) FROM {table} t "
                f"JOIN read_parquet({_quoted(target)}) p USING ({key}) "
                f"WHERE {file.file_id} IN ({held})",
            )
        connection.execute("DELETE FROM parquet_file WHERE file_id = ?", [file.file_id])
    return n_captures


def _take_along(store: Store, file: ParquetFile, where: str) -> int:
    """Rely on a copy of a Parquet file at another place, and make it; how many captures."""
    new = replace(file, place=where)
    if not _is_copy(new):
        with tempfile.TemporaryDirectory() as folder:
            _put(new, _fetch(store, file, Path(folder)))
    with transaction(store) as connection:
        connection.execute(
            "UPDATE parquet_file SET place = ? WHERE file_id = ?", [where, file.file_id]
        )
    return _count_captures(store, file)


def _fetch(store: Store, file: ParquetFile, folder: Path) -> Path:
    """Copy a file into a folder of this machine, and compare it."""
    draft = folder / file.name
    with (
        told(file.path, advice(store)),
        open_place(file.place).open(file.name) as read,
        draft.open("wb") as written,
    ):
        shutil.copyfileobj(read, written)
    check_parquet_file(store, file, open_place(str(folder)))
    return draft


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


def _count_captures(store: Store, file: ParquetFile) -> int:
    query = "SELECT count(*) FROM motion WHERE poses_at.file_id = ?"
    return int(store.connection.value(query, [file.file_id]))
