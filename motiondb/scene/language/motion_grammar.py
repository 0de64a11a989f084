"""A motion grammar: rules of order, words that find clips, and rules of space and time.

A context-free grammar says which actions may follow one another; each terminal is an action, found
among the clips by words; semantic rules are attached to symbols, and pass down to every clip that
a symbol derives. A rule may hold only below a certain nonterminal: what the paper writes as run and
walk with a dagger is ``run, walk in S_D``, the same action under a defender's rules.

A rule of a terminal looks at each of its clips; one of a nonterminal looks at the whole stretch of
clips that it derives (its start, its end, or throughout).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property

from motiondb.errors import SceneError, suggestion
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.scene.language.semantic_rules import SemanticRule, Weights

ROLES = ("receiver", "opponent")
"""Who may be meant by a rule: whom a pass or a screen is for, and who plays against the player."""


@dataclass(frozen=True)
class Terminal:
    """An action and the words that find its clips.

    Attributes
    ----------
    phrases : any of these says that a clip shows the action; () where no clip was asked for.
    without : a caption with one of these does not.
    event : the instant that rules look at where they name none; "" for the whole action.
    """

    name: str
    phrases: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    event: str = ""


@dataclass(frozen=True)
class Annotation:
    """A semantic rule of ``symbol``, below the nonterminal ``within`` ("" for everywhere)."""

    symbol: str
    rule: SemanticRule
    within: str = ""
    line: int = 0


@dataclass(frozen=True)
class Start:
    """A start symbol and the team that begins with it; "" for everybody."""

    symbol: str
    team: str = ""


@dataclass(frozen=True)
class MotionGrammar:
    """Everything that a grammar file says; ``grammar`` begins with the first start symbol."""

    name: str
    starts: tuple[Start, ...]
    grammar: Grammar
    terminals: tuple[Terminal, ...]
    annotations: tuple[Annotation, ...] = ()
    places: tuple[str, ...] = ()
    weights: Weights = field(default_factory=Weights)

    @cached_property
    def terminal(self) -> dict[str, Terminal]:
        """Terminals by name."""
        return {terminal.name: terminal for terminal in self.terminals}

    def start_of(self, team: str) -> str:
        """The start symbol of a team's players.

        Raises
        ------
        SceneError where the grammar has no start symbol for the team.
        """
        for start in self.starts:
            if start.team in ("", team):
                return start.symbol
        raise SceneError(
            f"{self.name}: expected a start symbol for the team {team!r}, found only"
            f" {', '.join(s.symbol + ' for ' + s.team for s in self.starts)}."
            f" Add a line 'start SYMBOL for {team}', or leave the team out."
        )

    def started(self, start: str = "") -> Grammar:
        """The grammar from one of its start symbols (the first, where none is named).

        Raises
        ------
        SceneError where it is none.
        """
        symbols = [s.symbol for s in self.starts]
        if start and start not in symbols:
            raise SceneError(
                f"{self.name}: expected one of the start symbols {', '.join(symbols)}, found"
                f" {start!r}.{suggestion(start, symbols) or ' Choose one of them.'}"
            )
        return replace(self.grammar, start=start or symbols[0])

    def rules_of(self, symbol: str, ancestors: Collection[str]) -> tuple[SemanticRule, ...]:
        """The semantic rules of a symbol that stands below ``ancestors`` in a parse tree."""
        return tuple(
            a.rule
            for a in self.annotations
            if a.symbol == symbol and (not a.within or a.within in ancestors)
        )
