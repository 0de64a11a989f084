"""Patterns completed by sentences of a grammar, against all strings tried one by one."""

from __future__ import annotations

import re
from collections import Counter
from itertools import islice, product
from math import exp

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.closure import BEST
from motiondb.grammar.cfg.context_free import GrammarError, read_grammar
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.parse import compiled_form, log_probability
from motiondb.grammar.derivation.complete import complete, intersect, sample_completions
from motiondb.grammar.derivation.pattern import (
    PatternSymbol,
    acceptor_of,
    automaton_of,
    read_pattern,
)
from motiondb.grammar.languages import finite_language
from tests.grammar.random_grammars import grammars

FINITE = read_grammar(
    "S -> a A b [0.5] | A B [0.3] | c [0.2]\nA -> x [0.6] | x y [0.3] | empty [0.1]\nB -> b | y b"
)
NESTED = read_grammar("S -> a S b [0.4] | x [0.5] | y [0.1]")
AMBIGUOUS = read_grammar("S -> S p S [0.3] | x [0.4] | y [0.3]")
TOKENS = st.lists(st.sampled_from(["...", "?", "a", "b", "x", "y"]), min_size=1, max_size=5)


def pattern(text):
    return read_pattern(text.split())


def matches(tokens, string):
    """Whether a string of one-letter terminals matches, by a regular expression."""
    written = "".join({"...": ".*", "?": "."}.get(token, token) for token in tokens)
    return re.fullmatch(written, "".join(string)) is not None


def dense_steps(made):
    """The weights (terminals, Q, Q) of an automaton's edges."""
    n = len(made.loops)
    steps = np.zeros((made.stays.shape[1], n, n))
    for s in range(n):
        if made.loops[s] >= 0:
            steps[:, s, s] = made.stays[made.loops[s]]
        for e in range(made.starts[s], made.starts[s + 1]):
            steps[made.terminals[e], s, made.targets[e]] += made.weights[e]
    return steps


@settings(max_examples=40, deadline=None)
@given(TOKENS, st.text("abxy", max_size=6), st.sampled_from([None, frozenset("abx")]))
def test_the_acceptor_reads_each_string_that_matches_in_one_way(tokens, string, allowed):
    made = acceptor_of(read_pattern(tokens), "abxy", allowed)
    steps = dense_steps(made)
    ways = np.zeros(len(made.loops))
    ways[0] = 1
    for symbol in string:
        ways = ways @ steps["abxy".index(symbol)]
    expected = matches(tokens, string) and (allowed is None or allowed.issuperset(string))
    assert ways[made.final].sum() == int(expected)


