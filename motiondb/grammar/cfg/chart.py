"""The chart of a sentence: for each stretch i..j, the symbols that derive it and how strongly.

A chart cell (i, j) lists its symbols in ascending order with their values; a value is a
floating-point number times a power of two that the whole cell shares, so that long sentences do
not run under. Cells are filled from the right: a tail (Y Z) over (i, j) takes Y from a dense row
of cells that begin at i, and Z from the list of (k, j) (Cocke, Younger and Kasami, on sparse
cells). What a cell then derives without reading more comes from the chains of the compiled
grammar, so that unit cycles and empty rules cost nothing here.

``sum_chart`` adds the values of derivations (probabilities, or their number), ``best_chart`` keeps
the greatest. ``best_choices`` reads the best tree out of a chart; see also forward.py.
"""

from __future__ import annotations

from math import frexp, inf, ldexp, log

import numpy as np
from numba import njit

TOLERANCE = 2.5e-10  # two log-probabilities this near count as equal; under the rule penalty


@njit(cache=True)
def fill_chart(best, sentence, by_right, left, chains):  # type: ignore[no-untyped-def]
    """Chart of a sentence.

    Parameters
    ----------
    best : whether derivations compete (max) instead of adding up.
    sentence : array (n,), symbol numbers.
    by_right : (starts (S + 1,), tails), the tails by their right child.
    left : array (S,), the left child of a tail.
    chains : (starts (S + 1,), symbols, weights), for each symbol what leads to it unread.

    Returns
    -------
    begin, end (n + 1, n + 1) into symbols and values (entries,); exponents (n + 1, n + 1).
    """
    n, n_symbols = len(sentence), len(left)
    begin = np.zeros((n + 1, n + 1), np.int64)
    end, exponents = np.zeros((n + 1, n + 1), np.int64), np.zeros((n + 1, n + 1), np.int64)
    symbols, values, used = np.zeros(256, np.int64), np.zeros(256), 0
    row, splits = np.zeros((n + 1, n_symbols)), np.zeros(n + 1, np.int64)
    base, full = np.zeros(n_symbols), np.zeros(n_symbols)
    touched, reached = np.zeros(n_symbols, np.int64), np.zeros(n_symbols, np.int64)
    for i in range(n - 1, -1, -1):
        n_splits = 0
        for j in range(i + 1, n + 1):
            n_touched = 0
            if j == i + 1:
                base[sentence[i]], touched[0], n_touched = 1.0, sentence[i], 1
            top = _top_exponent(begin, end, exponents, splits[:n_splits], i, j)
            for s in range(n_splits):
                k = splits[s]
                factor = ldexp(1.0, exponents[i, k] + exponents[k, j] - top)
                cell = symbols[begin[k, j] : end[k, j]], values[begin[k, j] : end[k, j]]
                n_touched = _combine(
                    best, row[k], cell, factor, by_right, left, (base, touched, n_touched)
                )
            n_reached = _climb(best, touched[:n_touched], base, chains, full, reached)
            if used + n_reached > len(symbols):
                more = max(n_reached, len(symbols))
                symbols = np.append(symbols, np.zeros(more, np.int64))
                values = np.append(values, np.zeros(more))
            shift = _shift(full, reached, n_reached)
            begin[i, j], exponents[i, j] = used, top + shift
            _sort(reached[:n_reached])
            for r in range(n_reached):
                value = ldexp(full[reached[r]], -shift)
                symbols[used], values[used], row[j, reached[r]] = reached[r], value, value
                full[reached[r]] = 0.0
                used += 1
            end[i, j] = used
            if n_reached > 0:
                splits[n_splits] = j
                n_splits += 1
        for j in range(i + 1, n + 1):
            for entry in range(begin[i, j], end[i, j]):
                row[j, symbols[entry]] = 0.0
    return begin, end, exponents, symbols[:used], values[:used]


@njit(cache=True)
def _combine(best, firsts, cell, factor, by_right, left, work):  # type: ignore[no-untyped-def]
    """Add the tails made of what ends at a place and the cell that begins there to ``base``."""
    starts, tails = by_right
    symbols, values = cell
    base, touched, n_touched = work
    for entry in range(len(symbols)):
        for t in range(starts[symbols[entry]], starts[symbols[entry] + 1]):
            tail = tails[t]
            first = firsts[left[tail]]
            if first == 0.0:  # not there; an endless count times 0 would be no number
                continue
            value = first * values[entry] * factor
            if value == 0.0:
                continue
            if base[tail] == 0.0:
                touched[n_touched] = tail
                n_touched += 1
            base[tail] = max(base[tail], value) if best else base[tail] + value
    return n_touched


@njit(cache=True)
def _climb(best, touched, base, chains, full, reached):  # type: ignore[no-untyped-def]
    """Follow the chains up from ``base`` (emptied) to ``full``; returns how many are reached."""
    starts, symbols, weights = chains
    n_reached = 0
    for t in range(len(touched)):
        symbol = touched[t]
        for c in range(starts[symbol], starts[symbol + 1]):
            above, value = symbols[c], weights[c] * base[symbol]
            if value == 0.0:
                continue
            if full[above] == 0.0:
                reached[n_reached] = above
                n_reached += 1
            full[above] = max(full[above], value) if best else full[above] + value
        base[symbol] = 0.0
    return n_reached


