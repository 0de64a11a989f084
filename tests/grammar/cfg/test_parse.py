"""The parser: numbers worked by hand, plain twins on random grammars, places of failure."""

from __future__ import annotations

from itertools import product
from math import exp, inf, log

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from random_grammars import TOY, grammars, tree_log_probability

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule, choices_of, read_grammar
from motiondb.grammar.cfg.parse import (
    ParseError,
    accepts,
    count_trees,
    explain,
    log_probability,
    parse,
)


def plain_chart(grammar: Grammar, sentence: tuple[str, ...], best: bool) -> float | None:
    """Value of the sentence by iterating all equations from 0; None where they settle slowly."""
    spans = [(i, j) for i in range(len(sentence) + 1) for j in range(i, len(sentence) + 1)]
    value = {(a, i, j): 0.0 for a in grammar.nonterminals for i, j in spans}

    def of(symbol: str, i: int, j: int) -> float:
        if grammar.is_nonterminal(symbol):
            return value[symbol, i, j]
        return float(j == i + 1 and sentence[i] == symbol)

    def string(right: tuple[str, ...], i: int, j: int) -> float:
        if not right:
            return float(i == j)
        parts = [of(right[0], i, k) * string(right[1:], k, j) for k in range(i, j + 1)]
        return max(parts) if best else sum(parts)

    for i, j in sorted(spans, key=lambda span: span[1] - span[0]):
        for _ in range(300):
            moved = 0.0
            for left, numbers in grammar.rules_of.items():
                terms = [
                    grammar.rules[r].probability * string(grammar.rules[r].right, i, j)
                    for r in numbers
                ]
                new = max(terms) if best else sum(terms)
                moved, value[left, i, j] = max(moved, new - value[left, i, j]), new
            if moved < 1e-13:
                break
        else:
            return None
    return value["S", 0, len(sentence)]


def check_tree(grammar: Grammar, tree: object, sentence: tuple[str, ...]) -> None:
    assert tree.leaves() == sentence
    for node in tree.nodes():
        if not node.is_leaf:
            rule = grammar.rules[node.rule]
            assert rule.left == node.symbol
            assert rule.right == tuple(child.symbol for child in node.children)


@given(grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=3).map(tuple))
@settings(max_examples=50, deadline=None)
def test_probabilities_are_those_of_the_plain_equations(
    grammar: Grammar, sentence: tuple[str, ...]
) -> None:
    total, best = plain_chart(grammar, sentence, False), plain_chart(grammar, sentence, True)
    assume(total is not None)
    assert accepts(grammar, sentence) == (total > 0)
    assert exp(log_probability(grammar, sentence)) == pytest.approx(total, rel=1e-8, abs=1e-300)
    fault = explain(grammar, sentence)
    if total == 0:
        assert fault is not None
        return
    assert fault is None
    tree = parse(grammar, sentence)
    check_tree(grammar, tree, sentence)
    # the penalty on rules may cost some 1e-9 a rule
    assert tree_log_probability(grammar, tree) == pytest.approx(log(best), abs=1e-6)


def plain_count(grammar: Grammar, sentence: tuple[str, ...]) -> float:
    """Number of trees by iterating: a number that still grows after many rounds has no end."""
    spans = [(i, j) for i in range(len(sentence) + 1) for j in range(i, len(sentence) + 1)]
    count = {(a, i, j): 0.0 for a in grammar.nonterminals for i, j in spans}

    def string(right: tuple[str, ...], i: int, j: int) -> float:
        if not right:
            return float(i == j)
        total = 0.0
        for k in range(i, j + 1):
            first = count.get((right[0], i, k), float(sentence[i:k] == (right[0],)))
            rest = string(right[1:], k, j) if first else 0.0
            total += first * rest if rest else 0.0
        return total

    for i, j in sorted(spans, key=lambda span: span[1] - span[0]):
        for turn in range(24):  # a tree without a cycle has at most 3 symbols of a span on a path
            for left, numbers in grammar.rules_of.items():
                new = sum(string(grammar.rules[r].right, i, j) for r in numbers)
                count[left, i, j] = inf if turn > 12 and new > count[left, i, j] else new
    return count["S", 0, len(sentence)]


