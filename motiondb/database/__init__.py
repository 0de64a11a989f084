"""The public operations: each loads from the store, computes with the pure packages, and saves.

=====================================  ============================================================
``motion_db``                          the class :class:`MotionDB`: ask, learn, generate
``captures``, ``words``, ``symbols``   its topics: the catalogue, captions, what was learned
``searching``, ``showing``             questions; facts and pictures of captures and symbols
``library``                            what to train on, what lacks, what another library has
``generating``, ``generated_files``    motion from a sentence; its files and its origin
``learn``, ``catalogue``               the steps of learning, and of adding captures and words
``grammars``, ``scenes``               the operations on grammars and scenes
``session``                            the open store and the only cache, by the store's revision
=====================================  ============================================================
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
