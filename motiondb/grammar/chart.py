"""The chart of a sentence: for each stretch i..j, the symbols that derive it and how strongly.

A chart cell (i, j) lists its symbols in ascending order with their values; a value is a
floating-point number times a power of two that the whole cell shares, so that long sentences do
not run under. Cells are filled from the right: a tail (Y Z) over (i, j) takes Y from a dense row
of cells that begin at i, and Z from the list of (k, j) (Cocke, Younger and Kasami, on sparse
cells). What a cell then derives without reading more comes from the chains of the compiled
grammar, so that unit cycles and empty rules cost nothing here.

``sum_chart`` adds the values of derivations (probabilities, or their number), ``best_chart`` keeps
the greatest. ``best_choices`` reads the best tree out of a chart, ``forward`` what may come next.
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
    starts, tails = by_right
    chain_starts, chain_symbols, chain_weights = chains
    n, n_symbols = len(sentence), len(left)
    begin = np.zeros((n + 1, n + 1), np.int64)
    end, exponents = np.zeros((n + 1, n + 1), np.int64), np.zeros((n + 1, n + 1), np.int64)
    symbols, values, used = np.zeros(256, np.int64), np.zeros(256), 0
    row = np.zeros((n + 1, n_symbols))
    base, full = np.zeros(n_symbols), np.zeros(n_symbols)
    touched, reached = np.zeros(n_symbols, np.int64), np.zeros(n_symbols, np.int64)
    splits = np.zeros(n + 1, np.int64)
    for i in range(n - 1, -1, -1):
        n_splits = 0
        for j in range(i + 1, n + 1):
            n_touched = n_reached = 0
            if j == i + 1:
                base[sentence[i]], touched[0], n_touched = 1.0, sentence[i], 1
            top = _top_exponent(begin, end, exponents, splits[:n_splits], i, j)
            for k in splits[:n_splits]:
                factor = ldexp(1.0, exponents[i, k] + exponents[k, j] - top)
                for entry in range(begin[k, j], end[k, j]):
                    symbol = symbols[entry]
                    for t in range(starts[symbol], starts[symbol + 1]):
                        tail = tails[t]
                        if row[k, left[tail]] == 0.0:
                            continue
                        value = row[k, left[tail]] * values[entry] * factor
                        if value == 0.0:
                            continue
                        if base[tail] == 0.0:
                            touched[n_touched] = tail
                            n_touched += 1
                        base[tail] = max(base[tail], value) if best else base[tail] + value
            for t in range(n_touched):
                symbol = touched[t]
                for c in range(chain_starts[symbol], chain_starts[symbol + 1]):
                    above, value = chain_symbols[c], chain_weights[c] * base[symbol]
                    if value == 0.0:
                        continue
                    if full[above] == 0.0:
                        reached[n_reached] = above
                        n_reached += 1
                    full[above] = max(full[above], value) if best else full[above] + value
                base[symbol] = 0.0
            while used + n_reached > len(symbols):
                symbols = np.concatenate((symbols, np.zeros_like(symbols)))
                values = np.concatenate((values, np.zeros_like(values)))
            shift = _shift(full, reached, n_reached)
            begin[i, j], exponents[i, j] = used, top + shift
            for symbol in np.sort(reached[:n_reached]):
                value = ldexp(full[symbol], -shift)
                symbols[used], values[used], row[j, symbol] = symbol, value, value
                full[symbol] = 0.0
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
def find(chart, symbol, i, j):  # type: ignore[no-untyped-def]
    """Value and exponent of a symbol over (i, j), i < j; value 0 where it is not there."""
    begin, end, exponents, symbols, values = chart
    low, high = begin[i, j], end[i, j]
    while low < high:
        middle = (low + high) // 2
        if symbols[middle] < symbol:
            low = middle + 1
        else:
            high = middle
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
    left, right, rule_of, rule_right, log_weights = forms
    choices, used = np.zeros(64, np.int64), 0
    stack, depth = np.zeros((64, 3), np.int64), 1
    stack[0, 0], stack[0, 2] = start, n
    while depth > 0:
        depth -= 1
        symbol, i, j = stack[depth]
        if depth + 2 > len(stack):
            stack = np.concatenate((stack, np.zeros_like(stack)))
        if used == len(choices):
            choices = np.concatenate((choices, np.zeros_like(choices)))
        goal = _log_best(chart, empties, symbol, i, j) - TOLERANCE
        if left[symbol] >= 0:
            k = i
            while k < j and (
                _log_best(chart, empties, left[symbol], i, k)
                + _log_best(chart, empties, right[symbol], k, j)
                < goal
            ):
                k += 1
            stack[depth, 0], stack[depth, 1], stack[depth, 2] = right[symbol], k, j
            stack[depth + 1, 0], stack[depth + 1, 1], stack[depth + 1, 2] = left[symbol], i, k
            depth += 2
        elif rule_of[symbol] < rule_of[symbol + 1]:
            rule = rule_of[symbol]
            while True:
                below = rule_right[rule]
                value = log_weights[rule]
                if below >= 0:
                    value += _log_best(chart, empties, below, i, j)
                elif i < j:
                    value = -inf
                if value >= goal or rule + 1 == rule_of[symbol + 1]:
                    break
                rule += 1
            choices[used] = rule
            used += 1
            if rule_right[rule] >= 0:
                stack[depth, 0], stack[depth, 1], stack[depth, 2] = rule_right[rule], i, j
                depth += 1
    return choices[:used]


@njit(cache=True)
def forward(chart, sentence, start, grammar):  # type: ignore[no-untyped-def]
    """What may stand at each place of a sentence, given all before it.

    Parameters
    ----------
    chart : the sum chart of the sentence.
    sentence, start : array (n,) and the start symbol.
    grammar : (by_left starts, by_left tails, right, left-corner closure as starts, symbols and
        weights by the symbol that begins).

    Returns
    -------
    weights (n + 1, S) and exponents (n + 1,): for a terminal t, ``weights[i, t]`` times two to the
    exponent is the probability that a string of the grammar begins with the first i symbols and t.
    """
    begin, end, exponents, symbols, values = chart
    starts, tails, right, corner_starts, corner_symbols, corner_weights = grammar
    n, n_symbols = len(sentence), len(right)
    asked, scale = np.zeros((n + 1, n_symbols)), np.zeros(n + 1, np.int64)
    seen, weights = np.zeros(n + 1, np.bool_), np.zeros((n + 1, n_symbols))
    asked[0, start] = 1.0
    for i in range(n + 1):
        greatest = asked[i].max()
        shift = frexp(greatest)[1] if greatest > 0.0 else 0
        scale[i] += shift
        for symbol in range(n_symbols):
            if asked[i, symbol] == 0.0:
                continue
            value = ldexp(asked[i, symbol], -shift)
            for c in range(corner_starts[symbol], corner_starts[symbol + 1]):
                weights[i, corner_symbols[c]] += value * corner_weights[c]
        for k in range(i + 1, n + 1):
            here = scale[i] + exponents[i, k]
            for entry in range(begin[i, k], end[i, k]):
                for t in range(starts[symbols[entry]], starts[symbols[entry] + 1]):
                    tail = tails[t]
                    if weights[i, tail] == 0.0:
                        continue
                    if not seen[k]:
                        seen[k], scale[k] = True, here
                    elif here > scale[k]:
                        asked[k] *= ldexp(1.0, scale[k] - here)
                        scale[k] = here
                    value = weights[i, tail] * values[entry]
                    asked[k, right[tail]] += value * ldexp(1.0, here - scale[k])
    return weights, scale
