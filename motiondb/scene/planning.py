"""The shortest string of a grammar that begins as given and goes through given goals, in order.

The goals c_1 ... c_g are sets of terminals; a string passes them where it has members of them as a
subsequence. An automaton counts: its state is how much of the prefix, then how many goals are
behind. For every symbol A, cost[A][i, j] is the length of the shortest string derived from A that
leads from state i to state j: a product of matrices over the right side of a rule, with sums for
products and minima for sums, least over the rules of A, until nothing falls any more. Costs are
whole numbers, lengths in the high digits and rules in the low ones, so that a derivation is always
dearer than its parts, and reading the tree back cannot go round in circles.

:mod:`motiondb.grammar.plan` goes to one goal, the most probable way; here there are many, and each
may be met by several terminals. For an empty prefix and the expression of a player in a diagram
this gives a string of g_user = 0 where the grammar has one, without sampling.

Source: the intersection of a context-free language with a regular one, Y. Bar-Hillel, M. Perles and
E. Shamir (1961); shortest derivations, D. E. Knuth, "A Generalization of Dijkstra's Algorithm",
Information Processing Letters 6 (1977).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from motiondb.errors import SceneError
from motiondb.grammar.cfg import Grammar, Tree
from motiondb.records import IntArray

_TERMINAL, _RULE, _NEVER = 1 << 24, 1, 1 << 60


def plan(
    grammar: Grammar, prefix: Sequence[str] = (), goals: Sequence[Collection[str]] = ()
) -> Tree:
    """The derivation of a shortest string; never of the empty one.

    Parameters
    ----------
    prefix : what has been done already, terminals.
    goals : what is still to be done, in this order; each a terminal's name in a set of choices.

    Raises
    ------
    SceneError where the grammar has no such string; it says how far the goals can be met.

    >>> from motiondb.grammar.cfg import read_grammar
    >>> grammar = read_grammar("S -> a S | B\\nB -> b | b c")
    >>> plan(grammar, ["a"], [{"a"}, {"c"}]).leaves()
    ('a', 'a', 'b', 'c')
    """
    wanted = [frozenset(goal) for goal in goals]
    if not prefix and not wanted:
        wanted = [frozenset(grammar.terminals)]
    costs = _costs(grammar, prefix, wanted)
    last = len(prefix) + len(wanted)
    start = costs[grammar.start]
    if start[0, last] >= _NEVER:
        raise SceneError(_nowhere(grammar, prefix, wanted, start[0]))
    return _tree(grammar, costs, grammar.start, 0, last)


def _costs(
    grammar: Grammar, prefix: Sequence[str], goals: Sequence[frozenset[str]]
) -> dict[str, IntArray]:
    """For every symbol the matrix of least costs between states of the automaton."""
    n = len(prefix) + len(goals) + 1
    costs: dict[str, IntArray] = {}
    for terminal in grammar.terminals:
        matrix = np.full((n, n), _NEVER, dtype=np.int64)
        for i in range(n):
            goal = i - len(prefix)
            if goal < 0 and prefix[i] != terminal:
                continue
            moves_on = goal < 0 or (goal < len(goals) and terminal in goals[goal])
            matrix[i, i + moves_on] = _TERMINAL
        costs[terminal] = matrix
    for left in grammar.nonterminals:
        costs[left] = np.full((n, n), _NEVER, dtype=np.int64)
    nothing = np.where(np.eye(n, dtype=bool), 0, _NEVER)
    falling = True
    while falling:
        falling = False
        for rule in grammar.rules:
            total = nothing
            for symbol in rule.right:
                total = _product(total, costs[symbol])
            better = np.minimum(costs[rule.left], np.minimum(total + _RULE, _NEVER))
            falling |= bool((better < costs[rule.left]).any())
            costs[rule.left] = better
    return costs


def _product(first: IntArray, second: IntArray) -> IntArray:
    """The product of matrices over minimum and sum."""
    return np.minimum(np.min(first[..., :, :, None] + second[None, :, :], axis=-2), _NEVER)


def _tree(grammar: Grammar, costs: dict[str, IntArray], symbol: str, i: int, j: int) -> Tree:
    """The derivation whose cost is ``costs[symbol][i, j]``."""
    if not grammar.is_nonterminal(symbol):
        return Tree(symbol)
    for number in grammar.rules_of[symbol]:
        right = grammar.rules[number].right
        rows = [np.full(len(costs[symbol]), _NEVER, dtype=np.int64)]
        rows[0][i] = 0
        for part in right:
            rows.append(np.minimum(np.min(rows[-1][:, None] + costs[part], axis=0), _NEVER))
        if rows[-1][j] + _RULE != costs[symbol][i, j]:
            continue
        children: list[Tree] = []
        end = j
        for row, part in zip(rows[-2::-1], right[::-1], strict=True):
            begin = int(np.argmin(row + costs[part][:, end]))
            children.append(_tree(grammar, costs, part, begin, end))
            end = begin
        return Tree(symbol, number, tuple(children[::-1]))
    raise AssertionError("a cost without a rule")


def _nowhere(
    grammar: Grammar, prefix: Sequence[str], goals: Sequence[frozenset[str]], reached: IntArray
) -> str:
    """Why there is no plan: the prefix, or the first goal that cannot be met behind the others."""
    ends = [state - len(prefix) for state in np.flatnonzero(reached < _NEVER).tolist()]
    met = max((goal for goal in ends if goal >= 0), default=-1)
    begun = f" that begins with '{' '.join(prefix)}'" if prefix else ""
    through = ", then ".join(" or ".join(sorted(goal)) for goal in goals)
    if met < 0:
        limit = "no string of the grammar begins so" if prefix else "the grammar has no string"
    else:
        limit = f"{' or '.join(sorted(goals[met]))} cannot come {'then' if met else 'at all'}"
    return (
        f"grammar: expected a string from {grammar.start}{begun} with {through or 'nothing more'},"
        f" but {limit}. Leave it out, change the order, or add a rule that allows it."
    )
