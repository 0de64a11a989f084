"""Answers of what changes captures, their words and their tags."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from motiondb.answers.plain import OPTIONAL
from motiondb.learn.drift import Drift
from motiondb.records import Relation
from motiondb.tabled import Tabled


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
class AddAnswer(AddReport):
    """The result of ``add``, and the state of the database after it."""

    captures: int
    drift: Drift | None


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
