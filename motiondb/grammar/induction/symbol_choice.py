"""Choose the nonterminal that a move gives to parts of right sides (:mod:`.proposals`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.rule_arrays import (
    LEFT,
    LENGTH,
    OFFSET,
    ROWS,
    RuleTable,
    compiled,
    mark_descendants,
)
from motiondb.grammar.induction.rule_places import Part, same_symbols
from motiondb.records import BoolArray, IntArray

_IS_NONTERMINAL = 0.5
"""Probability that a part which is one nonterminal is taken as the nonterminal of a class."""

_FIRST_HOME, _ANY_HOME, _ANY_NONTERMINAL = 0.4, 0.65, 0.75
"""Shares, summed up, of the nonterminals that a class joins: one that derives the first part or
else the second, the second or else the first, a random one. Else it is a new one."""


class Workspace(NamedTuple):
    """Arrays that the moves use."""

    alternatives: IntArray  # (nonterminals,): the number of rules of each nonterminal
    spared: BoolArray  # (nonterminals,): work array of marks
    goals: tuple[RuleTable, RuleTable]  # The tables for changed rules
    spare: RuleTable  # Work table of :func:`.rewriting.tidy`


@compiled
def draw(rng: np.random.Generator, n: int) -> int:
    """Draw an integer from 0 to n - 1.

    ``Generator.integers`` takes fifteen times as long in compiled code. The bias, less than
    n / 2^53, does not matter here.
    """
    return int(rng.random() * n)


@compiled
def spare(table: RuleTable, work: Workspace, symbol: int, loops: bool) -> None:
    """Mark the nonterminals whose rules must not receive a nonterminal."""
    if loops:
        work.spared[:] = False
    else:
        mark_descendants(table, symbol, work.spared)


@compiled
def held_nonterminal(table: RuleTable, part: Part, rng: np.random.Generator) -> int:
    """Return a random nonterminal, not the start, that a part holds; -1 if it holds none."""
    shift = draw(rng, part.length)
    for d in range(part.length):
        symbol = table.text[part.start + (d + shift) % part.length]
        if symbol > table.n_terminals:
            return int(symbol)
    return -1


@compiled
def unused(table: RuleTable, alternatives: IntArray) -> int:
    """Return a nonterminal without rules, -1 if there is none."""
    for k in range(1, alternatives.size):
        if alternatives[k] == 0:
            return k + table.n_terminals
    return -1


@compiled
def home(table: RuleTable, part: Part, rng: np.random.Generator) -> int:
    """Return a nonterminal, not the start, that has the part as an alternative; -1 if none has."""
    shift = draw(rng, table.used[ROWS])
    for d in range(table.used[ROWS]):
        r = (d + shift) % table.used[ROWS]
        if (
            table.rows[r, LENGTH] == part.length
            and table.rows[r, LEFT] > table.n_terminals
            and same_symbols(table.text, table.rows[r, OFFSET], part.start, part.length)
        ):
            return int(table.rows[r, LEFT])
    return -1


@compiled
def is_nonterminal(table: RuleTable, part: Part) -> bool:
    """Whether a part is one nonterminal, not the start."""
    return part.length == 1 and bool(table.text[part.start] > table.n_terminals)


@compiled
def symbol_for(
    table: RuleTable, work: Workspace, one: Part, other: Part, rng: np.random.Generator
) -> int:
    """Return the nonterminal for two parts: a part itself, a home, a random or a new one."""
    if rng.random() < _IS_NONTERMINAL:
        if is_nonterminal(table, one):
            return int(table.text[one.start])
        if is_nonterminal(table, other):
            return int(table.text[other.start])
    way = rng.random()
    if way < _ANY_HOME:
        first, second = (one, other) if way < _FIRST_HOME else (other, one)
        symbol = home(table, first, rng)
        if symbol < 0:
            symbol = home(table, second, rng)
        if symbol >= 0:
            return symbol
    elif way < _ANY_NONTERMINAL:
        left = table.rows[draw(rng, table.used[ROWS]), LEFT]
        if left != table.n_terminals:
            return int(left)
    return unused(table, work.alternatives)
