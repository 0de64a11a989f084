"""Foresight and freedom: worked numbers, and a twin that lists all passages."""

from __future__ import annotations

from collections import Counter
from itertools import product
from math import exp

import numpy as np
import pytest

from motiondb.grammar import foresight
from motiondb.grammar.cfg.context_free import Grammar, read_grammar
from motiondb.grammar.cfg.parse import prefix_log_probability
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.languages import finite_state_grammar

TOY = "S -> a B [0.75] | c [0.25]\nB -> b [0.5] | b b [0.5]"
SENTENCES = {"ab": 0.375, "abb": 0.375, "c": 0.25}


def factors(width: int) -> Counter[str]:
    """The probability of each window that begins anywhere in a passage, by listing passages."""
    found: Counter[str] = Counter()
    mean = sum(chance * len(sentence) for sentence, chance in SENTENCES.items())
    for sentences in product(SENTENCES, repeat=width + 1):
        chance = float(np.prod([SENTENCES[sentence] for sentence in sentences]))
        for start in range(len(sentences[0])):
            found["".join(sentences)[start : start + width]] += chance / mean
    return found


def test_windows_have_the_chances_of_all_passages_listed() -> None:
    found = foresight.endings_grammar(read_grammar(TOY))
    listed = factors(3)
    assert sum(listed.values()) == pytest.approx(1.0)
    actual = {"".join(w): exp(prefix_log_probability(found, w)) for w in product("abc", repeat=3)}
    # passages of the grammar end with a small chance, which those of the list do not
    for window, chance in actual.items():
        assert chance == pytest.approx(listed[window], rel=0.05, abs=1e-12), window


def test_a_model_accepts_factors_of_passages_only() -> None:
    model = foresight.make_model(read_grammar(TOY), [[tuple("ab"), tuple("c")]], 0.5)
    listed = set(factors(4))
    for window in product("abc", repeat=4):
        assert model.accepts(window) == ("".join(window) in listed), window


@pytest.mark.parametrize("weight", [0.0, 0.3, 0.9])
def test_smoothed_chances_sum_to_one_and_none_is_zero(weight: float) -> None:
    grammar = Grammar("S", read_grammar(TOY).rules, ("a", "b", "c", "d"))
    model = foresight.make_model(grammar, [[tuple("ab"), tuple("abb"), tuple("c")]], weight)
    for n in (1, 2, 3):
        total = sum(exp(model.log_probability(w)) for w in product("abcd", repeat=n))
        assert total == pytest.approx(1.0)
    assert model.log_probability(tuple("ddda")) > -np.inf


def test_judged_windows_by_hand() -> None:
    """After a comes b in the takes: of aab, aba is as probable a window, and baa is less."""
    takes = [[tuple("ab")] * 10]
    model = foresight.make_model(read_grammar("S -> a b"), takes, 0.0)
    less, ties, accepted, freedom = foresight.ranks(model, [tuple("abab")])[0]
    # shuffles of abab: aabb, abba, baab, baba, bbaa; the rules accept baba only
    assert (less, accepted, freedom) == (1.0, 1.0, pytest.approx(1 / 5))
    assert ties == 1.0
    less, ties, accepted, freedom = foresight.ranks(model, [tuple("bbaa")])[0]
    assert (less, accepted, freedom) == (0.0, 0.0, pytest.approx(2 / 5))


def test_a_cycle_is_foreseen_a_heap_is_not_and_a_list_is_told() -> None:
    cycle = [[tuple("abcde")] * 6] * 3
    found = foresight.foresee(induce, cycle, np.random.default_rng(0))
    assert found is not None
    assert (found.windows, found.foreseen) == (3 * 26, 1.0)
    # of 119 shuffles the four other turns of abcde are accepted, and nearly as probable
    assert found.right_of_two == pytest.approx(1.0, abs=4 / 119)
    assert (found.accepted, found.extreme) == (1.0, "")
    assert found.freedom == pytest.approx(4 / 119)
    rng = np.random.default_rng(1)
    heap = [[tuple(rng.choice(list("abcdef"), 12).tolist())] for _ in range(6)]
    judged = foresight.foresee(finite_state_grammar, heap, np.random.default_rng(0))
    assert judged is not None
    assert judged.right_of_two == pytest.approx(0.5, abs=0.2)
    assert judged.foreseen < 0.3
    listing = foresight.foresee(lambda s: induce(s, loops=False), heap, np.random.default_rng(0))
    assert listing is not None
    assert listing.extreme == "list"
    anything = read_grammar("S -> a | b | c | d | e | f")
    free = foresight.foresee(lambda _: anything, heap, np.random.default_rng(0))
    assert free is not None
    assert (free.freedom, free.extreme) == (1.0, "everything")


def test_too_few_takes_say_nothing() -> None:
    assert foresight.foresee(induce, [[tuple("abcdefgh")] * 9], np.random.default_rng(0)) is None
    assert foresight.foresee(induce, [[tuple("abcdef")]] * 4, np.random.default_rng(0)) is None
    assert foresight.foresee(induce, [], np.random.default_rng(0)) is None


def test_the_order_of_a_string_is_ranked_among_its_shuffles() -> None:
    takes = [[tuple("abcd")] * 8] * 2
    model = foresight.make_model(read_grammar("S -> a b c d"), takes, 0.5)
    rng = np.random.default_rng(0)
    known = foresight.order_rank(model, tuple("bcdabcdab"), rng)
    turned = foresight.order_rank(model, tuple("dcbadcbad"), rng)
    assert known is not None
    assert turned is not None
    assert known == 1.0
    assert turned < 0.5
    assert foresight.order_rank(model, tuple("abcd"), rng) is None
    assert foresight.order_rank(model, ("a",) * 20, rng) is None
