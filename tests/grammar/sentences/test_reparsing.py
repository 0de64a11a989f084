"""Strings cut by rules: prices of sentences, cheapest cuts, against slow twins; cuts of a kind."""

from __future__ import annotations

import itertools
import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce_with_bits
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.grammar.sentences.borders import (
    border_places,
    change_alike,
    recurring_splits,
    spaced,
    too_long,
)
from motiondb.grammar.sentences.partition import find_sentences
from motiondb.grammar.sentences.reparsing import cut_by_rules, sentence_prices
from motiondb.grammar.sentences.repeats import (
    common_prefixes,
    cover_repeats,
    join_strings,
    sorted_suffixes,
)

# terminals 0 1 2; S -> 0 A 2 | A; A -> 1 | 1 1 | empty
RULES = RuleSet(3, {3: {(0, 4, 2): 2, (4,): 1}, 4: {(1,): 1, (1, 1): 1, (): 1}})


def bits_of(symbol, part, rules):
    """Fewest bits of deriving a part, by trying everything."""
    if symbol not in rules:
        return 0.0 if part == (symbol,) else math.inf
    chosen = math.log2(len(rules[symbol]))
    return chosen + min(sequence_bits(right, part, rules) for right in rules[symbol])


def sequence_bits(right, part, rules):
    if not right:
        return 0.0 if not part else math.inf
    return min(
        bits_of(right[0], part[:n], rules) + sequence_bits(right[1:], part[n:], rules)
        for n in range(len(part) + 1)
    )


def new_rule_bits(part, rules, letter):
    if not part:
        return 0.0
    return min(
        letter
        + min([0.0 if n == 1 else math.inf, *(bits_of(left, part[:n], rules) for left in rules)])
        + new_rule_bits(part[n:], rules, letter)
        for n in range(1, len(part) + 1)
    )


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 2), min_size=1, max_size=7))
def test_prices_are_those_of_trying_everything(symbols):
    prices = sentence_prices(np.array([*symbols, 3]), RULES, 5)
    letter = math.log2(6)
    for i in range(len(symbols)):
        for n in range(1, min(5, len(symbols) - i) + 1):
            part = tuple(symbols[i : i + n])
            new = new_rule_bits(part, RULES.rules, letter) + 2 * letter + math.log2(3)
            assert prices[i, n] == pytest.approx(min(bits_of(3, part, RULES.rules), new), rel=1e-5)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 2), min_size=2, max_size=9), st.integers(1, 3))
def test_cuts_by_rules_are_the_cheapest_of_all(symbols, shortest):
    joined = np.array([*symbols, 3])
    n, longest = len(symbols), 5
    prices = sentence_prices(joined, RULES, longest)
    (cuts,) = cut_by_rules(joined, np.array([0, n + 1]), RULES, (shortest, longest))

    def price(places):
        spans = list(pairwise((0, *places, n)))
        if any(not shortest <= b - a <= longest for a, b in spans):
            return math.inf
        return sum(prices[a, b - a] for a, b in spans)

    best = min(price(c) for k in range(n) for c in combinations(range(1, n), k))
    if best < math.inf:
        assert price(cuts) == pytest.approx(best)
    else:
        assert cuts == ()


