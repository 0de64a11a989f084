"""Forward probabilities: what may stand at each place of a sentence, given all before it.

A string that begins with the first i symbols and then X needs a symbol *asked for* at place i
whose left corner X is. The start symbol is asked for at 0. Where a tail (Y Z) is a left corner at
i of what is asked for there, and Y derives the symbols i..k, then Z is asked for at k, times the
inside probability of Y. The sum over all chains of left corners is taken in closed form (Stolcke,
1995, whose forward probabilities these are, on a chart instead of Earley's states).
"""

from __future__ import annotations

from math import frexp, ldexp

import numpy as np
from numba import njit


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
        greatest = 0.0
        for symbol in range(n_symbols):
            greatest = max(greatest, asked[i, symbol])
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
                        for symbol in range(n_symbols):
                            asked[k, symbol] = ldexp(asked[k, symbol], scale[k] - here)
                        scale[k] = here
                    value = weights[i, tail] * values[entry]
                    asked[k, right[tail]] += value * ldexp(1.0, here - scale[k])
    return weights, scale
