"""Automata with blocks of several states, such as that of the pattern ``... a b ...``.

States of a block lead to one another, so each pair of blocks one of which has several states has a
system of equations in W(X, s, t) (:mod:`.inside`). It is iterated, parts first, from 0 to its least
solution. Cells between two states alone in their blocks are filled as in other automata.
"""

from __future__ import annotations

from math import ldexp

import numpy as np

from motiondb.grammar.cfg.automata import Automaton
from motiondb.grammar.cfg.inside import (
    MOST_ENTRIES,
    MOST_PRODUCTS,
    Closures,
    Inside,
    Rules,
    Work,
    add_splits,
    empty_cells,
    empty_row,
    fill_row,
    find,
    grown,
    store,
)
from motiondb.grammar.kernels import kernel, maker
from motiondb.records import FloatArray

_CLOSE = 1e-13  # Relative change of a weight below which an iteration has converged
_MOST_ROUNDS = 100_000
"""Largest number of iterations. Chosen by hand: a loop that continues with probability 0.999
needs 30,000."""


@maker
def fill_blocks(
    best: bool, auto: Automaton, rules: Rules, closures: Closures, shift: bool
) -> tuple[Inside, bool]:
    """Fill all cells of an automaton; also return whether they are complete, or grew too large."""
    made, work = empty_cells(auto, rules, closures.staying, shift)
    bounds, loops = auto.bounds, auto.loops
    n_blocks, used, n_products = len(bounds) - 1, 0, 0
    for b in range(n_blocks - 1, -1, -1):
        i = bounds[b]
        alone = loops[i] >= 0
        for c in range(b + alone, n_blocks):
            j = bounds[c]
            if alone and loops[j] >= 0:
                made, used, more = fill_row(
                    best, (i, j, j + 1), auto, rules, closures, made, used, work
                )
                n_products += more
            else:
                made, used = _fill_pair(best, (b, c), auto, rules, made, used, work)
                add_splits(made, i, (j, bounds[c + 1]), work)
            if n_products > MOST_PRODUCTS or used > MOST_ENTRIES:
                return made, False
        if alone:
            empty_row(made, i, work)
        else:
            work.row[:], work.n_splits[:] = 0.0, 0
    return made, True


@maker
def _fill_pair(
    best: bool,
    blocks: tuple[int, int],
    auto: Automaton,
    rules: Rules,
    made: Inside,
    used: int,
    work: Work,
) -> tuple[Inside, int]:
    """Fill the cells between two blocks; return the number of entries so far."""
    weights, (b, c) = _solve_pair(best, blocks, auto, rules, made), blocks
    for s in range(auto.bounds[b], auto.bounds[b + 1]):
        for t in range(auto.bounds[c], auto.bounds[c + 1]):
            n_reached = _take(weights[:, s - auto.bounds[b], t - auto.bounds[c]], work)
            made = grown(made, used + n_reached)
            used = store(made, (s, t), used, work, n_reached, 0)
    return made, used


@kernel
def _take(values: FloatArray, work: Work) -> int:
    """Copy values (S,) to ``full``; return the number of symbols that have one."""
    n_reached = 0
    for symbol in range(len(values)):
        if values[symbol] > 0.0:
            work.full[symbol] = values[symbol]
            work.reached[n_reached] = symbol
            n_reached += 1
    return n_reached


