"""Move motions, originals and scores of segments into Parquet files, and back.

A Parquet file holds the captures of some hours: their numbers and names, and packed motions
(:mod:`motiondb.store.catalogue.captures`) with original files (zlib), or the scores of their
segments (float32), which every ``learn`` makes anew. It is written, read back and compared before
the database, in the same transaction, keeps where the values stand in place of them. What is
interrupted leaves the captures whose file was finished moved, and the others as they were; the same
command then goes on.

Parquet files are never deleted once the database has relied on them: a copy of it may still.
"""

from __future__ import annotations

import hashlib
import mmap
import uuid
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import astuple, replace
from pathlib import Path
from typing import BinaryIO

from motiondb.errors import StoreError
from motiondb.files.safe_files import free_draft
from motiondb.records import Float32Array
from motiondb.store.catalogue import parquet_files
from motiondb.store.catalogue import places as locations
from motiondb.store.catalogue.parquet_files import KINDS, MOTIONS, SCORES, ParquetFile, Part
from motiondb.store.catalogue.places import PlaceError, told
from motiondb.store.catalogue.runs import finish_run, start_run
from motiondb.store.connection.faults import DamagedFileError
from motiondb.store.connection.handle import Store, bounded_memory
from motiondb.store.connection.statements import ragged
from motiondb.store.connection.transactions import transaction
from motiondb.store.learned import pack_scores, unpack_scores

IN_DATABASE = "here"
"""In place of a folder or URL: the database itself."""
Progress = Callable[[str, int, int], None]
"""Called with the name of the step, the number done, and the total number."""
_Batch = Sequence[tuple[int, str]]
"""Numbers and digests of some captures."""

_PART = "STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT)"
_FILE_BYTES = 2**27  # About how large a file is, with originals
_AT_MOST = {MOTIONS: (216_000, 1000), SCORES: (4_320_000, 10_000)}
"""Frames (2 and 40 hours), and captures, in a file; DuckDB finds 1000 originals by their index."""
_WRITTEN = {
    MOTIONS: "capture_id, c.name, m.n_frames, poses, sha256, s.format, file_name, data, "
    "skeleton_name, skeleton_data FROM capture c "
    "JOIN (FROM motion WHERE {numbers}) m USING (capture_id) "
    "JOIN (FROM source WHERE {digests}) s USING (sha256)",
    SCORES: "capture_id, name, n_symbols, p.scores FROM capture JOIN packed p USING (capture_id), "
    "learning",
}  # The columns of a file
_ROOM = "Nothing of it was moved. Look at the folder or URL, its permissions and its room."


def find_place(to: str) -> str:
    """How a place is kept; it is refused if nothing can lie there. ``IN_DATABASE`` is one, too."""
    if to == IN_DATABASE:
        return to
    name = locations.place_name(to)
    with told(name, _ROOM):
        locations.open_place(name).check()
    return name


def move_motions(store: Store, to: str, progress: Progress | None = None) -> int:
    """Move all that can be moved to a folder or URL, or into the database (``IN_DATABASE``).

    Returns the number of captures of which something was moved. DamagedFileError at the end names
    those of which something could not be read, and counts the others.
    """
    tell = progress or (lambda _what, _done, _total: None)
    place = find_place(to)
    files = [file for file in parquet_files.load_parquet_files(store) if file.place != place]
    if not files and (place == IN_DATABASE or not any(_batches(store))):
        return 0
    run_id = start_run(store, "move", {"to": place})
    moved, lost, missing = set[int](), dict[int, str](), list[str]()
    for done, file in enumerate(files):
        tell("moving motions", done, len(files))
        try:
            with bounded_memory(store, file.n_bytes):
                numbers, damaged = _move_file(store, file, place)
        except PlaceError as error:
            if not isinstance(error.__cause__, FileNotFoundError):
                raise
            missing.append(str(error))
            continue
        moved |= numbers
        lost |= damaged
    batches = [] if place == IN_DATABASE else list(_batches(store))
    total = len(files) + len(batches)
    for done, (kind, batch) in enumerate(batches, start=len(files)):
        tell("moving motions", done, total)
        with bounded_memory(store, _FILE_BYTES):
            _move_out(store, kind, batch, place)
        moved |= {number for number, _ in batch}
    tell("moving motions", total, total)
    finish_run(store, run_id)
    moved -= lost.keys()
    if missing:
        there = f"The other files ({len(files) - len(missing)}) are where they should be."
        raise PlaceError("\n".join([*missing, there]))
    if lost:
        names = ", ".join(lost.values())
        raise DamagedFileError(
            f"{store.path}: expected motions, originals and scores as they were written, found "
            f"others of the captures {names}. What is damaged of them stays where it is. Of "
            f"{len(moved)} captures, all was moved. Put a copy of the damaged files in their "
            "place, or remove these captures; scores are made anew by motiondb learn."
        )
    return len(moved)


