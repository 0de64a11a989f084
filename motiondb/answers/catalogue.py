"""Answers about captures and about what was learned."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from motiondb.answers.learning import StartAnswer
from motiondb.answers.plain import OPTIONAL, SPREAD, extended
from motiondb.learn.drift import Drift
from motiondb.records import Caption, CaptureInfo, DuplicateGroup, Event, Fit, Relation


@dataclass(frozen=True)
class WordProbability:
    """A word with its probability."""

    word: str
    probability: float


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
    return extended(ShownEvent, event, seconds=event.seconds)


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
    return extended(ListedCapture, info, words=tuple(captions))


@dataclass(frozen=True, kw_only=True)
class CaptureFacts:
    """The facts of a capture as text shows them: captions, copies and sources are sentences."""

    capture: str
    kind: str
    format: str
    seconds: float
    fps: float
    frames: int
    leg_length: str
    path: str
    sha256: str
    tags: dict[str, str] = field(metadata=SPREAD)
    words: list[str]
    events: dict[str, int]  # Number of each kind
    copies: list[str]
    notes: list[str]
    segments: list[ShownSegment]
    sources: list[str] | None = field(default=None, metadata=OPTIONAL)  # Of a generated capture
    grammar: str | None = field(default=None, metadata=OPTIONAL)
    string: str | None = field(default=None, metadata=OPTIONAL)  # What the grammar derived
    activities: list[ShownActivity]
    png: Path | None = field(default=None, metadata=OPTIONAL)
    gif: Path | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class AddReport:
    """The result of ``add``."""

    added: tuple[str, ...]  # Names of new captures
    # Name, and name in the database, of files whose content was there already
    known: tuple[tuple[str, str], ...]
    problems: tuple[str, ...]  # A sentence per file or sheet row that could not be used
    relations: tuple[Relation, ...]  # Copies, mirror images and cuts that were found
    notes: tuple[str, ...]  # What was unusual but used
    seconds: float
    # How many of ``added`` can be searched at once, because the database had learned
    counted: int = 0
    # Words of their captions that the vocabulary lacks; the next ``learn`` counts them
    new_words: tuple[str, ...] = ()
    events: int = 0  # Number of events saved with ``added``
    without_performer: int = 0  # Number of captures of ``added`` whose performer is not given
    replaced: tuple[str, ...] = ()  # Those of ``added`` that took the place of another capture


@dataclass(frozen=True)
class MergeReport:
    """The result of ``merge``."""

    added: tuple[str, ...]  # Names of new captures
    # Name there, and name here, of captures that are in both databases
    known: tuple[tuple[str, str], ...]
    changed: tuple[str, ...]  # Those of ``known`` that got captions, tags or events
    problems: tuple[str, ...]  # A sentence per capture that was left out
    relations: tuple[Relation, ...]  # Copies, mirror images and cuts that were found
    notes: tuple[str, ...]  # Tags with other values, and what is not taken over
    counted: int = 0  # How many captures were counted, because the database had learned
    new_words: tuple[str, ...] = ()  # That the vocabulary lacks; the next ``learn`` counts them


@dataclass(frozen=True)
class BackedUp:
    """A copy of a database that was written and checked."""

    output: Path
    bytes: int


@dataclass(frozen=True, kw_only=True)
class AddAnswer(AddReport):
    """The result of ``add``, and the state of the database after it."""

    captures: int
    drift: Drift | None


@dataclass(frozen=True)
class Exported:
    """A capture that was written to a file."""

    capture: str
    output: Path
    fps: float  # Frames per second of the file
    frames: int
    unit: str  # Length unit of the file: "m", "cm", ..., or its metres
    is_added_file: bool  # Whether the bytes are those of the file that was added
    changes: tuple[str, ...] = ()  # What was done to the motion
    skeleton: Path | None = field(default=None, metadata=OPTIONAL)  # The ASF beside an AMC
    fit: Fit | None = field(default=None, metadata=OPTIONAL)  # How well a rig follows the motion


@dataclass(frozen=True)
class Removed:
    """What was removed, and what that means for others."""

    removed: str | list[str]
    captures: list[str] | None = field(default=None, metadata=OPTIONAL)  # Of a scene
    # Sequences of a grammar
    no_longer_editable: list[str] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class Renamed:
    """The captures that were renamed: old name -> new name."""

    renamed: dict[str, str]


@dataclass(frozen=True)
class Undone:
    """What was taken back, by names of captures."""

    run: int  # The run that took it back; undoing this run does it again
    undone_run: int
    kind: str  # Of the run that was undone, such as "remove"
    restored: tuple[str, ...]
    removed: tuple[str, ...]
    changed: tuple[str, ...]  # Names, tags, captions or events are as they were


@dataclass(frozen=True)
class TagsSet:
    """The captures whose tags have changed."""

    tags: dict[str, str]
    captures: list[str]


@dataclass(frozen=True)
class TagRow:
    """A tag, with its number of captures and of different values."""

    tag: str
    captures: int
    values: int


@dataclass(frozen=True)
class CaptionVersion:
    """The captions that a capture had from a run on."""

    run: int
    kind: str  # Of the run that set them, such as "words"
    time: str  # Start of the run, ISO 8601, UTC
    words: tuple[Caption, ...]


@dataclass(frozen=True)
class SheetWritten:
    """A sheet of captions and tags that was written."""

    output: Path
    captures: int
    captions: int
    notes: tuple[str, ...]  # What the sheet cannot hold


@dataclass(frozen=True)
class FaultyFile:
    """A file that could not be read when it was added."""

    path: str
    problem: str
    noted: str  # Time, ISO 8601, UTC


@dataclass(frozen=True)
class SameFile:
    """A file that has the content of a capture of another name."""

    path: str
    capture: str


@dataclass(frozen=True)
class Duplicates:
    """Captures that repeat one another, and files that were the same as a capture."""

    groups: tuple[DuplicateGroup, ...]
    same_files: tuple[SameFile, ...]


@dataclass(frozen=True)
class MatchFile:
    """A match that was written as a motion, and the file beside it with its origin."""

    rank: int
    capture: str
    output: Path
    provenance: Path
    licence: str


@dataclass(frozen=True)
class CaptionsSet:
    """The captions of a capture after a change."""

    capture: str
    words: list[str]
    counted: bool
    new_words: list[str]


@dataclass(frozen=True)
class EventRow:
    """A kind of event, with its number of events and of captures that have it."""

    event: str
    count: int
    captures: int


@dataclass(frozen=True)
class Faults:
    """The faults of a database."""

    faults: list[str]


@dataclass(frozen=True)
class Compacted:
    """The size of a database file, bytes, and what became of motions and original files."""

    before: int
    after: int
    moved: int  # Captures whose motions and original files were moved
    unused: tuple[str, ...]  # Parquet files that this database no longer relies on


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
    cache_bytes: int = 0  # Of the folder beside it, which is made again when it is missing
    parquet_bytes: int | None = None  # Of Parquet files that hold motions and original files
    motions_at: list[str] | None = None  # Folders and URLs of these
    unused_bytes: int = 0  # Of the file; ``compact`` gives them back
    removed: int = 0  # Captures in the trash, which ``compact`` empties
    compact_pays: bool = False  # Whether a quarter of the file is unused, or more
    faulty_files: int = 0  # That ``add`` could not read
    symbols: int | None = None
    clusters: int | None = None
    words: int | None = None
    current: bool | None = None
    not_yet_learned: int | None = None
    start: StartAnswer | None = None  # The start that was used for learning


@dataclass(frozen=True, kw_only=True)
class InfoAnswer(DatabaseInfo):
    """What is in a database, how far it has changed since it learned, and its runs."""

    drift: Drift | None
    runs: list[dict[str, Any]]


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
