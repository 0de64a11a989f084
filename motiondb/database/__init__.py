"""The public operations: each loads from the store, computes with the pure packages, and saves.

========================  ===================================================================
``session``               the open store and the only cache, keyed by the store's revision
``learn``                 learn, drift; counts updated when captures and words change
``catalogue``             captures, words and events, in and out
``generate``              motion from a sentence, its files, generated captures that are kept
``ask``                   search, like, describe, facts and pictures
``grammars``, ``scenes``  the operations on grammars and scenes
``motion_db``             the class :class:`MotionDB`
========================  ===================================================================
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.database.motion_db import MotionDB

__all__ = ["MotionDB"]


def __getattr__(name: str) -> object:
    """Import the class when it is asked for: `check` works without it, three times as fast."""
    if name != "MotionDB":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from motiondb.database.motion_db import MotionDB

    return MotionDB
