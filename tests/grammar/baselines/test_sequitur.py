"""Sequitur's two constraints, its examples, and that it says the string again."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from motiondb.grammar.baselines.language_measures import finite_language
from motiondb.grammar.baselines.sequitur import sequitur_grammar
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, format_grammar
from motiondb.grammar.cfg.parse import parse

sentences_of = st.sampled_from(["a", "ab", "abc"]).flatmap(
    lambda names: st.lists(
        st.lists(st.sampled_from(names), max_size=30).map(tuple), min_size=1, max_size=4
    )
)


def check_constraints(grammar: Grammar) -> None:
    uses = Counter(symbol for rule in grammar.rules for symbol in rule.right)
    seen: set[tuple[str, str]] = set()
    for rule in grammar.rules:
        if rule.left != grammar.start:
            assert uses[rule.left] >= 2  # rule utility
            assert len(rule.right) >= 2
        places: dict[tuple[str, ...], int] = {}
        for place in range(len(rule.right) - 1):
            pair = rule.right[place : place + 2]
            if places.get(pair) == place - 1:
                continue  # aaa holds aa twice, but they overlap
            assert pair not in places  # digram uniqueness
            assert pair not in seen
            places[pair] = place
        seen |= set(places)


@given(sentences_of)
@settings(max_examples=300, deadline=None)
@example([tuple("aaaaaaaa")])
@example([tuple("abcabcab"), tuple("cabcab")])
def test_both_constraints_hold_and_the_sentences_come_back(
    sentences: list[tuple[str, ...]],
) -> None:
    grammar = sequitur_grammar(sentences)
    check_constraints(grammar)
    assert finite_language(grammar) == set(sentences)
    for rule in grammar.rules_of[grammar.start]:
        tree = next(t for s in sentences if (t := parse(grammar, s)).rule == rule)
        expected = sentences.count(tree.leaves()) / len(sentences)
        assert grammar.rules[rule].probability == pytest.approx(expected)


@pytest.mark.parametrize(
    ("string", "text"),
    [
        ("abcdbc", "S -> a R1 d R1\nR1 -> b c"),  # the paper's Figure 1
        ("abcdbcabcdbc", "S -> R1 R1\nR1 -> a R2 d R2\nR2 -> b c"),
        ("aaa", "S -> a a a"),
        ("aaaa", "S -> R1 R1\nR1 -> a a"),
        ("abababab", "S -> R1 R1\nR1 -> R2 R2\nR2 -> a b"),
    ],
)
def test_examples(string: str, text: str) -> None:
    assert format_grammar(sequitur_grammar([string])) == text


def test_rules_reach_across_sentences_but_no_pair_does() -> None:
    grammar = sequitur_grammar(["abx", "aby", "xa", "ya"])
    assert format_grammar(grammar).splitlines()[1:] == ["R1 -> a b"]
    check_constraints(grammar)


def test_a_long_string_holds_too() -> None:
    rng = np.random.default_rng(0)
    string = tuple("abcdefgh"[k] for k in rng.integers(0, 8, 20_000))
    grammar = sequitur_grammar([string])
    check_constraints(grammar)
    below = {s: (s,) for s in grammar.terminals}
    waiting = {rule.left: rule for rule in grammar.rules}
    while waiting:
        for left, rule in list(waiting.items()):
            if all(symbol in below for symbol in rule.right):
                below[left] = sum((below[symbol] for symbol in rule.right), ())
                del waiting[left]
    assert below[grammar.start] == string


def test_names_do_not_meet_terminals() -> None:
    grammar = sequitur_grammar([("S", "R1", "S", "R1")])
    assert format_grammar(grammar) == "S' -> R1' R1'\nR1' -> S R1"


def test_no_sentence_is_refused() -> None:
    with pytest.raises(GrammarError, match="sentences: expected at least one, found none"):
        sequitur_grammar([])