@njit(cache=True)
def _sort(numbers):  # type: ignore[no-untyped-def]
    """Shell's sort in place: quicker to compile than a general one, and cells are small."""
    gap = len(numbers) // 2
    while gap > 0:
        for i in range(gap, len(numbers)):
            number, j = numbers[i], i
            while j >= gap and numbers[j - gap] > number:
                numbers[j] = numbers[j - gap]
                j -= gap
            numbers[j] = number
        gap //= 2


@njit(cache=True)
def _top_exponent(begin, end, exponents, splits, i, j):  # type: ignore[no-untyped-def]
    top, found = 0, False
    for k in splits:
        if begin[k, j] < end[k, j]:
            here = exponents[i, k] + exponents[k, j]
            if not found or here > top:
                top, found = here, True
    return top


@njit(cache=True)
def _shift(full, reached, n_reached):  # type: ignore[no-untyped-def]
    greatest = 0.0
    for r in range(n_reached):
        value = full[reached[r]]
        if value > greatest and value < inf:
            greatest = value
    return frexp(greatest)[1] if greatest > 0.0 else 0


@njit(cache=True)
def place_of(symbols, symbol, low, high):  # type: ignore[no-untyped-def]
    """The first place from ``low`` to ``high`` with no smaller symbol (binary search)."""
    while low < high:
        middle = (low + high) // 2
        if symbols[middle] < symbol:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True)
def find(chart, symbol, i, j):  # type: ignore[no-untyped-def]
    """Value and exponent of a symbol over (i, j), i < j; value 0 where it is not there."""
    begin, end, exponents, symbols, values = chart
    low = place_of(symbols, symbol, begin[i, j], end[i, j])
    if low < end[i, j] and symbols[low] == symbol:
        return values[low], exponents[i, j]
    return 0.0, 0


@njit(cache=True)
def _log_best(chart, empties, symbol, i, j):  # type: ignore[no-untyped-def]
    if i == j:
        return log(empties[symbol]) if empties[symbol] > 0.0 else -inf
    value, exponent = find(chart, symbol, i, j)
    return log(value) + exponent * log(2.0) if value > 0.0 else -inf


@njit(cache=True)
def best_choices(chart, empties, forms, start, n):  # type: ignore[no-untyped-def]
    """Rules of the best tree in preorder, as indices among the rules in use.

    Parameters
    ----------
    chart, empties : the best chart, and (S,) the best values of the empty string.
    forms : (left, right, rule_of, rule_right, log weights) of the compiled grammar.
    start, n : the symbol to begin with and the sentence's length.
    """
    left, right, rule_of, rule_right, _ = forms
    choices, used = np.zeros(64, np.int64), 0
    nodes, begins, ends = np.zeros(64, np.int64), np.zeros(64, np.int64), np.zeros(64, np.int64)
    depth = 1
    nodes[0], ends[0] = start, n
    while depth > 0:
        depth -= 1
        symbol, i, j = nodes[depth], begins[depth], ends[depth]
        if depth + 2 > len(nodes):
            nodes = np.append(nodes, np.zeros_like(nodes))
            begins = np.append(begins, np.zeros_like(begins))
            ends = np.append(ends, np.zeros_like(ends))
        if used == len(choices):
            choices = np.append(choices, np.zeros_like(choices))
        goal = _log_best(chart, empties, symbol, i, j) - TOLERANCE
        if left[symbol] >= 0:
            k = i
            while k < j and (
                _log_best(chart, empties, left[symbol], i, k)
                + _log_best(chart, empties, right[symbol], k, j)
                < goal
            ):
                k += 1
            nodes[depth], begins[depth], ends[depth] = right[symbol], k, j
            nodes[depth + 1], begins[depth + 1], ends[depth + 1] = left[symbol], i, k
            depth += 2
        elif rule_of[symbol] < rule_of[symbol + 1]:
            choices[used] = _first_rule(chart, empties, forms, symbol, (i, j), goal)
            nodes[depth], begins[depth], ends[depth] = rule_right[choices[used]], i, j
            if nodes[depth] >= 0:
                depth += 1
            used += 1
    return choices[:used]


@njit(cache=True)
def _first_rule(chart, empties, forms, symbol, span, goal):  # type: ignore[no-untyped-def]
    """The first rule of a symbol that reaches the goal over a span."""
    _, _, rule_of, rule_right, log_weights = forms
    i, j = span
    for rule in range(rule_of[symbol], rule_of[symbol + 1] - 1):
        below, value = rule_right[rule], log_weights[rule]
        if below >= 0:
            value += _log_best(chart, empties, below, i, j)
        elif i < j:
            continue
        if value >= goal:
            return rule
    return rule_of[symbol + 1] - 1
