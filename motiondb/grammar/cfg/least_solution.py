"""Least solutions of a grammar's own equations: how likely a symbol ends, or becomes empty.

For the numbered form of a grammar, x(A) = sum p(A -> Y) x(Y) over its rules and x(Y Z) = x(Y) x(Z)
for a tail; the least solution is wanted. It is found in each strongly connected component of the
symbols, parts first, by Newton's method from 0, which rises to it (K. Etessami and M. Yannakakis,
"Recursive Markov Chains", Journal of the ACM 56, 2009).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from motiondb.grammar.cfg.closure import strong_components
from motiondb.records import FloatArray, IntArray

if TYPE_CHECKING:
    from motiondb.grammar.cfg.compiled import CompiledGrammar


def sparse_graph(
    n: int, sources: IntArray, targets: IntArray, weights: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Edges sorted by source: where each node's begin (n + 1,), their targets, their weights."""
    order = np.argsort(sources, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(sources, minlength=n))))
    return starts.astype(np.int64), targets[order], weights[order]


def grow(compiled: CompiledGrammar, seed: np.ndarray, *, all_parts: bool) -> np.ndarray:
    """Least set of symbols with a part (or all parts) of a right side in it; empty has all."""
    found, tails = seed.copy(), np.flatnonzero(compiled.left >= 0)
    rule_left, rule_right = compiled.rule_left, compiled.rule_right
    while True:
        new = found.copy()
        a, b = new[compiled.left[tails]], new[compiled.right[tails]]
        new[tails] |= (a & b) if all_parts else (a | b)
        new[rule_left[np.where(rule_right < 0, all_parts, new[rule_right])]] = True
        if np.array_equal(new, found):
            return found
        found = new


def _parts(compiled: CompiledGrammar, inside: np.ndarray) -> tuple[IntArray, IntArray]:
    """Graph from every symbol to its parts, within a set of symbols."""
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


def part_groups(compiled: CompiledGrammar, inside: np.ndarray) -> list[tuple[IntArray, bool]]:
    """Strong components of the parts, parts first, and whether each leads back to itself."""
    starts, targets = _parts(compiled, inside)
    label = strong_components(starts, targets)
    members = np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label))[:-1])
    sources = np.repeat(np.arange(compiled.n_symbols), np.diff(starts))
    cyclic = np.zeros(len(members), bool)
    cyclic[label[sources[label[sources] == label[targets]]]] = True
    return [(group, bool(c)) for group, c in zip(members, cyclic) if inside[group[0]]]


def _value(compiled: CompiledGrammar, symbol: int, x: FloatArray, weights: FloatArray) -> float:
    if compiled.left[symbol] >= 0:
        parts = x[compiled.left[symbol]], x[compiled.right[symbol]]
        return 0.0 if 0.0 in parts else float(parts[0] * parts[1])
    rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
    right = compiled.rule_right[rules]
    return float(weights[rules] @ np.where(right < 0, 1.0, x[right]))


def least_solution(
    compiled: CompiledGrammar, terminal_value: float, inside: np.ndarray
) -> FloatArray:
    """Least solution (S,) of x over the symbols ``inside`` (S,), 0 at the others.

    With ``terminal_value`` 1 the probability that a symbol ends, with 0 that it becomes empty.
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
    """Least solution of a component in place; exactly 1 where it is 1 (also where critical)."""
    identity = np.eye(len(group))
    x[group] = 1.0
    value, slope = _value_and_slope(compiled, group, x)
    if np.abs(value - 1.0).max() < 1e-12 and np.abs(np.linalg.eigvals(slope)).max() <= 1 + 1e-9:
        return
    x[group] = 0.0
    for _ in range(200):
        value, slope = _value_and_slope(compiled, group, x)
        step = np.linalg.solve(identity - slope, value - x[group])
        x[group] = np.clip(x[group] + step, 0.0, 1.0)
        if np.abs(step).max() < 1e-15:
            return


def _value_and_slope(
    compiled: CompiledGrammar, group: IntArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    value, slope = np.zeros(len(group)), np.zeros((len(group), compiled.n_symbols))
    for row, symbol in enumerate(group):
        value[row] = _value(compiled, symbol, x, compiled.probabilities)
        a, b = compiled.left[symbol], compiled.right[symbol]
        if a >= 0:
            slope[row, a] += x[b]
            slope[row, b] += x[a]
            continue
        rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
        right, chance = compiled.rule_right[rules], compiled.probabilities[rules]
        np.add.at(slope[row], right[right >= 0], chance[right >= 0])
    return value, slope[:, group]


def count_empties(compiled: CompiledGrammar) -> FloatArray:
    """Number (S,) of trees by which each symbol becomes empty, infinite through a cycle."""
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


def best_empties(compiled: CompiledGrammar, weights: FloatArray) -> FloatArray:
    """Greatest weight (S,) of a tree by which each symbol becomes empty; weights (R,) below 1."""
    right, tails = compiled.rule_right, compiled.left >= 0
    found = np.zeros(compiled.n_symbols)
    while True:
        new = found.copy()
        terms = weights * np.where(right < 0, 1.0, found[right])
        np.maximum.at(new, compiled.rule_left, terms)
        new[tails] = found[compiled.left[tails]] * found[compiled.right[tails]]
        if np.array_equal(new, found):
            return found
        found = new
