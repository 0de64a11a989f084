"""Least solutions of the equations of a grammar: the probability that a symbol ends, or is empty.

For the numbered form of a grammar, x(A) = sum p(A -> Y) x(Y) over its rules and x(Y Z) = x(Y) x(Z)
for a tail; the least solution is wanted. It is found in each strongly connected component of the
symbols, parts first, by Newton's method from 0, which rises to it (K. Etessami and M. Yannakakis,
"Recursive Markov Chains", Journal of the ACM 56, 2009).
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

import numpy as np

from motiondb.grammar.cfg.closure import Sparse, strong_components
from motiondb.records import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from motiondb.grammar.cfg.compiled import CompiledGrammar


_MOST_STEPS = 200  # Largest number of Newton steps; at a critical point each only halves the error


def sparse_graph(n: int, sources: IntArray, targets: IntArray, weights: FloatArray) -> Sparse:
    """Return edges as a graph, sorted by source."""
    order = np.argsort(sources, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(sources, minlength=n))))
    return Sparse(starts.astype(np.int64), targets[order], weights[order])


def grow(compiled: CompiledGrammar, seed: BoolArray, *, all_parts: bool) -> BoolArray:
    """Return the symbols (S,) that derive a string from the seed (S,), in linear time.

    Shapes: `seed` (S,).

    `all_parts`: Whether a tail needs both its children, and a rule may be empty; otherwise one
    child is enough, and an empty rule gives nothing.
    """
    reached, waiting = seed.copy(), np.flatnonzero(seed).tolist()
    if all_parts:
        waiting += compiled.rule_left[compiled.rule_right < 0].tolist()
        reached[waiting] = True
        waiting = np.flatnonzero(reached).tolist()
    above, starts = _users(compiled)
    while waiting:
        symbol = waiting.pop()
        for user in above[starts[symbol] : starts[symbol + 1]].tolist():
            left, right = compiled.left[user], compiled.right[user]
            if reached[user] or (
                all_parts and left >= 0 and not (reached[left] and reached[right])
            ):
                continue
            reached[user] = True
            waiting.append(user)
    return reached


def _users(compiled: CompiledGrammar) -> tuple[IntArray, IntArray]:
    """List the left sides and tails that contain each symbol, and the index of each list."""
    tails, real = np.flatnonzero(compiled.left >= 0), compiled.rule_right >= 0
    parts = np.concatenate((compiled.rule_right[real], compiled.left[tails], compiled.right[tails]))
    users = np.concatenate((compiled.rule_left[real], tails, tails))
    order = np.argsort(parts, kind="stable")
    return users[order], np.searchsorted(parts[order], np.arange(compiled.n_symbols + 1))


def _parts(compiled: CompiledGrammar, inside: BoolArray) -> tuple[IntArray, IntArray]:
    """Return the graph from every symbol to its parts, within a set of symbols."""
    tails = np.flatnonzero(compiled.left >= 0)
    real = compiled.rule_right >= 0
    sources = np.concatenate((compiled.rule_left[real], tails, tails))
    targets = np.concatenate(
        (compiled.rule_right[real], compiled.left[tails], compiled.right[tails])
    )
    keep = inside[sources] & inside[targets]
    sources, targets = sources[keep], targets[keep]
    starts, targets, _ = sparse_graph(compiled.n_symbols, sources, targets, np.ones(len(sources)))
    return starts, targets


def part_groups(compiled: CompiledGrammar, inside: BoolArray) -> list[tuple[IntArray, bool]]:
    """Return the strong components of the parts, parts first, and whether each has a cycle."""
    starts, targets = _parts(compiled, inside)
    label = strong_components(starts, targets)
    members = np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label))[:-1])
    sources = np.repeat(np.arange(compiled.n_symbols), np.diff(starts))
    cyclic = np.zeros(len(members), bool)
    cyclic[label[sources[label[sources] == label[targets]]]] = True
    return [(group, bool(c)) for group, c in zip(members, cyclic) if inside[group[0]]]


def _value(compiled: CompiledGrammar, symbol: int, x: FloatArray, weights: FloatArray) -> float:
    """Return the right side of the equation of a symbol."""
    if compiled.left[symbol] >= 0:
        parts = x[compiled.left[symbol]], x[compiled.right[symbol]]
        return 0.0 if 0.0 in parts else float(parts[0] * parts[1])
    rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
    right = compiled.rule_right[rules]
    return float(weights[rules] @ np.where(right < 0, 1.0, x[right]))


def least_solution(
    compiled: CompiledGrammar, terminal_value: float | FloatArray, inside: BoolArray
) -> FloatArray:
    """Return the least solution x (S,) over the symbols ``inside`` (S,), 0 at the others.

    Shapes: `terminal_value` (terminals,); `inside` (S,).
    """
    x = np.zeros(compiled.n_symbols)
    x[compiled.terminals] = terminal_value
    for group, cyclic in part_groups(compiled, inside):
        if cyclic:
            _newton(compiled, group, x)
        elif not compiled.n_nonterminals <= group[0] < len(compiled.names):
            x[group[0]] = _value(compiled, group[0], x, compiled.probabilities)
    return x


def _newton(compiled: CompiledGrammar, group: IntArray, x: FloatArray) -> None:
    """Find the least solution of a component in place.

    The unknowns are the nonterminals only: a right side X Y Z has the value x(X) x(Y) x(Z), so that
    many alternatives do not make the system larger. The solution is exactly 1 where it is 1, also
    at the critical point.
    """
    unknown = group[group < compiled.n_nonterminals]
    system = _make_system(compiled, unknown)
    identity = np.eye(len(unknown))
    x[unknown] = 1.0
    value, slope = _value_and_slope(system, x)
    certain = np.abs(value - 1.0).max() < 1e-12
    if not (certain and np.abs(np.linalg.eigvals(slope)).max() <= 1 + 1e-9):
        x[unknown] = 0.0
        for _ in range(_MOST_STEPS):
            value, slope = _value_and_slope(system, x)
            step = np.linalg.solve(identity - slope, value - x[unknown])
            x[unknown] = np.clip(x[unknown] + step, 0.0, 1.0)
            if np.abs(step).max() < 1e-15:
                break
    for tail in np.sort(group[compiled.left[group] >= 0]):  # parts have lower numbers
        x[tail] = x[compiled.left[tail]] * x[compiled.right[tail]]


@dataclass(frozen=True, eq=False)
class _System:
    """The equations of some nonterminals, a row for each of their rules."""

    unknown: IntArray  # (n,): the nonterminals, symbols
    lefts: IntArray  # (rules,): number of the left side among the unknown
    rights: IntArray  # (rules, longest right side): symbols of the right side, -1 beyond its end
    # (rules, longest right side): number of each of these symbols among the unknown, -1 for others
    columns: IntArray
    probabilities: FloatArray  # (rules,): p


def _make_system(compiled: CompiledGrammar, unknown: IntArray) -> _System:
    rules = np.flatnonzero(np.isin(compiled.rule_left, unknown))
    rights: list[list[int]] = []
    for symbol in compiled.rule_right[rules].tolist():
        right: list[int] = []
        while symbol >= 0 and compiled.left[symbol] >= 0:
            right.append(int(compiled.left[symbol]))
            symbol = int(compiled.right[symbol])
        rights.append([*right, symbol] if symbol >= 0 else right)
    padded = np.full((len(rights), max(map(len, rights), default=0)), -1)
    for row, right in zip(padded, rights, strict=True):
        row[: len(right)] = right
    number = np.full(compiled.n_symbols + 1, -1)
    number[unknown] = np.arange(len(unknown))
    lefts = number[compiled.rule_left[rules]]
    return _System(unknown, lefts, padded, number[padded], compiled.probabilities[rules])


def _value_and_slope(system: _System, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the right sides of the equations (n,), and their derivatives (n, n)."""
    n = len(system.unknown)
    factors = np.where(system.rights < 0, 1.0, x[system.rights])
    products = factors.prod(axis=1)
    value = np.zeros(n)
    np.add.at(value, system.lefts, system.probabilities * products)
    slope = np.zeros((n, n))
    for k in range(factors.shape[1]):
        rows = np.flatnonzero(system.columns[:, k] >= 0)
        others = np.delete(factors[rows], k, axis=1).prod(axis=1)
        cells = system.lefts[rows], system.columns[rows, k]
        np.add.at(slope, cells, system.probabilities[rows] * others)
    return value, slope


