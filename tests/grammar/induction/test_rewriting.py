"""Changes of rules in arrays against the same changes of rules in dictionaries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_rules import A, B, S, T, acyclic_rules

from motiondb.grammar.induction.law_checks import Laws, keeps_laws
from motiondb.grammar.induction.rewriting import (
    edit_substrings,
    merge,
    replace,
    substitute,
    tidy,
)
from motiondb.grammar.induction.rule_arrays import (
    ROWS,
    SYMBOLS,
    Part,
    Substring,
    bits_of,
    empty_table,
    occurrences,
    rules_of,
    table_of,
)
from motiondb.grammar.induction.rule_compaction import absorb_neighbours, release_ends
from motiondb.grammar.rules.rule_set import RuleSet


class Arrays:
    """A rule set in arrays, with room for one change."""

    def __init__(self, rule_set):
        self.like = rule_set
        self.table = table_of(rule_set, 64, 600)
        self.goal = empty_table(self.table.text, 64, rule_set.n_terminals)

    def spell(self, part):
        """Write a part into the text."""
        place = int(self.table.used[SYMBOLS])
        self.table.text[place : place + len(part)] = part
        self.table.used[SYMBOLS] += len(part)
        return Part(place, len(part))

    def after(self, change, *arguments):
        assert change(self.table, self.goal, *arguments)
        assert self.goal.used[ROWS] > 0
        actual = rules_of(self.goal, self.like).rules
        return {left: rights for left, rights in actual.items() if rights}

    def row(self, left, right):
        for r in range(self.table.used[ROWS]):
            symbol, offset, length, *_ = self.table.rows[r].tolist()
            if symbol == left and tuple(self.table.text[offset : offset + length]) == right:
                return r
        raise AssertionError


def collected(uses):
    """Rules of (left, right, count), a left that is its own right left out."""
    rules = {}
    for left, right, count in uses:
        if right != (left,):
            rights = rules.setdefault(left, {})
            rights[right] = rights.get(right, 0) + count
    return rules


def uses_of(rule_set):
    return [(x, right, n) for x, rights in rule_set.rules.items() for right, n in rights.items()]


def replaced(right, part, symbol):
    """The right side with the symbol for a part, from the left, and how often."""
    actual, i, number = [], 0, 0
    while i < len(right):
        if right[i : i + len(part)] == part:
            actual.append(symbol)
            i += len(part)
            number += 1
        else:
            actual.append(right[i])
            i += 1
    return tuple(actual), number


@settings(max_examples=40, deadline=None)
@given(acyclic_rules(), st.lists(st.integers(0, 2), min_size=1, max_size=3).map(tuple))
def test_a_part_is_replaced_wherever_it_stands(rule_set, part):
    arrays = Arrays(rule_set)
    place = arrays.spell(part)
    expected, nodes = [], 0
    for left, right, count in uses_of(rule_set):
        changed, number = (right, 0) if left == B else replaced(right, part, B)
        expected.append((left, changed, count))
        nodes += number * count
        seen = replaced(right, part, B)[1]
        assert occurrences(arrays.table, arrays.row(left, right), place) == seen
    if nodes:
        expected.append((B, part, nodes))
    spared = np.array([False, False, True])
    actual = arrays.after(replace, place, B, spared, -1)
    assert actual == collected(expected)


@settings(max_examples=40, deadline=None)
@given(acyclic_rules())
def test_two_nonterminals_become_one_as_if_renamed(rule_set):
    twin = rule_set.copy()
    twin.rename({B: A})
    expected = collected(uses_of(twin))
    assert Arrays(rule_set).after(merge, A, B) == expected


@settings(max_examples=40, deadline=None)
@given(acyclic_rules())
def test_a_nonterminal_of_one_rule_is_written_out(rule_set):
    spelled, count = next(iter(rule_set.rules[B].items()))
    rule_set.rules[B] = {spelled: count}
    expected = [
        (left, tuple(s for old in right for s in (spelled if old == B else (old,))), count)
        for left, right, count in uses_of(rule_set)
        if left != B
    ]
    assert Arrays(rule_set).after(substitute, B) == collected(expected)


@settings(max_examples=40, deadline=None)
@given(acyclic_rules(), st.data())
def test_alternatives_are_written_into_the_one_rule_that_uses_them(rule_set, data):
    for left in (S, A):  # B stands nowhere but in a rule of its own
        kept = {tuple(s for s in right if s != B): n for right, n in rule_set.rules[left].items()}
        rule_set.rules[left] = {right: n for right, n in kept.items() if right} or {(0,): 1}
    inner = data.draw(st.lists(st.integers(0, 2), max_size=3))
    place = data.draw(st.integers(0, len(inner)))
    right = (*inner[:place], B, *inner[place:])
    count = sum(rule_set.rules[B].values())
    rule_set.rules[A][right] = count
    expected = [u for u in uses_of(rule_set) if u[0] != B and u[1] != right]
    for part, number in rule_set.rules[B].items():
        expected.append((A, (*inner[:place], *part, *inner[place:]), number))
    assert Arrays(rule_set).after(substitute, B) == collected(expected)


def test_what_never_saves_bits_is_written_out_wherever_it_stands() -> None:
    """A stands alone in one rule of S; B, of one symbol, stands in two."""
    rules = {S: {(A,): 2, (B, 1): 1, (2, B): 1}, A: {(1, 2): 1, (2, 1): 1}, B: {(0,): 2}}
    arrays, numbers = Arrays(RuleSet(T, rules)), np.zeros((2, 8), dtype=np.int64)
    assert tidy(arrays.table, arrays.goal, *numbers)
    actual = rules_of(arrays.table, arrays.like).rules
    assert actual[S] == {(1, 2): 1, (2, 1): 1, (0, 1): 1, (2, 0): 1}


@pytest.mark.parametrize("one_row", [True, False])
def test_parts_at_two_places_become_alternatives(one_row):
    first, second = (0, 1, 2, 0), (2, 1, 1)
    rule_set = RuleSet(T, {S: {first: 2, second: 3}})
    arrays = Arrays(rule_set)
    a, b = arrays.row(S, first), arrays.row(S, second)
    if one_row:
        actual = arrays.after(edit_substrings, Substring(a, 0, 1), Substring(a, 2, 2), A)
        assert actual == {S: {(A, 1, A): 2, second: 3}, A: {(0,): 2, (2, 0): 2}}
    else:
        actual = arrays.after(edit_substrings, Substring(a, 1, 2), Substring(b, 1, 0), A)
        assert actual == {S: {(0, A, 0): 2, (2, A, 1, 1): 3}, A: {(1, 2): 2, (): 3}}


@settings(max_examples=40, deadline=None)
@given(acyclic_rules(least=0))
def test_bits_are_those_of_the_rule_set(rule_set):
    arrays = Arrays(rule_set)
    alternatives, nodes = np.zeros(8, dtype=np.int64), np.zeros(8, dtype=np.int64)
    logs = np.log2(np.maximum(np.arange(64), 1))
    bits = bits_of(arrays.table, nodes, alternatives, logs)
    assert bits == pytest.approx(rule_set.bits())


@pytest.mark.parametrize("loops", [False, True])
def test_rules_that_use_a_nonterminal_without_rules_break_the_laws(loops: bool) -> None:
    """It lies beyond the nonterminals with rules; what lies there in memory must not be read."""
    table = table_of(RuleSet(T, {S: {(0, A): 1}, A: {(1, 2): 1}}), 64, 600)
    table.used[ROWS] = 1  # the rule of A is gone
    alternatives = np.zeros(8, dtype=np.int64)
    alternatives[0] = 1
    zeros = np.zeros(T, dtype=np.int64)
    laws = Laws(zeros, zeros, 0, True, np.full(8, loops), loops)
    for _ in range(200):
        np.ones(64, dtype=np.bool_)  # memory that is reused without being cleared
        assert not keeps_laws(table, alternatives, laws)


@pytest.mark.parametrize(
    ("change", "rules", "held"),
    [
        # neighbours that differ, that are constant or single, or that save no bits
        (absorb_neighbours, {S: {(A, 1): 2}, A: {(0, A, 0): 1, (0,): 2}}, {}),
        (absorb_neighbours, {S: {(A, 1): 2}, A: {(0, A, 1): 1, (0,): 2}}, {"singles": {1}}),
        (absorb_neighbours, {S: {(A, 1): 2}, A: {(0, A, 1): 1, (0,): 2}}, {"constants": {1: 1}}),
        (
            absorb_neighbours,
            {
                S: {(A, 1): 4, (1, A, 1): 1},
                A: {(0, A, 1): 1, (0,): 1, (0,) * 2: 1, (0,) * 3: 1, (0,) * 4: 1},
            },
            {},
        ),
        # ends that cost bits to move, or that stand within the loop
        (release_ends, {S: {(0, A, A): 2, (A, 0): 1}, A: {(0, A): 1, (0, 1): 5}}, {}),
        (release_ends, {S: {(0, A): 2}, A: {(0, A, 0): 1, (0, 1): 2}}, {}),
    ],
)
def test_neighbours_and_ends_of_loops_that_stay(change, rules, held) -> None:
    rule_set = RuleSet(T, rules, **held, loops=True)
    assert change(rule_set) is rule_set
