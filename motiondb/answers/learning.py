"""Answers about what a database learned: symbols, words, and how well it answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from motiondb.answers.knowledge import StartAnswer
from motiondb.learn.drift import Drift
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from motiondb.learn.learned_model import LearnedModel


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
