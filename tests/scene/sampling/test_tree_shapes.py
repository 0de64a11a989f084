"""Trees as lists of rules, and the errors of subtrees beside the formula written out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import Tree, choices_of, derive_by, read_grammar
from motiondb.scene.sampling.random_subtrees import Derivations
from motiondb.scene.sampling.tree_growth import exchanged, subtree_errors, tree_shape

GRAMMAR = read_grammar("S -> A S B | A | empty\nA -> a | b a\nB -> empty | b S")
FREE = Derivations(GRAMMAR, [])


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
    shape = tree_shape(GRAMMAR, drawn(seed))
    leaves = np.random.default_rng(other).uniform(1.0, 30.0, len(shape.actions))
    actual = np.empty(len(shape.rules))
    assert subtree_errors(shape.children, leaves, actual) == len(shape.rules)
    wanted = errors_of(derive_by(GRAMMAR, shape.rules), leaves.tolist())
    np.testing.assert_allclose(actual, wanted, rtol=1e-12)


def test_worked_errors() -> None:
    shape = tree_shape(GRAMMAR, [1, 4])  # S(A(b a))
    actual = np.empty(2)
    subtree_errors(shape.children, np.array([2.0, 4.0]), actual)
    assert actual == pytest.approx([math.sqrt(2.0), 2.0])  # A: 8^(1/3); S: 2^(1/2)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 10_000))
def test_a_subtree_is_a_slice(seed: int, other: int) -> None:
    shape = tree_shape(GRAMMAR, drawn(seed))
    tree = derive_by(GRAMMAR, shape.rules)
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
        after = exchanged(GRAMMAR, shape, node, new.rules)
        _, first, last = shape.spans[node].tolist()
        assert after.actions == shape.actions[:first] + new.actions + shape.actions[last:]
