"""Answers about libraries: what to train on, what is there and lacks, what another one has."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from motiondb.answers.plain import OPTIONAL


@dataclass(frozen=True)
class ChosenInterval:
    """An interval to train on; times in seconds of its capture."""

    interval: int  # Number, from 1, in the order in which the intervals were taken
    capture: str
    start: float
    end: float
    split: str  # "train", "test", or "all"
    weight: float  # Seconds of the library that it stands for, its own among them
    weights: tuple[float, ...]  # The same for each of its seconds, spread evenly over it
    reason: str  # What it adds that the others do not have
    nearest: int | None  # Number of the chosen interval of the split that is most like it
    distance: float | None  # Mean distance of its seconds to that one
    words: tuple[str, ...]  # Of its captions; those of a whole capture may lie elsewhere in it
    symbols: tuple[int, ...]  # In order; none where nothing is learned
    quality: float  # Smallest number of its seconds
    performer: str
    licence: str
    source: str  # Path of the capture's file when it was added
    sha256: str  # Of that file
    file: str  # Name in the folder; "" where none was written


@dataclass(frozen=True)
class DroppedInterval:
    """An interval that was not chosen, and why."""

    capture: str
    start: float
    end: float
    reason: str


@dataclass(frozen=True)
class SplitChoice:
    """A choice from the captures of a split."""

    split: str
    performers: tuple[str, ...]
    seconds: float  # That could have been chosen
    chosen: float  # Seconds
    intervals: int
    # Mean distance of all of these seconds to the nearest chosen one; of another performer, where
    # there are five or more
    distance: float
    bound: float  # No choice of as many seconds has a smaller mean


@dataclass(frozen=True, kw_only=True)
class CurateAnswer:
    """The part of a library to train on."""

    seconds: float  # Of the captures of the filter
    splits: tuple[SplitChoice, ...]
    reasons: dict[str, float]  # Seconds that were not chosen, for each reason
    intervals: tuple[ChosenInterval, ...]
    dropped: tuple[DroppedInterval, ...]
    notes: tuple[str, ...]
    folder: Path | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class Moment:
    """A moment of a capture; times in seconds."""

    capture: str
    start: float
    end: float
    what: str


@dataclass(frozen=True)
class Cell:
    """How much a library has of one thing."""

    table: str  # "going", "changes", "symbols" or "words"
    row: str
    column: str
    amount: float  # Seconds, or how often
    unit: str  # "s" or "times"
    performers: int
    shot: str  # What to record; "" where there is enough
    nearest: tuple[Moment, ...]  # Where there is none: the moments that are most like it


@dataclass(frozen=True)
class CoverageAnswer:
    """What a library holds and lacks."""

    captures: int
    seconds: float
    not_upright: float  # Seconds on the floor, in rolls and flips, which no cell counts
    cells: tuple[Cell, ...]
    shots: tuple[str, ...]
    notes: tuple[str, ...]
    png: Path | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class SharedCapture:
    """A capture that another library has too."""

    capture: str
    other: str
    kind: str  # "same file", "same motion", "part of it", "contains it" or "mirrored"
    resampled: bool  # Whether the files have other rates
    start: float  # Of the common part, seconds of the longer of both
    end: float
    distance: float  # Metres; 0 for the same file
    fps: float
    other_fps: float
    licence: str
    other_licence: str


@dataclass(frozen=True)
class DiffAnswer:
    """Which captures another library has too."""

    other: Path
    captures: int
    other_captures: int
    shared: tuple[SharedCapture, ...]
    only_here: int  # Captures of which the other has nothing
    only_there: int
    notes: tuple[str, ...]
