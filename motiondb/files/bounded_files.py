"""Reading files that a user names, which may be larger than they should be, or have no end.

A pipe is read like a file, so that a shell may put a program in place of one; so what the system
says of a file's size does not count.
"""

from __future__ import annotations

import errno
import io
from pathlib import Path

MOST_TEXT = 10_000_000
"""Bytes of a text that people write: joint maps, synonyms, diagrams, grammars. Chosen by hand: a
thousand times what such files hold."""


def read_bounded(path: Path, most: int = MOST_TEXT) -> bytes:
    """Return the content of a file that is not too large."""
    with path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"more than {most / 1e6:g} MB")
    return data


def read_bounded_text(path: Path, encoding: str = "utf-8-sig") -> str:
    r"""Return the text of a file that is not too large, with ``\n`` for every end of line."""
    return io.TextIOWrapper(io.BytesIO(read_bounded(path)), encoding).read()
