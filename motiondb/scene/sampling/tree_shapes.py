"""Derivations as lists of rules, where a subtree is a slice; and the error of each subtree.

A tree is the list of its rules in preorder (:func:`motiondb.grammar.cfg.context_free.choices_of`).
The subtree of a nonterminal is a slice of this list, and derives a slice of the action string.
Exchanging a subtree is exchanging both slices.

The error of a subtree is the paper's geometric mean, with leaf errors of at least 1 (1 + a clip's
share of -log P(Y); with the printed errors, one flawless clip would make the error of all its
ancestors 0):

    E(T) = (product of E(children)) ^ (1 / (n + 1)),    1 if it derives nothing               (10)

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from motiondb.grammar.cfg.context_free import Grammar
from motiondb.records import FloatArray, IntArray

LEAF = -1  # Marks an action among the numbers of children


@dataclass(frozen=True, eq=False)
class TreeShape:
    """A derivation tree of one player."""

    rules: tuple[int, ...]  # Numbers of the rules in preorder, one for each nonterminal node
    actions: tuple[str, ...]
    children: IntArray  # (all nodes,), int: number of children in preorder; LEAF for an action
    symbols: tuple[str, ...]  # The symbol of each nonterminal node
    # (nonterminal nodes, 3), int: the rule after the last of the node's subtree (its first has the
    # number of the node), its first action, and the action after its last
    spans: IntArray


def tree_shape(grammar: Grammar, rules: Sequence[int]) -> TreeShape:
    r"""Return the shape of the tree with these rules in preorder.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> shape = tree_shape(read_grammar("S -> a A c\nA -> b | empty"), [0, 1])
    >>> shape.actions, shape.children.tolist(), shape.spans.tolist()
    (('a', 'b', 'c'), [3, -1, 1, -1, -1], [[2, 0, 3], [2, 1, 2]])
    """
    children: list[int] = []
    actions: list[str] = []
    symbols: list[str] = []
    spans: list[list[int]] = []
    waiting: list[str | int] = [grammar.start]
    nonterminals = grammar.rules_of
    while waiting:
        symbol = waiting.pop()
        if isinstance(symbol, int):  # the end of a node
            spans[symbol][0], spans[symbol][2] = len(symbols), len(actions)
        elif symbol in nonterminals:
            right = grammar.rules[rules[len(symbols)]].right
            waiting.append(len(symbols))
            waiting.extend(reversed(right))
            symbols.append(symbol)
            spans.append([0, len(actions), 0])
            children.append(len(right))
        else:
            actions.append(symbol)
            children.append(LEAF)
    return TreeShape(
        tuple(rules),
        tuple(actions),
        np.array(children, dtype=np.int64),
        tuple(symbols),
        np.array(spans, dtype=np.int64).reshape(-1, 3),
    )


def exchanged(grammar: Grammar, shape: TreeShape, node: int, rules: Sequence[int]) -> TreeShape:
    """Return the tree with another subtree at a node, given by its rules in preorder."""
    end = int(shape.spans[node, 0])
    return tree_shape(grammar, (*shape.rules[:node], *rules, *shape.rules[end:]))


@njit(cache=True, nogil=True)
def subtree_errors(children: IntArray, errors: FloatArray, output: FloatArray) -> int:
    """Fill ``output`` with E of all nonterminal nodes in preorder, and return their number.

    Parameters
    ----------
    children : array of int (nodes,)
        Of a :class:`TreeShape`.
    errors : array (at least actions,)
        Errors of the leaves.
    output : array (at least nonterminal nodes,)
        Receives the result.
    """
    n_leaves = n_nodes = 0
    for n in children:
        if n == LEAF:
            n_leaves += 1
        else:
            n_nodes += 1
    stack = np.empty(len(children))
    leaf, node, top = n_leaves, n_nodes, 0
    for i in range(len(children) - 1, -1, -1):  # children come after their parents
        n = children[i]
        if n == LEAF:
            leaf -= 1
            stack[top] = np.log(errors[leaf])
            top += 1
            continue
        total = 0.0
        for _ in range(n):
            top -= 1
            total += stack[top]
        stack[top] = total / (n + 1)
        top += 1
        node -= 1
        output[node] = np.exp(stack[top - 1])
    return n_nodes
