"""Whether a grammar is deterministic: FIRST sets and LR(1) conflicts.

An item is a rule with a point in its right side and a lookahead: ``[A -> a . B, x]``. A state of
the canonical LR(1) automaton is a closed set of items. Its actions are to shift a terminal that is
after a point, or to reduce a rule whose point is at the end if its lookahead comes next. A state
with two actions for one terminal is a conflict. Without conflicts, every string is parsed from left
to right with one terminal of lookahead and without backtracking, and has one tree.

Sets of lookaheads are bits of an integer; bit 0 is the end of the string.

Source: D. E. Knuth, "On the Translation of Languages from Left to Right", Information and Control
8 (1965); A. V. Aho, M. S. Lam, R. Sethi and J. D. Ullman, "Compilers", 2nd ed., chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Grammar, nullable_symbols

END_MARK = "the end"  # Name of the end of a string among lookaheads

_Core = tuple[int, int]
_State = dict[_Core, int]
_AUGMENTED = -1  # Number of the added rule that derives the start symbol


@dataclass(frozen=True)
class Conflict:
    """Two actions for one lookahead."""

    kind: str  # "shift-reduce" or "reduce-reduce"
    lookaheads: tuple[str, ...]  # The next terminals; :data:`END_MARK` for the end
    rules: tuple[int, ...]  # Numbers of the rules involved
    prefix: tuple[str, ...] = ()  # Symbols that lead to the conflict

    def describe(self, grammar: Grammar) -> str:
        """Return the conflict as a sentence."""
        named = [f"'{grammar.rules[number]}'" for number in self.rules]
        rules = " and ".join(named if len(named) > 1 else [*named, "accepting the string"])
        after = f"after '{' '.join(self.prefix)}', " if self.prefix else ""
        return f"{self.kind}: {after}before {' or '.join(self.lookaheads)}, between {rules}"


@dataclass(frozen=True)
class Automaton:
    """Size and conflicts of a canonical LR(1) automaton."""

    n_states: int  # Number of its states
    conflicts: tuple[Conflict, ...]


def first_sets(grammar: Grammar) -> dict[str, frozenset[str]]:
    r"""Return FIRST of every symbol: the terminals that its strings can begin with.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> sorted(first_sets(read_grammar("S -> A b\nA -> a | empty"))["S"])
    ['a', 'b']
    """
    nullable = nullable_symbols(grammar)
    first: dict[str, set[str]] = {t: {t} for t in grammar.terminals}
    first.update({left: set() for left in grammar.nonterminals})
    changed = True
    while changed:
        changed = False
        for rule in grammar.rules:
            before = len(first[rule.left])
            for symbol in rule.right:
                first[rule.left] |= first[symbol]
                if symbol not in nullable:
                    break
            changed |= len(first[rule.left]) > before
    return {symbol: frozenset(symbols) for symbol, symbols in first.items()}


def lr1_automaton(
    grammar: Grammar, max_states: int = 20_000, max_items: int = 2_000_000
) -> Automaton:
    """Return the size and the conflicts of the canonical LR(1) automaton of a grammar.

    The defaults keep the test within 10 s and 1 GB: a grammar of 1,000 alternatives, each followed
    by all, has a million items.
    """
    building = _Building(grammar)
    start: _State = {(_AUGMENTED, 0): 1}
    states = [building.closure(start)]
    prefixes: list[tuple[str, ...]] = [()]
    known = {_key(start)}  # kernels: each has one closure, and closures of two kernels differ
    at, n_items = 0, len(states[0])
    while at < len(states):
        for symbol, kernel in building.moves(states[at]).items():
            key = _key(kernel)
            if key not in known:
                known.add(key)
                states.append(building.closure(kernel))
                prefixes.append((*prefixes[at], symbol))
                n_items += len(states[-1])
                _check_size(len(states), max_states, n_items, max_items)
        at += 1
    return Automaton(len(states), _conflicts(building, zip(states, prefixes, strict=True)))


def _check_size(n_states: int, max_states: int, n_items: int, max_items: int) -> None:
    """Refuse an automaton that grows too large (SceneError)."""
    for count, most, what in ((n_states, max_states, "states"), (n_items, max_items, "items")):
        if count > most:
            raise SceneError(
                f"grammar: expected at most {most} {what} to test whether it is LR(1), found more."
                " Test a smaller grammar."
            )


def _key(state: _State) -> frozenset[tuple[_Core, int]]:
    return frozenset(state.items())


class _Building:
    """The grammar with its nullable and FIRST sets, and the bits of its terminals."""

    def __init__(self, grammar: Grammar) -> None:
        self.grammar = grammar
        self.marks = (END_MARK, *grammar.terminals)
        self.bit = {mark: 1 << n for n, mark in enumerate(self.marks)}
        self.nullable = nullable_symbols(grammar)
        first = first_sets(grammar)
        self.first = {s: sum(self.bit[t] for t in symbols) for s, symbols in first.items()}

    def right(self, rule: int) -> tuple[str, ...]:
        """Return the right side of a rule; also of the added rule."""
        return (self.grammar.start,) if rule == _AUGMENTED else self.grammar.rules[rule].right

    def next_symbol(self, core: _Core) -> str | None:
        """Return the symbol after the point of an item, or None at its end."""
        right = self.right(core[0])
        return right[core[1]] if core[1] < len(right) else None

    def closure(self, kernel: Mapping[_Core, int]) -> _State:
        """Return all items that a kernel implies, each with the bits of its lookaheads."""
        state, waiting = dict(kernel), list(kernel)
        while waiting:
            core = waiting.pop()
            symbol = self.next_symbol(core)
            if symbol is None or not self.grammar.is_nonterminal(symbol):
                continue
            ahead = self._first_of(self.right(core[0])[core[1] + 1 :], state[core])
            for number in self.grammar.rules_of[symbol]:
                item, known = (number, 0), state.get((number, 0), 0)
                if ahead | known != known or item not in state:
                    state[item] = known | ahead
                    waiting.append(item)
        return state

    def _first_of(self, symbols: Sequence[str], behind: int) -> int:
        terminals = 0
        for symbol in symbols:
            terminals |= self.first[symbol]
            if symbol not in self.nullable:
                return terminals
        return terminals | behind

    def moves(self, state: _State) -> dict[str, _State]:
        """Return the kernels that a state leads to, by the symbol after the point."""
        kernels: dict[str, _State] = {}
        for (rule, at), ahead in state.items():
            symbol = self.next_symbol((rule, at))
            if symbol is not None:
                kernels.setdefault(symbol, {})[rule, at + 1] = ahead
        return kernels

    def names(self, bits: int) -> tuple[str, ...]:
        """Return the terminals of a set of lookaheads."""
        return tuple(mark for mark in self.marks if self.bit[mark] & bits)


def _conflicts(
    building: _Building, states: Iterable[tuple[_State, tuple[str, ...]]]
) -> tuple[Conflict, ...]:
    """Return every conflict once, with the shortest prefix that leads to it."""
    found: dict[tuple[str, tuple[int, ...]], Conflict] = {}
    names = cache(building.names)  # a large grammar has a million conflicts at few sets
    for state, prefix in states:
        shifts, reductions = _actions(building, state)
        for at, (rule, ahead) in enumerate(reductions):
            for symbol, rules in shifts.items():
                if building.bit[symbol] & ahead:
                    _add(found, "shift-reduce", (symbol,), {rule, *rules}, prefix)
            for other, other_ahead in reductions[at + 1 :]:
                if ahead & other_ahead:
                    common = names(ahead & other_ahead)
                    _add(found, "reduce-reduce", common, {rule, other}, prefix)
    return tuple(found.values())


def _actions(
    building: _Building, state: _State
) -> tuple[dict[str, list[int]], list[tuple[int, int]]]:
    """Return the rules that shift, by terminal, and those that reduce, with their lookaheads."""
    shifts: dict[str, list[int]] = {}
    reductions: list[tuple[int, int]] = []
    for core, ahead in state.items():
        symbol = building.next_symbol(core)
        if symbol is None:
            reductions.append((core[0], ahead))
        elif not building.grammar.is_nonterminal(symbol):
            shifts.setdefault(symbol, []).append(core[0])
    return shifts, reductions


def _add(
    found: dict[tuple[str, tuple[int, ...]], Conflict],
    kind: str,
    lookaheads: tuple[str, ...],
    rules: set[int],
    prefix: tuple[str, ...],
) -> None:
    """Keep a conflict, or its lookaheads with the same conflict of an earlier state."""
    numbers = tuple(sorted(rules - {_AUGMENTED}))
    known = found.get((kind, numbers))
    if known is None:
        found[kind, numbers] = Conflict(kind, lookaheads, numbers, prefix)
    elif known.lookaheads != lookaheads:
        lookaheads = tuple(dict.fromkeys((*known.lookaheads, *lookaheads)))
        found[kind, numbers] = Conflict(kind, lookaheads, numbers, known.prefix)