def slow_probability(grammar, tokens, allowed):
    """The probability of a pattern: all items of the deterministic automaton, again and again.

    Also whether the iteration came to an end; at a critical grammar it would take for ever.
    """
    compiled = compiled_form(grammar)
    made = automaton_of(read_pattern(tokens), compiled.names[compiled.terminals], allowed)
    n = len(made.steps)
    weights = np.zeros((compiled.n_symbols, n, n))
    for place, steps in enumerate(made.steps.T):
        for s in np.flatnonzero(steps >= 0):
            weights[compiled.terminals.start + place, s, steps[s]] = 1.0
    for _ in range(500):
        before = weights.copy()
        for symbol in range(compiled.n_symbols):
            if compiled.left[symbol] >= 0:
                weights[symbol] = weights[compiled.left[symbol]] @ weights[compiled.right[symbol]]
            elif symbol < compiled.n_nonterminals:
                rules = range(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
                rights = [(compiled.probabilities[r], compiled.rule_right[r]) for r in rules]
                weights[symbol] = sum(p * (np.eye(n) if y < 0 else weights[y]) for p, y in rights)
        if np.abs(weights - before).max() < 1e-15:
            break
    return weights[compiled.start, 0, made.accepting].sum(), np.abs(weights - before).max() < 1e-15


@settings(max_examples=30, deadline=None)
@given(
    grammars(),
    st.lists(st.sampled_from(["...", "?", "a", "b"]), min_size=1, max_size=6),
    st.sampled_from([None, frozenset("a")]),
)
@example(read_grammar("S -> S a [0.5] | empty [0.5]"), ["...", "?", "a", "a", "..."], None)
def test_the_probability_of_a_pattern_is_that_of_a_slow_iteration(grammar, tokens, allowed):
    slow, ended = slow_probability(grammar, tokens, allowed)
    meeting = intersect(grammar, read_pattern(tokens), allowed)
    if ended:
        assert meeting.ends.sum() == pytest.approx(slow, rel=1e-9, abs=1e-12)
    best = inside(meeting.compiled, meeting.automaton, BEST)
    n = range(len(best.loops))
    for item in product(range(meeting.compiled.n_symbols), n, n):
        assert best.weight(*item) <= meeting.sums.weight(*item) + 1e-9
        assert (best.weight(*item) > 0) == (meeting.sums.weight(*item) > 0)


@settings(max_examples=30, deadline=None)
@given(TOKENS, st.integers(1, 4))
def test_completions_of_a_finite_language_are_its_best_matching_strings(tokens, n):
    asked = read_pattern(tokens)
    chance = {s: exp(log_probability(FINITE, s)) for s in finite_language(FINITE)}
    matching = {s: p for s, p in chance.items() if matches(tokens, s)}
    if not matching:
        with pytest.raises(GrammarError, match="pattern: expected"):
            complete(FINITE, asked, n)
        return
    completions = complete(FINITE, asked, n)
    total = sum(matching.values())
    assert completions.probability == pytest.approx(total)
    best = sorted(matching.values(), reverse=True)[:n]
    assert [c.probability for c in completions.sentences] == pytest.approx(
        [p / total for p in best]
    )
    assert all(
        c.probability == pytest.approx(matching[c.string] / total) for c in completions.sentences
    )


@pytest.mark.parametrize("grammar", [NESTED, AMBIGUOUS])
@pytest.mark.parametrize("text", ["... x ...", "? ? ?", "? ... y ?", "x", "... ? ? ? ..."])
def test_completions_of_endless_languages_are_the_best_of_all_short_strings(grammar, text):
    tokens = text.split()
    strings = [s for n in range(1, 8) for s in product(grammar.terminals, repeat=n)]
    chance = {s: exp(log_probability(grammar, s)) for s in strings if matches(tokens, s)}
    matching = sorted((p for p in chance.values() if p > 0), reverse=True)
    if not matching:
        with pytest.raises(GrammarError, match="pattern"):
            complete(grammar, pattern(text))
        return
    completions = complete(grammar, pattern(text), 3)
    ours = [c.probability * completions.probability for c in completions.sentences]
    assert ours == pytest.approx(matching[:3], rel=1e-6)


def test_samples_have_the_distribution_of_the_grammar_given_the_pattern():
    asked = pattern("a ... b")
    rng = np.random.default_rng(5)
    trees = islice(sample_completions(NESTED, asked, rng), 4000)
    counts = Counter(tree.leaves() for tree in trees)
    total = intersect(NESTED, asked).ends.sum()
    assert total == pytest.approx(0.4 * 1.0)  # S -> a S b, and S always ends
    for string, number in counts.most_common(4):
        expected = exp(log_probability(NESTED, string)) / total
        assert number / 4000 == pytest.approx(expected, abs=4 * (expected / 4000) ** 0.5)
    again = np.random.default_rng(5)
    first = next(sample_completions(NESTED, asked, np.random.default_rng(5)))
    assert next(sample_completions(NESTED, asked, again)) == first


def test_a_place_takes_any_of_its_terminals_and_only_what_is_allowed():
    asked = read_pattern([PatternSymbol("letter", frozenset("xy"))])
    assert [c.string for c in complete(NESTED, asked).sentences] == [("x",), ("y",)]
    completions = complete(NESTED, asked, allowed=frozenset("aby"))
    assert [c.string for c in completions.sentences] == [("y",)]
    assert completions.probability == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a y b b", "expected 'b' at once after 'a y b', found .* it can hold nothing"),
        ("... x ... y", "expected 'y' anywhere after '... x', found .* it can hold b"),
        ("b ...", "expected 'b' at once at the beginning, found .* can hold a, x, y"),
        ("a x", "a sentence can end after 'a x', found none"),
    ],
)
def test_an_impossible_pattern_says_why(text, message):
    with pytest.raises(GrammarError, match=message):
        complete(NESTED, pattern(text))
    with pytest.raises(GrammarError, match=message):
        next(sample_completions(NESTED, pattern(text), np.random.default_rng(0)))


def test_an_empty_pattern_and_one_of_too_many_states_are_refused():
    with pytest.raises(GrammarError, match="pattern: expected terminals"):
        read_pattern([])
    with pytest.raises(GrammarError, match="needs at most 200 states"):
        automaton_of(pattern("... x " + "? " * 12), ["x", "y"])