def check_place(store: Store, place: str) -> None:
    """PlaceError if a file that the database relies on is missing in the place to move to."""
    for file in parquet_files.load_parquet_files(store):
        if file.place == place:
            with told(file.path, parquet_files.advice(store, file)):
                locations.find_file(place, file.name)


def _batches(store: Store) -> Iterator[tuple[str, _Batch]]:
    """What files are to hold, and the captures whose values are in the database, file by file.

    Generated ones stay: they are few, and every question reads them.
    """
    for kind, tables in KINDS.items():
        table, (_, (column, *_)) = next(iter(tables.items()))
        query = (
            f"SELECT capture_id, sha256, motion_frames FROM capture JOIN {table} USING (capture_id)"
            f" WHERE {column}_at IS NULL AND kind = 'captured' ORDER BY capture_id"
        )
        most_frames, most_captures = _AT_MOST[kind]
        batch, n_frames = list[tuple[int, str]](), 0
        for number, sha256, length in store.connection.execute(query).fetchall():
            if batch and (n_frames + length > most_frames or len(batch) == most_captures):
                yield kind, batch
                batch, n_frames = [], 0
            batch.append((number, sha256))
            n_frames += length
        if batch:
            yield kind, batch


def _move_out(store: Store, kind: str, batch: _Batch, where: str) -> None:
    """Move values of some captures into a new Parquet file, in one transaction."""
    name = f"{kind}-{uuid.uuid4().hex}.parquet"
    with (
        _noted(store, where, name),
        _draft_beside(store) as draft,
        transaction(store) as connection,
    ):
        _write_parquet(store, kind, batch, draft)
        number = int(connection.value("SELECT coalesce(max(file_id), 0) + 1 FROM parquet_file"))
        with (
            draft.open("rb") as opened,
            mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ) as whole,
        ):
            file = ParquetFile(number, where, name, len(whole), hashlib.sha256(whole).hexdigest())
            for table in KINDS[kind]:
                _note_parts(store, table, batch, file, whole)
        connection.insert_row("parquet_file", *astuple(file))
        _put(file, draft)


@contextmanager
def _noted(store: Store, place: str, name: str) -> Iterator[None]:
    """Note a file before it is written: if a kill leaves it, it is told as one not needed."""
    path = f"{place}/{name}"
    parquet_files.note_unused(store, path)
    try:
        yield
    except BaseException:
        with suppress(Exception):  # the first error is the cause
            try:
                locations.find_file(place, name)
            except FileNotFoundError:
                parquet_files.end_note(store, path)
        raise
    parquet_files.end_note(store, path)


@contextmanager
def _draft_beside(store: Store) -> Iterator[Path]:
    """The name of a draft beside the database; one that a kill leaves goes at the next opening."""
    try:
        with free_draft(store.path) as draft:
            yield draft
    except OSError as error:
        raise StoreError(
            f"{store.path}: expected room for a draft beside it, found: {error.strerror or error}. "
            "What was moved before stays moved. Make room and run the command again."
        ) from error


