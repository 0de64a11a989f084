"""The files as they were: packed on the way in (by any worker), bit for bit on the way out."""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

from motiondb.errors import QueryError, StoreError
from motiondb.store.connection.handle import Store

_LEVEL = 1
"""zlib's level: level 6 takes five times as long on captures and saves a sixth."""


@dataclass(frozen=True, eq=False)
class Source:
    """A capture file and, where it needs one, its skeleton file.

    Attributes
    ----------
    sha256 : of the file's bytes followed by the skeleton file's, hexadecimal.
    format : as in ``Clip``.
    file_name, skeleton_name : without folders; None: no skeleton file.
    data, skeleton_data : bytes, packed with zlib in the store and in :func:`pack_source`'s answer,
        plain in :func:`load_source`'s.
    """

    sha256: str
    format: str
    file_name: str
    data: bytes
    skeleton_name: str | None = None
    skeleton_data: bytes | None = None


def digest(data: bytes, skeleton_data: bytes | None = None) -> str:
    """The name of a content: sha256 of the file's bytes, then of its skeleton file's.

    >>> digest(b"walk")[:8], digest(b"wa", b"lk")[:8]
    ('7a6c4fac', '7a6c4fac')
    """
    return hashlib.sha256(data + (skeleton_data or b"")).hexdigest()


def pack_source(
    file_name: str,
    data: bytes,
    format: str,
    skeleton_name: str | None = None,
    skeleton_data: bytes | None = None,
) -> Source:
    """What ``save_capture`` takes; costs 13 ms a megabyte, so let the workers call it."""
    return Source(
        digest(data, skeleton_data),
        format,
        file_name,
        zlib.compress(data, _LEVEL),
        skeleton_name,
        None if skeleton_data is None else zlib.compress(skeleton_data, _LEVEL),
    )


def load_source(store: Store, capture_id: int) -> Source:
    """The file of a capture, unpacked, equal bit for bit to what was added.

    Raises
    ------
    QueryError : no such capture. StoreError : the bytes do not give their digest.
    """
    row = store.connection.execute(
        "SELECT sha256, s.format, file_name, data, skeleton_name, skeleton_data FROM source s "
        "JOIN capture USING (sha256) WHERE capture_id = ?",
        [capture_id],
    ).fetchone()
    if row is None:
        raise QueryError(f"capture {capture_id}: expected a capture in {store.path}, found none.")
    return unpack_source(store.path, Source(*row))


def unpack_source(path: Path, source: Source) -> Source:
    """The stored bytes as they were added.

    Parameters
    ----------
    path : Path
        The database file, for the message.
    source : Source
        As it is stored, with packed bytes.

    Raises
    ------
    StoreError
        The bytes do not give their digest.
    """
    packed = source.skeleton_data
    try:
        data = zlib.decompress(source.data)
        skeleton = None if packed is None else zlib.decompress(packed)
    except zlib.error:
        data, skeleton = b"", None
    if digest(data, skeleton) != source.sha256:
        raise StoreError(
            f"{path}: expected the bytes of {source.file_name} with digest {source.sha256[:12]}, "
            "found others. The file is damaged: restore a copy, or add the capture again."
        )
    return replace(source, data=data, skeleton_data=skeleton)
