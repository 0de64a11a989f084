"""The errors that motiondb raises, all subclasses of :class:`MotionDBError`.

A message reads ``where: expected X, found Y. What to do.`` The library raises; only ``cli/``
prints.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

_LONG_WORD = re.compile(r"(\S{200})\S{800,}")


class MotionDBError(Exception):
    """Base class of all errors; messages say what was expected and found, and what to do.

    Parameters
    ----------
    message : str
        Of words of 1,000 characters and more, only the beginning is said.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(_LONG_WORD.sub(r"\1...", message))


class CaptureError(MotionDBError):
    """A capture file that cannot be read or written.

    Parameters
    ----------
    path : object
        The file, as the user named it.
    faults : iterable of (int or None, str), or str
        Line and sentence of every structural fault; all are reported at once.
    """

    def __init__(self, path: object, faults: Iterable[tuple[int | None, str]] | str) -> None:
        pairs = [(None, faults)] if isinstance(faults, str) else list(faults)
        self.path = str(path)
        self.faults = pairs
        lines = [f"{path}:{n}: {text}" if n is not None else f"{path}: {text}" for n, text in pairs]
        super().__init__("\n".join(lines))


class NoBodyError(CaptureError):
    """Markers that are not those of a whole body; they can be kept as markers."""


class SkeletonError(MotionDBError):
    """A skeleton whose joints cannot be matched with the canonical body."""


class ImplausibleError(MotionDBError):
    """A capture whose motion no person can do."""


class SheetError(MotionDBError):
    """A sheet of words that cannot be read."""


class KnowledgeError(MotionDBError):
    """A file of knowledge that cannot be read, written or used."""


class StoreError(MotionDBError):
    """A database file that cannot be opened, read or written."""


class HeldError(StoreError):
    """A database file that another process holds; later it may be free."""


class NotLearnedError(MotionDBError):
    """A question that needs the learned model, before ``learn`` was run."""


class QueryError(MotionDBError):
    """A question that cannot be answered as asked (unknown name, empty query, bad filter)."""


class UnknownWordsError(QueryError):
    """A question whose words no caption of the database holds."""


class ClusterError(MotionDBError):
    """A cluster that cannot be reached or used, or that went away."""


class SceneError(MotionDBError):
    """A motion grammar, a tactics diagram or a scene that cannot be used."""


def suggestion(name: str, known: Iterable[str]) -> str:
    """Sentence that names the known names most similar to a wrong one, or "".

    >>> suggestion("wlak", ["walk", "run"])
    ' Did you mean walk?'
    >>> suggestion("xyz", ["walk", "run"])
    ''
    """
    near = get_close_matches(name[:100], list(known), n=3, cutoff=0.6)
    return f" Did you mean {' or '.join(near)}?" if near else ""
