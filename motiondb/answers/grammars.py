"""Answers about grammars and their sequences."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from motiondb.answers.making import Source
from motiondb.answers.plain import OPTIONAL
from motiondb.answers.questions import DescribedWord
from motiondb.grammar.derivation.edit import Region
from motiondb.grammar.foresight import Foresight
from motiondb.tabled import Tabled


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
class DoubtfulSentence:
    """A sentence that looks like an error, with what one change would make of it."""

    shown: Medoid  # Where it is
    string: tuple[str, ...]
    instead: tuple[str, ...]  # What the other sentences would have
    says: str


@dataclass(frozen=True, repr=False)
class GrammarAnswer(Tabled):
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
    doubtful: tuple[DoubtfulSentence, ...]  # Sentences that look like errors
    left_out: tuple[Medoid, ...]  # What was left out as errors
    foresight: Foresight | None  # On held-out takes; None where it cannot be said
    foresight_says: str  # The same as a sentence, or why it cannot be said
    bits: dict[str, float]
    text: str
    text_with_loops: str


@dataclass(frozen=True)
class GrammarQuestion:
    """Whether a terminal can come straight after another, with a segment that shows each."""

    first: str
    then: str
    observed: int  # How often it does in the captures
    gain: float  # Bits of the answer times shuffles of windows that it decides; the largest first
    first_shown: Medoid
    then_shown: Medoid
    first_words: str = ""  # What the terminal shows, if the database has learned words
    then_words: str = ""


@dataclass(frozen=True)
class GrammarAsked:
    """The questions of a grammar, and how many answers were just kept."""

    grammar: str
    questions: list[GrammarQuestion]
    kept: int
    picture: str | None = None


@dataclass(frozen=True)
class GrammarRules:
    """The rules of a grammar, as text that can be edited."""

    grammar: str
    text: str


@dataclass(frozen=True)
class GrammarEdited:
    """A grammar that was edited, and sequences that can no longer be edited with it."""

    grammar: str
    no_longer_editable: list[str]
    undone: str | None = None  # What the edit had changed that was taken back


@dataclass(frozen=True)
class ParsedSentence:
    """A sentence of a motion."""

    string: tuple[str, ...]
    tree: str


@dataclass(frozen=True)
class ParseFault:
    """Why a string of terminals does not parse."""

    position: int
    found: str | None
    expected: tuple[str, ...]
    may_end: bool
    says: str


@dataclass(frozen=True)
class ParseAnswer:
    """A motion as a string of terminals, with its sentences or the fault; distances in metres."""

    string: tuple[str, ...]
    spans: list[tuple[float, float]]
    learned_from: bool
    distances: tuple[float, ...]
    usual_distance: float | None
    unlike: tuple[int, ...]  # Positions of terminals that are farther than usual
    share_unlike: float
    is_unlike: bool
    log_probability: float | None  # Smoothed, also where the string does not parse
    order_rank: float | None  # Share of shuffles of the string that are less probable
    of_another_activity: str  # Why it probably is; empty if nothing says so
    sentences: list[ParsedSentence]
    fault: ParseFault | None


@dataclass(frozen=True)
class NextTerminal:
    """A terminal that may come next; None is the end."""

    terminal: str | None
    end: bool
    probability: float


@dataclass(frozen=True)
class WayAnswer:
    """The most probable way to a terminal, and from there to the end of the sentence."""

    to_goal: tuple[str, ...]
    then: tuple[str, ...]
    log_probability: float
    tree: str


@dataclass(frozen=True)
class CompletedSentence:
    """A sentence that matches a pattern."""

    string: tuple[str, ...]
    probability: float


@dataclass(frozen=True)
class CompletionsAnswer:
    """The most probable sentences that match a pattern."""

    probability: float
    proven: bool
    sentences: list[CompletedSentence]


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
    new_sentences: int  # How many of them no take has
    changes: int  # From one place of the takes to another; 0: a replay
    longest_stretch: float  # Seconds that come from one take without a change
    says: str  # The same as a sentence
    seconds: float
    join_cost: float
    foot_slip: float
    foot_slip_of_sources: float
    spans: tuple[TerminalSpan, ...]
    sources: tuple[Source, ...]


@dataclass(frozen=True, kw_only=True)
class WrittenSequence(SequenceAnswer):
    """A sequence that was made, with the names of its files and of the capture that holds it."""

    output: str | None = field(default=None, metadata=OPTIONAL)
    provenance: str | None = field(default=None, metadata=OPTIONAL)
    capture: str | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, kw_only=True)
class Alternative(WrittenSequence):
    """A sequence with another derivation of its region."""

    region: tuple[str, ...]
    log_probability: float


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


@dataclass(frozen=True, kw_only=True)
class OfferedEdits(AlternativesAnswer):
    """The alternatives for a region of a sequence."""

    grammar: str
    string: tuple[str, ...]
    alternatives: list[Alternative | Unplayable]
