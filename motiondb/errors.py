"""The errors that motiondb raises, all subclasses of :class:`MotionDBError`.

A message reads ``where: expected X, found Y. What to do.`` The library raises; only ``cli/``
prints.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Fault:
    """What is wrong at a place of a text, from which a program may make its own sentence."""

    expected: str
    found: str
    advice: str
    line: int = 0  # From 1; 0 if it is about the whole text
    column: int = 0  # From 1; 0 for the whole line
    subject: str = ""  # The statement that it is about, as it is told
    code: str = ""  # The kind of fault, where programs tell it in another way than by its sentence
    fields: Mapping[str, str] = field(default_factory=dict)  # What the kind is about

    def __str__(self) -> str:
        """Return the sentence, without the place."""
        about = f"'{self.subject}': " if self.subject else ""
        return f"{about}expected {self.expected}, found {self.found}. {self.advice}"


class SceneError(MotionDBError):
    """A motion grammar, a tactics diagram or a scene that cannot be used.

    Parameters
    ----------
    *told : str or Fault
        The message, or the faults of a text; all are reported at once.
    where : str
        Name of the text.
    """

    def __init__(self, *told: str | Fault, where: str = "") -> None:
        self.faults = tuple(one for one in told if isinstance(one, Fault))
        lines = []
        for one in told:
            parts = (where, one.line, one.column) if isinstance(one, Fault) else (where,)
            lines.append(": ".join(filter(None, (":".join(str(p) for p in parts if p), str(one)))))
        super().__init__("\n".join(lines))


def suggestion(name: str, known: Iterable[str]) -> str:
    """Sentence that names the known names most similar to a wrong one, or "".

    >>> suggestion("wlak", ["walk", "run"])
    ' Did you mean walk?'
    >>> suggestion("xyz", ["walk", "run"])
    ''
    """
    near = [n for n in get_close_matches(name[:100], list(known), n=3, cutoff=0.6) if n != name]
    return f" Did you mean {' or '.join(near)}?" if near else ""
