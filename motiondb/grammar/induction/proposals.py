"""Random changes of rules in arrays: the moves of the annealed search (:mod:`.annealing`).

A move reads the rows of a table and writes the changed rows into one of two spare tables,
``goals``. It returns the number of this table, or -1 if nothing was changed. Unless loops are
allowed, no nonterminal is put into its own rules or into those of symbols that it derives.

The shares of the moves, and of the variants within a move, were chosen by hand; they were not
tuned. With these shares, ``benchmarks/grammar_tasks/effort.py`` chose the number and the length of
the annealings (:mod:`.rule_compaction`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.rewriting import (
    edit_substrings,
    merge,
    replace,
    substitute,
)
from motiondb.grammar.induction.rule_arrays import (
    LEFT,
    LENGTH,
    LONGEST_MEMBER,
    OFFSET,
    ROWS,
    Part,
    RuleTable,
    Substring,
    fitting_length,
    mark_descendants,
    neighbours,
    occurrences,
    same_symbols,
    shared_ends,
)
from motiondb.grammar.kernels import kernel, merged
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


@kernel
def draw(rng: np.random.Generator, n: int) -> int:
    """Draw an integer from 0 to n - 1.

    ``Generator.integers`` takes fifteen times as long in compiled code. The bias, less than
    n / 2^53, does not matter here.
    """
    return int(rng.random() * n)


@kernel
def spare(table: RuleTable, work: Workspace, symbol: int, loops: bool) -> None:
    """Mark the nonterminals whose rules must not receive a nonterminal."""
    if loops:
        work.spared[:] = False
    else:
        mark_descendants(table, symbol, work.spared)


@kernel
def held_nonterminal(table: RuleTable, part: Part, rng: np.random.Generator) -> int:
    """Return a random nonterminal, not the start, that a part holds; -1 if it holds none."""
    shift = draw(rng, part.length)
    for d in range(part.length):
        symbol = table.text[part.start + (d + shift) % part.length]
        if symbol > table.n_terminals:
            return int(symbol)
    return -1


@kernel
def unused(table: RuleTable, alternatives: IntArray) -> int:
    """Return a nonterminal without rules, -1 if there is none."""
    for k in range(1, alternatives.size):
        if alternatives[k] == 0:
            return k + table.n_terminals
    return -1


@kernel
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


@kernel
def is_nonterminal(table: RuleTable, part: Part) -> bool:
    """Whether a part is one nonterminal, not the start."""
    return part.length == 1 and bool(table.text[part.start] > table.n_terminals)


@kernel
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


LONGEST_CHUNK = 10
"""Largest number of symbols of a chunk. Chosen by hand: longer repeats are built from chunks of
chunks."""


_EXCHANGES = 0.25
_CLASSES = _EXCHANGES + 0.3
_CHUNKS = _CLASSES + 0.15
_FOLDS = _CHUNKS + 0.12
_MERGES = _FOLDS + 0.1
"""Cumulative shares of the moves; the remainder substitutes a nonterminal. Most moves are exchanges
and classes, because only these make alternatives."""

_FROM_THE_LEFT = 0.5
"""Probability that an exchange looks for a common beginning before a common end."""

_SHORTENED = 0.1
"""Probability that an exchange uses only a part of the shared symbols, which may be shared by
chance."""

_TWO_ONLY = 0.4
"""Probability that a class is made in two places only, and not wherever its members occur."""

_CHUNK_JOINS = 0.2
"""Probability that a chunk that is not yet an alternative joins a random nonterminal."""

_CHUNK_LOOPS = 0.5
"""Probability that a chunk that is not yet an alternative and contains nonterminals joins one of
these, if loops are allowed."""

_FOLD_ONCE = 0.4  # Probability that an alternative is replaced in one rule only


_NOTHING = -1  # Return value of a move that changed nothing


@kernel
def change(table: RuleTable, work: Workspace, loops: bool, rng: np.random.Generator) -> int:
    """Try one random move.

    Parameters
    ----------
    table : RuleTable
        The rules.
    work : Workspace
        Filled with the changed rules.
    loops : bool
        Whether a nonterminal may be put into rules that it leads to.
    rng : numpy.random.Generator
        Draws the move.
    """
    kind = rng.random()
    if kind < _EXCHANGES:
        return _try_exchange(table, work, loops, rng)
    if kind < _CLASSES:
        return _try_class(table, work, loops, rng)
    if kind < _CHUNKS:
        return _try_chunk(table, work, loops, rng)
    r = draw(rng, table.used[ROWS])
    symbol = table.rows[r, LEFT]
    if symbol == table.n_terminals:
        return _NOTHING
    if kind < _FOLDS:
        return _try_fold(table, r, work, loops, rng)
    if kind < _MERGES:
        other = table.rows[draw(rng, table.used[ROWS]), LEFT]
        if other in (symbol, table.n_terminals):
            return _NOTHING
        return (
            0 if merge(table, work.goals[0], min(symbol, other), max(symbol, other)) else _NOTHING
        )
    return _try_substitute(table, work, symbol)


@merged
def _try_substitute(table: RuleTable, work: Workspace, symbol: int) -> int:
    """Substitute a nonterminal of one rule everywhere, or one of several that is used once."""
    uses = 0
    for r in range(table.used[ROWS]):
        offset = table.rows[r, OFFSET]
        for k in range(offset, offset + table.rows[r, LENGTH]):
            uses += table.text[k] == symbol
    if uses != 1 and work.alternatives[symbol - table.n_terminals] > 1:
        return _NOTHING
    return 0 if substitute(table, work.goals[0], symbol) else _NOTHING


@merged
def _try_exchange(table: RuleTable, work: Workspace, loops: bool, rng: np.random.Generator) -> int:
    """Merge two right sides of a nonterminal; their differing parts become alternatives."""
    rows = table.rows
    a = draw(rng, table.used[ROWS])
    left = rows[a, LEFT]
    if work.alternatives[left - table.n_terminals] < 2:
        return _NOTHING
    b, shift = a, draw(rng, table.used[ROWS])
    for d in range(table.used[ROWS]):
        r = (d + shift) % table.used[ROWS]
        if r != a and rows[r, LEFT] == left:
            b = r
            break
    p, q = shared_ends(table, a, b, rng.random() < _FROM_THE_LEFT)
    if p + q == 0:
        return _NOTHING
    if rng.random() < _SHORTENED:
        if rng.random() < 0.5:
            p -= draw(rng, p + 1)
        else:
            q -= draw(rng, q + 1)
        if p + q == 0:
            return _NOTHING
    one = Substring(a, p, rows[a, LENGTH] - p - q)
    other = Substring(b, p, rows[b, LENGTH] - p - q)
    return _join(table, work, (one, other), loops, rng)


@kernel
def _join(
    table: RuleTable,
    work: Workspace,
    parts: tuple[Substring, Substring],
    loops: bool,
    rng: np.random.Generator,
) -> int:
    """Make two substrings alternatives of one nonterminal, where they stand."""
    a, b = parts
    one = Part(table.rows[a.row, OFFSET] + a.first, a.length)
    other = Part(table.rows[b.row, OFFSET] + b.first, b.length)
    symbol = symbol_for(table, work, one, other, rng)
    if symbol < 0:
        return _NOTHING
    first, second = table.text[one.start], table.text[other.start]
    if one.length == 1 and first == symbol and is_nonterminal(table, other) and second != symbol:
        return 0 if merge(table, work.goals[0], symbol, second) else _NOTHING
    spare(table, work, symbol, loops)
    for row in (a.row, b.row):
        if work.spared[table.rows[row, LEFT] - table.n_terminals]:
            return _NOTHING
    return 0 if edit_substrings(table, work.goals[0], a, b, symbol) else _NOTHING


@merged
def _try_class(table: RuleTable, work: Workspace, loops: bool, rng: np.random.Generator) -> int:
    """Make two parts between the same neighbours alternatives of one nonterminal."""
    a = draw(rng, table.used[ROWS])
    n = table.rows[a, LENGTH]
    i = draw(rng, n + 1)
    first = Substring(a, i, draw(rng, min(LONGEST_MEMBER, n - i) + 1))
    if first.length == n:  # the part is the whole right side and has no neighbours
        return _NOTHING
    second = _substring_between(table, first, rng)
    if second.row < 0 or first.length + second.length == 0:
        return _NOTHING
    # in one row the earlier place comes first
    swapped = first.row == second.row and second.first < first.first
    one, other = (second, first) if swapped else (first, second)
    if one.length == 0 or other.length == 0 or rng.random() < _TWO_ONLY:
        return _join(table, work, (one, other), loops, rng)
    return _join_everywhere(
        table,
        work,
        (
            Part(table.rows[one.row, OFFSET] + one.first, one.length),
            Part(table.rows[other.row, OFFSET] + other.first, other.length),
        ),
        loops,
        rng,
    )


@merged
def _substring_between(table: RuleTable, first: Substring, rng: np.random.Generator) -> Substring:
    """Return a random other substring between the same neighbours; row -1 if there is none."""
    before, _ = neighbours(table, first)
    shift = draw(rng, table.used[ROWS])
    for d in range(table.used[ROWS]):
        r = (d + shift) % table.used[ROWS]
        start, m = table.rows[r, OFFSET], table.rows[r, LENGTH]
        turn = draw(rng, m + 1)
        for e in range(m + 1):
            k = (e + turn) % (m + 1)
            if (table.text[start + k - 1] if k > 0 else -1) != before:
                continue
            length = fitting_length(table, first, r, k)
            if length >= 0:
                return Substring(r, k, length)
    return Substring(-1, 0, 0)


@merged
def _join_everywhere(
    table: RuleTable,
    work: Workspace,
    parts: tuple[Part, Part],
    loops: bool,
    rng: np.random.Generator,
) -> int:
    """Make two parts alternatives of one nonterminal wherever they occur."""
    one, other = parts
    symbol = symbol_for(table, work, one, other, rng)
    if symbol < 0:
        return _NOTHING
    if is_nonterminal(table, one) and is_nonterminal(table, other):
        return (
            0
            if merge(table, work.goals[0], table.text[one.start], table.text[other.start])
            else _NOTHING
        )
    longer_first = one.length >= other.length  # the shorter may be part of the longer
    source, place = table, 0
    for turn in range(2):
        part = one if (turn == 0) == longer_first else other
        if part.length == 1 and table.text[part.start] == symbol:
            continue
        spare(source, work, symbol, loops)
        if not replace(source, work.goals[place], part, symbol, work.spared, -1):
            return _NOTHING
        source, place = work.goals[place], 1 - place
    return 1 - place


@merged
def _try_chunk(table: RuleTable, work: Workspace, loops: bool, rng: np.random.Generator) -> int:
    """Replace a part that occurs in several places by a nonterminal."""
    a = draw(rng, table.used[ROWS])
    n = table.rows[a, LENGTH]
    if n < 2:
        return _NOTHING
    i = draw(rng, n - 1)
    part = Part(table.rows[a, OFFSET] + i, 2 + draw(rng, min(LONGEST_CHUNK, n - i) - 1))
    number = 0
    for r in range(table.used[ROWS]):
        number += occurrences(table, r, part)
    symbol = home(table, part, rng)
    joins = rng.random() < _CHUNK_JOINS
    if loops and symbol < 0 and rng.random() < _CHUNK_LOOPS:
        symbol = held_nonterminal(table, part, rng)
    if symbol < 0 and joins:
        symbol = table.rows[draw(rng, table.used[ROWS]), LEFT]
    elif symbol < 0 and number >= 2:
        symbol = unused(table, work.alternatives)
    if symbol <= table.n_terminals:
        return _NOTHING
    spare(table, work, symbol, loops)
    return 0 if replace(table, work.goals[0], part, symbol, work.spared, -1) else _NOTHING


@merged
def _try_fold(
    table: RuleTable, r: int, work: Workspace, loops: bool, rng: np.random.Generator
) -> int:
    """Replace the right side of row ``r`` by its nonterminal elsewhere, once or everywhere."""
    part, symbol = Part(table.rows[r, OFFSET], table.rows[r, LENGTH]), table.rows[r, LEFT]
    if part.length == 0:
        return _NOTHING
    spare(table, work, symbol, loops)
    only = -1
    if rng.random() < _FOLD_ONCE:
        shift = draw(rng, table.used[ROWS])
        for d in range(table.used[ROWS]):
            k = (d + shift) % table.used[ROWS]
            spared = work.spared[table.rows[k, LEFT] - table.n_terminals]
            if not spared and occurrences(table, k, part):
                only = k
                break
    return 0 if replace(table, work.goals[0], part, symbol, work.spared, only) else _NOTHING
