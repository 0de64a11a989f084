"""Answers about knowledge: its content and origin, and what a database started from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.learn.knowledge import Knowledge


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
class ShownKnowledge(KnowledgeAnswer):
    """The content and origin of knowledge, with its words."""

    vocabulary: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class ExportedKnowledge(KnowledgeAnswer):
    """Knowledge that was written to a file."""

    file: Path
    bytes: int


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
