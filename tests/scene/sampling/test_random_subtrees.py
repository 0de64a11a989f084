"""Subtrees drawn under the condition that the diagram's wishes are still met."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Grammar, Tree, choices_of, derive_by, read_grammar
from motiondb.scene.language.expressions import Item, expressions, g_user, spans
from motiondb.scene.sampling.random_subtrees import NOWHERE, Derivations
from motiondb.scene.sampling.tree_growth import exchanged, subtree_errors, tree_shape

FINITE = read_grammar(
    """
    S -> A B [0.7] | B [0.3]
    A -> run [0.4] | walk [0.35] | catch [0.25]
    B -> catch shoot [0.6] | A shoot [0.3] | empty [0.1]
    """
)
"""All its strings can be listed."""


ASKED = ("catch", "shoot", "fake_shot")


def all_derivations(grammar: Grammar, symbol: str) -> list[tuple[float, tuple[int, ...], tuple]]:
    """Probability, rules and string of every tree, one after the other: the slow twin."""
    if not grammar.is_nonterminal(symbol):
        return [(1.0, (), (symbol,))]
    actual = []
    for number in grammar.rules_of[symbol]:
        partial = [(grammar.rules[number].probability, (number,), ())]
        for part in grammar.rules[number].right:
            partial = [
                (p * q, rules + more, string + tail)
                for p, rules, string in partial
                for q, more, tail in all_derivations(grammar, part)
            ]
        actual += partial
    return actual


ITEMS = [Item(("catch",)), Item(("shoot",))]


def test_inside_sums_are_those_of_all_trees() -> None:
    derivations = Derivations(FINITE, ITEMS)
    for symbol in FINITE.nonterminals:
        wanted = np.zeros((3, 3))
        for p, _, string in all_derivations(FINITE, symbol):
            for i in range(3):
                wanted[i, derivations.run(string, i)[-1]] += p
        np.testing.assert_allclose(derivations.inside(symbol), wanted, atol=1e-12)


def test_another_thread_never_sees_sums_that_are_being_made(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    derivations, seen = Derivations(FINITE, ITEMS), list[np.ndarray]()
    made = derivations._trees.made
    weigh = type(made).weight

    def weight(self: object, symbol: int, *states: int) -> float:
        if not seen:  # as a chain that asks in between
            seen.append(np.zeros(0))
            seen[0] = derivations.inside("S").copy()
        return float(weigh(made, symbol, *states))

    monkeypatch.setattr(type(made), "weight", weight)
    np.testing.assert_array_equal(derivations.inside("S"), seen[0])
    assert seen[0].any()


def test_draws_have_the_probabilities_of_the_trees_that_fit() -> None:
    from scipy.stats import chisquare

    derivations = Derivations(FINITE, ITEMS)
    fit = {
        rules: p
        for p, rules, string in all_derivations(FINITE, "S")
        if g_user(string, [i.actions for i in ITEMS]) == 0
    }
    rng = np.random.default_rng(5)
    drawn = Counter(derivations.draw("S", 0, [2], rng).rules for _ in range(4000))
    assert set(drawn) <= set(fit)
    expected = np.array(list(fit.values())) / sum(fit.values()) * 4000
    assert expected.min() > 5
    # p over 0.001: a right sampler fails at one seed in a thousand, and this seed does not
    assert chisquare([drawn[rules] for rules in fit], expected).pvalue > 0.001


def test_recursion_without_end_has_its_least_solution() -> None:
    # S = S S p + (1 - p): the least solution is (1 - p) / p for p over a half
    derivations = Derivations(read_grammar("S -> S S [0.75] | a [0.25]"), [])
    assert derivations.inside("S")[0, 0] == pytest.approx(1.0 / 3.0, rel=1e-9)


@pytest.mark.parametrize("name", list(scene_texts.shipped(".tactics")))
def test_every_draw_does_what_the_diagram_asks_and_nothing_with_strangers(name: str) -> None:
    text = read_scene_text(name)
    diagram, grammar = text.diagram, text.grammar
    rng = np.random.default_rng(2)
    for player in diagram.players:
        items = expressions(diagram)[player.name]
        start = grammar.started(grammar.start_of(player.team))
        derivations = Derivations(start, items, grammar.only_asked)
        asked = Counter(action for item in items for action in item.actions)
        for _ in range(10):
            derivation = derivations.draw(start.start, 0, [len(items)], rng)
            tree = derive_by(start, derivation.rules)
            assert tree.leaves() == derivation.actions
            assert choices_of(tree) == derivation.rules
            assert spans(derivation.actions, items) is not None
            assert derivations.fits(derivation.actions)
            again = {a for item in items if item.repeated for a in item.actions}
            for action, times in Counter(derivation.actions).items():
                assert action not in grammar.only_asked or times == asked[action] or action in again


def test_what_nobody_asks_for_leads_nowhere_but_for_repeats() -> None:
    grammar = read_grammar("S -> fake_shot S | run S | shoot")
    derivations = Derivations(grammar, [Item(("fake_shot",), True), Item(("shoot",))], ASKED)
    assert derivations.run(["run", "fake_shot", "fake_shot", "shoot"])[-1] == 2
    assert derivations.run(["shoot"]) == [0, NOWHERE]
    assert derivations.run(["fake_shot", "run", "shoot", "shoot"])[-2:] == [2, NOWHERE]


def test_an_expression_that_cannot_be_met_is_refused() -> None:
    with pytest.raises(SceneError, match=r"from S that fits \(shoot\)\(catch\), found none\. Chan"):
        Derivations(read_grammar("S -> catch shoot"), [Item(("shoot",)), Item(("catch",))])
    with pytest.raises(SceneError, match=r"from S that fits \(catch\), found none"):
        Derivations(read_grammar("S -> catch shoot"), [Item(("catch",))], ASKED)


def test_too_long_a_draw_is_none() -> None:
    derivations = Derivations(read_grammar("S -> a S [0.999] | a [0.001]"), [])
    assert derivations.draw("S", 0, [0], np.random.default_rng(0), 5) is None


ENDLESS = read_grammar("S -> A S B | A | empty\nA -> a | b a\nB -> empty | b S")
FREE = Derivations(ENDLESS, [])


def drawn(seed: int) -> tuple[int, ...]:
    derivation = FREE.draw("S", 0, [0], np.random.default_rng(seed), 60)
    return derivation.rules if derivation else (1, 3)


def errors_of(tree: Tree, leaves: list[float]) -> list[float]:
    """E of all nonterminals in preorder: (10), one node after the other."""

    def error(node: Tree) -> float:
        if node.is_leaf:
            return left.pop(0)
        place = len(actual)
        actual.append(0.0)
        product = math.prod(error(child) for child in node.children)
        actual[place] = product ** (1.0 / (len(node.children) + 1))
        return actual[place]

    left, actual = list(leaves), []
    error(tree)
    return actual


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 10_000))
def test_errors_are_geometric_means(seed: int, other: int) -> None:
    shape = tree_shape(ENDLESS, drawn(seed))
    leaves = np.random.default_rng(other).uniform(1.0, 30.0, len(shape.actions))
    actual = np.empty(len(shape.rules))
    assert subtree_errors(shape.children, leaves, actual) == len(shape.rules)
    wanted = errors_of(derive_by(ENDLESS, shape.rules), leaves.tolist())
    np.testing.assert_allclose(actual, wanted, rtol=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 10_000))
def test_a_subtree_is_a_slice(seed: int, other: int) -> None:
    shape = tree_shape(ENDLESS, drawn(seed))
    tree = derive_by(ENDLESS, shape.rules)
    assert shape.actions == tree.leaves()
    assert shape.rules == choices_of(tree)
    inner = [node for node in tree.nodes() if not node.is_leaf]
    for number, node in enumerate(inner):
        end, first, last = shape.spans[number].tolist()
        assert shape.symbols[number] == node.symbol
        assert shape.rules[number:end] == choices_of(node)
        assert shape.actions[first:last] == node.leaves()
    node = other % len(inner)
    new = FREE.draw(shape.symbols[node], 0, [0], np.random.default_rng(other), 60)
    if new is not None:
        after = exchanged(ENDLESS, shape, node, new.rules)
        _, first, last = shape.spans[node].tolist()
        assert after.actions == shape.actions[:first] + new.actions + shape.actions[last:]
