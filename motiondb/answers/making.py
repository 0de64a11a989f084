"""Answers of what makes motion: motions from sentences, with the origin of their frames."""

from __future__ import annotations

from dataclasses import dataclass, field

from motiondb.answers.catalogue import CaptureQuality
from motiondb.answers.database import WordProbability
from motiondb.answers.plain import OPTIONAL
from motiondb.answers.questions import UnderstoodQuestion
from motiondb.generate.joining import Seam
from motiondb.generate.smoothness import Smoothness
from motiondb.records import Fit, Match
from motiondb.search.chances import WordSource
from motiondb.tabled import Tabled


@dataclass(frozen=True)
class Source:
    """A capture that frames come from."""

    capture: str
    licence: str
    sha256: str
    frames: int


@dataclass(frozen=True)
class ActionVerdict:
    """Whether a generated motion shows an action (None: this cannot be decided)."""

    words: tuple[str, ...]
    start: float
    end: float
    shown: bool | None
    probability: float | None
    reason: str
    described: tuple[WordProbability, ...]
    done: tuple[str, ...]


@dataclass(frozen=True)
class DecodedAction:
    """The symbols that an action was decoded to."""

    symbols: tuple[int, ...]
    log_probability: float
    nodes_expanded: int
    certificate: str


@dataclass(frozen=True, kw_only=True)
class GeneratedAnswer:
    """A motion that was generated from a sentence."""

    words: str
    seed: int
    method: str
    seconds: float
    shown: bool  # Whether it shows every action
    why_not: str  # What is not understood, not shown, or not sure to be shown; "" if it shows all
    actions: tuple[tuple[str, ...], ...]
    shown_actions: tuple[ActionVerdict, ...]
    decided: tuple[str, ...]
    symbols: tuple[int, ...]
    recognised: tuple[int, ...]
    decodings: tuple[DecodedAction, ...]
    sources: tuple[Source, ...]
    smoothness: Smoothness
    words_from: tuple[WordSource, ...] = ()
    question: UnderstoodQuestion


@dataclass(frozen=True, kw_only=True)
class WrittenMotion(GeneratedAnswer):
    """A motion from a sentence, with the names of its files and of the capture that holds it."""

    output: str
    provenance: str
    changes: tuple[str, ...] = ()  # What was done to the motion before it was written
    fit: Fit | None = field(default=None, metadata=OPTIONAL)  # How well a rig follows the motion
    capture: str | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class JoinedPart:
    """A part of a capture in a joined motion; times in seconds."""

    capture: str
    start: float
    end: float


@dataclass(frozen=True, kw_only=True)
class JoinedAnswer:
    """A motion of parts of captures."""

    seconds: float
    parts: tuple[JoinedPart, ...]
    seams: tuple[Seam, ...]
    sources: tuple[Source, ...]


@dataclass(frozen=True, kw_only=True)
class WrittenJoin(JoinedAnswer):
    """A motion of parts of captures, with the names of its files."""

    output: str
    provenance: str
    changes: tuple[str, ...] = ()
    fit: Fit | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class Variants:
    """Several motions from one sentence."""

    shown: bool  # Whether all of them show every action
    asked: int  # How many were asked for
    variants: list[WrittenMotion]


@dataclass(frozen=True, kw_only=True, repr=False)
class Judgement(Tabled):
    """Whether a motion of any origin shows a sentence, by the judge of generated motion."""

    sentence: str
    seconds: float  # Of the motion
    shown: bool | None  # None: not sure
    actions: tuple[ActionVerdict, ...]  # In the order of the sentence
    in_order: bool | None  # None: no order is asked for, or it cannot be told
    reason: str  # What is not shown, or not sure to be; "" if all is shown
    chosen: str  # Of alternatives the one that the verdict is about; "" without any
    question: UnderstoodQuestion
    sentences: tuple[str, ...]  # How words that no caption holds were taken, and other notes
    left_out: tuple[str, ...]  # Captures of this motion, which are no evidence about it
    nearest: Match | None  # The real capture that moves most like it; None without any other
    # What the motion lacks
    quality: CaptureQuality | None = field(default=None, metadata=OPTIONAL)
