"""The chart of a sentence: for each span i..j, the symbols that derive it and their values.

A cell (i, j) lists its symbols in ascending order with their values. A value is a floating-point
number times a power of two that the whole cell shares, so that long sentences do not underflow.
Cells are filled from the right: a tail (Y Z) over (i, j) takes Y from a dense row of cells that
begin at i, and Z from the list of (k, j) (Cocke, Younger and Kasami, on sparse cells). What a cell
derives without reading more symbols is taken from the chains of the compiled grammar, so unit
cycles and empty rules need no work here.

A chart sums the values of derivations (probabilities, or their number) or keeps the greatest.
The best tree is read from a chart of greatest values.

*Forward probabilities* are those of the next symbol at each position, given those before it. A
string that begins with the first i symbols and then X needs a symbol that is *predicted* at place
i and has X as a left corner. The start symbol is predicted at 0. If a tail (Y Z) is a left corner
at i of a predicted symbol, and Y derives the symbols i..k, then Z is predicted at k, times the
inside probability of Y. The sum over all chains of left corners is taken in closed form (Stolcke,
1995, whose forward probabilities these are, on a chart instead of Earley's states).
"""

from __future__ import annotations

from math import frexp, inf, ldexp, log
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.closure import Sparse
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.records import FloatArray, IntArray

MOST_PRODUCTS = 500_000_000
"""Largest number of products of two cells' entries in a chart. They take 3 to 5 s, and a
sentence that is refused needs two charts, so the answer comes within 10 s. Learned grammars need
far fewer: a passage of 900 symbols takes 0.1 s."""
_SPLIT = 1  # Number of products that one split of a span counts as
MOST_ENTRIES = 12_000_000
"""Largest number of entries of a chart: 192 MB, and twice that while the arrays grow."""


class Chart(NamedTuple):
    """The chart of a sentence of n symbols."""

    begin: IntArray  # (n + 1, n + 1): index of the first entry of each cell
    end: IntArray  # (n + 1, n + 1): index after the last entry of each cell
    exponents: IntArray  # (n + 1, n + 1): the power of two of each cell
    symbols: IntArray  # (entries,): symbol of each entry, ascending within a cell
    values: FloatArray  # (entries,): value of each entry, before the power of two of its cell


class Tails(NamedTuple):
    """Tails by one of their children: ``tails[starts[s]:starts[s + 1]]`` have the child s."""

    starts: IntArray
    tails: IntArray


class TailRules(NamedTuple):
    """How symbols combine: tails by their right child, and the left child of each tail (S,)."""

    by_right: Tails
    left: IntArray


class _Work(NamedTuple):
    """Values by symbol (S,), and lists of the symbols that have one."""

    base: FloatArray  # (S,): values of a cell before the chains
    full: FloatArray  # (S,): values of a cell after the chains
    touched: IntArray  # (S,): list of the symbols with a value in ``base``
    reached: IntArray  # (S,): list of the symbols with a value in ``full``


class _Span(NamedTuple):
    """A span i..j whose cell is filled, and the power of two that all its products share."""

    i: int
    j: int
    top: int


def fill_chart(best: bool, sentence: IntArray, rules: TailRules, chains: Sparse) -> Chart:
    """Fill the chart of a sentence.

    Shapes: `sentence` (n,).

    `chains`: For each symbol, the symbols from which it is reached without reading anything, with
    weights.
    """
    chart, is_whole = _fill(best, sentence, rules, chains)
    if not is_whole:
        raise GrammarError(
            f"sentence: expected a chart of at most {MOST_PRODUCTS:,} products and"
            f" {MOST_ENTRIES:,} entries, found more for {len(sentence):,} symbols: too many"
            " symbols of the grammar derive the same spans. Give the sentence in parts, or use a"
            " grammar with fewer alternatives."
        )
    return chart


@njit(cache=True)
def _fill(best: bool, sentence: IntArray, rules: TailRules, chains: Sparse) -> tuple[Chart, bool]:
    """Fill the chart of a sentence; also return whether it is complete, or grew too large."""
    n, n_symbols = len(sentence), len(rules.left)
    begin = np.zeros((n + 1, n + 1), np.int64)
    end, exponents = np.zeros((n + 1, n + 1), np.int64), np.zeros((n + 1, n + 1), np.int64)
    symbols, values, used = np.zeros(256, np.int64), np.zeros(256), 0
    row, splits = np.zeros((n + 1, n_symbols)), np.zeros(n + 1, np.int64)
    work = _Work(
        np.zeros(n_symbols),
        np.zeros(n_symbols),
        np.zeros(n_symbols, np.int64),
        np.zeros(n_symbols, np.int64),
    )
    n_products = 0
    for i in range(n - 1, -1, -1):
        n_splits = 0
        for j in range(i + 1, n + 1):
            chart = Chart(begin, end, exponents, symbols, values)
            if j == i + 1:
                work.base[sentence[i]], work.touched[0] = 1.0, sentence[i]
            span = _Span(i, j, _top_exponent(chart, splits[:n_splits], i, j))
            n_touched, more = _combine(best, chart, row, splits[:n_splits], (rules, work, span))
            n_products += more
            n_reached = _climb(best, n_touched, chains, work)
            if n_products > MOST_PRODUCTS or used + n_reached > MOST_ENTRIES:
                return chart, False
            if used + n_reached > len(symbols):
                more = max(n_reached, len(symbols))
                symbols = np.append(symbols, np.zeros(more, np.int64))
                values = np.append(values, np.zeros(more))
            shift = _shift(work, n_reached)
            begin[i, j], exponents[i, j] = used, span.top + shift
            _sort(work.reached[:n_reached])
            for symbol in work.reached[:n_reached]:
                value = ldexp(work.full[symbol], -shift)
                symbols[used], values[used], row[j, symbol] = symbol, value, value
                work.full[symbol] = 0.0
                used += 1
            end[i, j] = used
            if n_reached > 0:
                splits[n_splits] = j
                n_splits += 1
        for j in range(i + 1, n + 1):
            row[j, symbols[begin[i, j] : end[i, j]]] = 0.0
    return Chart(begin, end, exponents, symbols[:used], values[:used]), True