@given(grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=3).map(tuple))
@settings(max_examples=30, deadline=None)
@example(read_grammar("S -> A | a\nA -> A A | empty"), ("a",))
@example(read_grammar("S -> S | b S | empty"), ("a", "b"))
@example(read_grammar("S -> A S | a\nA -> A | b"), ("b", "a"))
def test_number_of_trees_is_that_of_the_plain_equations(
    grammar: Grammar, sentence: tuple[str, ...]
) -> None:
    assert count_trees(grammar, sentence) == plain_count(grammar, sentence)


def test_the_toy_language_has_14_strings_and_16_derivations() -> None:
    inner = [s for n in range(4) for s in product("fd", repeat=n)]
    strings = [("r", *s, end, "m") for s in inner for end in "ps"]
    counts = [count_trees(TOY, string) for string in strings]
    assert sum(count > 0 for count in counts) == 14
    assert sum(counts) == 16
    assert count_trees(TOY, tuple("rfpm")) == 2  # f is the first or the second X3


def test_empty_string_with_endless_empty_trees() -> None:
    # e = 0.3 e^2 + 0.5, so e = (1 - sqrt(0.4)) / 0.6
    grammar = read_grammar("S -> S S [0.3] | empty [0.5] | a [0.2]")
    assert count_trees(grammar, []) == inf
    e = (1 - 0.4**0.5) / 0.6
    assert exp(log_probability(grammar, [])) == pytest.approx(e)
    # one a: x = 0.6 e x + 0.2
    assert exp(log_probability(grammar, ["a"])) == pytest.approx(0.2 / (1 - 0.6 * e))
    assert choices_of(parse(grammar, [])) == (1,)
    assert choices_of(parse(grammar, ["a"])) == (2,)


def test_equally_probable_trees_go_by_fewest_rules_then_rule_order_then_short_first_part() -> None:
    fewest = read_grammar("S -> A [0.5] | B [0.5]\nA -> C\nC -> a\nB -> a")
    assert choices_of(parse(fewest, ["a"])) == (1, 4)
    order = read_grammar("S -> B | A\nA -> a\nB -> a")
    assert choices_of(parse(order, ["a"])) == (0, 3)
    split = read_grammar("S -> S S [0.5] | a [0.5]")
    tree = parse(split, ["a"] * 4)
    assert [child.leaves() for child in tree.children] == [("a",), ("a",) * 3]


def test_long_sentences_do_not_run_under() -> None:
    grammar = read_grammar("S -> a S [0.001] | b S [0.001] | empty [0.998]")
    sentence = ["a", "b"] * 150
    assert log_probability(grammar, sentence) == pytest.approx(300 * log(0.001) + log(0.998))
    assert parse(grammar, sentence).leaves() == tuple(sentence)


def test_a_rule_of_probability_zero_is_never_used() -> None:
    grammar = read_grammar("S -> a [1] | b [0]")
    assert accepts(grammar, ["a"])
    assert not accepts(grammar, ["b"])


@given(grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=4).map(tuple))
@settings(max_examples=40, deadline=None)
@example(read_grammar("S -> a A\nA -> b | empty"), ("a", "a"))
def test_failure_names_the_first_bad_symbol_and_all_that_could_stand_there(
    grammar: Grammar, sentence: tuple[str, ...]
) -> None:
    longer = [s for n in range(7) for s in product("ab", repeat=n)]
    language = {s for s in longer if accepts(grammar, s)}
    fault = explain(grammar, sentence)
    if sentence in language:
        assert fault is None
        return
    assert fault is not None
    before = sentence[: fault.position]
    # what stands before goes on with every expected symbol and with no other, as far as we look
    seen = {s[len(before)] for s in language if s[: len(before)] == before and s != before}
    assert seen <= set(fault.expected)
    assert fault.may_end == (before in language)
    assert fault.symbol == (sentence[len(before)] if len(before) < len(sentence) else None)
    assert fault.symbol not in fault.expected