def _put(file: ParquetFile, draft: Path) -> None:
    """Copy a file to its place and compare what stands there."""
    place = locations.open_place(file.place)
    try:
        with told(file.path, _ROOM):
            place.write(file.name, draft)
            found = locations.digest_of(place, file.name)
        if found != file.sha256:
            raise StoreError(
                f"{file.path}: expected the bytes that were copied there, found others. {_ROOM}"
            )
    except BaseException:
        with suppress(Exception):  # the first error is the cause
            # a whole file stays: another process may have put it there, for a copy of the database
            if locations.digest_of(place, file.name) != file.sha256:
                place.delete(file.name)
        raise


def _write_parquet(store: Store, kind: str, batch: _Batch, path: Path) -> None:
    """Write values of captures as a Parquet file, in which they stand as they are."""
    run = store.connection.execute
    if kind == SCORES:
        run("CREATE TEMP TABLE packed (capture_id BIGINT, scores BLOB)")
        packed = _load_values(store, "segment_score", "capture_id", "scores", batch)
        values = ragged(list(packed.values()))
        store.connection.insert("packed", capture_id=list(packed), scores=values)
    written = _WRITTEN[kind].format(
        numbers=_chosen(batch, "capture_id"), digests=_chosen(batch, "sha256")
    )
    run(
        f"COPY (SELECT {written} ORDER BY capture_id) TO {_quoted(path)} "
        "(FORMAT parquet, COMPRESSION uncompressed)"
    )
    run("DROP TABLE IF EXISTS packed")


def _load_values(
    store: Store, table: str, key: str, column: str, batch: _Batch
) -> dict[int | str, bytes | None]:
    """Values of a column as they stand in a Parquet file, by the key of their row."""
    query = f"SELECT {key}, {column} FROM {table} WHERE {_chosen(batch, key)}"
    if column == "scores":
        rows = store.connection.arrays(query)
        return dict(zip(rows[key].tolist(), map(pack_scores, rows[column])))
    return dict(store.connection.execute(query).fetchall())


def _quoted(path: Path) -> str:
    return "'" + str(path).replace("'", "''") + "'"


def _chosen(batch: _Batch, key: str) -> str:
    """The condition for the rows of some captures, by their number or their digest."""
    keys = (str(n) if key == "capture_id" else f"'{sha256}'" for n, sha256 in batch)
    return f"{key} IN ({', '.join(keys)})"


