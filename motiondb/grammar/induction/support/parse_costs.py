"""Rules as arrays with the bits of their use, for parsing (:mod:`.cheapest_parse`).

A node of a nonterminal with h alternatives costs log2 h bits, and a symbol of a new rule the
logarithm of the alphabet.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET, RuleTable
from motiondb.grammar.rules.rule_laws import nullable_lefts
from motiondb.grammar.rules.rule_set import Right, RuleSet
from motiondb.records import BoolArray, FloatArray, IntArray


class Costs(NamedTuple):
    """Rules with their costs."""

    table: RuleTable  # The rules, component by component, bottom-up
    groups: IntArray  # (components + 1,): index of the first rule of each component
    recursive: BoolArray  # (components,): whether the nonterminals of a component derive themselves
    again: BoolArray  # (rules,): whether a rule can begin with a nonterminal of its component
    bits: FloatArray  # (nonterminals,): bits of a node of each nonterminal
    symbol_bits: float  # Bits of a symbol of a new rule


def costs_of(
    donor: RuleSet, rows: list[tuple[int, Right]], lefts: list[int], groups: list[list[int]]
) -> Costs:
    """Write rules into arrays."""
    names = {left: donor.start + k for k, left in enumerate(lefts)}
    table = np.zeros((len(rows), 5), dtype=np.int64)
    text = np.zeros(1 + sum(len(right) for _, right in rows), dtype=np.int64)
    end = 0
    for r, (left, right) in enumerate(rows):
        text[end : end + len(right)] = [names.get(symbol, symbol) for symbol in right]
        table[r, LEFT], table[r, OFFSET], table[r, LENGTH] = names[left], end, len(right)
        end += len(right)
    sizes = [sum(len(donor.rules[left]) for left in group) for group in groups]
    nullable = nullable_lefts(donor.rules)
    group_of = {left: g for g, group in enumerate(groups) for left in group}
    return Costs(
        RuleTable(table, text, np.array([len(rows), end]), donor.n_terminals),
        np.cumsum([0, *sizes]).astype(np.int64),
        np.array([_derives_itself(donor, group) for group in groups], dtype=np.bool_),
        np.array([_begins_within(row, group_of, nullable) for row in rows], dtype=np.bool_),
        np.array([math.log2(max(1, len(donor.rules[left]))) for left in lefts]),
        math.log2(len(lefts) + donor.n_terminals + 1),
    )


def _derives_itself(donor: RuleSet, group: list[int]) -> bool:
    """Whether the nonterminals of a component derive themselves."""
    return len(group) > 1 or any(group[0] in right for right in donor.rules[group[0]])


def _begins_within(
    row: tuple[int, Right], group_of: dict[int, int], nullable: frozenset[int]
) -> bool:
    """Whether a right side can begin with a nonterminal of the component of its left side."""
    left, right = row
    for symbol in right:
        if group_of.get(symbol) == group_of[left]:
            return True
        if symbol not in nullable:
            return False
    return False