def test_splits_at_a_kind_of_border_keep_the_shortest_length():
    splits = recurring_splits(["abcabcab"], 2, 8)
    assert ((3, 6),) in splits  # before a, after c, between both: once
    assert len(splits) == len(set(splits))
    assert all(min(np.diff((0, *cuts, 8))) >= 2 for (cuts,) in splits)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.text("abc", min_size=4, max_size=20), min_size=1, max_size=3), st.integers(0, 99)
)
def test_changes_of_a_kind_stay_inside_and_keep_the_shortest_length(strings, seed):
    rng = np.random.default_rng(seed)
    cuts = spaced(strings, [list(range(1, len(s))) for s in strings], 2)
    places = border_places(strings)
    for _ in range(5):
        cuts = change_alike(strings, places, cuts, 2, rng)
        for string, inner in zip(strings, cuts, strict=True):
            edges = (0, *inner, len(string))
            assert all(b - a >= 2 for a, b in pairwise(edges))


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 12), st.integers(1, 4), st.integers(0, 4), st.sets(st.integers(1, 11)))
def test_sentences_are_too_long_only_where_shorter_ones_are_possible(n, shortest, more, places):
    longest = shortest + more
    cuts = tuple(sorted(place for place in places if place < n))
    lengths = np.diff((0, *cuts, n))
    allowed = any(
        all(shortest <= b - a <= longest for a, b in pairwise((0, *chosen, n)))
        for k in range(n)
        for chosen in combinations(range(1, n), k)
    )
    actual = too_long(["x" * n], (cuts,), (shortest, longest))
    assert actual == (allowed and max(lengths) > longest)


def test_rules_that_are_known_are_never_made_worse():
    sentences = [tuple("abxcd"), tuple("abycd"), tuple("abxcd")]
    # a b c d x y are 0 to 5: S -> a b A c d, A -> x | y
    known = RuleSet(6, {6: {(0, 1, 7, 2, 3): 3}, 7: {(4,): 2, (5,): 1}})
    assert induce_with_bits(sentences, known=[known]).bits.total <= known.bits() + 1e-9


def test_the_true_sentences_of_a_grammar_are_found_in_long_strings():
    truth = read_grammar("S -> r F F i\nF -> D A | A\nA -> p p | p k | k\nD -> y | u")
    rng = np.random.default_rng(6)
    sentences = [derive(truth, rng).leaves() for _ in range(10)]
    strings = [sum(sentences[:5], ()), sum(sentences[5:], ())]
    partition = find_sentences(strings, np.random.default_rng(0), evaluations=400)
    assert partition.sentences == tuple(sentences)


TEXTS = st.lists(st.integers(0, 3), min_size=1, max_size=40)


def naive_suffixes(text):
    return sorted(range(len(text)), key=lambda i: tuple(text[i:]))


def common(one, other):
    n = 0
    while n < min(len(one), len(other)) and one[n] == other[n]:
        n += 1
    return n


@settings(max_examples=50, deadline=None)
@given(TEXTS)
def test_suffixes_and_common_prefixes_are_those_of_sorting(text):
    suffixes = sorted_suffixes(text)
    assert suffixes.tolist() == naive_suffixes(text)
    ranked = [text[i:] for i in suffixes]
    expected = [0, *(common(a, b) for a, b in itertools.pairwise(ranked))]
    assert common_prefixes(text, suffixes) == expected


@settings(max_examples=50, deadline=None)
@given(TEXTS)
def test_the_cover_holds_repeats_that_do_not_overlap_and_leaves_none_out(text):
    starts, lengths = cover_repeats(text)
    taken = np.zeros(len(text), dtype=int)
    for start, length in zip(starts, lengths):
        taken[start : start + length] += 1
        word = text[start : start + length]
        assert any(
            text[i : i + length] == word and abs(i - start) >= length
            for i in range(len(text) - length + 1)
        )
    assert taken.max() <= 1
    for one, other in itertools.pairwise(naive_suffixes(text)):
        reach = min(common(text[one:], text[other:]), abs(one - other))
        for i in (one, other):
            free = next((k for k in range(reach) if taken[i + k]), reach)
            assert free < 2


def test_a_run_is_cut_down_to_its_period():
    assert cover_repeats([0, 1] * 5)[1].tolist() == [2] * 5
    assert cover_repeats([0] * 50)[1].tolist() == []


def test_no_repeat_reaches_across_the_end_of_a_string():
    symbols, bounds = join_strings(["abc", "abc", "cab"])
    assert bounds.tolist() == [0, 4, 8, 12]
    starts, lengths = cover_repeats(symbols)
    assert list(zip(starts.tolist(), lengths.tolist())) == [(0, 3), (4, 3), (9, 2)]
