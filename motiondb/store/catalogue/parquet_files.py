"""Parts of Parquet files: where a motion, an original file or scores lie that are elsewhere.

A column ``NAME_at`` holds the number of a file, first byte and length of a value in it, and the
value's CRC-32. The files are Parquet that is not compressed once more: a value stands in it as it
is, and one read of its bytes gets it. DuckDB's own ``read_parquet`` reads a row group, which has
2048 rows at least when DuckDB has written it: 44 ms for a motion, against 2 ms (measured).

The files have names that are never used again, and are never changed.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from motiondb.errors import StoreError
from motiondb.store.catalogue.places import digest_of, open_place, told
from motiondb.store.connection.faults import DamagedFileError, DamagedMotionError
from motiondb.store.connection.handle import Block, Store
from motiondb.store.connection.transactions import transaction

Part = Mapping[str, int]
"""A value of a column ``NAME_at``: file_id, start, n_bytes, crc32."""
MOTIONS, SCORES = "motions", "scores"
KINDS: Mapping[str, Mapping[str, tuple[str, tuple[str, ...]]]] = {
    MOTIONS: {
        "motion": ("capture_id", ("poses",)),
        "source": ("sha256", ("data", "skeleton_data")),
    },
    SCORES: {"segment_score": ("capture_id", ("scores",))},
}
"""What a file holds -> tables of its values -> key of the table, and its columns that are moved.

