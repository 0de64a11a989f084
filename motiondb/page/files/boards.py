"""The user's tactics diagrams: text files in one folder, the same that the command line reads."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from motiondb.database.catalogue.parts import write_bytes
from motiondb.database.scenes.scene_texts import TACTICS, shipped, shipped_text
from motiondb.page.answers import PageError, unknown

NAME = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
"""Names of diagrams: file names that are valid on every system."""
_TITLE = re.compile(r'^\s*diagram\s+"([^"]*)"', re.MULTILINE)
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com[0-9]|lpt[0-9])")


@dataclass(frozen=True)
class BoardFile:
    """A diagram that can be opened."""

    name: str
    title: str
    shipped: bool  # Whether it comes with motiondb


def list_boards(folder: Path) -> list[BoardFile]:
    """Return the shipped diagrams and the user's, each by name."""
    known = [
        BoardFile(name, _title(shipped_text(name, TACTICS), name), True)
        for name in shipped(TACTICS)
    ]
    for path in sorted(folder.glob(f"*{TACTICS}")) if folder.is_dir() else ():
        name = path.name.removesuffix(TACTICS)
        if re.fullmatch(NAME, name) and name not in shipped(TACTICS) and _is_own(path):
            known.append(BoardFile(name, _title(_read(path), name), False))
    return known


def read_board_text(folder: Path, name: str) -> tuple[str, bool]:
    """Return the text of a diagram, and whether it is a shipped one."""
    if name in shipped(TACTICS):
        return shipped_text(name, TACTICS), True
    path = board_path(folder, name)
    if not _is_own(path):
        raise unknown("board", name)
    return _read(path), False


def save_board(folder: Path, name: str, text: str) -> None:
    """Write a diagram into the folder, which is created if it is missing."""
    path = board_path(folder, name)
    if name in shipped(TACTICS):
        raise PageError(
            f"{name}: expected another name than those of the shipped diagrams. Choose one.",
            409,
            "ConflictError",
        )
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise PageError(
            f"{folder.name}: expected a folder for boards, found: {error.strerror}."
        ) from None
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise PageError(f"{name}: expected a file, found something else. Choose another name.")
    write_bytes(path, text.encode())


def remove_board(folder: Path, name: str) -> None:
    """Delete a diagram of the user."""
    path = board_path(folder, name)
    if not _is_own(path):
        raise unknown("board", name, "Shipped ones stay.")
    path.unlink()


def board_path(folder: Path, name: str) -> Path:
    """Return the path of a diagram; a name that contains a path is refused."""
    if not re.fullmatch(NAME, name) or _RESERVED.fullmatch(name):
        raise PageError(
            f"board: expected a name of letters, digits, - and _, found {name[:100]!r}."
        )
    return folder / f"{name}{TACTICS}"


def _is_own(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8-sig", errors="replace")


def _title(text: str, name: str) -> str:
    matched = _TITLE.search(text)
    return matched[1] if matched and matched[1] else name
