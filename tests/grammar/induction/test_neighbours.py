"""Neighbours moved into recursive nonterminals: the same language, fewer bits."""

from __future__ import annotations

from motiondb.grammar.induction.rule_compaction import absorb_neighbours, release_ends
from motiondb.grammar.rules.rule_set import RuleSet

A, B, S, X = 0, 1, 2, 3


def test_what_precedes_a_loop_is_moved_into_it() -> None:
    rules = RuleSet(2, {S: {(A, X): 2}, X: {(A, X, B): 1, (B,): 2}}, loops=True)
    assert absorb_neighbours(rules).rules == {S: {(A, S, B): 1, (A, B): 2}}


def test_rules_whose_neighbours_differ_stay() -> None:
    rules = RuleSet(2, {S: {(X, B): 2}, X: {(A, X, A): 1, (A,): 2}}, loops=True)
    assert absorb_neighbours(rules) is rules


def test_constants_and_singles_are_not_moved_into_loops() -> None:
    rules = {S: {(X, B): 2}, X: {(A, X, B): 1, (A,): 2}}
    for held in (RuleSet(2, rules, singles=frozenset({B})), RuleSet(2, rules, {B: 1})):
        assert absorb_neighbours(held) is held


def test_nothing_is_moved_where_no_bits_are_saved() -> None:
    rights = {(A, X, B): 1, (A,): 1, (A, A): 1, (A, A, A): 1, (A, A, A, A): 1}
    rules = RuleSet(2, {S: {(X, B): 4, (B, X, B): 1}, X: rights}, loops=True)
    absorbed = absorb_neighbours(rules)
    assert absorbed.bits() <= rules.bits()
    assert absorbed is rules


def test_the_end_of_a_repetition_is_moved_out_of_it() -> None:
    rules = RuleSet(2, {S: {(A, X): 2}, X: {(A, X): 1, (A, B): 2}}, loops=True)
    assert release_ends(rules).rules == {S: {(A, X, B): 2}, X: {(A, X): 1, (A,): 2}}


def test_an_end_stays_where_moving_it_costs_bits_or_changes_strings() -> None:
    twice = {S: {(A, X, X): 2, (X, A): 1}, X: {(A, X): 1, (A, B): 5}}
    inside = {S: {(A, X): 2}, X: {(A, X, A): 1, (A, B): 2}}
    for rules in (RuleSet(2, twice, loops=True), RuleSet(2, inside, loops=True)):
        assert release_ends(rules) is rules
