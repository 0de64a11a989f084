"""Inserting and removing one link of a chain in a tree, with everything below it kept.

Many grammars spell repetition by right recursion, A -> B A (a move and more moves). Deriving a node
of such a chain again discards everything after it. Growing puts one link above a node v of symbol
A,

    T_v   ->   A(B(..), T_v),

and shrinking removes it, so that an action is inserted or removed and the others, with their clips,
stay. Growing at v and shrinking at v are each other's reverse: for every v by itself their
probabilities give the ratio of a Metropolis-Hastings step. The probability of growing, at a given
v, is

    p_r / (sum of p over the rules A -> B A)  *  p(B's subtree) / I_B[i, ends],

where the last factor is the condition that the string fits (:mod:`.random_subtrees`). That of
shrinking is 1.

Source: P. J. Green, "Reversible jump Markov chain Monte Carlo computation and Bayesian model
determination", Biometrika 82 (1995): births and deaths as pairs of moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.kernels import maker
from motiondb.records import FloatArray, IntArray
from motiondb.scene.sampling.random_subtrees import Derivations

# Derivations as lists of rules, where a subtree is a slice; and the error of each subtree.


LEAF = -1  # Marks an action among the numbers of children


@dataclass(frozen=True, eq=False)
class TreeShape:
    """A derivation tree of one player.

    A tree is the list of its rules in preorder
    (:func:`motiondb.grammar.cfg.context_free.choices_of`). The subtree of a nonterminal is a slice
    of this list, and derives a slice of the action string. Exchanging a subtree is exchanging both
    slices.

    The error of a subtree is the paper's geometric mean, with leaf errors of at least 1 (1 + a
    clip's share of -log P(Y); with the printed errors, one flawless clip would make the error of
    all its ancestors 0):

        E(T) = (product of E(children)) ^ (1 / (n + 1)),    1 if it derives nothing             (10)

    Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
    Forum 35 (2016), section 5.
    """

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


@maker
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


@dataclass(frozen=True)
class Linked:
    """A tree with one link more or less."""

    rules: tuple[int, ...]  # Its rules in preorder
    span: tuple[int, int]  # The actions [first, last) of the old tree that are replaced
    actions: tuple[str, ...]  # The actions that replace them
    log_ratio: float  # Log q(old) / q(new)


@dataclass(frozen=True, eq=False)
class Chains:
    """The rules A -> B A of a player's grammar."""

    derivations: Derivations
    links: dict[str, tuple[int, ...]]  # Numbers of these rules for every A that has some
    rules: frozenset[int]

    def places(self, shape: TreeShape, growing: bool) -> list[int]:
        """Return the nodes above which a link can be put, or those that are links."""
        if growing:
            return [node for node, symbol in enumerate(shape.symbols) if symbol in self.links]
        return [node for node, rule in enumerate(shape.rules) if rule in self.rules]

    def grown(
        self, shape: TreeShape, node: int, most: int, rng: np.random.Generator
    ) -> Linked | None:
        """Return a tree with a random link of at most ``most`` actions above a node, or None."""
        numbers = self.links[shape.symbols[node]]
        rules = self.derivations.grammar.rules
        weights = np.cumsum([rules[number].probability for number in numbers])
        at = int(np.searchsorted(weights, rng.random() * weights[-1], "right"))
        rule = numbers[min(at, len(numbers) - 1)]
        first = int(shape.spans[node, 1])
        since, ends = self._around(shape, first, first)
        if self._fits(rule, since, ends) <= 0.0:
            return None
        link = self.derivations.draw(rules[rule].right[0], since, ends, rng, most)
        if link is None:
            return None
        spelled = (*shape.rules[:node], rule, *link.rules, *shape.rules[node:])
        log_q = self._log_probability(rule, link.rules, since, ends)
        return Linked(spelled, (first, first), link.actions, -log_q)

    def shrunk(self, shape: TreeShape, node: int) -> Linked | None:
        """Return a tree without the link at a node; None if the rest does not fit."""
        rule, below = shape.rules[node], node + 1
        grammar = self.derivations.grammar
        if grammar.is_nonterminal(grammar.rules[rule].right[0]):
            below = int(shape.spans[node + 1, 0])
        first, last = int(shape.spans[node, 1]), int(shape.spans[below, 1])
        since, ends = self._around(shape, first, last)
        if since not in ends or len(shape.actions) == last - first:
            return None
        log_q = self._log_probability(rule, shape.rules[node + 1 : below], since, ends)
        spelled = (*shape.rules[:node], *shape.rules[below:])
        return Linked(spelled, (first, last), (), log_q)

    def _around(self, shape: TreeShape, first: int, last: int) -> tuple[int, list[int]]:
        """Return the state before a span, and those after it from which the rest fits."""
        since = self.derivations.run(shape.actions[:first])[-1]
        return since, self.derivations.ends_before(shape.actions[last:])

    def _fits(self, rule: int, since: int, ends: Sequence[int]) -> float:
        link = self.derivations.grammar.rules[rule].right[0]
        return float(self.derivations.inside(link)[since, ends].sum())

    def _log_probability(
        self, rule: int, link: Sequence[int], since: int, ends: Sequence[int]
    ) -> float:
        rules = self.derivations.grammar.rules
        whole = sum(rules[number].probability for number in self.links[rules[rule].left])
        whole *= self._fits(rule, since, ends)
        return self.derivations.log_probability([rule, *link]) - math.log(whole)


def chains(derivations: Derivations) -> Chains:
    r"""Return the rules A -> B A of a grammar with B another symbol and a probability above 0.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> from motiondb.scene.sampling.tree_growth import tree_shape
    >>> grammar = read_grammar("A -> B A | B\nB -> b")
    >>> found = chains(Derivations(grammar, []))
    >>> shape = tree_shape(grammar, [0, 2, 1, 2])
    >>> found.places(shape, True), found.places(shape, False), found.shrunk(shape, 0).rules
    ([0, 2], [0], (1, 2))
    """
    links: dict[str, tuple[int, ...]] = {}
    for number, rule in enumerate(derivations.grammar.rules):
        linked = len(rule.right) == 2 and rule.right[1] == rule.left != rule.right[0]
        if linked and rule.probability > 0.0:
            links[rule.left] = (*links.get(rule.left, ()), number)
    return Chains(derivations, links, frozenset(n for link in links.values() for n in link))


def places(
    known: Sequence[Chains], shapes: Sequence[TreeShape], growing: bool
) -> list[tuple[int, int]]:
    """Return the players and nodes where a link can be inserted or removed."""
    return [
        (player, node)
        for player, (one, shape) in enumerate(zip(known, shapes, strict=True))
        for node in one.places(shape, growing)
    ]
