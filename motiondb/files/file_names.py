"""Whether a name that a user gave is that of a file or a folder.

``pathlib`` raises an error for a name that the system cannot have, such as one of 300 characters;
here such a name is that of no file.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path

from motiondb.errors import StoreError


def is_file(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a file of this name.

    >>> is_file("n" * 300)
    False
    """
    try:
        return Path(name).is_file()
    except OSError:
        return False


def is_folder(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a folder of this name.

    >>> is_folder("."), is_folder("n" * 300)
    (True, False)
    """
    try:
        return Path(name).is_dir()
    except OSError:
        return False


def plain_name(path: Path) -> str:
    """Return the name of a file so that DuckDB takes it for no more than that.

    DuckDB keeps a database called ``:memory:`` nowhere, and looks for one called ``md:x`` or
    ``sqlite:x`` at other programs.

    >>> plain_name(Path(":memory:")), plain_name(Path("/data/a.duckdb"))
    ('./:memory:', '/data/a.duckdb')
    """
    return os.path.join(".", path)  # noqa: PTH118  pathlib drops the dot


def check_file_name(path: Path) -> None:
    """Refuse the name of a database that the system cannot have."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        shown = os.fsencode(path).decode("utf-8", "backslashreplace")
        raise StoreError(
            f"{shown}: expected a file name in UTF-8, found other bytes. Give another name."
        ) from None
    try:
        path.exists()
        draft = f".{path.name}.new-{os.getpid()}-{threading.get_ident()}.wal"
        path.with_name(draft).exists()  # the longest name of a file made beside it
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise StoreError(
            f"{str(path)[:100]}: expected the name of a file, found: {reason}. Give another name."
        ) from None
