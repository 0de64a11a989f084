"""What a database learned, in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from motiondb.learn.drift import Drift
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
class LearnAnswer(LearnedSummary):
    """The size of what was learned, what had changed before, and the start that was used."""

    drift: Drift | None
    start: StartAnswer | None


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


@dataclass(frozen=True)
class Evaluation:
    """How well a database answers about captures that it has not learned from."""

    where: str
    learned_from: int  # Number of captures
    judged: int  # Number of captures
    scores: tuple[Score, ...]
    words: tuple[WordScore, ...]
