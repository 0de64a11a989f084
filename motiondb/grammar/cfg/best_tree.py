"""Read the best tree of a sentence from its chart of greatest values."""

from __future__ import annotations

from math import inf, log
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.chart import Chart, find
from motiondb.records import FloatArray, IntArray

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
