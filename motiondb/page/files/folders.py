"""Folders on the server's computer from which captures may be added.

The user names them when the page is started. A path in a request is relative to one of them; links
that lead out of it are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motiondb.page.answers import PageError, unknown
from motiondb.page.settings import upload_kind

MOST_ENTRIES = 2000  # Largest number of entries of a folder that are listed


def allowed_path(roots: Sequence[Path], root: int, path: str) -> Path:
    """Return a path below one of the allowed folders."""
    if not 0 <= root < len(roots):
        raise PageError(
            "folder: expected one of the folders that the page was started with, found another."
            " Start motiondb serve with --folder FOLDER.",
            403,
            "FolderError",
        )
    base = roots[root].resolve()
    parts = [part for part in path.split("/") if part not in ("", ".")]
    try:
        allowed = base.joinpath(*parts).resolve()
        inside = allowed.is_relative_to(base) and ".." not in parts and allowed.exists()
    except (OSError, ValueError):  # a loop of links, or characters that no path may have
        inside = False
    if not inside:
        raise unknown("folder", path, "Choose one that is listed.")
    return allowed


def list_folder(roots: Sequence[Path], root: int, path: str) -> dict[str, Any]:
    """Return the folders, the number of captures and the sheets in an allowed folder."""
    folder = allowed_path(roots, root, path)
    if not folder.is_dir():
        raise unknown("folder", path, "Choose one that is listed.")
    names: dict[str, list[str]] = {"folder": [], "capture": [], "skeleton": [], "sheet": []}
    try:
        for entry in sorted(folder.iterdir())[:MOST_ENTRIES]:
            kind = "folder" if entry.is_dir() else upload_kind(entry.name)
            if kind and not entry.name.startswith(".") and not entry.is_symlink():
                names[kind].append(entry.name)
    except OSError as error:
        raise PageError(
            f"folder: expected one that can be read, found: {error.strerror}."
        ) from None
    return {
        "root": root,
        "path": path,
        "folders": names["folder"],
        "captures": len(names["capture"]),
        "sheets": names["sheet"],
    }
