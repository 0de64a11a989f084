"""Languages side by side, and the finite state machine that they are compared with."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, product
from math import exp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import TOY

from grammar_tasks.language_match import match_languages
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule, read_grammar
from motiondb.grammar.cfg.parse import ParseError, accepts, log_probability, parse, suggest
from motiondb.grammar.derivation.derive import derive, nearest_length
from motiondb.grammar.languages import (
    coverage,
    derived_strings,
    finite_language,
    finite_state_grammar,
    held_out_coverage,
)

SIX = [tuple(s) for s in ("rfdpm", "rfdsm", "rdfsm", "rdpm", "rdsm", "rpm")]


def test_the_toy_language_whole() -> None:
    inner = ["", "f", "d", "fd", "df", "ff", "fdf"]
    assert finite_language(TOY) == {tuple(f"r{x}{end}m") for x in inner for end in "ps"}
    assert finite_language(TOY, limit=13) is None


rules = st.builds(
    Rule,
    st.sampled_from(["S", "A", "B"]),
    st.lists(st.sampled_from(["S", "A", "B", "a", "b"]), max_size=2).map(tuple),
)


@given(st.lists(rules, min_size=2, max_size=6))
@settings(max_examples=50, deadline=None)
def test_a_finite_language_is_all_that_is_accepted(actual: list[Rule]) -> None:
    ending = [Rule("S", ("a",)), Rule("A", ()), Rule("B", ("b",))]
    grammar = Grammar("S", (*actual, *ending), ("a", "b")).with_probabilities(
        [1.0] * (len(actual) + 3)
    )
    short = {s for n in range(7) for s in product("ab", repeat=n) if accepts(grammar, s)}
    whole = finite_language(grammar)
    if whole is not None:
        assert {s for s in whole if len(s) < 7} == short
    else:  # three nonterminals and two symbols a rule: no gap between lengths is above 8
        assert nearest_length(grammar, 40) >= 32


def test_precision_sampled_and_recall_exact() -> None:
    loose = read_grammar("S -> r A m\nA -> T [0.8] | T A [0.2]\nT -> f | d | p | s")
    matches = match_languages(loose, TOY, np.random.default_rng(0), n=4000)
    assert (matches.precision_is_exact, matches.recall_is_exact) == (False, True)
    assert matches.recall == 1.0
    chance = sum(exp(log_probability(loose, s)) for s in finite_language(TOY))
    assert matches.precision == pytest.approx(chance, abs=0.03)  # 4 standard deviations


def test_coverage() -> None:
    assert coverage(TOY, [*SIX, ("r", "unknown")]) == pytest.approx(6 / 7)
    with pytest.raises(GrammarError, match="expected at least one to cover"):
        coverage(TOY, [])


def test_held_out_coverage_of_each_left_out_once() -> None:
    rng = np.random.default_rng(0)
    strings = [tuple(s) for s in ("ab", "ab", "abb", "c")]
    # abb covers both ab, ab does not cover bb
    assert held_out_coverage(finite_state_grammar, strings, rng, folds=4) == 0.5
    assert held_out_coverage(lambda seen: TOY, SIX, rng, folds=3) == 1.0
    with pytest.raises(GrammarError, match="folds: expected 2 to 4, the number of sentences"):
        held_out_coverage(finite_state_grammar, strings, rng, folds=5)


sentences_of = st.lists(
    st.lists(st.sampled_from("abc"), max_size=6).map(tuple), min_size=1, max_size=5
)


def pairs(sentences: list[tuple[str, ...]]) -> Counter[tuple[str | None, str | None]]:
    return Counter(pair for s in sentences for pair in pairwise([None, *s, None]))


@given(sentences_of, st.lists(st.sampled_from("abc"), max_size=5).map(tuple))
@settings(max_examples=50, deadline=None)
def test_the_machine_accepts_exactly_the_observed_transitions(
    sentences: list[tuple[str, ...]], string: tuple[str, ...]
) -> None:
    machine = finite_state_grammar(sentences)
    transitions = pairs(sentences)
    assert accepts(machine, string) == (set(pairs([string])) <= set(transitions))
    chance = 1.0
    for before, after in zip((None, *string), (*string, None)):
        out = sum(n for (a, _), n in transitions.items() if a == before)
        chance *= transitions[before, after] / out if out else 0.0
    assert exp(log_probability(machine, string)) == pytest.approx(chance)


def test_the_machine_by_hand() -> None:
    with pytest.raises(GrammarError, match="expected at least one, found none"):
        finite_state_grammar([])
    machine = finite_state_grammar(["ab", "abb", "S"])
    assert machine.start == "S'"
    assert dict(suggest(machine, [])) == pytest.approx({"a": 2 / 3, "S": 1 / 3})
    assert dict(suggest(machine, ["a", "b"])) == pytest.approx({"b": 1 / 3, None: 2 / 3})
    with pytest.raises(ParseError, match=r"symbol 1 \('a'\): expected b, found a"):
        parse(machine, "aa")
    assert derive(machine, np.random.default_rng(0), length=9).leaves() == tuple("abbbbbbbb")


def test_the_machine_generates_what_the_grammar_does_not() -> None:
    """A machine knows pairs only: it nests nothing and counts nothing."""
    nested = read_grammar("S -> a S b | a b")
    strings = derived_strings(nested, np.random.default_rng(0), 30)
    machine = finite_state_grammar(strings)
    assert coverage(machine, strings) == 1.0
    assert coverage(nested, derived_strings(machine, np.random.default_rng(0), 300)) < 0.7
