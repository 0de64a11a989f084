"""Sentences that follow one another, as in a take."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar, Tree
from motiondb.grammar.derivation.derive import derive


def draw_chain(
    grammar: Grammar, seconds: Mapping[str, float], wanted: float, rng: np.random.Generator
) -> tuple[Tree, ...]:
    """Draw sentences that follow one another until they take a wanted time.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> chain = draw_chain(
    ...     read_grammar("S -> a b"), {"a": 1.0, "b": 2.0}, 10.0, np.random.default_rng(0)
    ... )
    >>> [" ".join(tree.leaves()) for tree in chain]
    ['a b', 'a b', 'a b']
    """
    trees: list[Tree] = []
    total = 0.0
    while total < wanted:
        tree = derive(grammar, rng)
        longer = total + sum(seconds[name] for name in tree.leaves())
        if trees and wanted - total <= longer - wanted:
            break
        trees.append(tree)
        total = longer
    return tuple(trees)