def test_expected_set_is_exact_where_the_language_is_finite() -> None:
    with pytest.raises(ParseError) as caught:
        parse(TOY, tuple("rfdfdm"))
    assert (caught.value.position, caught.value.symbol) == (4, "d")
    assert caught.value.expected == ("p", "s")
    with pytest.raises(ParseError) as caught:
        parse(TOY, tuple("r"))
    assert caught.value.expected == ("d", "f", "p", "s")
    assert caught.value.symbol is None


BALL = read_grammar("S -> hold A\nA -> dribble B\nB -> shoot | pass | empty")


@pytest.mark.parametrize(
    ("sentence", "message"),
    [
        (
            "hold dribble dribble",
            "symbol 2 ('dribble'): expected one of pass, shoot, the end, found dribble. Put"
            " another symbol there, or learn the rules from sentences that hold this one.",
        ),
        (
            "hold dribbel",
            "symbol 1 ('dribbel'): expected dribble, found dribbel, a symbol that the grammar"
            " does not know. Did you mean dribble?",
        ),
        (
            "hold B",
            "symbol 1 ('B'): expected dribble, found B, a nonterminal."
            " A sentence holds terminals only.",
        ),
        (
            "hold",
            "end of the sentence (after symbol 0, 'hold'): expected dribble, found the end."
            " Go on with it.",
        ),
        ("", "end of the sentence: expected hold, found the end. Go on with it."),
        (
            "hold dribble pass zzz",
            "symbol 3 ('zzz'): expected the end, found zzz, a symbol that the grammar does not"
            " know. Use a terminal of the grammar.",
        ),
    ],
)
def test_message_of_a_failure(sentence: str, message: str) -> None:
    with pytest.raises(ParseError) as caught:
        parse(BALL, sentence.split())
    assert str(caught.value) == message


def test_a_grammar_that_derives_nothing_is_refused() -> None:
    with pytest.raises(GrammarError, match=r"never ends\. Add a rule"):
        parse(read_grammar("S -> a S"), ["a"])
    with pytest.raises(GrammarError, match="a rule for the start symbol 'S', found none"):
        parse(Grammar("S", ()), ["a"])
    nothing = Grammar("S", (Rule("S", ("a",), 0.0),))
    with pytest.raises(GrammarError, match="probability above 0"):
        parse(nothing, ["a"])


def test_a_sentence_of_thousands_of_symbols_is_refused() -> None:
    grammar = read_grammar("S -> a S | a")
    assert parse(grammar, ["a"] * 200).leaves() == ("a",) * 200
    with pytest.raises(GrammarError, match="expected at most 1,000 symbols, found 4,000"):
        parse(grammar, ["a"] * 4_000)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "".join(f"N{k} -> N{k + 1}\n" for k in range(1_200)) + "N1200 -> a",
            "grammar: expected at most 1,001 nonterminals, found 1,201.",
        ),
        (
            "S -> " + "a " * 1_001,
            "grammar: expected at most 1,000 symbols on a right side, found 1,001.",
        ),
        (
            "S -> " + " | ".join(f"a{k} S" for k in range(10_001)) + " | b",
            "grammar: expected at most 20,000 symbols on all right sides, found 20,003.",
        ),
        (
            "".join(f"N{k} -> N{(k + 1) % 900} | N{(k + 7) % 900} | a\n" for k in range(900)),
            "grammar: expected at most 4,000,000 chains from symbol to symbol without reading "
            "anything, found more.",
        ),
    ],
)  # fmt: skip
def test_a_grammar_that_is_too_large_is_refused(text: str, message: str) -> None:
    with pytest.raises(GrammarError) as error:
        parse(read_grammar(text), ["a"])
    assert str(error.value).startswith(message)


def test_a_chart_that_would_grow_too_large_is_refused() -> None:
    names = [f"N{k}" for k in range(40)]
    rules = [f"{a} -> {' | '.join(f'{a} {b}' for b in names)} | a | b" for a in names]
    dense = read_grammar(f"S -> {' | '.join(names)}\n" + "\n".join(rules))
    with pytest.raises(GrammarError) as error:
        log_probability(dense, ["a", "b"] * 200)
    assert str(error.value) == (
        "sentence: expected a chart of at most 500,000,000 products and 12,000,000 entries, "
        "found more for 400 symbols: too many symbols of the grammar derive the same spans. "
        "Give the sentence in parts, or use a grammar with fewer alternatives."
    )
