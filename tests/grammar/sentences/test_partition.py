"""Sentences cut out of strings: what may be cut, what is counted, what the search finds."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_rules import strings_of

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.rule_arrays import empty_table, rules_of
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.grammar.sentences import context_bits
from motiondb.grammar.sentences.borders import recurring_splits, united_splits
from motiondb.grammar.sentences.cutting import (
    cheapest_cuts,
    cutting_room,
    draw_best,
    draw_cuts,
    recut,
    search_cuts,
    shared_symbols,
)
from motiondb.grammar.sentences.partition import find_sentences, sentences_between

PAPER = tuple("abxcdabycdabxcd")


def markov_string(n, k, seed):
    rng = np.random.default_rng(seed)
    chances = rng.dirichlet(np.full(k, 0.15), k)
    actual = [0]
    while len(actual) < n:
        actual.append(int(rng.choice(k, p=chances[actual[-1]])))
    return tuple(f"t{symbol}" for symbol in actual)


def test_the_papers_string_is_cut_as_the_paper_cuts_it():
    partition = find_sentences([PAPER], np.random.default_rng(0), evaluations=200)
    assert partition.cuts == ((5, 10),)
    assert round(partition.bits.total, 4) == 41.0391


@pytest.mark.parametrize(("cuts", "bits"), [((5, 10), 41.0391), ((), 47.5489)])
def test_the_bits_of_a_partition_are_those_of_its_grammar(cuts, bits):
    # uncut, abxcd is a rule of its own: S A abycd A @ A abxcd, 8 + 1 + 6 symbols of 9 kinds
    assert round(cutting_room([PAPER]).bits(cuts), 4) == bits


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from("abc"), min_size=2, max_size=40), st.integers(0, 99))
def test_quick_bits_are_those_of_the_rules_they_stand_for(letters, seed):
    string = tuple(letters)
    if len(set(string)) < 2:
        return
    room = cutting_room([string], 1, 6)
    spans = room.spans(draw_cuts(room, np.random.default_rng(seed)))
    rules = context_rules(room.covered, *spans)
    assert context_bits.context_bits(room.covered, *spans) == pytest.approx(rules.bits())
    assert is_lawful(rules)
    sentences = [tuple(room.covered.symbols[a:b].tolist()) for a, b in zip(*spans, strict=True)]
    assert strings_of(rules.rules, rules.start, 50) == set(sentences)


def context_rules(covered, starts, ends):
    """The grammar whose bits context_bits counts, as rules with the number of their uses."""
    n = 2 * starts.size + 1
    text = np.empty(
        2 * (covered.symbols.size + int((ends - starts).max()) + starts.size), dtype=np.int64
    )
    table = empty_table(text, n, covered.n_terminals)
    _, used = context_bits._context_grammar(covered, starts, ends, table)
    result = rules_of(table, RuleSet(covered.n_terminals, {}))
    rules = dict(result.rules)
    for number in np.flatnonzero(used).tolist():
        symbol = covered.n_terminals + 1 + number
        first, length = int(covered.repeat_starts[number]), int(covered.repeat_lengths[number])
        count = sum(
            nodes * right.count(symbol)
            for rights in rules.values()
            for right, nodes in rights.items()
        )
        spelled = tuple(covered.symbols[first : first + length].tolist())
        result.rules[symbol] = {spelled: count}
    return result


def test_no_cut_divides_a_chosen_repeat_or_makes_too_short_a_sentence():
    strings = [markov_string(90, 6, 1), markov_string(60, 6, 2)]
    room = cutting_room(strings, 4, 15)
    rng = np.random.default_rng(0)
    for _ in range(50):
        cuts = draw_cuts(room, rng)
        starts, ends = room.spans(cuts)
        assert not room.covered.inside[list(cuts)].any()
        assert (ends - starts).min() >= 4
        assert ends.tolist()[-1] == 151
        assert 90 in ends.tolist()


def test_the_search_finds_fewer_bits_than_as_many_random_candidates():
    room = cutting_room([markov_string(150, 8, 3)], 3, 20)
    searched = [search_cuts(room, np.random.default_rng(seed), 600)[1] for seed in range(4)]
    drawn = [draw_best(room, np.random.default_rng(seed), 600)[1] for seed in range(4)]
    assert np.mean(searched) < np.mean(drawn)
    assert min(searched) < min(drawn)


@settings(max_examples=30, deadline=None)
@given(st.sets(st.integers(1, 29), max_size=9), st.sets(st.integers(1, 29), max_size=2), st.data())
def test_recuts_are_the_cheapest_of_all(free, pinned, data):
    places = np.array(sorted({0, 30} | free | pinned))
    fixed = np.isin(places, [0, 30, *pinned])
    cost = st.floats(-5, 5).map(lambda x: round(x, 2))
    costs = np.array(data.draw(st.lists(cost, min_size=len(places), max_size=len(places))))
    cuts = cheapest_cuts(places, fixed, costs, 3, 12)
    assert set(np.flatnonzero(fixed)) <= set(cuts.tolist())
    best = min(path_cost(places, fixed, costs, path) for path in paths(fixed))
    assert path_cost(places, fixed, costs, cuts.tolist()) == pytest.approx(best)


def paths(fixed):
    """All choices of places that hold the fixed ones."""
    inner = np.flatnonzero(~fixed).tolist()
    for chosen in product((False, True), repeat=len(inner)):
        yield sorted([*np.flatnonzero(fixed).tolist(), *(i for i, c in zip(inner, chosen) if c)])


def path_cost(places, fixed, costs, path):
    """As the docstring says: too near is not allowed unless both are fixed, too long is dear."""
    total = 0.0
    for i, j in pairwise(path):
        length = places[j] - places[i]
        if length < 3 and not (fixed[i] and fixed[j]):
            return np.inf
        total += costs[j] + 1e3 * max(0, length - 12)
    return total


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 2), min_size=2, max_size=14), st.data())
def test_shared_symbols_are_those_before_and_after(symbols, data):
    n = len(symbols)
    cuts = data.draw(st.sets(st.integers(1, n - 1), max_size=3))
    actual = shared_symbols(np.array(symbols), np.arange(n + 1), np.array(sorted(cuts), dtype=int))
    for place in range(n + 1):
        others = [cut for cut in cuts if cut != place]
        after = [common(symbols[place:], symbols[cut:]) for cut in others]
        before = [common(symbols[:place][::-1], symbols[:cut][::-1]) for cut in others]
        assert actual[place] == max(after, default=0) + max(before, default=0)


def common(one, other):
    """Length of the common beginning, six at most."""
    return next(
        (i for i, (x, y) in enumerate(zip(one, other)) if x != y or i == 6),
        min(len(one), len(other), 6),
    )


def test_a_recut_keeps_lengths_and_the_cover_and_the_ends_of_strings():
    room = cutting_room([markov_string(90, 6, 1), markov_string(60, 6, 2)], 4, 15)
    rng = np.random.default_rng(0)
    cuts = draw_cuts(room, rng)
    for _ in range(50):
        cuts = recut(room.covered.symbols, room.allowed, room.bounds, (4, 15), cuts, rng)
        starts, ends = room.spans(cuts)
        assert set(cuts) <= set(room.allowed)
        assert (ends - starts).min() >= 4
        assert 90 in ends.tolist()


def test_the_same_seed_finds_the_same_sentences_and_they_make_up_the_strings():
    strings = [markov_string(14, 5, 4), markov_string(9, 5, 5)]
    one = find_sentences(strings, np.random.default_rng(7), evaluations=60)
    assert one == find_sentences(strings, np.random.default_rng(7), evaluations=60)
    assert sum(one.sentences, ()) == strings[0] + strings[1]
    assert len(one.sentences) == sum(len(cuts) + 1 for cuts in one.cuts)


def test_a_border_that_always_recurs_may_be_cut_although_it_repeats():
    # every sentence ends in z and begins with a: "za" repeats, and the cover forbids each border
    string = tuple("abczadczabbzadbzabcz")
    assert ((4, 8, 12, 16),) in recurring_splits([string], 3, 6)
    partition = find_sentences([string], np.random.default_rng(0), lengths=(3, 6))
    assert partition.cuts == ((4, 8, 12, 16),)


def test_no_sentence_is_longer_than_was_wished():
    rng = np.random.default_rng(0)
    motif = tuple(
        map(str, rng.integers(4, size=11))
    )  # recurs, and is longer than a sentence may be
    strings = [(*map(str, rng.integers(4, size=9)), *motif, *motif) for _ in range(2)]
    partition = find_sentences(strings, rng, lengths=(3, 8))
    assert {3 <= len(sentence) <= 8 for sentence in partition.sentences} == {True}
    assert sum(map(len, partition.sentences)) == sum(map(len, strings))


@pytest.mark.parametrize(
    ("strings", "lengths", "message"),
    [
        ([], {}, "at least two different symbols, found 0"),
        ([("a",) * 9], {}, "at least two different symbols, found 1"),
        ([tuple("ab"), ()], {}, "string 2: expected at least one symbol"),
        ([tuple("ab")], {"lengths": (5, 4)}, "found 5 and 4"),
    ],
)
def test_strings_that_cannot_be_cut_are_refused(strings, lengths, message):
    with pytest.raises(GrammarError, match=message):
        find_sentences(strings, np.random.default_rng(0), **lengths)


def test_sentences_that_begin_and_end_in_two_ways_are_among_the_united_splits():
    # sentences begin with a or b and end with y or z; no kind of border is at all their ends
    first = tuple("apqybppqyapqqybpqy")
    second = tuple("bpqzapqqzapqzbppqz")
    true = ((4, 9, 14), (4, 9, 13))
    assert true not in recurring_splits([first, second], 3, 8)
    assert united_splits([first, second], 3, 8)[0] == true


@pytest.mark.parametrize("cuts", [(0,), (3,), (2, 1)])
def test_cuts_outside_a_string_are_refused(cuts):
    with pytest.raises(GrammarError, match="string 1: expected rising cuts between 1 and 2"):
        sentences_between([tuple("abc")], [cuts])
