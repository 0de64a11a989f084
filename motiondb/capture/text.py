"""Text captures as clean bytes, and blocks of numbers with the line of every fault.

A text capture may come with a byte order mark, as UTF-16, with CRLF or bare CR line ends. The
readers see UTF-8 or Latin-1 bytes with ``\\n`` (a ``\\r`` before it counts as white space).
"""

from __future__ import annotations

import re

import numpy as np

from motiondb.errors import CaptureError
from motiondb.records import FloatArray, IntArray

Faults = list[tuple[int | None, str]]

MAX_FAULTS = 20
"""So many faults of one kind are listed; the rest are counted."""
CUT_SHORT = (
    "The file may be cut short: export it again, or pass --skip-bad-frames to leave this frame out."
)


def clean_bytes(data: bytes, path: object) -> bytes:
    """The bytes of a text file without byte order mark, as an ASCII-compatible encoding.

    Raises
    ------
    CaptureError
        for an empty file, or one that is not text.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = data.decode("utf-16", errors="replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf")
    if not data.strip():
        raise CaptureError(path, "expected a capture, found an empty file. Export it again.")
    if b"\0" in data:
        raise CaptureError(
            path, "expected text, found binary data. Check the file's ending, or export it as text."
        )
    return data if b"\n" in data else data.replace(b"\r", b"\n")


def decode(data: bytes) -> str:
    """Text of cleaned bytes: UTF-8, or Latin-1 where that fails."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def line_number(data: bytes, offset: int) -> int:
    """The number, from 1, of the line that holds a byte offset.

    >>> line_number(b"a\\nb\\nc", 4)
    3
    """
    return data.count(b"\n", 0, offset) + 1


def count_values(block: bytes) -> tuple[IntArray, IntArray]:
    """How many values stand on each line that has any.

    Returns
    -------
    lines : array (rows,), line number within the block, from 0.
    counts : array (rows,).
    """
    characters = np.frombuffer(block, np.uint8)
    starts = characters > 32
    starts[1:] &= characters[:-1] <= 32
    ends = np.append(np.flatnonzero(characters == 10), len(characters) - 1)
    totals = np.cumsum(starts, dtype=np.int64)
    counts = np.diff(totals[ends], prepend=0) if len(characters) else np.zeros(0, np.int64)
    lines = np.flatnonzero(counts)
    return lines, counts[lines]


def read_number_block(
    block: bytes, first_line: int, width: int, expected: str, skip_bad: bool
) -> tuple[FloatArray, Faults]:
    """A table of numbers, a frame a line.

    A frame may also be wrapped over several lines, when no line is longer than a frame and the
    total is right.

    Parameters
    ----------
    block : the lines.
    first_line : number of the block's first line in the file, for messages.
    width : values in a frame.
    expected : how a message says it, such as "63 values (6 for the root, 57 for 19 joints)".
    skip_bad : leave frames with a fault out.

    Returns
    -------
    table : array (frames, width); only good frames.
    faults : one for every bad frame.
    """
    lines, counts = count_values(block)
    good = counts == width
    total = int(counts.sum())
    if not good.all() and len(lines) > total / max(width, 1) and total % max(width, 1) == 0:
        table = _floats(block.split())
        wrapped = counts.max() <= width and not skip_bad
        if wrapped and table is not None and np.isfinite(table).all():
            return table.reshape(-1, width), []
    if good.all():
        table = _floats(block.split())
        if table is not None and np.isfinite(table).all():
            return table.reshape(-1, width), []
    rows, faults = [], []
    text_lines = block.split(b"\n")
    for line, count in zip(lines.tolist(), counts.tolist()):
        row, fault = _read_row(text_lines[line], count, width, expected)
        rows.append(row)
        if fault:
            faults.append((first_line + line, fault))
    kept = [row for row in rows if row is not None]
    return np.array(kept, dtype=float).reshape(-1, width), faults


def shorten(faults: Faults) -> Faults:
    """The first ``MAX_FAULTS`` faults, and how many more there are."""
    if len(faults) <= MAX_FAULTS:
        return faults
    more = len(faults) - MAX_FAULTS
    return [*faults[:MAX_FAULTS], (None, f"... and {more} more faults like these.")]


def number(token: str) -> float | None:
    """A finite number, or None.

    >>> number("-1.5e-3"), number("nan"), number("1_0")
    (-0.0015, None, None)
    """
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", token):
        return None
    value = float(token)
    return value if np.isfinite(value) else None


def _read_row(
    line: bytes, count: int, width: int, expected: str
) -> tuple[list[float] | None, str | None]:
    if count != width:
        return None, f"expected {expected}, found {count}. {CUT_SHORT}"
    tokens = decode(line).split()
    values = [number(token) for token in tokens]
    for place, (token, value) in enumerate(zip(tokens, values)):
        if value is None:
            found = f"expected numbers, found {token[:20]!r} as value {place + 1}"
            return None, f"{found}. Mend the line, or pass --skip-bad-frames to leave it out."
    return [value for value in values if value is not None], None


def _floats(tokens: list[bytes]) -> FloatArray | None:
    try:
        return np.array(tokens, dtype=float)
    except ValueError:
        return None
