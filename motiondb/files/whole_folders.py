"""Folders that are written whole: under another name, which they lose when they are complete."""

from __future__ import annotations

import glob
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from motiondb.errors import MotionDBError
from motiondb.files.safe_files import is_running, link_target


def unwritable(folder: Path, error: OSError) -> MotionDBError:
    """The error for a folder that the system does not let be written."""
    return MotionDBError(
        f"{folder}: expected a folder that can be written, found: {error.strerror or error}."
        " Check its permissions and the room on its disk."
    )


def _mend(folder: Path) -> None:
    """Repair the state that killed processes left while they wrote this folder.

    An earlier folder that had been moved away is restored; partial folders are removed.
    """
    for left in folder.parent.glob(f".{glob.escape(folder.name)}.*.*"):
        owner, _, kind = left.name.removeprefix(f".{folder.name}.").rpartition(".")
        if kind not in ("part", "old") or not owner.isdigit() or is_running(int(owner)):
            continue
        if kind == "old" and not folder.exists():
            left.rename(folder)
        else:
            shutil.rmtree(left, ignore_errors=True)


@contextmanager
def whole_folder(folder: Path, check: Callable[[Path], None]) -> Iterator[Path]:
    """Give a folder to write into; rename it to ``folder`` on success, remove it otherwise.

    A link stays: the folder that it stands for is replaced. What a killed process left of it is
    removed first. `check`: Raises where the folder may not be replaced.
    """
    folder = link_target(folder)
    _mend(folder.absolute())
    check(folder)
    folder = folder.absolute()
    part = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    old = folder.with_name(f".{folder.name}.{os.getpid()}.old")
    try:
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        yield part
        if folder.exists():
            folder.rename(old)
        try:
            part.rename(folder)
        except OSError:
            if old.exists():
                old.rename(folder)
            raise
    except OSError as error:
        raise unwritable(folder, error) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
