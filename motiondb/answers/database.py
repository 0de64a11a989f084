"""Answers about a database: what is in it and what it learned, its changes, faults and copies.

Also what of it to train on, what it lacks, and what another one has too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from motiondb.answers.plain import OPTIONAL
from motiondb.records import Relation
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from motiondb.learn.knowledge import Knowledge
    from motiondb.learn.learned_model import LearnedModel


@dataclass(frozen=True, kw_only=True)
class KnowledgeAnswer:
    """The content and origin of knowledge."""

    name: str
    version: str  # Of motiondb, that learned it
    captures: int
    captions: int
    performers: int
    seconds: float
    licences: Mapping[str, int]
    runs: Sequence[Mapping[str, object]]
    credit: str
    sha256: str
    symbols: int
    words: int


def knowledge_answer(knowledge: Knowledge) -> KnowledgeAnswer:
    """Return the content and origin of knowledge, as :meth:`MotionDB.export_knowledge` gives it."""
    origin = knowledge.origin
    return KnowledgeAnswer(
        **origin.facts(),
        sha256=origin.digest,
        symbols=knowledge.symbols.n_symbols,
        words=len(knowledge.words),
    )


@dataclass(frozen=True, kw_only=True)
class StartAnswer(KnowledgeAnswer):
    """The knowledge that a database started from, and its share in what it learned."""

    weight: float  # What a caption of the start counts, where one of the database counts 1
    own_captions: int
    unchecked: str  # Why answers carry no probabilities; "" where they do
    strange_motion: float  # Share of the motion that the symbols of the start do not explain
    fits: bool
    words_of_start_alone: int
    words_of_both: int
    words_of_own_captions_alone: int


@dataclass(frozen=True, repr=False)
class DatabaseInfo(Tabled):
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
    parquet_bytes: int | None = None  # Of Parquet files with motions, original files and scores
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


@dataclass(frozen=True)
class Faults:
    """The faults of a database."""

    faults: list[str]


@dataclass(frozen=True)
class BackedUp:
    """A copy of a database that was written and checked."""

    output: Path
    bytes: int


@dataclass(frozen=True)
class LearnedSummary:
    """The size of what was learned."""

    captures: int
    segments: int
    symbols: int
    clusters: int
    dimensions: int
    words: int
    run: int


@dataclass(frozen=True, kw_only=True)
class LearnResult(LearnedSummary):
    """The result of a job that learns."""

    kind: Literal["learn"] = "learn"
    start: str | None = None  # Name of the knowledge it started from


def learned_summary(model: LearnedModel) -> LearnedSummary:
    """Return the size of what was learned.

    Parameters
    ----------
    model : LearnedModel
        What :meth:`MotionDB.learn` gives.
    """
    return LearnedSummary(
        len(set(model.segments.capture_ids.tolist())),
        len(model.segments.symbols),
        model.symbols.n_symbols,
        len(model.space.weights),
        model.space.coordinates.shape[1],
        len(model.association.words),
        model.run_id,
    )


@dataclass(frozen=True)
class WordProbability:
    """A word with its probability."""

    word: str
    probability: float


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


@dataclass(frozen=True)
class Score:
    """The mean of a measure over questions about captures that were not learned from."""

    task: str  # words, captions, examples, intervals or descriptions
    measure: str
    questions: int
    value: float | None  # None without questions
    chance: float | None  # What guessing would reach; None where it was not computed


@dataclass(frozen=True)
class WordScore:
    """How well captures that show a word are found by it."""

    word: str
    captures: int  # Captures whose captions hold it
    average_precision: float
    chance: float


@dataclass(frozen=True, repr=False)
class Evaluation(Tabled):
    """How well a database answers about captures that it has not learned from."""

    where: str
    learned_from: int  # Number of captures
    judged: int  # Number of captures
    scores: tuple[Score, ...]
    words: tuple[WordScore, ...]


@dataclass(frozen=True, repr=False)
class AddReport(Tabled):
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
    # A sentence per file that could not be used before either, and is as it was then
    known_faulty: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class MergeReport(Tabled):
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
class CaptionsSet:
    """The captions of a capture after a change."""

    capture: str
    words: list[str]
    counted: bool
    new_words: list[str]


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
