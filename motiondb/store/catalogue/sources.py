"""Stored capture files, returned bit for bit."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from motiondb.errors import QueryError, StoreError
from motiondb.files.packed_files import Source, digest
from motiondb.store.catalogue.parquet_files import load_part
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction

_AT_ONCE = 1000  # DuckDB finds so many rows by their index


def load_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture, uncompressed and equal bit for bit to the file that was added."""
    source = load_packed_source(store, capture_id)
    if not source.data:
        raise QueryError(
            f"{source.file_name}: expected the file as it was added, found that it was left out "
            "(--no-originals). Export the motion on the canonical body (--canonical), or add its "
            "file again."
        )
    return unpack_source(store.path, source)


def load_packed_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture as it is stored, for another store."""
    query = "sha256 = (SELECT sha256 FROM capture WHERE capture_id = ?)"
    source = find_source(store, query, capture_id)
    if source is None:
        raise QueryError(f"capture {capture_id}: expected a capture in {store.path}, found none.")
    return source


def load_left_out(store: Store, digests: Sequence[str]) -> set[str]:
    """Those of some digests whose files are without their bytes."""
    found = set[str]()
    for first in range(0, len(digests), _AT_ONCE):
        some = digests[first : first + _AT_ONCE]
        query = (
            f"SELECT sha256 FROM source WHERE sha256 IN ({', '.join('?' * len(some))}) "
            "AND octet_length(data) = 0 AND data_at IS NULL"
        )
        found |= set(store.connection.column(query, some))
    return found


def fill_in(store: Store, source: Source) -> None:
    """Keep the bytes of a file that was left out."""
    with transaction(store) as connection:
        connection.execute(
            "UPDATE source SET file_name = ?, skeleton_name = ?, data = ?, skeleton_data = ? "
            "WHERE sha256 = ?",
            [
                source.file_name,
                source.skeleton_name,
                source.data,
                source.skeleton_data,
                source.sha256,
            ],
        )


def find_source(store: Store, condition: str, value: object) -> Source | None:
    """The file whose row satisfies a condition with one parameter, as it is stored, or None."""
    query = f"SELECT * FROM source WHERE {condition}"  # a damaged older file has fewer columns
    row = store.connection.execute(query, [value]).fetchone()
    if row is None:
        return None
    sha256, kind, file_name, skeleton_name, data, skeleton, *rest = row
    data_at, skeleton_at = rest or (None, None)
    return Source(
        sha256,
        kind,
        file_name,
        data if data_at is None else load_part(store, data_at),
        skeleton_name,
        skeleton if skeleton_at is None else load_part(store, skeleton_at),
    )


def unpack_source(path: Path, source: Source) -> Source:
    """Decompress the stored bytes of a file and check their digest."""
    packed = source.skeleton_data
    try:
        data = zlib.decompress(source.data)
        skeleton = None if packed is None else zlib.decompress(packed)
    except zlib.error:
        data, skeleton = b"", None
    if digest(data, skeleton, source.take) != source.sha256:
        raise StoreError(
            f"{path}: expected the bytes of {source.file_name} with digest {source.sha256[:12]}, "
            "found others. The file is damaged: restore a copy, or add the capture again."
        )
    return replace(source, data=data, skeleton_data=skeleton)