Motions never change; every ``learn`` makes other scores."""

_AHEAD = 2**23  # Bytes that are read together where parts are asked for one after the other
_BETWEEN = 4096  # At most so many bytes stand between two values of a column
_UNTOLD = "unused_parquet_files"  # Key in ``meta`` of a list in JSON


@dataclass(frozen=True)
class ParquetFile:
    """A file that holds motions and originals, or scores of segments; never changed."""

    file_id: int
    place: str  # As :func:`~motiondb.store.catalogue.places.place_name` returns it
    name: str  # Begins with what it holds
    n_bytes: int
    sha256: str

    def __post_init__(self) -> None:
        """Refuse a name that motiondb does not write, and that may lead elsewhere."""
        if not re.fullmatch(rf"({'|'.join(KINDS)})-[0-9a-f]{{32}}\.parquet", self.name):
            raise StoreError(
                f"{self.name!r}: expected a name of a Parquet file as motiondb writes it, found "
                "another. The database was changed by another program: restore a copy."
            )

    @property
    def kind(self) -> str:
        """What it holds, one of ``KINDS``."""
        return self.name.partition("-")[0]

    @property
    def path(self) -> str:
        """Path or URL of the file."""
        return f"{self.place}/{self.name}"


def load_parquet_files(store: Store) -> list[ParquetFile]:
    """Load the Parquet files that the database relies on, in order of number."""
    rows = store.connection.execute("SELECT * FROM parquet_file ORDER BY file_id").fetchall()
    return [ParquetFile(*row) for row in rows]


def check_parquet_file(store: Store, file: ParquetFile) -> None:
    """Read a file to its end; StoreError if it is missing or has another digest."""
    with told(file.path, advice(store, file)):
        found = digest_of(open_place(file.place), file.name)
    if found != file.sha256:
        raise DamagedFileError(
            f"{file.path}: expected the digest {file.sha256[:12]}, found {found[:12]}: the file is "
            f"damaged. {advice(store, file)}"
        )


def load_part(store: Store, at: Part) -> bytes:
    """Read the bytes of a part; those that follow are read with it where parts come in order."""
    number, start, stop = at["file_id"], at["start"], at["start"] + at["n_bytes"]
    block = store.local.block
    data, is_near = b"", False
    if block is not None and block.file_id == number:
        is_near = block.start <= start <= block.stop + _BETWEEN
        data = block.data[start - block.start : stop - block.start] if is_near else b""
    if not is_whole(data, at):  # it is not in the block, or that is of a former file
        file = _file_of(store, number)
        end = max(stop, min(start + _AHEAD, file.n_bytes)) if is_near else stop
        with told(file.path, advice(store, file)):
            read = open_place(file.place).read(file.name, start, end)
        store.local.block = Block(number, start, read)
        data = read[: stop - start]
        if not is_whole(data, at):
            fault = DamagedFileError if file.kind == SCORES else DamagedMotionError
            raise fault(
                f"{file.path}: expected the bytes of {_captures_at(store, file, at)} as they were "
                f"written, found others. {advice(store, file)}"
            )
    return data


def is_whole(data: bytes, at: Part) -> bool:
    """Whether bytes are the value that was written."""
    return len(data) == at["n_bytes"] and zlib.crc32(data) == at["crc32"]


def load_captures_in(
    store: Store, file: ParquetFile, start: int | None = None
) -> list[tuple[int, str, str, list[Part]]]:
    """Number, digest and name of captures of which a file has values, and where these stand.

    `start`: Only those of which a value begins there.
    """
    tables = KINDS[file.kind]
    joined = " ".join(f"JOIN {table} USING ({key})" for table, (key, _) in tables.items())
    places = [f"{column}_at" for _, columns in tables.values() for column in columns]
    rows = store.connection.execute(
        f"SELECT capture_id, sha256, name, {', '.join(places)} FROM capture {joined} WHERE "
        + " OR ".join(
            f"({at}.file_id = $file AND {at}.start = coalesce($start, {at}.start))" for at in places
        )
        + " ORDER BY capture_id",
        {"file": file.file_id, "start": start},
    ).fetchall()
    return [
        (number, sha256, name, [at for at in parts if at]) for number, sha256, name, *parts in rows
    ]


def _captures_at(store: Store, file: ParquetFile, at: Part) -> str:
    """The captures of a value, for a message."""
    names = [name for _, _, name, _ in load_captures_in(store, file, at["start"])]
    what = "the scores of " if file.kind == SCORES else ""
    return f"{what}the capture {', '.join(sorted(names)[:5])}" if names else "a removed capture"


def _file_of(store: Store, number: int) -> ParquetFile:
    query = "SELECT * FROM parquet_file WHERE file_id = ?"
    row = store.connection.execute(query, [number]).fetchone()
    if row is None:
        raise StoreError(
            f"{store.path}: expected the Parquet file {number} in the table parquet_file, "
            "found none. The database was changed by another program: restore a copy."
        )
    return ParquetFile(*row)


def advice(store: Store, file: ParquetFile) -> str:
    """What to do where a Parquet file cannot be read."""
    there = f"(motiondb compact --db {store.path} --motions-to PLACE)"
    if file.kind == SCORES:
        return (
            f"It holds scores of segments of {store.path}: put a copy there, say where it lies now "
            f"{there}, or make them anew (motiondb learn --db {store.path})."
        )
    return (
        f"It holds motions and originals of {store.path}: put a copy there, or say where it lies "
        f"now {there}."
    )


def forget_unused(store: Store, kind: str) -> None:
    """Forget the Parquet files of a kind of which nothing is needed; their paths wait to be told.

    The trash is not looked at: it must have been emptied before files of motions are forgotten.
    """
    used = " UNION ".join(
        f"SELECT {column}_at.file_id FROM {table} WHERE {column}_at IS NOT NULL"
        for table, (_, columns) in KINDS[kind].items()
        for column in columns
    )
    files = [file for file in load_parquet_files(store) if file.kind == kind]
    numbers = set(store.connection.column(used)) if files else set()
    for file in files:
        if file.file_id not in numbers:
            forget(store, file)


def forget(store: Store, file: ParquetFile) -> None:
    """Forget a file of which nothing is needed; its path waits to be told."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM parquet_file WHERE file_id = ?", [file.file_id])
        note_unused(store, file.path)


def note_unused(store: Store, path: str) -> None:
    """Keep the path of a file that is no longer relied on, until it has been told."""
    _note(store, [*untold_files(store), path])


def end_note(store: Store, path: str) -> None:
    """Take a path out of those that wait to be told: it is relied on, or not there."""
    _note(store, [each for each in untold_files(store) if each != path])


def _note(store: Store, paths: list[str]) -> None:
    with transaction(store) as connection:
        text = json.dumps(list(dict.fromkeys(paths)))
        connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", [_UNTOLD, text])


def untold_files(store: Store) -> list[str]:
    """Paths of Parquet files that the database no longer relies on, and nobody has been told."""
    noted = store.connection.value("SELECT value FROM meta WHERE key = ?", [_UNTOLD])
    used = {file.path for file in load_parquet_files(store)}
    return [path for path in json.loads(noted or "[]") if path not in used]


def forget_untold(store: Store) -> None:
    """Forget the paths of :func:`untold_files` once they have been told."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM meta WHERE key = ?", [_UNTOLD])
