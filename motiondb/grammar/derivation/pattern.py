"""Patterns of sentences: places for one terminal, and gaps between them.

A *place* takes one terminal of a set. A *gap* takes any number of terminals, or none. The strings
that match a pattern are those that a small automaton reads: state k means that k places are filled,
and a gap is a step from a state to itself. The automaton is made deterministic (by sets of states),
so that each string is read in one way only and its probability is counted once.

Source: J. E. Hopcroft and J. D. Ullman, "Introduction to Automata Theory, Languages, and
Computation" (1979), section 2.3, for automata over sets of states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.records import BoolArray, IntArray

GAP, ANY = "...", "?"
"""The notation for any number of terminals, and for any one terminal."""

MOST_STATES = 200
"""Largest number of states of the automaton. The time of a completion grows with their third
power."""


@dataclass(frozen=True)
class Place:
    """One terminal of a pattern.

    Attributes
    ----------
    text : str
        Text of the place in the pattern.
    terminals : frozenset of str or None
        The terminals that it may be; None for any.
    """

    text: str
    terminals: frozenset[str] | None = None


@dataclass(frozen=True)
class Pattern:
    """Places with gaps between some of them.

    Attributes
    ----------
    places : tuple of Place
        The places.
    gaps : tuple of bool
        Whether a gap is before each place, and after the last one.
    """

    places: tuple[Place, ...]
    gaps: tuple[bool, ...]

    @property
    def text(self) -> str:
        """The pattern as it is written.

        >>> Pattern((Place("a", frozenset("a")), Place("?")), (False, True, False)).text
        'a ... ?'
        """
        parts = [GAP] if self.gaps[0] else []
        for place, gap in zip(self.places, self.gaps[1:], strict=True):
            parts += [place.text, GAP] if gap else [place.text]
        return " ".join(parts)

    def beginning(self, n: int) -> Pattern:
        """Return the first ``n`` places, followed by anything."""
        return Pattern(self.places[:n], (*self.gaps[:n], True))

    def within(self, playable: frozenset[str]) -> Pattern:
        """Return the pattern with these terminals only, in its places and in places for any."""
        return replace(
            self,
            places=tuple(
                replace(place, terminals=playable & (place.terminals or playable))
                for place in self.places
            ),
        )


@dataclass(frozen=True, eq=False)
class Automaton:
    """A deterministic automaton that reads terminals, from state 0.

    Attributes
    ----------
    steps : array (states, terminals)
        The state after each terminal, -1 if it cannot be read.
    accepting : array (states,)
        Whether a string may end in each state.
    """

    steps: IntArray
    accepting: BoolArray


def read_pattern(words: Sequence[Place | str]) -> Pattern:
    """Return the pattern of a list of places, terminals, ``?`` and ``...``.

    Parameters
    ----------
    words : sequence of Place or str
        A string is the name of a terminal, ``?`` or ``...``.

    Raises
    ------
    GrammarError
        There is neither a place nor a gap.

    >>> read_pattern(["...", "a", "?", "...", "..."]).gaps
    (True, False, True)
    """
    places: list[Place] = []
    gaps = [False]
    for word in words:
        if word == GAP:
            gaps[-1] = True
            continue
        if isinstance(word, str):
            word = Place(word, None if word == ANY else frozenset({word}))
        places.append(word)
        gaps.append(False)
    if not places and not gaps[0]:
        raise GrammarError(
            f"pattern: expected terminals, {ANY} or {GAP}, found nothing."
            f" Write for example 'a {GAP} b'."
        )
    return Pattern(tuple(places), tuple(gaps))


def automaton_of(
    pattern: Pattern, terminals: Sequence[str], allowed: frozenset[str] | None = None
) -> Automaton:
    """Return the deterministic automaton of a pattern.

    Parameters
    ----------
    pattern : Pattern
        The pattern.
    terminals : sequence of str
        The terminals that the automaton reads, by number.
    allowed : frozenset of str, optional
        Terminals that a string may hold; all unless given.

    Raises
    ------
    GrammarError
        The pattern needs more than ``MOST_STATES`` states.

    >>> made = automaton_of(read_pattern(["...", "b"]), ["a", "b"])
    >>> made.steps.tolist(), made.accepting.tolist()
    ([[0, 1], [0, 1]], [False, True])
    """
    n = len(pattern.places)
    number = {frozenset({0}): 0}
    waiting = [frozenset({0})]
    steps: list[list[int]] = []
    for states in waiting:  # the list grows during the loop
        row = []
        for terminal in terminals:
            known = allowed is None or terminal in allowed
            after = frozenset(
                target for k in states for target in _targets(pattern, k, terminal) if known
            )
            if after and after not in number:
                number[after] = len(number)
                waiting.append(after)
            row.append(number[after] if after else -1)
        steps.append(row)
        if len(number) > MOST_STATES:
            raise GrammarError(
                f"pattern: expected one that needs at most {MOST_STATES} states, found more in"
                f" {pattern.text!r}. Give fewer places after a gap."
            )
    accepting = [n in states for states in waiting]
    return Automaton(np.array(steps, dtype=np.int64), np.array(accepting, dtype=np.bool_))


def _targets(pattern: Pattern, state: int, terminal: str) -> list[int]:
    """Return the numbers of places that may be filled after a terminal."""
    states = [state] if pattern.gaps[state] else []
    if state < len(pattern.places):
        wanted = pattern.places[state].terminals
        if wanted is None or terminal in wanted:
            states.append(state + 1)
    return states