@maker
def _solve_pair(
    best: bool, blocks: tuple[int, int], auto: Automaton, rules: Rules, made: Inside
) -> FloatArray:
    """Return the weights (S, s, t) between two blocks, by iteration from 0, parts first."""
    (b, c), bounds, parts, n_symbols = blocks, auto.bounds, rules.parts, len(rules.left)
    span = bounds[b], bounds[b + 1], bounds[c], bounds[c + 1]
    weights = np.zeros((n_symbols, span[1] - span[0], span[3] - span[2]))
    given, new = np.zeros_like(weights), np.zeros(weights.shape[1:])
    _put_edges(auto, span, rules.first, weights)
    for symbol in range(n_symbols):
        _add_between(best, symbol, span, rules, made, given[symbol])
    near = _within(made, n_symbols, span[0], span[1]) if b < c else weights
    far = _within(made, n_symbols, span[2], span[3]) if b < c else weights
    for g in range(len(parts.cyclic)):
        members = parts.members[parts.bounds[g] : parts.bounds[g + 1]]
        for _ in range(_MOST_ROUNDS):
            changed = False
            for symbol in members:
                if rules.left[symbol] >= 0:
                    new[:] = given[symbol]
                    _add_product(best, new, near[rules.left[symbol]], weights[rules.right[symbol]])
                    if b < c:
                        _add_product(
                            best, new, weights[rules.left[symbol]], far[rules.right[symbol]]
                        )
                else:
                    _add_rules(best, new, symbol, rules, weights, b == c)
                changed = _raise(weights[symbol], new) or changed
            if not changed or not parts.cyclic[g]:
                break
    return weights


@kernel
def _put_edges(
    auto: Automaton, span: tuple[int, int, int, int], first: int, weights: FloatArray
) -> None:
    """Write the weights of the edges between two blocks into ``weights`` (S, s, t)."""
    for s in range(span[0], span[1]):
        for e in range(auto.starts[s], auto.starts[s + 1]):
            if span[2] <= auto.targets[e] < span[3]:
                symbol = first + auto.terminals[e]
                weights[symbol, s - span[0], auto.targets[e] - span[2]] = auto.weights[e]


@kernel
def _raise(weights: FloatArray, new: FloatArray) -> bool:
    """Raise weights to new ones; return whether one rose by more than rounding."""
    changed = False
    for s in range(new.shape[0]):
        for t in range(new.shape[1]):
            if new[s, t] > weights[s, t]:
                changed = changed or new[s, t] - weights[s, t] > _CLOSE * new[s, t]
                weights[s, t] = new[s, t]
    return changed


@maker
def _within(made: Inside, n_symbols: int, first: int, last: int) -> FloatArray:
    """Return the weights (S, s, t) from the states of a block to each other."""
    weights = np.zeros((n_symbols, last - first, last - first))
    for symbol in range(n_symbols):
        for s in range(first, last):
            for t in range(first, last):
                value, exponent = find(made, symbol, s, t)
                weights[symbol, s - first, t - first] = ldexp(value, exponent)
    return weights


@kernel
def _add_between(
    best: bool,
    tail: int,
    span: tuple[int, int, int, int],
    rules: Rules,
    made: Inside,
    new: FloatArray,
) -> None:
    """Add what a tail derives by way of the states strictly between two blocks."""
    if rules.left[tail] < 0:
        return
    for s in range(span[0], span[1]):
        for u in range(span[1], span[2]):
            first, up = find(made, rules.left[tail], s, u)
            if first == 0.0:
                continue
            for t in range(span[2], span[3]):
                second, more = find(made, rules.right[tail], u, t)
                value, place = ldexp(first * second, up + more), (s - span[0], t - span[2])
                new[place] = max(new[place], value) if best else new[place] + value


@kernel
def _add_product(best: bool, new: FloatArray, first: FloatArray, second: FloatArray) -> None:
    """Add the product of two matrices, or take the greater of both."""
    for s in range(first.shape[0]):
        for u in range(first.shape[1]):
            if first[s, u] > 0.0:
                for t in range(second.shape[1]):
                    value = first[s, u] * second[u, t]
                    new[s, t] = max(new[s, t], value) if best else new[s, t] + value


@kernel
def _add_rules(
    best: bool, new: FloatArray, symbol: int, rules: Rules, weights: FloatArray, same: bool
) -> None:
    """Fill ``new`` (s, t) with what the rules of a nonterminal derive."""
    new[:] = 0.0
    for r in range(rules.rule_of[symbol], rules.rule_of[symbol + 1]):
        below = rules.rule_right[r]
        for s in range(new.shape[0]):
            for t in range(new.shape[1]):
                value = 0.0
                if below >= 0:
                    value = rules.weights[r] * weights[below, s, t]
                elif same and s == t:
                    value = rules.weights[r]
                new[s, t] = max(new[s, t], value) if best else new[s, t] + value
