"""What may come next: probabilities by hand and by enumeration of the language."""

from __future__ import annotations

from itertools import product
from math import exp, inf

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import Grammar, Rule, read_grammar
from motiondb.grammar.cfg.parse import ParseError, log_probability, prefix_log_probability, suggest

LEFT = read_grammar("S -> S a [0.5] | S b [0.2] | c [0.3]")


rules = st.builds(
    Rule,
    st.sampled_from(["S", "A"]),
    st.lists(st.sampled_from(["S", "A", "a", "b"]), max_size=3).map(tuple),
    st.sampled_from([1.0, 2.0]),
)


@st.composite
def dying_grammars(draw: st.DrawFn) -> Grammar:
    """Grammars whose strings are short nearly always: every nonterminal ends with 8 of 10."""
    actual, ending = draw(st.lists(rules, min_size=1, max_size=5)), []
    for left in ("S", "A"):
        ending.append(Rule(left, tuple(draw(st.lists(st.sampled_from(["a", "b"]), max_size=2)))))
    grown = {left: sum(r.probability for r in actual if r.left == left) or 1.0 for left in "SA"}
    weights = [0.2 * r.probability / grown[r.left] for r in actual] + [0.8, 0.8]
    return Grammar("S", (*actual, *ending), ("a", "b")).with_probabilities(weights)


@given(dying_grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=3).map(tuple))
@settings(max_examples=40, deadline=None)
def test_probabilities_are_those_of_the_enumerated_language(
    grammar: Grammar, prefix: tuple[str, ...]
) -> None:
    tails = [tail for n in range(7) for tail in product("ab", repeat=n)]
    chance = {tail: exp(log_probability(grammar, prefix + tail)) for tail in tails}
    assume(sum(chance.values()) > 0)
    begun = exp(prefix_log_probability(grammar, prefix))
    unseen = begun - sum(chance.values())  # of the longer strings
    assert unseen > -1e-12
    actual = dict(suggest(grammar, prefix))
    assert sum(actual.values()) == pytest.approx(1)
    assert actual.get(None, 0.0) * begun == pytest.approx(chance[()])
    for symbol in ("a", "b"):
        seen = sum(p for tail, p in chance.items() if tail[:1] == (symbol,))
        assert seen - 1e-12 <= actual.get(symbol, 0.0) * begun <= seen + unseen + 1e-12


@given(dying_grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=4).map(tuple))
@settings(max_examples=40, deadline=None)
def test_prefix_probabilities_add_up(grammar: Grammar, prefix: tuple[str, ...]) -> None:
    """P(w ...) = P(w) + the sum over t of P(w t ...)."""
    here = exp(prefix_log_probability(grammar, prefix))
    more = sum(exp(prefix_log_probability(grammar, (*prefix, t))) for t in "ab")
    assert here == pytest.approx(exp(log_probability(grammar, prefix)) + more, abs=1e-12)


def test_a_prefix_of_no_sentence() -> None:
    assert prefix_log_probability(LEFT, ["a"]) == -inf
    assert prefix_log_probability(LEFT, ["c", "zzz"]) == -inf
    with pytest.raises(ParseError, match=r"symbol 0 \('a'\): expected c, found a"):
        suggest(LEFT, ["a", "b"])


def test_a_language_of_the_empty_string_alone() -> None:
    grammar = read_grammar("S -> empty")
    assert suggest(grammar, []) == ((None, 1.0),)
    with pytest.raises(ParseError, match="expected the end, found a, a symbol"):
        suggest(grammar, ["a"])
