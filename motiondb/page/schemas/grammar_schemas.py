"""Schemas of grammars and their sequences."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from motiondb.page.schemas.shared_schemas import DescribedWord, Facts, StretchFacts


class GrammarRow(Facts):
    """The size of a grammar."""

    name: str
    run_id: int
    captures: int
    frames: int
    terminals: int
    segments: int
    sentences: int
    nonterminals: int
    rules: int
    bits: float
    seconds: float = Field(description="Duration of the captures.")
    derives_new: bool = Field(description="Whether it derives new sentences.")


class GrammarRows(Facts):
    """The grammars of the database."""

    grammars: list[GrammarRow]


class GrammarCapture(Facts):
    """A capture that a grammar was learned from."""

    capture: str
    sha256: str
    seconds: float
    there: bool = Field(description="Whether it is still in the database.")


class SymbolShareOfTerminal(Facts):
    """How often a terminal has a symbol."""

    symbol: int
    share: float


class Medoid(Facts):
    """The most typical segment of a terminal."""

    capture: str
    start: float
    end: float


class TerminalFacts(Facts):
    """A terminal of a grammar."""

    terminal: str
    count: int
    seconds: float
    words: list[DescribedWord]
    symbols: list[SymbolShareOfTerminal]
    medoid: Medoid


class GrammarFacts(Facts):
    """Everything about a grammar."""

    grammar: str
    run: int
    seed: int | None
    settings: dict[str, Any]
    captures: list[GrammarCapture]
    frames: int
    segments: int
    terminals: list[TerminalFacts]
    objective: float | None
    sentences: int
    sentence_lengths: tuple[int, float, int]
    nonterminals: int
    rules: int
    derives_new: bool
    bits: dict[str, float]
    text: str
    text_with_loops: str
    sequences: list[str] = Field(description="Names of the captures that hold its sequences.")


class GrammarRemoved(Facts):
    """A grammar that was removed, and sequences that can no longer be edited."""

    removed: str
    lost: list[str]


class StripPart(Facts):
    """A terminal of a sequence, in time."""

    at: int
    terminal: str
    nonterminal: str
    start: float
    end: float
    words: list[str]
    capture: str
    source_start: float
    source_end: float


class PathFacts(Facts):
    """The path of the root joint on the ground: [x, z] in metres."""

    fps: float
    points: list[tuple[float, float]]


class TreeNode(Facts):
    """A node of a parse tree, in preorder; start and end are positions in the string."""

    symbol: str
    parent: int
    start: int
    end: int
    terminal: bool


class Positions(Facts):
    """Positions of a string, half-open."""

    start: int
    end: int


class SequenceSource(Facts):
    """A capture that frames come from."""

    capture: str
    licence: str
    sha256: str
    frames: int


class SequenceFacts(Facts):
    """A sequence of a grammar."""

    id: str
    ref: str
    parent: str | None
    edited: Positions | None
    saved: str | None
    grammar: str
    seed: int
    string: list[str]
    sentences: int
    seconds: float
    join_cost: float
    foot_slip: float
    foot_slip_of_sources: float
    sources: list[SequenceSource]
    strip: list[StripPart]
    path: PathFacts
    tree: list[TreeNode]
    tree_text: str
    stretches: list[StretchFacts]


class AlternativeSequence(SequenceFacts):
    """A sequence with another derivation of a region."""

    region: list[str]
    log_probability: float


class NotPlayable(Facts):
    """A derivation for which no motion can be made."""

    string: list[str]
    region: list[str]
    log_probability: float
    not_playable: str


class RegionFacts(Facts):
    """The edited region."""

    symbol: str
    start: int
    end: int
    path: list[int]
    position: int


class Alternatives(Facts):
    """Other derivations of a region."""

    region: RegionFacts
    can_widen: bool
    can_narrow: bool
    alternatives: list[AlternativeSequence | NotPlayable]