@njit(cache=True)
def _combine(
    best: bool,
    chart: Chart,
    row: FloatArray,
    splits: IntArray,
    setting: tuple[TailRules, _Work, _Span],
) -> tuple[int, int]:
    """Add the tails over a span, split at every place, to ``base``.

    ``row[k]`` (S,) holds the values of the cell (i, k). Returns the number of symbols with a value,
    and the number of products that were evaluated; a split counts as :data:`_SPLIT` of them.
    """
    rules, work, span = setting
    starts, tails, left = rules.by_right.starts, rules.by_right.tails, rules.left
    base, touched, symbols, values = work.base, work.touched, chart.symbols, chart.values
    n_touched, n_products = int(span.j == span.i + 1), _SPLIT * len(splits)
    for k in splits:
        low, high = chart.begin[k, span.j], chart.end[k, span.j]
        if low == high:
            continue
        shift = chart.exponents[span.i, k] + chart.exponents[k, span.j] - span.top
        factor = ldexp(1.0, shift) if shift else 1.0
        for entry in range(low, high):
            symbol = symbols[entry]
            second = values[entry] * factor
            n_products += starts[symbol + 1] - starts[symbol]
            for t in range(starts[symbol], starts[symbol + 1]):
                tail = tails[t]
                first = row[k, left[tail]]
                if first == 0.0:  # no value; an infinite count times 0 would be NaN
                    continue
                value = first * second
                if value == 0.0:
                    continue
                if base[tail] == 0.0:
                    touched[n_touched] = tail
                    n_touched += 1
                base[tail] = max(base[tail], value) if best else base[tail] + value
    return n_touched, n_products


@njit(cache=True)
def _climb(best: bool, n_touched: int, chains: Sparse, work: _Work) -> int:
    """Follow the chains from ``base`` (emptied) to ``full``; return the number of symbols."""
    base, full = work.base, work.full
    n_reached = 0
    for symbol in work.touched[:n_touched]:
        for c in range(chains.starts[symbol], chains.starts[symbol + 1]):
            above, value = chains.columns[c], chains.values[c] * base[symbol]
            if value == 0.0:
                continue
            if full[above] == 0.0:
                work.reached[n_reached] = above
                n_reached += 1
            full[above] = max(full[above], value) if best else full[above] + value
        base[symbol] = 0.0
    return n_reached


@njit(cache=True)
def _sort(numbers: IntArray) -> None:
    """Shell's sort in place: it compiles faster than a general one, and cells are small."""
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
def _top_exponent(chart: Chart, splits: IntArray, i: int, j: int) -> int:
    """Return the greatest power of two among the products over a span."""
    top, is_known = 0, False
    for k in splits:
        if chart.begin[k, j] < chart.end[k, j]:
            exponent = chart.exponents[i, k] + chart.exponents[k, j]
            if not is_known or exponent > top:
                top, is_known = exponent, True
    return top


@njit(cache=True)
def _shift(work: _Work, n_reached: int) -> int:
    """Return the power of two of the greatest finite value of a cell."""
    greatest = 0.0
    for symbol in work.reached[:n_reached]:
        value = work.full[symbol]
        if value > greatest and value < inf:
            greatest = value
    return frexp(greatest)[1] if greatest > 0.0 else 0


@njit(cache=True)
def find(chart: Chart, symbol: int, i: int, j: int) -> tuple[float, int]:
    """Return value and exponent of a symbol over (i, j), i < j; value 0 if it has no entry."""
    low, high = chart.begin[i, j], chart.end[i, j]
    while low < high:  # binary search
        middle = (low + high) // 2
        if chart.symbols[middle] < symbol:
            low = middle + 1
        else:
            high = middle
    if low < chart.end[i, j] and chart.symbols[low] == symbol:
        return chart.values[low], chart.exponents[i, j]
    return 0.0, 0


TOLERANCE = 2.5e-10
"""Largest difference of log-probabilities that count as equal. It is smaller than the rule
penalty."""


