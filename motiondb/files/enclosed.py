"""Files of a folder that others may fill: a link that leads out of it is refused, not read.

A path is resolved first, and then opened one folder after the other without following links. So a
link that is put in its way after it was resolved is refused too.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path

from motiondb.errors import CaptureError

_READ = os.O_RDONLY | getattr(os, "O_BINARY", 0)
_IS_LINK = (errno.ELOOP, errno.ENOTDIR)  # Errors of opening a link, as a file and as a folder


def leads_out(path: Path, folder: Path) -> bool:
    """Return whether a path leads out of a folder."""
    return not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def check_inside(path: Path, folder: Path) -> None:
    """Refuse a path that leads out of a folder (CaptureError)."""
    if leads_out(path, folder):
        raise _outside(path)


def open_inside(path: Path, folder: Path, flags: int = _READ) -> int:
    """Open a file that lies in a folder, also when links are followed, and return its descriptor.

    Raises
    ------
    CaptureError
        The path leads out of the folder.
    OSError
        There is no such file, or it cannot be read.
    """
    check_inside(path, folder)
    root, real = os.path.realpath(folder), os.path.realpath(path)
    if os.open not in os.supports_dir_fd:  # Windows
        return os.open(real, flags)
    descriptor = os.open(root, os.O_RDONLY)
    for part in Path(real).relative_to(root).parts:
        try:
            below = os.open(part, flags | os.O_NOFOLLOW, dir_fd=descriptor)
        except OSError as error:
            raise (_outside(path) if error.errno in _IS_LINK else error) from None
        finally:
            os.close(descriptor)
        descriptor = below
    return descriptor


def _outside(path: Path) -> CaptureError:
    return CaptureError(
        path,
        "expected a file inside the folder, found a link that leads out of it. Copy the file into "
        "the folder.",
    )
