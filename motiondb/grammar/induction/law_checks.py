"""Check the laws of rules (:mod:`motiondb.grammar.rules.rule_set`), in arrays.

What nonterminals derive is a fixed point: rules may loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.rule_arrays import (
    LEFT,
    LENGTH,
    OFFSET,
    ROWS,
    RuleTable,
    mark_descendants,
    table_of,
)
from motiondb.grammar.kernels import kernel, maker, merged
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.records import BoolArray, IntArray

WEIGHT_BITS = 48
"""Number of bits of the random weight of a constant terminal: different numbers have equal sums
with probability 2^-48, and sums over sentences fit into 64 bits."""

_ODD = 0x9E3779B97F4A7C15  # Powers of it look random in their lowest bits

_WAITS, _FITS, _BREAKS = range(3)  # The state of a rule while the laws are checked bottom-up


class Laws(NamedTuple):
    """The laws of a rule set, in a form that is checked by sums and bits."""

    # (T,): a random number for each constant terminal and 0 for the others, so that sums of weights
    # are equal only where the numbers of these terminals are
    weights: IntArray
    marks: IntArray  # (T,): a different bit for each single terminal, 0 for the others
    total: int  # The sum of weights of a sentence
    empties: bool  # Whether right sides may be empty
    # (nonterminals,): nonterminals that may derive a string which holds themselves, from the start
    # symbol on
    may_loop: BoolArray
    loops: bool


def laws_of(rule_set: RuleSet, may_loop: BoolArray, weights_of: Sequence[int]) -> Laws:
    """Return the laws of a rule set, given a random weight for each of its constants."""
    weights = np.zeros(rule_set.n_terminals, dtype=np.int64)
    total = 0
    for (terminal, number), weight in zip(rule_set.constants.items(), weights_of, strict=True):
        weights[terminal] = weight
        total += weight * number
    marks = np.zeros(rule_set.n_terminals, dtype=np.int64)
    for place, terminal in enumerate(sorted(rule_set.singles)):
        marks[terminal] = 1 << place
    return Laws(weights, marks, total, rule_set.empties, may_loop, bool(may_loop.any()))


def is_lawful(rule_set: RuleSet) -> bool:
    """Whether rules keep all laws of their rule set.

    >>> is_lawful(RuleSet(2, {2: {(0, 3): 2}, 3: {(1,): 1, (0, 3): 1}}))
    False
    >>> is_lawful(RuleSet(2, {2: {(0, 3): 2}, 3: {(1,): 1, (0, 3): 1}}, loops=True))
    True
    """
    known = {*rule_set.rules, *range(rule_set.n_terminals)}
    if not all(known.issuperset(right) for _, right in rule_set.uses()):
        return False
    n_rules, n_lefts = sum(map(len, rule_set.rules.values())), len(rule_set.rules)
    table = table_of(rule_set, n_rules, sum(len(right) for _, right in rule_set.uses()) + 1)
    alternatives = np.array([len(rule_set.rules[left]) for left in sorted(rule_set.rules)])
    weights = [pow(_ODD, k + 1, 1 << WEIGHT_BITS) for k in range(len(rule_set.constants))]
    laws = laws_of(rule_set, np.full(n_lefts, rule_set.loops), weights)
    return bool(keeps_laws(table, alternatives, laws))


class _Derived(NamedTuple):
    """Properties of what the nonterminals derive; arrays (nonterminals,), valid where ``known``."""

    known: BoolArray
    nullable: BoolArray
    sums: IntArray
    held: IntArray


@maker
def keeps_laws(table: RuleTable, alternatives: IntArray, laws: Laws) -> bool:
    """Check the laws of :mod:`motiondb.grammar.rules.rule_set` on arrays.

    Parameters
    ----------
    table : RuleTable
        The rules.
    alternatives : array (nonterminals,)
        The number of rules of each nonterminal.
    laws : Laws
        The laws that must hold.
    """
    n = 1 + _last_nonterminal(table)  # the arrays have room for many more
    alternatives = alternatives[:n]
    derived = _Derived(
        np.zeros(n, np.bool_), np.zeros(n, np.bool_), np.zeros(n, np.int64), np.zeros(n, np.int64)
    )
    if not _solve_sums(table, laws, derived) or derived.sums[0] != laws.total:
        return False
    _grow_sets(table, laws, derived)
    for r in range(table.used[ROWS]):
        state, _, _, _ = _read_right(table, r, laws, derived)
        if state == _BREAKS:
            return False
    if derived.nullable[0] or _repeats_nullable(table, derived.nullable):
        return False
    if laws.loops:
        reached = np.zeros(n, np.bool_)
        mark_descendants(table, table.n_terminals, reached)
        for k in range(n):
            if alternatives[k] > 0 and not reached[k]:
                return False
    waiting = alternatives > 0
    return _ends_bottom_up(table, waiting, laws.may_loop) and not _derives_itself_alone(
        table, derived.nullable, alternatives
    )


@merged
def _last_nonterminal(table: RuleTable) -> int:
    """Return the greatest nonterminal with rules, or on a right side, where it may have none."""
    last = 0
    for r in range(table.used[ROWS]):
        last = max(last, table.rows[r, LEFT] - table.n_terminals)
        for k in range(table.rows[r, OFFSET], table.rows[r, OFFSET] + table.rows[r, LENGTH]):
            last = max(last, table.text[k] - table.n_terminals)
    return last


@kernel
def _read_right(
    table: RuleTable, r: int, laws: Laws, derived: _Derived
) -> tuple[int, int, int, bool]:
    """Return the state of a rule, its sum of weights, its single terminals, and if it is empty."""
    total, bits, twice, empty = 0, 0, 0, True
    offset = table.rows[r, OFFSET]
    for k in range(offset, offset + table.rows[r, LENGTH]):
        symbol = table.text[k]
        if symbol < table.n_terminals:
            total += laws.weights[symbol]
            twice |= bits & laws.marks[symbol]
            bits |= laws.marks[symbol]
            empty = False
            continue
        symbol -= table.n_terminals
        if not derived.known[symbol]:
            return _WAITS, 0, 0, False
        total += derived.sums[symbol]
        twice |= bits & derived.held[symbol]
        bits |= derived.held[symbol]
        empty = empty and derived.nullable[symbol]
    if twice or (empty and not laws.empties):
        return _BREAKS, total, bits, empty
    return _FITS, total, bits, empty


@merged
def _repeats_nullable(table: RuleTable, nullable: BoolArray) -> bool:
    """Whether a nonterminal that may be empty occurs next to itself."""
    text = table.text
    for r in range(table.used[ROWS]):
        offset = table.rows[r, OFFSET]
        for k in range(offset + 1, offset + table.rows[r, LENGTH]):
            symbol = text[k] - table.n_terminals
            if symbol >= 0 and text[k] == text[k - 1] and nullable[symbol]:
                return True
    return False


@merged
def _solve_sums(table: RuleTable, laws: Laws, derived: _Derived) -> bool:
    """Fill the sums of weights; False if rules disagree, or a nonterminal derives no string.

    A nonterminal is known as soon as one of its rules is. Each rule is compared when all
    nonterminals of its right side are known.
    """
    n_rows, n_read, before = table.used[ROWS], 0, -1
    while n_read < n_rows:
        if n_read == before:
            return False
        before, n_read = n_read, 0
        for r in range(n_rows):
            state, total, _, _ = _read_right(table, r, laws, derived)
            if state == _WAITS:
                continue
            n_read += 1
            left = table.rows[r, LEFT] - table.n_terminals
            if derived.known[left] and derived.sums[left] != total:
                return False
            derived.known[left] = True
            derived.sums[left] = total
    for r in range(n_rows):  # rules that were read before a nonterminal was known
        _, total, _, _ = _read_right(table, r, laws, derived)
        if derived.sums[table.rows[r, LEFT] - table.n_terminals] != total:
            return False
    return True


@merged
def _grow_sets(table: RuleTable, laws: Laws, derived: _Derived) -> None:
    """Determine which nonterminals may be empty, and the single terminals that each may hold."""
    grown = True
    while grown:
        grown = False
        for r in range(table.used[ROWS]):
            _, _, bits, empty = _read_right(table, r, laws, derived)
            left = table.rows[r, LEFT] - table.n_terminals
            if bits & ~derived.held[left]:
                derived.held[left] |= bits
                grown = True
            if empty and not derived.nullable[left]:
                derived.nullable[left] = True
                grown = True


@maker
def _ends_bottom_up(table: RuleTable, waiting: BoolArray, may_loop: BoolArray) -> bool:
    """Whether all cycles of rules lead through nonterminals that may loop only.

    ``waiting`` marks the nonterminals, and is changed. A nonterminal that waits for no other is
    done. If there is none, those are done that may loop and wait only for others that may loop.
    """
    while True:
        n_done = 0
        for k in range(waiting.size):
            if waiting[k] and not _waits(table, k, waiting, waiting):
                waiting[k] = False
                n_done += 1
        if n_done > 0:
            continue
        left_over = False
        for k in range(waiting.size):
            left_over = left_over or waiting[k]
        if not left_over:
            return True
        if not _drop_loops(table, waiting, may_loop):
            return False


@kernel
def _waits(table: RuleTable, k: int, waiting: BoolArray, others: BoolArray) -> bool:
    """Whether a rule of a nonterminal holds one that waits and is among others."""
    for r in range(table.used[ROWS]):
        if table.rows[r, LEFT] - table.n_terminals != k:
            continue
        offset = table.rows[r, OFFSET]
        for d in range(offset, offset + table.rows[r, LENGTH]):
            symbol = table.text[d] - table.n_terminals
            if symbol >= 0 and waiting[symbol] and others[symbol]:
                return True
    return False


@maker
def _drop_loops(table: RuleTable, waiting: BoolArray, may_loop: BoolArray) -> bool:
    """Unmark the nonterminals that may loop and wait only for each other; whether there are any."""
    kept = waiting & may_loop[: waiting.size]
    pruned = True
    while pruned:
        pruned = False
        outside = ~kept
        for k in range(kept.size):
            if kept[k] and _waits(table, k, waiting, outside):
                kept[k] = False
                pruned = True
    for k in range(kept.size):
        if kept[k]:
            waiting[k] = False
    return bool(kept.any())


@merged
def _derives_itself_alone(table: RuleTable, nullable: BoolArray, alternatives: IntArray) -> bool:
    """Whether a nonterminal derives exactly itself."""
    waiting = alternatives > 0
    dropped = True
    while dropped:
        dropped = False
        for k in range(waiting.size):
            if waiting[k] and not _waits_alone(table, k, waiting, nullable):
                waiting[k] = False
                dropped = True
    return bool(waiting.any())


@merged
def _waits_alone(table: RuleTable, k: int, waiting: BoolArray, nullable: BoolArray) -> bool:
    """Whether a rule of a nonterminal derives exactly a waiting one."""
    for r in range(table.used[ROWS]):
        if table.rows[r, LEFT] - table.n_terminals != k:
            continue
        offset, n_full, full, may_be_alone = table.rows[r, OFFSET], 0, -1, False
        for d in range(offset, offset + table.rows[r, LENGTH]):
            symbol = table.text[d] - table.n_terminals
            if symbol < 0 or not nullable[symbol]:
                n_full, full = n_full + 1, symbol
            elif waiting[symbol]:
                may_be_alone = True
        if n_full == 0 and may_be_alone:
            return True
        if n_full == 1 and full >= 0 and waiting[full]:
            return True
    return False