def count_empties(compiled: CompiledGrammar) -> FloatArray:
    """Return the number (S,) of trees by which each symbol becomes empty, perhaps infinite."""
    x = np.zeros(compiled.n_symbols)
    for group, cyclic in part_groups(compiled, compiled.nullable):
        for symbol in group:
            rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
            right = compiled.rule_right[rules]
            if cyclic:
                x[symbol] = np.inf
            elif compiled.left[symbol] >= 0:
                x[symbol] = x[compiled.left[symbol]] * x[compiled.right[symbol]]
            else:
                x[symbol] = np.where(right < 0, 1.0, x[right]).sum()
    return x


def best_solution(
    compiled: CompiledGrammar, weights: FloatArray, terminals: FloatArray
) -> FloatArray:
    """Return the greatest weight (S,) of a tree of each symbol over terminals with weights.

    The symbols are settled in descending order of their weights, since no tree weighs more than
    its parts (D. Knuth, "A Generalization of Dijkstra's Algorithm", Information Processing Letters
    6, 1977). Weights (R,) and (terminals,) of at most 1.
    """
    best = np.zeros(compiled.n_symbols)
    above, starts = _users(compiled)
    by_right: dict[tuple[int, int], float] = {}
    for left, right, weight in zip(
        compiled.rule_left.tolist(), compiled.rule_right.tolist(), weights.tolist(), strict=True
    ):
        by_right[left, right] = max(weight, by_right.get((left, right), 0.0))
    agenda = [(-weight, left) for (left, right), weight in by_right.items() if right < 0]
    agenda += [(-w, t) for t, w in enumerate(terminals.tolist(), compiled.terminals.start) if w]
    heapify(agenda)
    while agenda:
        value, symbol = heappop(agenda)
        if best[symbol] > 0.0 or value == 0.0:
            continue
        best[symbol] = -value
        for user in above[starts[symbol] : starts[symbol + 1]].tolist():
            if best[user] > 0.0:
                continue
            if compiled.left[user] >= 0:
                weight = best[compiled.left[user]] * best[compiled.right[user]]
            else:
                weight = by_right[user, symbol] * best[symbol]
            if weight > 0.0:
                heappush(agenda, (-weight, user))
    return best
