"""Patterns of sentences: symbols, and gaps between them.

A *symbol* of a pattern matches one terminal of a set. A *gap* takes any number of terminals, or
none. The strings that match a pattern are those that a small automaton reads: state k means that k
symbols are matched, and a gap is a step from a state to itself.

Each string must be read in one way only, so that its probability is counted once. Up to the last
gap the automaton is made deterministic (by sets of states). A set holds no state below its highest
gap, because what can be read from there can be read from the gap too. The symbols after the last
gap match the last terminals of the string. So they need no sets: one state for each is enough,
although the automaton that is read from the left (:func:`acceptor_of`) is then not deterministic.

Sources: J. E. Hopcroft and J. D. Ullman, "Introduction to Automata Theory, Languages, and
Computation" (1979), section 2.3, for automata over sets of states; R. Book, S. Even, S. Greibach
and G. Ott, "Ambiguity in Graphs and Expressions", IEEE Transactions on Computers C-20 (1971), for
automata that read each string in one way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import strong_components
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.records import BoolArray, IntArray

GAP, ANY = "...", "?"  # The notation for any number of terminals, and for any one terminal

MOST_STATES = 200
"""Largest number of states of an automaton. The time of a completion grows with their third
power at most."""


@dataclass(frozen=True)
class PatternSymbol:
    """A symbol of a pattern: it matches one terminal of a set."""

    text: str  # Text of the symbol in the pattern
    terminals: frozenset[str] | None = None  # The terminals that match it; None for any


@dataclass(frozen=True)
class Pattern:
    """Symbols with gaps between some of them."""

    symbols: tuple[PatternSymbol, ...]
    gaps: tuple[bool, ...]  # Whether a gap is before each symbol, and after the last one

    @property
    def text(self) -> str:
        """The pattern as it is written.

        >>> a, anything = PatternSymbol("a", frozenset("a")), PatternSymbol("?")
        >>> Pattern((a, anything), (False, True, False)).text
        'a ... ?'
        """
        parts = [GAP] if self.gaps[0] else []
        for symbol, gap in zip(self.symbols, self.gaps[1:], strict=True):
            parts += [symbol.text, GAP] if gap else [symbol.text]
        return " ".join(parts)

    def beginning(self, n: int) -> Pattern:
        """Return the first ``n`` symbols, followed by anything."""
        return Pattern(self.symbols[:n], (*self.gaps[:n], True))

    def within(self, playable: frozenset[str]) -> Pattern:
        """Return the pattern with these terminals only, also where any was allowed."""
        return replace(
            self,
            symbols=tuple(
                replace(symbol, terminals=playable & (symbol.terminals or playable))
                for symbol in self.symbols
            ),
        )


@dataclass(frozen=True, eq=False)
class Automaton:
    """A deterministic automaton that reads terminals, from state 0."""

    steps: IntArray  # (states, terminals): the state after each terminal, -1 if it cannot be read
    accepting: BoolArray  # (states,): whether a string may end in each state


def read_pattern(words: Sequence[PatternSymbol | str]) -> Pattern:
    """Return the pattern of a list of symbols, terminals, ``?`` and ``...``.

    >>> read_pattern(["...", "a", "?", "...", "..."]).gaps
    (True, False, True)
    """
    symbols: list[PatternSymbol] = []
    gaps = [False]
    for word in words:
        if word == GAP:
            gaps[-1] = True
            continue
        if isinstance(word, str):
            word = PatternSymbol(word, None if word == ANY else frozenset({word}))
        symbols.append(word)
        gaps.append(False)
    if not symbols and not gaps[0]:
        raise GrammarError(
            f"pattern: expected terminals, {ANY} or {GAP}, found nothing."
            f" Write for example 'a {GAP} b'."
        )
    return Pattern(tuple(symbols), tuple(gaps))


def automaton_of(
    pattern: Pattern, terminals: Sequence[str], allowed: frozenset[str] | None = None
) -> Automaton:
    """Return the deterministic automaton of a pattern.

    >>> made = automaton_of(read_pattern(["...", "b"]), ["a", "b"])
    >>> made.steps.tolist(), made.accepting.tolist()
    ([[0, 1], [0, 1]], [False, True])
    """
    n = len(pattern.symbols)
    number = {frozenset({0}): 0}
    waiting = [frozenset({0})]
    steps: list[list[int]] = []
    for states in waiting:  # the list grows during the loop
        row = []
        for terminal in terminals:
            known = allowed is None or terminal in allowed
            reached = {t for k in states for t in _targets(pattern, k, terminal) if known}
            highest = max((k for k in reached if pattern.gaps[k]), default=0)
            after = frozenset(k for k in reached if k >= highest)
            if after and after not in number:
                number[after] = len(number)
                waiting.append(after)
            row.append(number[after] if after else -1)
        steps.append(row)
        _check_size(pattern, len(number))
    accepting = [n in states for states in waiting]
    return Automaton(np.array(steps, dtype=np.int64), np.array(accepting, dtype=np.bool_))


def _check_size(pattern: Pattern, n_states: int) -> None:
    if n_states > MOST_STATES:
        raise GrammarError(
            f"pattern: expected one that needs at most {MOST_STATES} states, found more in"
            f" {pattern.text!r}. Give fewer positions after a gap."
        )


def acceptor_of(
    pattern: Pattern, terminals: Sequence[str], allowed: frozenset[str] | None = None
) -> automata.Automaton:
    """Return the automaton of a pattern that reads each string in one way at most.

    >>> made = acceptor_of(read_pattern(["a", "...", "b", "?"]), ["a", "b"])
    >>> made.starts.tolist(), made.targets.tolist(), made.terminals.tolist()
    ([0, 1, 2, 4, 4], [1, 2, 3, 3], [0, 1, 0, 1])
    >>> made.stays[made.loops].tolist(), made.final.tolist()
    ([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [0.0, 0.0]], [False, False, False, True])
    """
    last = max((k for k, gap in enumerate(pattern.gaps) if gap), default=0)
    head = Pattern(pattern.symbols[:last], (*pattern.gaps[:last], pattern.gaps[last]))
    tail = pattern.symbols[last:]
    made = automaton_of(head, terminals, allowed)
    n_head = len(made.steps)
    n = n_head + len(tail)
    _check_size(pattern, n)
    order, bounds = _blocks(made)
    place = np.empty(n_head, dtype=np.int64)
    place[order] = np.arange(n_head)
    steps = np.zeros((n, len(terminals), n), dtype=np.bool_)
    states, read = np.nonzero(made.steps >= 0)
    steps[place[states], read, place[made.steps[states, read]]] = True
    ends = np.zeros(n, dtype=np.bool_)
    ends[place[made.accepting]] = True
    for k, one in enumerate(tail, start=n_head):
        fits = [
            number
            for number, t in enumerate(terminals)
            if (one.terminals is None or t in one.terminals) and (allowed is None or t in allowed)
        ]
        steps[np.flatnonzero(ends)[:, None], fits, k] = True
        ends[:] = False
        ends[k] = True
    bounds = np.concatenate((bounds, np.arange(n_head + 1, n + 1)))
    return automata.from_steps(steps, ends, bounds)


def _blocks(automaton: Automaton) -> tuple[IntArray, IntArray]:
    """Return the states in an order that all steps follow except within blocks, and the bounds."""
    sources, read = np.nonzero(automaton.steps >= 0)
    starts = np.searchsorted(sources, np.arange(len(automaton.steps) + 1))
    label = strong_components(starts.astype(np.int64), automaton.steps[sources, read])
    order = np.argsort(-label, kind="stable")
    return order, np.concatenate(([0], np.cumsum(np.bincount(label)[::-1])))


def _targets(pattern: Pattern, state: int, terminal: str) -> list[int]:
    """Return the numbers of symbols that may be matched after a terminal."""
    states = [state] if pattern.gaps[state] else []
    if state < len(pattern.symbols):
        wanted = pattern.symbols[state].terminals
        if wanted is None or terminal in wanted:
            states.append(state + 1)
    return states
