"""Rows of the catalogue, captions, runs, and answers."""

from __future__ import annotations

from dataclasses import dataclass, field

from motiondb.records.arrays import MOTION_FPS


@dataclass(frozen=True)
class Caption:
    """Words that a person wrote about a capture or a part of it.

    Attributes
    ----------
    words : str
        The text.
    start : float or None
        Start of the part, seconds; None: the start of the capture.
    end : float or None
        End of the part, seconds; None: the end of the capture.
    """

    words: str
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True, order=True)
class Event:
    """An instant of a capture: a foot strikes, a ball is released.

    Attributes
    ----------
    frame : int
        Frame of the canonical motion, 30 a second.
    name : str
        "foot_strike", "catch", "release", "contact", ... as people wrote it.
    joint : str
        The canonical joint that takes part, "" where it is not known.
    other : str
        What the joint touches ("ball", "ground", "opponent"), "" where it is not known.
    """

    frame: int
    name: str
    joint: str = ""
    other: str = ""

    @property
    def seconds(self) -> float:
        """Time of the event from the start of the capture, seconds."""
        return round(self.frame / MOTION_FPS, 3)


@dataclass(frozen=True, eq=False)
class CaptureInfo:
    """A row of the catalogue.

    Attributes
    ----------
    capture_id : int
        Number in the store.
    name : str
        Path below the added folder without its ending, such as ``16/16_01``.
    sha256 : str
        Digest of the file's bytes (and of its skeleton file's), hexadecimal.
    format : str
        As in :class:`Clip`.
    kind : str
        "captured" or "generated".
    fps : float
        Frames per second of the file, or those that a sheet gives.
    n_frames : int
        Frames of the file.
    duration : float
        Seconds.
    motion_frames : int
        Frames of the canonical motion, 30 a second.
    leg_length : float
        The performer's, metres.
    path : str
        Path of the file when it was added.
    run_id : int
        Run that added it.
    tags : dict
        Performer, licence and every further column of the sheet.
    notes : tuple of str
        What is unusual in the file.
    """

    capture_id: int
    name: str
    sha256: str
    format: str
    kind: str
    fps: float
    n_frames: int
    duration: float
    motion_frames: int
    leg_length: float
    path: str
    run_id: int
    tags: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Relation:
    """How one capture repeats another.

    Attributes
    ----------
    capture : str
        Name of the capture.
    other : str
        Name of the capture that it repeats.
    kind : str
        "same", "mirror" or "cut".
    start : float
        Start of the repeated part in ``other``, seconds.
    end : float
        End of the repeated part in ``other``, seconds.
    distance : float
        Mean distance between the poses of both (``motiondb.search.copies``).
    """

    capture: str
    other: str
    kind: str
    start: float
    end: float
    distance: float


@dataclass(frozen=True)
class Run:
    """The run that made a derived row."""

    run_id: int  # Number of the run
    kind: str
    parameters: dict[str, object]  # Everything that decided the result
    seed: int | None  # Seed of the random generator
    version: str
    started: str  # Time in UTC, ISO 8601
    finished: str | None  # Time in UTC; None if the run was killed


@dataclass(frozen=True)
class MatchPart:
    """One part of an answer to words: its interval in a capture, with certainties."""

    words: str  # What the question asks for in this part
    start: float  # Begin, seconds; that of the whole capture if the place is unknown
    end: float  # End, seconds; that of the whole capture if the place is unknown
    # Probability that the capture shows it; None if it is not known
    probability: float | None = None
    # Probability that the interval shows it; None if it is not known
    interval_probability: float | None = None
    # "known", or "unknown" where only a caption of the whole capture speaks for it
    place: str = "known"


@dataclass(frozen=True)
class Match:
    """One answer to a search: an interval of a capture.

    Attributes
    ----------
    rank : int
        1 for the best.
    capture : str
        Name of the capture.
    start : float
        Seconds.
    end : float
        Seconds.
    score : float
        Orders the answers, largest first.
    words : tuple of str
        Words of the question that the capture shows, or words of the interval.
    reason : str
        Why it was found.
    probability : float or None
        Probability that the answer is right: for words, that the capture shows the requested
        actions; for an example, that the interval shows the same action. None if too little was
        written about the captures to learn it (:mod:`motiondb.meaning.calibration`), or too few
        captions of the database have checked it (:mod:`motiondb.learn.checking`).
    interval_probability : float or None
        For words: probability that the interval shows the requested actions; None if it is not
        known.
    place : str
        "known", or "unknown" where a part's place is; then the interval is the whole capture.
    parts : tuple of MatchPart
        Parts of a question in words, in order.
    """

    rank: int
    capture: str
    start: float
    end: float
    score: float
    words: tuple[str, ...] = ()
    reason: str = ""
    probability: float | None = None
    interval_probability: float | None = None
    place: str = "known"
    parts: tuple[MatchPart, ...] = ()
