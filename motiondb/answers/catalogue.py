"""Answers about captures: rows of the catalogue, facts, captions, events, files and gaits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from motiondb.answers.plain import OPTIONAL, SPREAD, extended
from motiondb.body.gait import FootEvent, FootPrint, GaitCycle, GaitMeasure, JointAngles
from motiondb.records import Caption, CaptureInfo, DuplicateGroup, Event, Finding, Fit, Quality
from motiondb.tabled import Tabled


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


@dataclass(frozen=True, kw_only=True, repr=False)
class CaptureFacts(Tabled):
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
    lacks: list[str] | None = field(default=None, metadata=OPTIONAL)  # Where it was measured
    png: Path | None = field(default=None, metadata=OPTIONAL)
    gif: Path | None = field(default=None, metadata=OPTIONAL)


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
class DataSet:
    """Captures that were written as a data set in the form of another program."""

    folder: Path
    form: str
    captures: int
    frames: int
    captions: int
    without_captions: int  # Captures
    left_out: tuple[str, ...]  # Sentences


@dataclass(frozen=True)
class Ghost:
    """A box for something that was not captured, in the world of the motion that is played."""

    sentence: str
    start: float  # Seconds
    end: float
    centre: tuple[float, float, float]  # Metres of the standard body, y up, the ground at 0
    size: tuple[float, float, float]  # Whole lengths


@dataclass(frozen=True)
class CaptureQuality:
    """What a capture lacks; its findings stand beside any number."""

    capture: str
    quality: float  # Mean of the seconds
    seconds: list[float]  # A number from 0 to 1 for each
    findings: tuple[Finding, ...]
    untold: tuple[str, ...]  # What cannot be told
    png: Path | None = field(default=None, metadata=OPTIONAL)


def capture_quality(name: str, quality: Quality) -> CaptureQuality:
    """Return what the capture of a name lacks."""
    seconds = [round(float(number), 3) for number in quality.seconds]
    return CaptureQuality(
        name, round(float(quality.seconds.mean()), 3), seconds, quality.findings, quality.untold
    )


@dataclass(frozen=True)
class PerformerRate:
    """Whether captures of a performer (or of a folder) play at their true speed."""

    performer: str
    flights: int  # Jumps that were believed
    speed: float | None  # 1: as it was; None: cannot be told
    error: float | None  # Of the speed
    sentence: str


@dataclass(frozen=True)
class QualityAnswer:
    """What captures lack."""

    captures: list[CaptureQuality]
    performers: list[PerformerRate]
    measured: int  # Captures that were measured now; of others it was known
    problems: list[str]  # Captures that could not be measured
    without_body: int = 0  # Captures of markers without a body, of which nothing can be told


@dataclass(frozen=True)
class SelectionRow:
    """A selection, with its number of captures, of parts of them, and of seconds."""

    selection: str
    captures: int
    parts: int
    seconds: float


@dataclass(frozen=True)
class SelectedPart:
    """What a selection holds of a capture; times in seconds."""

    interval: int  # Number, from 1, by capture and time
    capture: str
    start: float
    end: float
    whole: bool  # Whether it is all of the capture
    kind: str  # "captured" or "generated"
    performer: str
    licence: str
    source: str  # Path of the capture's file when it was added
    sha256: str  # Of that file
    made_of: tuple[str, ...]  # Of generated motion: captures with their licences
    file: str  # Name in the folder; "" where none was written


@dataclass(frozen=True)
class SelectionChanged:
    """The captures of which a selection holds something else than before."""

    selection: str
    captures: tuple[str, ...]


@dataclass(frozen=True)
class PackWritten:
    """A selection that was written into a folder."""

    selection: str
    folder: Path
    motions: int
    licences: tuple[str, ...]


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
class EventRow:
    """A kind of event, with its number of events and of captures that have it."""

    event: str
    count: int
    captures: int


@dataclass(frozen=True, repr=False)
class GaitReport(Tabled):
    """How somebody walks or runs; seconds from the start of the motion, metres."""

    name: str
    seconds: float
    fps: float  # Of the capture, at which the events were found
    events: tuple[FootEvent, ...]
    cycles: tuple[GaitCycle, ...]
    measures: tuple[GaitMeasure, ...]
    angles: tuple[JointAngles, ...]
    prints: tuple[FootPrint, ...]
    treadmill: float  # Its speed, metres a second; 0 without one
    notes: tuple[str, ...] = ()
    png: Path | None = field(default=None, metadata=OPTIONAL)

    def _rows(self) -> tuple[str, Sequence[Mapping[str, object]]]:
        title = f"{self.name}: {len(self.cycles)} cycles, {len(self.events)} events of the feet"
        return title, [vars(each) for each in self.measures]
