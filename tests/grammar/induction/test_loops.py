"""Rules that loop: their laws, parsing by them, the evidence for loops, languages learned."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import naive_laws
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_rules import LITTLE, A, B, S, T, acyclic_rules, keeps_laws_of, looping_rules, strings_of

from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.cfg.parse import accepts
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce, induce_with_bits, without_loops
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.loop_evidence import (
    Context,
    judge_loops,
    keep_supported,
    rounds_asked,
    split_context,
    unlike_context,
)
from motiondb.grammar.induction.refitting import PARENT, RULE, SPAN, read_all, refit
from motiondb.grammar.languages import derived_strings
from motiondb.grammar.rules import rule_set
from motiondb.grammar.rules.rule_set import RuleSet


@settings(max_examples=120, deadline=None)
@given(looping_rules(), st.lists(st.booleans(), min_size=3, max_size=3).filter(any))
def test_the_search_checks_the_laws_as_the_plain_check_does_and_who_may_loop(rules, may_loop):
    looping = rule_set.recursive_lefts(rules.rules)
    allowed = all(may_loop[left - S] for left in looping)
    assert is_lawful(rules) == naive_laws.lawful(rules)
    assert keeps_laws_of(rules, may_loop) == (naive_laws.lawful(rules) and allowed)


@settings(max_examples=40, deadline=None)
@given(acyclic_rules(least=0), looping_rules())
def test_the_search_checks_the_laws_without_loops_as_the_plain_check_does(rules, laws):
    rules.constants, rules.singles = laws.constants, laws.singles
    assert keeps_laws_of(rules, [False] * 3) == naive_laws.lawful(rules) == is_lawful(rules)


@settings(max_examples=50, deadline=None)
@given(looping_rules())
def test_laws_hold_for_all_short_strings(rules):
    if not is_lawful(rules):
        return
    strings = strings_of(rules.rules, S, 6)
    assert () not in strings
    for string in strings:
        for terminal, number in rules.constants.items():
            assert string.count(terminal) == number
        assert all(string.count(terminal) <= 1 for terminal in rules.singles)


@pytest.mark.parametrize(
    "rules",
    [
        {S: {(A,): 1}, A: {(0, A): 1}},  # never ends
        {S: {(0,): 1}, A: {(A, 1): 1, (2,): 1}},  # is never reached
        {S: {(A, 0): 1}, A: {(B,): 1, (1,): 1}, B: {(A,): 1, (2,): 1}},  # A derives B derives A
        {S: {(0, A): 1}, A: {(A, B): 1, (1,): 1}, B: {(): 1, (2,): 1}},  # A derives A alone
        {S: {(A,): 1}, A: {(0, A): 1, (): 1}},  # an empty sentence
    ],
)
def test_loops_that_are_never_lawful(rules):
    assert not is_lawful(RuleSet(T, rules, loops=True))


def naive_bits(rules, string):
    """Fewest bits of a string, by lowering the bits of all spans until they must be right."""
    n = len(string)
    best = {(left, i, j): math.inf for left in rules for i in range(n + 1) for j in range(i, n + 1)}

    def of(right, i, j):
        if not right:
            return 0.0 if i == j else math.inf
        if right[0] < T:
            return of(right[1:], i + 1, j) if i < j and string[i] == right[0] else math.inf
        return min(best[right[0], i, k] + of(right[1:], k, j) for k in range(i, j + 1))

    for _ in range(3 * len(rules) * (n + 1)):
        for left, i, j in best:
            node = math.log2(len(rules[left]))
            cost = node + min(of(right, i, j) for right in rules[left])
            best[left, i, j] = min(best[left, i, j], cost)
    return best[S, 0, n]


@settings(max_examples=40, deadline=None)
@given(looping_rules(), st.lists(st.integers(0, 2), min_size=1, max_size=4).map(tuple))
def test_rules_with_loops_are_parsed_in_the_fewest_bits(rules, sentence):
    if naive_laws.derives_itself_alone(rules.rules):
        return
    rows, parses = read_all(rules, [sentence])
    parse, expected = parses[sentence], naive_bits(rules.rules, sentence)
    if parse.cover:
        assert expected == math.inf
        return
    spent = sum(math.log2(len(rules.rules[rows[r][0]])) for r in parse.nodes[:, RULE])
    assert spent == pytest.approx(expected)
    for k, (row, parent, place, span) in enumerate(parse.nodes.tolist()):
        below = parse.nodes[:, PARENT] == k
        held = [symbol for symbol in rows[row][1] if symbol >= T]
        assert below.sum() == len(held)
        assert span == parse.nodes[below, SPAN].sum() + len(rows[row][1]) - len(held)
        if parent >= 0:
            assert parent < k
            assert rows[parse.nodes[parent, RULE]][1][place] == rows[row][0]


# ---- evidence -------------------------------------------------------------------------------

# S -> A 1; A -> 0 A | 0: sentences of k zeros and a one have k - 1 rounds
CHAIN = {2: {(3, 1): 1}, 3: {(0, 3): 1, (0,): 1}}


def zeros(counts):
    return RuleSet(2, {2: {(0,) * k + (1,): number for k, number in counts.items()}}, loops=True)


@pytest.mark.parametrize(
    ("counts", "rounds", "supported"),
    [
        ({1: 10, 2: 6, 3: 3, 5: 1}, 4, True),
        ({1: 10, 2: 10}, 1, False),  # twice in a row is one round
        ({1: 7, 2: 7, 3: 6}, 2, False),  # one to three times: (1 - 20 / 34)^6 = .005
        ({3: 20}, 2, False),  # always three times
    ],
)
def test_evidence_for_a_chain(counts, rounds, supported):
    flat = zeros(counts)
    (judged,) = judge_loops(RuleSet(2, CHAIN, loops=True), flat, rounds_asked(flat))
    assert (judged.left, judged.right, judged.rounds) == (3, (0, 3), rounds)
    assert judged.supported == supported


def test_fewer_than_twenty_sentences_must_have_three_rounds():
    few, many = zeros({1: 12, 2: 5, 3: 2}), zeros({1: 12, 2: 6, 3: 2})
    assert (rounds_asked(few), rounds_asked(many)) == (3, 2)
    rules = RuleSet(2, CHAIN, loops=True)
    assert not judge_loops(rules, few, rounds_asked(few))[0].supported
    assert judge_loops(rules, many, rounds_asked(many))[0].supported


def test_what_is_rare_in_a_loop_needs_only_stand_within_it():
    # S -> 0 S 0 | 1 S 1 | 2: 1 is never twice on a path, but below and above 0
    rules = RuleSet(3, {3: {(0, 3, 0): 1, (1, 3, 1): 1, (2,): 1}}, loops=True)
    plain = {(2,): 9, (0, 2, 0): 5, (0, 0, 2, 0, 0): 3, (0, 0, 0, 2, 0, 0, 0): 1}
    inner = plain | {(0, 1, 2, 1, 0): 1, (1, 0, 2, 0, 1): 1}
    judged = judge_loops(rules, RuleSet(3, {3: inner}, loops=True), 2)
    assert [(one.right, one.supported) for one in judged] == [((0, 3, 0), True), ((1, 3, 1), True)]
    outer = plain | {(1, 0, 2, 0, 1): 2}  # always outermost
    judged = judge_loops(rules, RuleSet(3, {3: outer}, loops=True), 2)
    assert [one.supported for one in judged] == [True, False]


def test_unsupported_loops_are_written_out_and_supported_ones_kept():
    rules = RuleSet(2, CHAIN, loops=True)
    endless, bounded = zeros({1: 10, 2: 6, 3: 3, 5: 1}), zeros({1: 9, 2: 9, 3: 9})
    assert keep_supported(refit(rules, endless), endless, 2).rules[3].keys() == {(0, 3), (0,)}
    kept = keep_supported(refit(rules, bounded), bounded, 2)
    assert is_lawful(kept)
    assert not rule_set.recursive_lefts(kept.rules)
    assert strings_of(kept.rules, 2, 9) == {(0, 1), (0, 0, 1), (0, 0, 0, 1)}


# ---- languages ------------------------------------------------------------------------------

LANGUAGES = {
    "repetition": "S -> stand A rest\nA -> left right A [0.6] | left right [0.4]",
    "nested": "S -> a S b [0.65] | a b [0.35]",
    "mirror": "S -> a S a [0.35] | b S b [0.3] | m [0.35]",
}


@cache
def drawn(text, n, seed):
    truth, rng = read_grammar(text), np.random.default_rng(seed)
    return tuple(derive(truth, rng).leaves() for _ in range(n))


@pytest.mark.parametrize("name", LANGUAGES)
def test_recursive_languages_are_learned_from_twenty_sentences(name):
    truth, sentences = read_grammar(LANGUAGES[name]), list(drawn(LANGUAGES[name], 20, 5))
    induced = induce_with_bits(sentences, effort=LITTLE)
    rng = np.random.default_rng(0)
    assert all(accepts(truth, string) for string in derived_strings(induced.grammar, rng, 100))
    assert all(accepts(induced.grammar, string) for string in derived_strings(truth, rng, 100))
    bounded = induce_with_bits(sentences, effort=without_loops(sentences, LITTLE))
    assert induced.bits.total < bounded.bits.total


def test_one_to_three_times_stays_bounded_with_fifty_sentences():
    text = "S -> stand A rest\nA -> l r | l r l r | l r l r l r"
    grammar = induce(drawn(text, 50, 1), effort=LITTLE)
    assert {len(s) for s in derived_strings(grammar, np.random.default_rng(0), 300)} == {4, 6, 8}


ROUNDS = {1: 8, 2: 4, 3: 2, 5: 1}
ONE_OF_BOTH = {(*[k] * n, 2): count for k in (0, 1) for n, count in ROUNDS.items()}


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
    assert strings_of(kept.rules, S, 8) == expected


def test_two_loops_that_go_on_independently_are_kept():
    rounds = {0: 4, **ROUNDS}
    told = {(*[0] * i, *[1] * j, 2): rounds[i] * rounds[j] for i, j in product(rounds, repeat=2)}
    flat = RuleSet(T, {S: told}, loops=True)
    rules = refit(RuleSet(T, EITHER, loops=True), flat)
    assert unlike_context(rules, flat) is None


@st.composite
def contexts(draw, rules):
    """A place of a nonterminal in a rule, perhaps beside a rule of another place, or the start."""
    places = [
        (left, right, k)
        for left, rights in rules.rules.items()
        for right in rights
        for k, symbol in enumerate(right)
        if symbol >= T
    ]
    left, right, place = draw(st.sampled_from([(-1, (), 0), *places]))
    others = [k for k, symbol in enumerate(right) if symbol >= T and k != place]
    beside = None
    if others and draw(st.booleans()):
        other = draw(st.sampled_from(others))
        beside = other, draw(st.sampled_from(sorted(rules.rules[right[other]])))
    return Context(left, right, place, beside)


@settings(max_examples=100, deadline=None)
@given(looping_rules((0, 1, S, A, B)), st.data())
def test_splitting_a_context_changes_no_string(rules, data):
    rules = RuleSet(T, rules.rules, loops=True)
    context = data.draw(contexts(rules))
    before = {left: dict(rights) for left, rights in rules.rules.items()}
    actual = split_context(rules, context)
    assert strings_of(actual.rules, S, 4) == strings_of(rules.rules, S, 4)
    assert rules.rules == before