class Forms(NamedTuple):
    """The rules of a compiled grammar, as :func:`best_choices` needs them."""

    left: IntArray  # (S,): left child of each symbol that is a tail, else -1
    right: IntArray  # (S,): right child of each symbol that is a tail, else -1
    rule_of: IntArray  # (S + 1,): index of the first rule of each symbol
    rule_right: IntArray  # (R,): right side of a rule, -1 for the empty string
    log_weights: FloatArray  # (R,): log-probability of a rule, less the penalty


@njit(cache=True)
def _log_best(chart: Chart, empties: FloatArray, symbol: int, i: int, j: int) -> float:
    """Return the log of the best value of a symbol over (i, j), -inf if there is none."""
    if i == j:
        return log(empties[symbol]) if empties[symbol] > 0.0 else -inf
    value, exponent = find(chart, symbol, i, j)
    return log(value) + exponent * log(2.0) if value > 0.0 else -inf


@njit(cache=True)
def best_choices(chart: Chart, empties: FloatArray, forms: Forms, start: int, n: int) -> IntArray:
    """Return the rules of the best tree in preorder, as indices among the rules in use.

    Parameters
    ----------
    chart : Chart
        The chart of greatest values.
    empties : array (S,)
        The greatest values of the empty string.
    forms : Forms
        The rules.
    start : int
        The symbol at the root.
    n : int
        Length of the sentence.
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
            k = _first_split(chart, empties, (left[symbol], right[symbol]), (i, j), goal)
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
def _first_split(
    chart: Chart,
    empties: FloatArray,
    children: tuple[int, int],
    span: tuple[int, int],
    goal: float,
) -> int:
    """Return the first split of a span at which two children reach the goal."""
    left, right = children
    k, j = span
    while k < j:
        first = _log_best(chart, empties, left, span[0], k)
        if first + _log_best(chart, empties, right, k, j) >= goal:
            break
        k += 1
    return k


@njit(cache=True)
def _first_rule(
    chart: Chart,
    empties: FloatArray,
    forms: Forms,
    symbol: int,
    span: tuple[int, int],
    goal: float,
) -> int:
    """Return the first rule of a symbol that reaches the goal over a span."""
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


class Corners(NamedTuple):
    """The rules, in the form needed for the beginnings of strings."""

    by_left: Tails  # Tails by their left child
    right: IntArray  # (S,): right child of a tail, else -1
    closure: Sparse  # For each symbol, the symbols that its string can begin with, with weights


@njit(cache=True)
def forward(chart: Chart, n: int, start: int, corners: Corners) -> tuple[FloatArray, IntArray]:
    """Compute forward probabilities of a sentence.

    Parameters
    ----------
    chart : Chart
        The chart of sums of the sentence.
    n : int
        Length of the sentence.
    start : int
        The start symbol.
    corners : Corners
        The rules.

    Returns
    -------
    weights : array (n + 1, S)
        For a terminal t, ``weights[i, t]`` times two to the exponent is the probability that a
        string of the grammar begins with the first i symbols and t.
    exponents : array (n + 1,)
        The exponents.
    """
    n_symbols = len(corners.right)
    predicted, scale = np.zeros((n + 1, n_symbols)), np.zeros(n + 1, np.int64)
    seen, weights = np.zeros(n + 1, np.bool_), np.zeros((n + 1, n_symbols))
    predicted[0, start] = 1.0
    for i in range(n + 1):
        scale[i] += _close_corners(predicted[i], weights[i], corners.closure)
        for k in range(i + 1, n + 1):
            exponent = scale[i] + chart.exponents[i, k]
            for entry in range(chart.begin[i, k], chart.end[i, k]):
                symbol, value = chart.symbols[entry], chart.values[entry]
                for tail in corners.by_left.tails[
                    corners.by_left.starts[symbol] : corners.by_left.starts[symbol + 1]
                ]:
                    if weights[i, tail] == 0.0:
                        continue
                    if not seen[k]:
                        seen[k], scale[k] = True, exponent
                    elif exponent > scale[k]:
                        _scale(predicted[k], scale[k] - exponent)
                        scale[k] = exponent
                    part = weights[i, tail] * value
                    predicted[k, corners.right[tail]] += part * ldexp(1.0, exponent - scale[k])
    return weights, scale


@njit(cache=True)
def _close_corners(predicted: FloatArray, weights: FloatArray, closure: Sparse) -> int:
    """Fill the weights of all left corners of the predicted symbols; return their power of two."""
    greatest = 0.0
    for value in predicted:
        greatest = max(greatest, value)
    shift = frexp(greatest)[1] if greatest > 0.0 else 0
    for symbol in range(len(predicted)):
        if predicted[symbol] == 0.0:
            continue
        value = ldexp(predicted[symbol], -shift)
        for c in range(closure.starts[symbol], closure.starts[symbol + 1]):
            weights[closure.columns[c]] += value * closure.values[c]
    return shift


@njit(cache=True)
def _scale(values: FloatArray, exponent: int) -> None:
    """Multiply values by a power of two."""
    for symbol in range(len(values)):
        values[symbol] = ldexp(values[symbol], exponent)
