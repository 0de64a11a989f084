"""Uses of a motion grammar besides scenes: checking, validating, suggesting, planning.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import exp, inf

import numpy as np

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.grammar.cfg import parse as parsing
from motiondb.grammar.cfg.compiled import CompiledGrammar, compile_grammar
from motiondb.grammar.cfg.context_free import (
    Grammar,
    Tree,
    derive_by,
    nullable_symbols,
    reachable_symbols,
)
from motiondb.grammar.cfg.parse import (
    best_strings,
    count_trees,
    explain,
    parse,
    prefix_log_probability,
)
from motiondb.grammar.derivation.plan import best_plan
from motiondb.scene.language.motion_grammar import MotionGrammar

LONGEST_STRING = 400
"""Most actions of a string. Parsing takes time in proportion to the cube of the length: 400 actions
of the basketball grammar are answered in 1 s, 1,600 in a minute. A player acts about once a second,
so 400 are some minutes."""
_STRINGS, _STEPS = 50, 1000
"""Most probable strings whose trees are counted, and prefixes that are extended to find them."""


@dataclass(frozen=True)
class StartReport:
    """Properties of the strings of one start symbol."""

    symbol: str
    team: str  # The role that begins with it, or ""
    empty: bool  # Whether it derives the empty string, which no character may have
    n_strings: int  # Number of its most probable strings whose trees were counted
    ambiguous: tuple[str, ...]  # The first of these with several trees; () if each has one
    n_trees: float = 1.0  # Number of its trees, perhaps infinite


@dataclass(frozen=True)
class GrammarReport:
    """Properties of a grammar.

    Attributes
    ----------
    name : str
        Its name.
    nonterminals : tuple of str
        Its nonterminals.
    terminals : tuple of str
        Its terminals.
    useless : tuple of str
        Symbols that no start symbol leads to.
    nullable : tuple of str
        Nonterminals that derive the empty string.
    rules : tuple of str
        The context-free rules.
    n_semantic_rules : int
        Number of semantic rules.
    starts : tuple of StartReport
        Properties of each start symbol.
    """

    name: str
    nonterminals: tuple[str, ...]
    terminals: tuple[str, ...]
    useless: tuple[str, ...]
    nullable: tuple[str, ...]
    rules: tuple[str, ...]
    n_semantic_rules: int
    starts: tuple[StartReport, ...]


@dataclass(frozen=True)
class Validation:
    """Whether a string of actions is allowed, with its tree or the place where it fails.

    Attributes
    ----------
    allowed : bool
        Whether the grammar has the string.
    start : str
        The start symbol it was parsed from; several, joined by " or ", if they fail alike.
    tree : Tree or None
        Its parse tree.
    position : int
        The first action, from 0, that is not allowed at its place; the length of the string if more
        actions must follow.
    expected : tuple of str
        The actions that are allowed there.
    message : str
        The fault as a sentence; "" if the string is allowed.
    n_trees : float
        Number of parse trees, perhaps infinite; the string is ambiguous if there is more than one.
    """

    allowed: bool
    start: str
    tree: Tree | None = None
    position: int = -1
    expected: tuple[str, ...] = ()
    message: str = ""
    n_trees: float = 0.0


@dataclass(frozen=True)
class Suggestions:
    """The actions that may come next, and the end, with probabilities that sum to 1.

    The probabilities are those of the grammar's rules: equal where the file gives none.
    """

    actions: tuple[tuple[str, float], ...]
    end: float


def check(grammar: MotionGrammar) -> GrammarReport:
    """Report useless and nullable symbols of a grammar, and whether it is ambiguous.

    A symbol is useless if no start symbol leads to it and nobody rests by it. (Nonterminals that
    never end are refused when the file is read.) No program can decide whether any grammar is
    ambiguous; the trees of the most probable strings are counted.
    """
    reached = {rest.action for rest in grammar.activity.rests}
    starts = []
    for start in grammar.starts:
        rules = grammar.started(start.symbol)
        reached |= reachable_symbols(rules)
        empty, counted = start.symbol in nullable_symbols(rules), 0
        several: tuple[tuple[str, ...], float] = (), 1.0
        for string, _ in best_strings(rules, _STRINGS, steps=_STEPS):
            counted += 1
            n_trees = count_trees(rules, string)
            if string and n_trees > 1.0:
                several = string, n_trees
                break
        starts.append(StartReport(start.symbol, start.team, empty, counted, *several))
    whole = grammar.grammar
    names = tuple(terminal.name for terminal in grammar.terminals)
    useless = tuple(s for s in (*whole.nonterminals, *names) if s not in reached)
    nullable = tuple(s for s in whole.nonterminals if s in nullable_symbols(whole))
    return GrammarReport(
        grammar.name,
        whole.nonterminals,
        names,
        useless,
        nullable,
        tuple(map(str, whole.rules)),
        len(grammar.annotations),
        tuple(starts),
    )


def validate(grammar: MotionGrammar, actions: Sequence[str], start: str = "") -> Validation:
    """Return whether a string of actions belongs to the grammar, from one of its start symbols.

    Without ``start``, the start symbols that parse the longest prefix answer together. The empty
    string is never allowed: every player has at least one action.
    """
    _check_length(grammar, actions)
    symbols = [start] if start else [s.symbol for s in grammar.starts]
    faults: list[Validation] = []
    may_end: set[str] = set()
    for symbol in symbols:
        rules = grammar.started(symbol)
        fault = explain(rules, actions) if actions else None
        if fault is not None:
            faults.append(Validation(False, symbol, None, fault.position, fault.expected))
            may_end |= {symbol} if fault.may_end else set()
        elif actions:
            n_trees = count_trees(rules, actions)
            return Validation(True, symbol, parse(rules, actions), n_trees=n_trees)
        else:
            first = tuple(name for name, _ in parsing.suggest(rules, ()) if name is not None)
            faults.append(Validation(False, symbol, None, 0, first))
    furthest = max(fault.position for fault in faults)
    best = [fault for fault in faults if fault.position == furthest]
    expected = tuple(dict.fromkeys(name for fault in best for name in fault.expected))
    ends = furthest > 0 and any(fault.start in may_end for fault in best)
    names = " or ".join(fault.start for fault in best)
    options = [*expected, *(["the end"] if ends else [])]
    message = _say(names, actions, furthest, options)
    return Validation(False, names, None, furthest, expected, message)


def _check_length(grammar: MotionGrammar, actions: Sequence[object]) -> None:
    """Refuse a string that would take too long to parse (SceneError)."""
    if len(actions) > LONGEST_STRING:
        raise SceneError(
            f"{grammar.name}: expected at most {LONGEST_STRING} actions, found {len(actions)}. "
            "Ask for a shorter string."
        )


def _say(start: str, actions: Sequence[str], position: int, options: Sequence[str]) -> str:
    """Return the place where a string fails as a sentence."""
    wanted = f"one of {', '.join(options)}" if len(options) > 1 else "".join(options)
    before = f" after '{' '.join(actions[:position])}'" if position else ""
    place, advice = "the end", "Go on with one of them."
    if position < len(actions):
        place, advice = f"'{actions[position]}'", "Put one of them there, or add a rule for it."
        advice = suggestion(actions[position], options).strip() or advice
    if not actions:
        advice = "Every player needs at least one action."
    at = f"action {position + 1}{before}, from {start}"
    return f"{at}: expected {wanted or 'nothing more'}, found {place}. {advice}"


def suggest(grammar: MotionGrammar, actions: Sequence[str], start: str = "") -> Suggestions:
    """Return the actions that may follow a string, most probable first.

    Without ``start``, every start symbol is weighted by the probability of the string from it.
    """
    _check_length(grammar, actions)
    symbols = [start] if start else [s.symbol for s in grammar.starts]
    log_weights = [prefix_log_probability(grammar.started(symbol), actions) for symbol in symbols]
    highest = max(log_weights)
    chances: dict[str | None, float] = {}
    for symbol, log_weight in zip(symbols, log_weights):
        rules = grammar.started(symbol)
        # relative, because the probability of a long string is below the smallest number
        weight = exp(log_weight - highest) if log_weight > -inf else 0.0
        if weight > 0.0:
            for action, chance in parsing.suggest(rules, actions):
                chances[action] = chances.get(action, 0.0) + weight * chance
    end = chances.pop(parsing.END, 0.0)
    if not actions:  # every player has at least one action
        end = 0.0
    total = sum(chances.values()) + end
    if total <= 0.0:
        raise SceneError(f"{grammar.name}: {validate(grammar, actions, start).message}")
    ranked = sorted(chances.items(), key=lambda pair: -pair[1])
    pairs = tuple((str(action), chance / total) for action, chance in ranked)
    return Suggestions(pairs, end / total)


def plan(
    grammar: MotionGrammar,
    actions: Sequence[str] = (),
    goals: Sequence[Collection[str]] = (),
    start: str = "",
) -> Tree:
    """The shortest string that begins with ``actions`` and then reaches the goals in order."""
    _check_length(grammar, [*actions, *goals])
    known = grammar.terminal
    for goal in goals:
        for action in goal:
            if action not in known:
                raise SceneError(
                    f"{grammar.name}: expected an action, found {action!r}. The actions are"
                    f" {', '.join(known)}."
                )
    return shortest_tree(grammar.started(start), actions, goals)


def shortest_tree(
    grammar: Grammar, prefix: Sequence[str] = (), goals: Sequence[Collection[str]] = ()
) -> Tree:
    r"""Return the tree of a shortest string, of fewest rules; it is never the empty string.

    `goals`: Sets of terminals to pass after the prefix, in this order; any member of a set will do.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> grammar = read_grammar("S -> a S | B\nB -> b | b c")
    >>> shortest_tree(grammar, ["a"], [{"a"}, {"c"}]).leaves()
    ('a', 'a', 'b', 'c')
    """
    wanted = [frozenset(goal) for goal in goals]
    if not prefix and not wanted:
        wanted = [frozenset(grammar.terminals)]
    compiled = _with_equal_rules(grammar)
    choices = best_plan(compiled, prefix, wanted, shortest=True)
    if isinstance(choices, int):
        fault = _nowhere(grammar, prefix, wanted, choices - len(prefix))
        raise SceneError(fault, where="grammar")
    return derive_by(grammar, compiled.rule_numbers[choices].tolist())


@lru_cache(maxsize=16)
def _with_equal_rules(grammar: Grammar) -> CompiledGrammar:
    """Return a grammar whose trees of equal strings differ by their number of rules alone."""
    compiled = compile_grammar(grammar)
    return replace(compiled, probabilities=np.ones(len(compiled.probabilities)))


def _nowhere(
    grammar: Grammar, prefix: Sequence[str], goals: Sequence[frozenset[str]], met: int
) -> Fault:
    """Return why there is no plan: the prefix, or the first goal that cannot be met."""
    begun = f" that begins with '{' '.join(prefix)}'" if prefix else ""
    through = ", then ".join(" or ".join(sorted(goal)) for goal in goals)
    if met < 0:
        limit = "no string of the grammar begins so" if prefix else "the grammar has no string"
    else:
        missing = " or ".join(sorted(goals[met]))
        limit = f"{missing} cannot come {'then' if met else 'at all'}"
    what = f"a string from {grammar.start}{begun} with {through or 'nothing more'}"
    advice = "Leave it out, change the order, or add a rule that allows it."
    fields = {} if met else {"missing": missing}
    return Fault(what, f"that {limit}", advice, fields=fields)
