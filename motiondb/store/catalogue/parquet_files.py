"""Parts of Parquet files: where a motion or an original file lies that is not in the database.

A column ``NAME_at`` holds the number of a file, first byte and length of a value in it, and the
value's CRC-32. The files are Parquet that is not compressed once more: a value stands in it as it
is, and one read of its bytes gets it. DuckDB's own ``read_parquet`` reads a row group, which has
2048 rows at least when DuckDB has written it: 44 ms for a motion, against 2 ms (measured).

The files have names that are never used again, and are never changed.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from motiondb.errors import StoreError
from motiondb.store.catalogue.places import digest_of, open_place, told
from motiondb.store.connection.faults import DamagedFileError, DamagedMotionError
from motiondb.store.connection.handle import Block, Store

Part = Mapping[str, int]
"""A value of a column ``NAME_at``: file_id, start, n_bytes, crc32."""

_AHEAD = 2**23  # Bytes that are read together where parts are asked for one after the other
_BETWEEN = 4096  # At most so many bytes stand between two values of a column


@dataclass(frozen=True)
class ParquetFile:
    """A file that holds motions and originals, never changed."""

    file_id: int
    place: str  # As :func:`~motiondb.store.catalogue.places.place_name` returns it
    name: str
    n_bytes: int
    sha256: str

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
    with told(file.path, advice(store)):
        found = digest_of(open_place(file.place), file.name)
    if found != file.sha256:
        raise DamagedFileError(
            f"{file.path}: expected the digest {file.sha256[:12]}, found {found[:12]}: the file is "
            f"damaged. {advice(store)}"
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
        with told(file.path, advice(store)):
            read = open_place(file.place).read(file.name, start, end)
        store.local.block = Block(number, start, read)
        data = read[: stop - start]
        if not is_whole(data, at):
            raise DamagedMotionError(
                f"{file.path}: expected the bytes of {_captures_at(store, at)} as they were "
                f"written, found others. {advice(store)}"
            )
    return data


def is_whole(data: bytes, at: Part) -> bool:
    """Whether bytes are the value that was written."""
    return len(data) == at["n_bytes"] and zlib.crc32(data) == at["crc32"]


def _captures_at(store: Store, at: Part) -> str:
    """The captures of a value, for a message."""
    stands = " OR ".join(
        f"({column}.file_id = $file_id AND {column}.start = $start)"
        for column in ("poses_at", "data_at", "skeleton_data_at")
    )
    names = store.connection.column(
        "SELECT name FROM capture JOIN motion USING (capture_id) JOIN source USING (sha256) "
        f"WHERE {stands} ORDER BY name LIMIT 5",
        {"file_id": at["file_id"], "start": at["start"]},
    )
    return f"the capture {', '.join(names)}" if names else "a removed capture"


def _file_of(store: Store, number: int) -> ParquetFile:
    query = "SELECT * FROM parquet_file WHERE file_id = ?"
    row = store.connection.execute(query, [number]).fetchone()
    if row is None:
        raise StoreError(
            f"{store.path}: expected the Parquet file {number} in the table parquet_file, "
            "found none. The database was changed by another program: restore a copy."
        )
    return ParquetFile(*row)


def advice(store: Store) -> str:
    """What to do where a Parquet file cannot be read."""
    return (
        f"It holds motions and originals of {store.path}: put a copy there, or say where it lies "
        f"now (motiondb compact --db {store.path} --motions-to PLACE)."
    )
