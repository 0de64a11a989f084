"""Answers about captures and about what was learned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from motiondb.answers.asking import WordProbability
from motiondb.answers.plain import fields_of
from motiondb.records import Caption, CaptureInfo, Event


@dataclass(frozen=True)
class ShownSegment:
    """An interval with its motion symbol."""

    symbol: int
    start: float
    end: float
    log_likelihood: float | None  # Nats per frame
    known: bool  # False: unlike all learned motion


@dataclass(frozen=True)
class SymbolSegment(ShownSegment):
    """A segment of a symbol, with its capture."""

    capture: str


@dataclass(frozen=True)
class ShownActivity:
    """An interval of one activity; equal numbers are the same activity."""

    activity: int
    start: float
    end: float
    words: tuple[str, ...]


@dataclass(frozen=True)
class ShownEvent(Event):
    """An event with its time."""

    seconds: float = 0.0


def shown_event(event: Event) -> ShownEvent:
    """Return an event with its time from the start of the capture, seconds.

    Parameters
    ----------
    event : Event
        The event.
    """
    return ShownEvent(**fields_of(event), seconds=event.seconds)


@dataclass(frozen=True, eq=False, kw_only=True)
class ListedCapture(CaptureInfo):
    """A row of the catalogue with its captions."""

    words: tuple[Caption, ...]


def listed_capture(info: CaptureInfo, captions: tuple[Caption, ...] = ()) -> ListedCapture:
    """Return a row of the catalogue with its captions.

    Parameters
    ----------
    info : CaptureInfo
        The row.
    captions : tuple of Caption
        What people wrote about the capture.
    """
    return ListedCapture(**fields_of(info), words=tuple(captions))


@dataclass(frozen=True, kw_only=True)
class AddResult:
    """What was added: the numbers of new and of known captures, and the names of the new ones."""

    kind: Literal["add"] = "add"
    added: int
    known: int
    captures: list[str]
    problems: list[str]  # A sentence per file or sheet row that could not be used
    notes: list[str]
    new_words: list[str]
    counted: int  # How many of the new captures can be searched at once
    seconds: float


@dataclass(frozen=True)
class DatabaseInfo:
    """What is in a database; what it has not learned is None."""

    database: str
    bytes: int
    captures: int
    generated: int
    seconds: float
    performers: int
    captures_with_words: int
    copies: int
    grammars: int
    learned: bool
    symbols: int | None = None
    clusters: int | None = None
    words: int | None = None
    current: bool | None = None
    not_yet_learned: int | None = None
    start: dict[str, Any] | None = None  # The start that was used for learning


@dataclass(frozen=True)
class SymbolRow:
    """A motion symbol, with its most probable words."""

    symbol: int
    cluster: int
    count: int
    captures: int
    seconds: float  # Mean length of its segments
    words: tuple[WordProbability, ...]


@dataclass(frozen=True)
class SymbolProbability:
    """A symbol that is associated with a word."""

    symbol: int
    probability: float


@dataclass(frozen=True)
class WordRow:
    """A learned word, with its captions and its most probable symbols."""

    word: str
    count: int
    symbols: tuple[SymbolProbability, ...]
