"""Loops that are used differently from context to context are found and split."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.induction.loop_evidence import (
    Context,
    keep_supported,
    split_context,
    unlike_context,
)
from motiondb.grammar.induction.refitting import refit
from motiondb.grammar.rules.rule_set import RuleSet

# terminals 0, 1, 2; start 3; nonterminals 4 and 5
T, S, A, B = 3, 3, 4, 5
ROUNDS = {1: 8, 2: 4, 3: 2, 5: 1}
ONE_OF_BOTH = {(*[k] * n, 2): count for k in (0, 1) for n, count in ROUNDS.items()}


def strings_of(rules, longest):
    """All strings of at most ``longest`` terminals, by applying rules until nothing is new."""
    known = {left: set() for left in rules}
    while True:
        size = sum(map(len, known.values()))
        for left, rights in rules.items():
            for right in rights:
                parts = [known.get(symbol, {(symbol,)}) for symbol in right]
                for chosen in product(*parts):
                    string = sum(chosen, ())
                    if len(string) <= longest:
                        known[left].add(string)
        if sum(map(len, known.values())) == size:
            return known[S]


@pytest.mark.parametrize(("sentences", "doubted"), [(3, False), (4, True)])
def test_a_loop_that_never_ends_at_once_by_hand(sentences, doubted):
    # A -> 0 A | empty, one round or three: below A it ends every second time, below S never;
    # .5^6 = .0156, .5^8 = .0039
    flat = RuleSet(T, {S: {(0, 1): sentences, (0, 0, 0, 1): sentences}}, loops=True)
    rules = RuleSet(T, {S: {(A, 1): 1}, A: {(0, A): 1, (): 1}}, loops=True)
    assert unlike_context(rules, flat) == (Context(S, (A, 1), 0) if doubted else None)


EITHER = {S: {(A, B, 2): 1}, A: {(0, A): 1, (): 1}, B: {(1, B): 1, (): 1}}


def test_two_loops_of_which_one_is_always_idle_become_two_rules():
    flat = RuleSet(T, {S: ONE_OF_BOTH}, loops=True)
    rules = RuleSet(T, EITHER, loops=True)
    actual = unlike_context(rules, flat)
    assert (actual.left, actual.right, actual.beside is not None) == (S, (A, B, 2), True)
    kept = keep_supported(refit(rules, flat), flat, 2)
    expected = {(*[k] * n, 2) for k in (0, 1) for n in range(1, 8)}
    assert strings_of(kept.rules, 8) == expected


def test_two_loops_that_go_on_independently_are_kept():
    rounds = {0: 4, **ROUNDS}
    told = {(*[0] * i, *[1] * j, 2): rounds[i] * rounds[j] for i, j in product(rounds, repeat=2)}
    flat = RuleSet(T, {S: told}, loops=True)
    rules = refit(RuleSet(T, EITHER, loops=True), flat)
    assert unlike_context(rules, flat) is None


@st.composite
def rules_and_contexts(draw):
    symbol = st.sampled_from([0, 1, S, A, B])
    rules = {
        left: draw(
            st.dictionaries(
                st.lists(symbol, min_size=int(left == S), max_size=3)
                .map(tuple)
                .filter(lambda right, left=left: right != (left,)),
                st.integers(1, 4), min_size=1, max_size=3,
            )
        )
        for left in (S, A, B)
    }  # fmt: skip
    places = [
        (left, right, k)
        for left, rights in rules.items()
        for right in rights
        for k, symbol in enumerate(right)
        if symbol >= T
    ]
    left, right, place = draw(st.sampled_from([(-1, (), 0), *places]))
    others = [k for k, symbol in enumerate(right) if symbol >= T and k != place]
    beside = None
    if others and draw(st.booleans()):
        other = draw(st.sampled_from(others))
        beside = other, draw(st.sampled_from(sorted(rules[right[other]])))
    return RuleSet(T, rules, loops=True), Context(left, right, place, beside)


@settings(max_examples=100, deadline=None)
@given(rules_and_contexts())
def test_splitting_a_context_changes_no_string(drawn):
    rules, context = drawn
    before = {left: dict(rights) for left, rights in rules.rules.items()}
    actual = split_context(rules, context)
    assert strings_of(actual.rules, 4) == strings_of(rules.rules, 4)
    assert rules.rules == before
