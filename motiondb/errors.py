"""The errors that motiondb raises, all children of :class:`MotionDBError`.

A message reads ``where: expected X, found Y. What to do.`` The library raises; only ``cli/``
prints.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class MotionDBError(Exception):
    """Anything that motiondb refuses, said in a sentence that the user can act on."""


class CaptureError(MotionDBError):
    """A capture file that cannot be read or written.

    Parameters
    ----------
    path : the file, as the user named it.
    faults : every structural fault found, as (line or None, sentence); all are reported at once.
    """

    def __init__(self, path: object, faults: Iterable[tuple[int | None, str]] | str) -> None:
        pairs = [(None, faults)] if isinstance(faults, str) else list(faults)
        self.path = str(path)
        self.faults = pairs
        lines = [f"{path}:{n}: {text}" if n is not None else f"{path}: {text}" for n, text in pairs]
        super().__init__("\n".join(lines))


class SkeletonError(MotionDBError):
    """A skeleton whose joints cannot be matched with the canonical body."""


class ImplausibleError(MotionDBError):
    """A capture whose motion no person can do."""


class SheetError(MotionDBError):
    """A sheet of words that cannot be read."""


class StoreError(MotionDBError):
    """A database file that cannot be opened, read or written."""


class NotLearnedError(MotionDBError):
    """A question that needs ``learn`` to have run first."""


class QueryError(MotionDBError):
    """A question that cannot be answered as asked (unknown name, empty query, bad filter)."""


class SceneError(MotionDBError):
    """A motion grammar, a tactics diagram or a scene that cannot be used."""


def suggestion(name: str, known: Iterable[str]) -> str:
    """Say which known names are near a wrong one, or nothing.

    >>> suggestion("wlak", ["walk", "run"])
    ' Did you mean walk?'
    >>> suggestion("xyz", ["walk", "run"])
    ''
    """
    near = get_close_matches(name[:100], list(known), n=3, cutoff=0.6)
    return f" Did you mean {' or '.join(near)}?" if near else ""
