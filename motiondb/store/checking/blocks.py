"""Compare every block of the file with its checksum, without DuckDB.

DuckDB looks at a block's checksum when it reads the block. Some it reads only for some questions
(indexes) or only for changes, so that queries alone do not find all damage. The file is laid out as
follows (DuckDB storage versions 64 and later; ``src/storage/single_file_block_manager.cpp``)::

    0, 4096, 8192   three headers of 4096 bytes; of the last two, the newer one counts
    12288 + n size  block n

Each begins with a checksum of 8 bytes: 5381, combined by exclusive or with every further word of 8
bytes times 0xbf58476d1ce4e5b9, modulo 2^64. A header holds after it, as words: the iteration, the
pointer to the tables, the pointer to the list of free blocks, the number of blocks, their size.
Free blocks may hold anything. A pointer is a block's number and, in the highest 8 bits, which of
its 64 parts; a part begins with the pointer to the next one.

A file must not be read so by a process that has it open in DuckDB: closing it would drop the lock
that keeps other processes away (POSIX, ``fcntl``). :mod:`motiondb.store.checking.beside` does it in
another process.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

_HEADER_SIZE = 4096  # Bytes of a header. This and the following are of DuckDB's format of files
_BLOCKS_START = 3 * _HEADER_SIZE  # Byte at which the blocks begin: after three headers
_PARTS = 64  # Parts of a block of metadata
_NO_POINTER = 2**64 - 1  # Pointer of the last block of a chain
_FACTOR = np.uint64(0xBF58476D1CE4E5B9)
_START = 5381  # Factor and initial value of DuckDB's checksum
_LARGEST_BLOCK = 2**24
"""Bytes; DuckDB's blocks are 262,144 by default. More is not believed of a header."""


@dataclass(frozen=True)
class FileLayout:
    """The contents of the valid header."""

    iteration: int  # Rises with every checkpoint
    free_list: int  # Pointer to the list of free blocks
    n_blocks: int  # Blocks of the file, free ones included
    block_size: int


def find_damage(path: Path) -> str | None:
    """Say which blocks of a database file are damaged, or None if none is."""
    with path.open("rb") as file:
        while True:
            layout = _read_layout(file)
            if layout is None:
                return None
            damaged = _damaged_blocks(file, layout)
            if not damaged:
                return None
            again = _read_layout(file)
            if again is not None and again.iteration == layout.iteration:
                break  # else a checkpoint came in between
    shown = ", ".join(str(block) for block in damaged[:8])
    more = ", ..." if len(damaged) > 8 else ""
    return f"{len(damaged)} damaged of {layout.n_blocks} blocks ({shown}{more})."


def checksum(data: bytes) -> int:
    """DuckDB's checksum of a multiple of 8 bytes.

    >>> checksum(bytes(16))
    5381
    """
    words = np.frombuffer(data, dtype="<u8")
    return int(np.bitwise_xor.reduce(words * _FACTOR)) ^ _START


def _read_layout(file: BinaryIO) -> FileLayout | None:
    """The layout by the header that holds; None if neither can be believed."""
    layouts = []
    for number in (1, 2):
        file.seek(number * _HEADER_SIZE)
        header = file.read(_HEADER_SIZE)
        if len(header) == _HEADER_SIZE and _is_whole(header):
            iteration, _tables, free_list, n_blocks, size = struct.unpack_from("<5Q", header, 8)
            layouts.append(FileLayout(iteration, free_list, n_blocks, size))
    newest = max(layouts, key=lambda layout: layout.iteration, default=None)
    if newest is None or not _HEADER_SIZE < newest.block_size <= _LARGEST_BLOCK:
        return None
    return newest


def _damaged_blocks(file: BinaryIO, layout: FileLayout) -> list[int]:
    free = _free_blocks(file, layout)
    return [
        number
        for number in range(layout.n_blocks)
        if number not in free and not _is_whole(_read_block(file, layout, number))
    ]


def _free_blocks(file: BinaryIO, layout: FileLayout) -> set[int]:
    """Numbers of the free blocks; none if their list is damaged."""
    size = (layout.block_size - 8) // _PARTS // 8 * 8
    data, pointer = b"", layout.free_list
    seen: set[int] = set()
    while pointer != _NO_POINTER and pointer not in seen:
        seen.add(pointer)
        block = _read_block(file, layout, pointer & (2**56 - 1))
        if not _is_whole(block):
            return set()
        start = 8 + (pointer >> 56) * size
        (pointer,) = struct.unpack_from("<Q", block, start)
        data += block[start + 8 : start + size]
    count = struct.unpack_from("<Q", data)[0] if data else 0
    if 8 * (count + 1) > len(data):
        return set()
    return set(struct.unpack_from(f"<{count}Q", data, 8))


def _read_block(file: BinaryIO, layout: FileLayout, number: int) -> bytes:
    file.seek(_BLOCKS_START + number * layout.block_size)
    return file.read(layout.block_size)


def _is_whole(data: bytes) -> bool:
    """Whether bytes begin with the checksum of the rest."""
    return (
        len(data) > 8
        and len(data) % 8 == 0
        and struct.unpack_from("<Q", data)[0] == checksum(data[8:])
    )
