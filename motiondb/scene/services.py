"""What a motion grammar is good for besides scenes: checking, validating, suggesting, planning.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import inf

from motiondb.errors import SceneError
from motiondb.grammar.cfg import Grammar, Tree, nullable_symbols, reachable_symbols
from motiondb.grammar.parse import explain, parse
from motiondb.scene import planning
from motiondb.scene.expressions import expressions
from motiondb.scene.lr import Conflict, ll1_conflicts, lr1_automaton
from motiondb.scene.motion_grammar import MotionGrammar
from motiondb.scene.tactics import Diagram


@dataclass(frozen=True)
class StartReport:
    """What is known of the strings of one start symbol.

    Attributes
    ----------
    empty : whether it derives the empty string; no character on court may have it.
    n_states, conflicts : of the canonical LR(1) automaton; () where the grammar is LR(1).
    lalr_conflicts, ll1_conflicts : () where it is LALR(1), LL(1).
    """

    symbol: str
    team: str
    empty: bool
    n_states: int
    conflicts: tuple[Conflict, ...]
    lalr_conflicts: tuple[Conflict, ...]
    ll1_conflicts: tuple[Conflict, ...]


@dataclass(frozen=True)
class GrammarReport:
    """A grammar looked at: its symbols, those of no use, and the class of each start symbol."""

    name: str
    nonterminals: tuple[str, ...]
    terminals: tuple[str, ...]
    useless: tuple[str, ...]
    nullable: tuple[str, ...]
    starts: tuple[StartReport, ...]


@dataclass(frozen=True)
class Validation:
    """Whether a string of actions is allowed, its tree, or where it fails.

    Attributes
    ----------
    position : the first action, from 0, that cannot stand where it stands; the length of the string
        where more must follow.
    expected : the actions that could stand there.
    message : the sentence that says so; "" where the string is allowed.
    """

    allowed: bool
    tree: Tree | None = None
    position: int = -1
    expected: tuple[str, ...] = ()
    message: str = ""


@dataclass(frozen=True)
class Suggestions:
    """The actions that may come next, and whether the string may end here."""

    actions: tuple[str, ...]
    may_end: bool


def check(grammar: MotionGrammar) -> GrammarReport:
    """Look at a grammar: useless and nullable symbols, LR(1), LALR(1) and LL(1).

    A symbol is useless where no start symbol leads to it. (Nonterminals that never end are refused
    when the file is read.)
    """
    reached: set[str] = set()
    starts = []
    for start in grammar.starts:
        rules = grammar.started(start.symbol)
        reached |= reachable_symbols(rules)
        automaton = lr1_automaton(rules)
        starts.append(
            StartReport(
                start.symbol,
                start.team,
                start.symbol in nullable_symbols(rules),
                automaton.n_states,
                automaton.conflicts,
                automaton.lalr_conflicts,
                ll1_conflicts(rules),
            )
        )
    whole = grammar.grammar
    names = tuple(terminal.name for terminal in grammar.terminals)
    useless = tuple(s for s in (*whole.nonterminals, *names) if s not in reached)
    nullable = tuple(s for s in whole.nonterminals if s in nullable_symbols(whole))
    return GrammarReport(grammar.name, whole.nonterminals, names, useless, nullable, tuple(starts))


def validate(grammar: MotionGrammar, actions: Sequence[str], start: str = "") -> Validation:
    """Whether a string of actions is one of the grammar's, from one of its start symbols.

    Without ``start``, the start symbol that gets furthest answers. The empty string is never
    allowed: whoever is on court does something.
    """
    if start:
        return _validate(grammar.started(start), actions)
    tried = [_validate(grammar.started(s.symbol), actions) for s in grammar.starts]
    return max(tried, key=lambda found: inf if found.allowed else found.position)


def _validate(grammar: Grammar, actions: Sequence[str]) -> Validation:
    if not actions:
        expected = suggest_from(grammar, ()).actions
        message = (
            f"the empty string: expected at least one action, of {', '.join(expected)}, found"
            " none. Whoever is on court does something."
        )
        return Validation(False, None, 0, expected, message)
    fault = explain(grammar, actions)
    if fault is None:
        return Validation(True, parse(grammar, actions))
    return Validation(False, None, fault.position, fault.expected, str(fault))


def suggest(grammar: MotionGrammar, actions: Sequence[str], start: str = "") -> Suggestions:
    """The actions that may follow on a string.

    Without ``start``, those of every start symbol from which the string can begin.

    Raises
    ------
    SceneError where no string of the grammar begins so.
    """
    symbols = [start] if start else [s.symbol for s in grammar.starts]
    found, may_end = dict[str, None](), False
    failure: SceneError | None = None
    for symbol in symbols:
        try:
            one = suggest_from(grammar.started(symbol), actions)
        except SceneError as error:
            failure = error
            continue
        found |= dict.fromkeys(one.actions)
        may_end |= one.may_end
    if not found and not may_end and failure is not None:
        message = validate(grammar, actions, start).message
        raise SceneError(f"{grammar.name}: {message}") from failure
    return Suggestions(tuple(found), may_end)


def suggest_from(grammar: Grammar, actions: Sequence[str]) -> Suggestions:
    """The same for the one start symbol of a context-free grammar."""
    # a symbol that is none of the grammar's fails behind the string, and tells what may stand there
    fault = explain(grammar, (*actions, ""))
    assert fault is not None
    if fault.position < len(actions):
        raise SceneError(str(fault))
    return Suggestions(fault.expected, fault.may_end and bool(actions))


def plan(
    grammar: MotionGrammar,
    actions: Sequence[str] = (),
    goals: Sequence[Collection[str]] = (),
    start: str = "",
) -> Tree:
    """The shortest string that begins with ``actions`` and then goes through the goals in order.

    Raises
    ------
    SceneError where the grammar has none, or a goal is no action of it.
    """
    known = grammar.terminal
    for goal in goals:
        for action in goal:
            if action not in known:
                raise SceneError(
                    f"{grammar.name}: expected an action, found {action!r}. The actions are"
                    f" {', '.join(known)}."
                )
    return planning.plan(grammar.started(start), actions, goals)


def cast(diagram: Diagram, grammar: MotionGrammar) -> dict[str, Tree]:
    """For each player the shortest string of the grammar that fits the diagram (g_user = 0).

    Raises
    ------
    SceneError, naming the player and what the grammar does not allow them.
    """
    found = {}
    for name, items in expressions(diagram).items():
        start = grammar.start_of(diagram.player[name].team)
        try:
            found[name] = plan(grammar, (), [item.actions for item in items], start)
        except SceneError as error:
            wanted = "".join(str(item) for item in items)
            raise SceneError(
                f"{diagram.name}: expected of {name} what the grammar {grammar.name} allows, found"
                f" {wanted}. {error}"
            ) from None
    return found
