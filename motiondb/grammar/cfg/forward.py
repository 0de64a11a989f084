"""Forward probabilities: the next symbol at each position of a sentence, given those before it.

A string that begins with the first i symbols and then X needs a symbol that is *predicted* at place
i and has X as a left corner. The start symbol is predicted at 0. If a tail (Y Z) is a left corner
at i of a predicted symbol, and Y derives the symbols i..k, then Z is predicted at k, times the
inside probability of Y. The sum over all chains of left corners is taken in closed form (Stolcke,
1995, whose forward probabilities these are, on a chart instead of Earley's states).
"""

from __future__ import annotations

from math import frexp, ldexp
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.chart import Chart, Tails
from motiondb.grammar.cfg.closure import Sparse
from motiondb.records import FloatArray, IntArray


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
