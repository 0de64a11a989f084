"""Stored capture files: compressed when they are added, returned bit for bit."""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

from motiondb.errors import QueryError, StoreError
from motiondb.store.catalogue.parquet_files import load_part
from motiondb.store.connection.handle import Store

_LEVEL = 1
"""Compression level of zlib.

Level 6 takes five times as long on captures, and its output is a sixth smaller (measured).
"""

_WITH_TAKES = frozenset({"fbx"})  # Formats of which one file may hold several captures


@dataclass(frozen=True, eq=False)
class Source:
    """A capture file and, where it needs one, its skeleton file."""

    # Digest of the uncompressed bytes of the file followed by those of the skeleton file,
    # hexadecimal
    sha256: str
    format: str  # Format of the file, as in ``Clip``
    # Name of the file, without folders; of a format with takes, "#" and the take follow, nothing
    # after "#" for the only one
    file_name: str
    # Content of the file. It is compressed with zlib in the store and after :func:`pack_source`,
    # and uncompressed after :func:`load_source`. Nothing if it was left out (:func:`leave_out`)
    data: bytes
    # Name of the skeleton file, without folders; None: there is no skeleton file
    skeleton_name: str | None = None
    skeleton_data: bytes | None = None  # Content of the skeleton file, compressed where ``data`` is

    @property
    def own_name(self) -> str:
        """Name of the file without that of a take."""
        return self.file_name.rpartition("#")[0] if self.format in _WITH_TAKES else self.file_name

    @property
    def take(self) -> str:
        """Name of the take; "" for the only one of its file."""
        return self.file_name.rpartition("#")[2] if self.format in _WITH_TAKES else ""


def digest(data: bytes, skeleton_data: bytes | None = None, take: str = "") -> str:
    """Return the SHA-256 digest of a file's bytes followed by those of its skeleton file.

    The name of a take follows, if the file has several.

    >>> digest(b"walk")[:8], digest(b"wa", b"lk")[:8]
    ('7a6c4fac', '7a6c4fac')
    """
    return hashlib.sha256(data + (skeleton_data or b"") + take.encode()).hexdigest()


def pack_source(
    file_name: str,
    data: bytes,
    format: str,
    skeleton_name: str | None = None,
    skeleton_data: bytes | None = None,
    take: str = "",
) -> Source:
    """Compress a file for ``save_capture``: 13 ms a megabyte, for processes that read."""
    return Source(
        digest(data, skeleton_data, take),
        format,
        f"{file_name}#{take}" if format in _WITH_TAKES else file_name,
        zlib.compress(data, _LEVEL),
        skeleton_name,
        None if skeleton_data is None else zlib.compress(skeleton_data, _LEVEL),
    )


def leave_out(source: Source) -> Source:
    """A packed file without its content: names and digest alone are kept."""
    skeleton = None if source.skeleton_data is None else b""
    return replace(source, data=b"", skeleton_data=skeleton)


def load_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture, uncompressed and equal bit for bit to the file that was added."""
    source = load_packed_source(store, capture_id)
    if not source.data:
        raise QueryError(
            f"{source.file_name}: expected the file as it was added, found that it was left out "
            "(--no-originals). Export the motion on the canonical body (--canonical), or remove "
            "the capture and add its file again."
        )
    return unpack_source(store.path, source)


def load_packed_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture as it is stored, for another store."""
    query = "sha256 = (SELECT sha256 FROM capture WHERE capture_id = ?)"
    source = find_source(store, query, capture_id)
    if source is None:
        raise QueryError(f"capture {capture_id}: expected a capture in {store.path}, found none.")
    return source


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
