"""Schemas of the catalogue."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from motiondb.page.schemas.shared_schemas import (
    CaptionFacts,
    Facts,
    SegmentFacts,
    SourceFacts,
    StretchFacts,
    WordsOverTime,
)


class DriftFacts(Facts):
    """How far the database has changed since the last learning."""

    relearn: bool
    reasons: list[str]
    words: list[str]


class AcceptsFacts(Facts):
    """What may be uploaded."""

    captures: list[str]
    skeletons: list[str]
    sheets: list[str]
    max_file_bytes: int
    max_request_bytes: int
    max_files: int


class RootFacts(Facts):
    """A folder that the user allowed."""

    root: int
    name: str


class StatusFacts(Facts):
    """The contents of the database, and what the page may do."""

    version: str
    database: str
    bytes: int
    read_only: bool
    learned: bool
    current: bool | None = Field(description="null if the database has not learned.")
    captures: int
    generated: int
    seconds: float
    performers: int
    captures_with_words: int
    copies: int
    grammars: int
    symbols: int | None
    clusters: int | None
    words: int | None
    not_yet_learned: int | None
    start: dict[str, Any] | None = Field(
        default=None, description="The start that was used for learning; absent if there was none."
    )
    revision: int
    drift: DriftFacts | None
    accepts: AcceptsFacts
    folders: list[RootFacts]
    running_jobs: int


class CaptureRow(Facts):
    """A row of the catalogue."""

    name: str
    ref: str
    kind: str
    format: str
    fps: float
    frames: int
    duration: float = Field(description="Seconds.")
    performer: str | None
    licence: str | None
    tags: dict[str, str]
    words: list[CaptionFacts]
    notes: list[str]
    learned: bool
    copies: int


class CaptureRows(Facts):
    """Rows of the catalogue."""

    total: int
    offset: int
    revision: int
    captures: list[CaptureRow]


class FacetValue(Facts):
    """A value of a column, with the filter that selects its captures."""

    value: str
    count: int
    where: str | None


class FacetFacts(Facts):
    """The values of a column or tag."""

    column: str
    label: str
    values: list[FacetValue]
    more: int
    missing: int


class FacetList(Facts):
    """The facets of the captures that a filter selects."""

    total: int
    facets: list[FacetFacts]


class RelationFacts(Facts):
    """How one capture repeats another."""

    capture: str
    kind: str
    other: str
    start: float | None = Field(description="Seconds; null: throughout.")
    end: float | None
    distance: float | None


class EventFacts(Facts):
    """An event at one moment."""

    time: float
    name: str
    joint: str | None
    other: str | None


class ActivityFacts(Facts):
    """An interval of one activity; equal numbers are the same activity."""

    activity: int
    start: float
    end: float
    words: list[str]


class CaptureFacts(Facts):
    """Everything about one capture."""

    name: str
    ref: str
    kind: str
    format: str
    fps: float
    frames: int
    duration: float
    performer: str | None
    licence: str | None
    tags: dict[str, str]
    words: list[CaptionFacts]
    notes: list[str]
    learned: bool
    copies: list[RelationFacts]
    leg_length: float
    path: str
    sha256: str
    events: list[EventFacts]
    segments: list[SegmentFacts]
    activities: list[ActivityFacts]
    recognised: list[WordsOverTime]
    sources: list[SourceFacts]
    stretches: list[StretchFacts]
    grammar: str | None
    string: list[str] | None


class WordsChanged(Facts):
    """The words of a capture after an edit."""

    capture: str
    words: list[CaptionFacts]
    counted: bool
    new_words: list[str]
    undo: int = Field(description="Edits that can be undone.")


class Undoable(Facts):
    """The number of edits that can be undone, and the capture of the next one."""

    left: int
    capture: str | None


class Undone(Facts):
    """The words of a capture after an edit was undone."""

    capture: str
    words: list[CaptionFacts]
    left: int


class Removed(Facts):
    """Captures that were removed."""

    removed: list[str]


class DuplicateGroup(Facts):
    """Captures that repeat one another."""

    keep: str
    captures: list[str]
    relations: list[RelationFacts]


class DuplicateGroups(Facts):
    """All groups of copies."""

    groups: list[DuplicateGroup]


class WordSymbol(Facts):
    """A symbol that is associated with a word."""

    symbol: int
    probability: float


class WordFacts(Facts):
    """A learned word."""

    word: str
    count: int
    symbols: list[WordSymbol]


class Vocabulary(Facts):
    """The learned words, most frequent first."""

    words: list[WordFacts]
