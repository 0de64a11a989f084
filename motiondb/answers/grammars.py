"""Answers about grammars and their sequences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from motiondb.answers.asking import DescribedWord
from motiondb.answers.making import Source
from motiondb.grammar.derivation.edit import Region


@dataclass(frozen=True)
class GrammarRow:
    """The size of a grammar; bits by part, with their sum."""

    grammar: str
    run: int
    captures: int
    frames: int
    terminals: int
    segments: int
    sentences: int
    nonterminals: int
    rules: int
    bits: dict[str, float]
    seconds: float


@dataclass(frozen=True, kw_only=True)
class GrammarLearned:
    """A grammar that was learned, and the captures that can no longer be edited with it."""

    kind: Literal["grammar"] = "grammar"
    grammar: str
    no_longer_editable: list[str]


@dataclass(frozen=True)
class LearnedTake:
    """A capture that a grammar was learned from."""

    capture: str
    sha256: str
    seconds: float
    there: bool  # Whether it is still in the database


@dataclass(frozen=True)
class TerminalSymbol:
    """How often a terminal has a symbol."""

    symbol: int
    share: float


@dataclass(frozen=True)
class Medoid:
    """The most typical segment of a terminal."""

    capture: str
    start: float
    end: float


@dataclass(frozen=True)
class TerminalRow:
    """A terminal of a grammar."""

    terminal: str
    count: int
    seconds: float
    words: tuple[DescribedWord, ...]
    symbols: tuple[TerminalSymbol, ...]
    medoid: Medoid


@dataclass(frozen=True)
class GrammarAnswer:
    """Everything about a grammar."""

    grammar: str
    run: int
    seed: int | None
    settings: dict[str, Any]
    captures: tuple[LearnedTake, ...]
    frames: int
    segments: int
    terminals: tuple[TerminalRow, ...]
    objective: float | None
    sentences: int
    sentence_lengths: tuple[int, float, int]  # Shortest, mean, longest
    nonterminals: int
    rules: int
    derives_new: bool  # Whether it derives new sentences
    bits: dict[str, float]
    text: str
    text_with_loops: str


@dataclass(frozen=True)
class TerminalSpan:
    """When a terminal of a sequence is played."""

    terminal: str
    start: float
    end: float


@dataclass(frozen=True)
class SequenceAnswer:
    """A sequence of a grammar; foot slip in m/s."""

    grammar: str
    seed: int
    string: tuple[str, ...]
    tree: str
    sentences: int
    seconds: float
    join_cost: float
    foot_slip: float
    foot_slip_of_sources: float
    spans: tuple[TerminalSpan, ...]
    sources: tuple[Source, ...]


@dataclass(frozen=True, kw_only=True)
class Unplayable:
    """Another derivation of a region for which no motion can be made, and why."""

    string: tuple[str, ...]
    region: tuple[str, ...]
    log_probability: float
    not_playable: str


@dataclass(frozen=True, kw_only=True)
class AlternativesAnswer:
    """The region of a sequence that is edited."""

    region: Region
