"""A capture file as it is stored: compressed, with its digest. Nothing of the store is needed here.

Processes that read files pack them, so that the one that saves them has less to do.
"""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass, replace

from motiondb.files.folder import WITH_TAKES

_LEVEL = 1
"""Compression level of zlib.

Level 6 takes five times as long on captures, and its output is a sixth smaller (measured).
"""


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
    # and uncompressed after ``load_source``. Nothing if it was left out (:func:`leave_out`)
    data: bytes
    # Name of the skeleton file, without folders; None: there is no skeleton file
    skeleton_name: str | None = None
    skeleton_data: bytes | None = None  # Content of the skeleton file, compressed where ``data`` is

    @property
    def own_name(self) -> str:
        """Name of the file without that of a take."""
        return self.file_name.rpartition("#")[0] if self.format in WITH_TAKES else self.file_name

    @property
    def take(self) -> str:
        """Name of the take; "" for the only one of its file."""
        return self.file_name.rpartition("#")[2] if self.format in WITH_TAKES else ""


def digest(data: bytes, skeleton_data: bytes | None = None, take: str = "") -> str:
    """Return the SHA-256 digest of a file's bytes followed by those of its skeleton file.

    The name of a take follows, if the file has several. Nothing lies between them, and cannot any
    more, since captures without their files keep this digest: two pairs count as one capture if
    the end of one file is moved to the beginning of the other, which no program does.

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
        f"{file_name}#{take}" if format in WITH_TAKES else file_name,
        zlib.compress(data, _LEVEL),
        skeleton_name,
        None if skeleton_data is None else zlib.compress(skeleton_data, _LEVEL),
    )


def leave_out(source: Source) -> Source:
    """A packed file without its content: names and digest alone are kept."""
    skeleton = None if source.skeleton_data is None else b""
    return replace(source, data=b"", skeleton_data=skeleton)
