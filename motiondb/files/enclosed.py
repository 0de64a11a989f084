"""Files of a folder that others may fill: a link that leads out of it is refused, not read.

A path is resolved first, and then opened one folder after the other without following links. So a
link that is put in its way after it was resolved is refused too.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path

from motiondb.errors import CaptureError

_IS_LINK = (errno.ELOOP, errno.ENOTDIR)  # Errors of opening a link, as a file and as a folder


def leads_out(path: Path, folder: Path) -> bool:
    """Return whether a path leads out of a folder."""
    return not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def open_inside(path: Path, folder: Path) -> int:
    """Open a file that lies in a folder, also when links are followed, and return its descriptor.

    A pipe is not waited for: the caller must look at what was opened.

    Raises
    ------
    CaptureError
        The path leads out of the folder.
    OSError
        There is no such file, or it cannot be read.
    """
    root = os.path.realpath(folder)
    real = Path(os.path.realpath(path, strict=True))
    if not real.is_relative_to(root):
        raise _outside(path)
    no_link = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    if os.open not in os.supports_dir_fd:  # Windows
        return os.open(real, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    descriptor = os.open(root, os.O_RDONLY)
    for part in real.relative_to(root).parts:
        try:
            below = os.open(part, os.O_RDONLY | no_link, dir_fd=descriptor)
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
