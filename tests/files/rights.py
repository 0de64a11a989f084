"""What an administrator may do without the rights to a file, taken away for a while."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from functools import partial
from unittest import mock

_OVERRIDE = 0b110  # CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH


@contextlib.contextmanager
def as_others() -> Iterator[bool]:
    """Let this thread open only what its rights allow; False: the system does not provide it."""
    is_root = os.name == "posix" and os.geteuid() == 0
    if not is_root:
        yield os.name == "posix"
        return
    if sys.platform != "linux" or not _override(False):
        yield False
        return
    asked = partial(os.access, effective_ids=True)  # usually it asks what else this user may do
    try:
        with mock.patch.object(os, "access", asked):
            yield True
    finally:
        _override(True)


def _override(may: bool) -> bool:
    """Take what is effective of the capabilities, or give it back; whether the system knows how."""
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    head, sets = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
    libc.capget(head, sets)  # what is effective, permitted, inherited
    sets[0] = sets[0] | (sets[1] & _OVERRIDE) if may else sets[0] & ~_OVERRIDE
    return int(libc.capset(head, sets)) == 0