def _note_parts(
    store: Store, table: str, batch: _Batch, file: ParquetFile, whole: mmap.mmap
) -> None:
    """Keep where the values of captures stand in a Parquet file, in place of the values."""
    key, columns = KINDS[file.kind][table]
    keys = [sha256 if key == "sha256" else number for number, sha256 in batch]
    found = []
    for column in columns:
        values = _load_values(store, table, key, column, batch)
        found.append(_find([values[of_row] for of_row in keys], file, whole))
    rows = ", ".join(f"({of_row!r}, {', '.join(parts)})" for of_row, *parts in zip(keys, *found))
    left = ", ".join(f"{c}[1:0] AS {c}, p.{c}_at AS {c}_at" for c in columns)  # nothing of each
    _rewrite(
        store,
        table,
        key,
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


def _rewrite(store: Store, table: str, key: str, rows: str) -> None:
    """Put the rows of a query in place of those of the same keys."""
    # UPDATE would keep the replaced values in memory, and write rows beside them anew
    run = store.connection.execute
    run(f"CREATE TEMP TABLE rewritten AS {rows}")
    run(f"DELETE FROM {table} WHERE {key} IN (SELECT {key} FROM rewritten)")
    run(f"INSERT INTO {table} FROM rewritten")
    run("DROP TABLE rewritten")


def _move_file(store: Store, file: ParquetFile, where: str) -> tuple[set[int], dict[int, str]]:
    """Move what a Parquet file holds; numbers of its captures, and the damaged ones with names.

    Of a damaged file, what can be read comes into the database, from where it can be moved.
    """
    new = replace(file, place=where)
    is_there = where != IN_DATABASE and _is_copy(store, new)
    if not is_there:
        with _draft_beside(store) as draft:
            digest = _fetch(store, file, draft)
            if where == IN_DATABASE or digest != file.sha256:
                numbers, damaged = _bring_back(store, file, draft)
                return (numbers if where == IN_DATABASE else set()), damaged
            with _noted(store, new.place, new.name):
                _put(new, draft)
    with transaction(store) as connection:
        connection.execute(
            "UPDATE parquet_file SET place = ? WHERE file_id = ?", [where, file.file_id]
        )
        if is_there:  # the former path may be another name of the same file
            return set(), {}
        parquet_files.note_unused(store, file.path)
    return {number for number, *_ in parquet_files.load_captures_in(store, file)}, {}


def _bring_back(store: Store, file: ParquetFile, draft: Path) -> tuple[set[int], dict[int, str]]:
    """Move captures of a file into the database, in one transaction, from a copy of the file.

    Returns their numbers, and numbers and names of those with a damaged value, which stay.
    """
    batch, damaged = list[tuple[int, str]](), dict[int, str]()
    with transaction(store), draft.open("rb") as opened:
        for number, sha256, name, parts in parquet_files.load_captures_in(store, file):
            if all(parquet_files.is_whole(_read_value(opened, at), at) for at in parts):
                batch.append((number, sha256))
            else:
                damaged[number] = name
        if batch:
            for table in KINDS[file.kind]:
                _bring_values(store, table, batch, file, opened)
        if not damaged:
            parquet_files.forget(store, file)
    return {number for number, _ in batch}, damaged


def _bring_values(
    store: Store, table: str, batch: _Batch, file: ParquetFile, opened: BinaryIO
) -> None:
    """Put the values of captures, which an open file holds, into their rows of a table."""
    key, columns = KINDS[file.kind][table]
    run = store.connection.execute
    places = ", ".join(f"{c}_at" for c in columns)
    keys, *parts = zip(
        *run(f"SELECT {key}, {places} FROM {table} WHERE {_chosen(batch, key)}").fetchall()
    )
    run(f"CREATE TEMP TABLE back AS SELECT {key}, {', '.join(columns)} FROM {table} LIMIT 0")
    values = {
        column: ragged([at and _value(column, _read_value(opened, at)) for at in of_column])
        for column, of_column in zip(columns, parts)
    }
    store.connection.insert("back", **{key: list(keys)}, **values)
    back = ", ".join(f"coalesce(b.{c}, t.{c}) AS {c}, NULL::{_PART} AS {c}_at" for c in columns)
    _rewrite(
        store, table, key, f"SELECT t.* REPLACE ({back}) FROM {table} t JOIN back b USING ({key})"
    )
    run("DROP TABLE back")


def _value(column: str, data: bytes) -> bytes | Float32Array:
    """A value of a column as it is in the database."""
    return unpack_scores(data) if column == "scores" else data


def _read_value(opened: BinaryIO, at: Part) -> bytes:
    opened.seek(at["start"])
    return opened.read(at["n_bytes"])


def _fetch(store: Store, file: ParquetFile, draft: Path) -> str:
    """Copy a file to this machine; its digest."""
    counted, pieces = (
        hashlib.sha256(),
        locations.read_pieces(locations.open_place(file.place), file.name),
    )
    hint = parquet_files.advice(store, file)
    with draft.open("xb") as written:
        while True:
            with told(file.path, hint):  # errors of the place; the draft's are others
                piece = next(pieces, b"")
            if not piece:
                return counted.hexdigest()
            counted.update(piece)
            written.write(piece)


def _is_copy(store: Store, file: ParquetFile) -> bool:
    """Whether a file stands at its place already; one of other content is refused.

    What a killed move left there half written is deleted.
    """
    with told(file.path, _ROOM):
        try:
            found = locations.digest_of(locations.open_place(file.place), file.name)
        except FileNotFoundError:
            return False
        if found != file.sha256 and file.path in parquet_files.untold_files(store):
            locations.open_place(file.place).delete(file.name)
            return False
    if found != file.sha256:
        raise StoreError(
            f"{file.path}: expected no such file or a copy of it, found another one. {_ROOM}"
        )
    return True
