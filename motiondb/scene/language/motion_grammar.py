"""A motion grammar: rules of order, words that find clips, and rules of space and time.

A context-free grammar says which actions may follow one another. Each terminal is an action whose
clips are found by words. Semantic rules are attached to symbols and are inherited by every clip
that the symbol derives. A rule may be limited to actions below a certain nonterminal: the paper's
run and walk with a dagger are written ``run, walk in S_D``, the same actions under the rules of a
defender.

A rule of a terminal is evaluated for each of its clips. A rule of a nonterminal is evaluated over
the whole sequence of clips that it derives (at its start, at its end, or throughout).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.grammar.cfg.context_free import Grammar, Tree, reachable_symbols
from motiondb.scene.language.activity import GIVE, SEND, STRIKE, Activity
from motiondb.scene.language.semantic_rules import END, START, SemanticRule, Weights


@dataclass(frozen=True)
class Terminal:
    """An action and the words that find its clips."""

    name: str  # Name of the action
    # A caption with any of these shows the action; () if no clips were asked for
    phrases: tuple[str, ...] = ()
    without: tuple[str, ...] = ()  # A caption with any of these does not show it
    # The instant at which rules without a moment are evaluated; "" for the whole action
    event: str = ""
    asked: bool = False  # Whether it is played only where a diagram asks for it
    # A terminal of a learned grammar, and its name, whose segments are the clips; "" for words
    learned: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class Annotation:
    """A semantic rule of a symbol."""

    symbol: str  # The terminal or nonterminal
    rule: SemanticRule
    within: str = ""  # The nonterminal below which the rule holds; "" for everywhere
    line: int = 0  # Line of the file


@dataclass(frozen=True)
class Start:
    """A start symbol."""

    symbol: str
    team: str = ""  # The role whose strings begin with it; "" for everybody


@dataclass(frozen=True)
class MotionGrammar:
    """The contents of a grammar file.

    Attributes
    ----------
    name : str
        Name of the grammar.
    starts : tuple of Start
        Its start symbols.
    grammar : Grammar
        The context-free grammar from the first start symbol.
    terminals : tuple of Terminal
        The actions.
    annotations : tuple of Annotation
        The semantic rules.
    places : tuple of str
        Names of places whose positions a diagram must give.
    weights : Weights
        Weights of the terms that belong to no action.
    activity : Activity
        Verbs, roles, the object, places and ground.
    """

    name: str
    starts: tuple[Start, ...]
    grammar: Grammar
    terminals: tuple[Terminal, ...]
    annotations: tuple[Annotation, ...] = ()
    places: tuple[str, ...] = ()
    weights: Weights = field(default_factory=Weights)
    activity: Activity = field(default_factory=Activity)

    @cached_property
    def terminal(self) -> dict[str, Terminal]:
        """Terminals by name."""
        return {terminal.name: terminal for terminal in self.terminals}

    @cached_property
    def only_asked(self) -> tuple[str, ...]:
        """Actions that are played only where the diagram asks for them.

        The grammar says which. Those that give or send the object, and the catches of what is
        given, are always among them: there would be throws to nobody, and catches from nowhere.
        """
        said = [terminal.name for terminal in self.terminals if terminal.asked]
        thrown = self.activity.doing(GIVE, SEND, STRIKE)
        caught = (row for row in self.activity.replies if row[0] in thrown)
        return tuple(dict.fromkeys([*said, *thrown, *(a for _, _, row in caught for a in row)]))

    def start_of(self, team: str) -> str:
        """Return the start symbol of a role.

        Raises
        ------
        SceneError
            The grammar has no start symbol for the role.
        """
        for start in self.starts:
            if start.team in ("", team):
                return start.symbol
        found = f"only {', '.join(s.symbol + ' for ' + s.team for s in self.starts)}"
        advice = f"Add a line 'start SYMBOL for {team}', or leave the role out."
        fault = Fault(f"a start symbol for the role {team!r}", found, advice)
        raise SceneError(fault, where=self.name)

    def started(self, start: str = "") -> Grammar:
        """Return the context-free grammar from one of the start symbols (the first by default).

        Raises
        ------
        SceneError
            ``start`` is not a start symbol.
        """
        symbols = [s.symbol for s in self.starts]
        if start and start not in symbols:
            raise SceneError(
                f"{self.name}: expected one of the start symbols {', '.join(symbols)}, found"
                f" {start!r}.{suggestion(start, symbols) or ' Choose one of them.'}"
            )
        return replace(self.grammar, start=start or symbols[0])

    def unasked(self, team: str) -> tuple[str, ...]:
        """Return a role's actions without an event or the object that nobody has to ask for."""
        known = reachable_symbols(self.started(self.start_of(team)))
        free = (one.name for one in self.terminals if one.name in known and not one.event)
        return tuple(n for n in free if n not in self.only_asked and not self.activity.deed(n))

    def rules_of(self, symbol: str, ancestors: Collection[str]) -> tuple[SemanticRule, ...]:
        """Return the semantic rules of a symbol that has ``ancestors`` above it in a parse tree."""
        return tuple(
            a.rule
            for a in self.annotations
            if a.symbol == symbol and (not a.within or a.within in ancestors)
        )


@dataclass(frozen=True)
class Node:
    """A node with the actions [first, last) that it derives and its ancestors."""

    symbol: str
    is_leaf: bool
    first: int
    last: int
    above: frozenset[str]


def nodes_of(tree: Tree) -> Iterator[Node]:
    """Yield all nodes with the actions [first, last) that they derive and their ancestors.

    The order is postorder. There is no recursion, because the depth of nesting may equal the length
    of the string.
    """
    done = 0
    waiting: list[tuple[Tree, frozenset[str], int]] = [(tree, frozenset(), -1)]
    while waiting:
        node, above, first = waiting.pop()
        if node.is_leaf:
            yield Node(node.symbol, True, done, done + 1, above)
            done += 1
        elif first >= 0:
            yield Node(node.symbol, False, first, done, above)
        else:
            waiting.append((node, above, done))
            below = above | {node.symbol}
            waiting.extend((child, below, -1) for child in reversed(node.children))


def counts_elsewhere(
    rule: SemanticRule,
    k: int,
    item_of: Sequence[int],
    of_action: Sequence[tuple[SemanticRule, ...]],
) -> bool:
    """Return whether the next (for ``at start`` the previous) action of the item has the rule."""
    step = {END: 1, START: -1}.get(rule.moment.name, 0)
    m = k + step
    if step == 0 or not 0 <= m < len(of_action):
        return False
    return item_of[m] == item_of[k] and rule in of_action[m]
