"""Questions about pairs, and grammars that keep to the answers: twins that list all strings."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from motiondb.grammar.cfg.context_free import GrammarError, read_grammar
from motiondb.grammar.cfg.parse import log_probability
from motiondb.grammar.foresight import Pairs
from motiondb.grammar.languages import finite_language
from motiondb.grammar.pair_questions import find_questions, spliced, without_pairs

TEXT = "S -> A B A [0.5] | B b [0.5]\nA -> a [0.5] | b [0.25] | empty [0.25]\nB -> c A [0.5] | a"


@pytest.mark.parametrize("no", [[("a", "a")], [("a", "b"), ("c", "b")], [("b", "c"), ("a", "c")]])
def test_no_removes_exactly_the_strings_with_the_pair(no: list[tuple[str, str]]) -> None:
    grammar = read_grammar(TEXT)
    before = finite_language(grammar)
    after = finite_language(without_pairs(grammar, no))
    assert before is not None
    kept = {s for s in before if not set(pairwise(s)) & set(no)}
    assert after == kept
    left = sum(np.exp(log_probability(grammar, s)) for s in kept)
    for s in kept:
        chance = np.exp(log_probability(without_pairs(grammar, no), s))
        assert chance == pytest.approx(np.exp(log_probability(grammar, s)) / left)


def test_no_that_leaves_nothing_is_refused() -> None:
    with pytest.raises(GrammarError, match="leave a sentence"):
        without_pairs(read_grammar("S -> a b"), [("a", "b")])


def test_rules_that_become_too_many_are_refused_and_deep_ones_are_not() -> None:
    many = read_grammar(f"S -> {'A ' * 12}[0.9] | e [0.1]\nA -> a | b | c | d")
    with pytest.raises(GrammarError, match="expected at most 2000 rules"):
        without_pairs(many, [("a", "b"), ("c", "d")])
    chain = "\n".join(f"N{k} -> a N{k + 1}" for k in range(250))
    deep = read_grammar(f"S -> x | N0\n{chain}\nN250 -> b")
    assert log_probability(without_pairs(deep, [("b", "a")]), ["a"] * 250 + ["b"]) == (
        pytest.approx(np.log(0.5))
    )


def test_yes_is_an_example_only_where_none_shows_the_pair() -> None:
    sentences = [tuple("xab"), tuple("ycd")]
    assert spliced(sentences, [("a", "b"), ("a", "d"), ("a", "z")]) == [("x", "a", "d")]


def test_answers_change_the_smoothed_chances_which_still_sum_to_one() -> None:
    takes = [tuple("abab"), tuple("acbd")]
    plain = Pairs(takes, "abcd")
    told = Pairs(takes, "abcd", {("a", "d"): True, ("b", "b"): False})
    for before in "abcd":
        assert sum(told.chance(t, before) for t in "abcd") == pytest.approx(1.0)
    assert told.chance("d", "a") > plain.chance("d", "a")
    assert told.chance("b", "b") < 0.1 * plain.chance("b", "b")


def test_questions_leave_out_what_is_known_and_begin_with_the_largest_gain() -> None:
    takes = [[tuple("abcabc")], [tuple("abdabc")]]
    asked = find_questions(takes, "abcd", answered=[("c", "b")], n=100)
    pairs = [(one.first, one.then) for one in asked]
    assert ("a", "b") not in pairs  # seen four times
    assert ("c", "b") not in pairs  # answered
    assert ("b", "d") in pairs  # seen once
    assert [one.gain for one in asked] == sorted((one.gain for one in asked), reverse=True)
    assert not [
        p for p in find_questions(takes, "abcd", n=100, repetitions=False) if p.first == p.then
    ]
    assert len(find_questions(takes, "abcd", n=2)) == 2
