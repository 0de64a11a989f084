"""Strings cut again, exactly: the cheapest cuts where each place has a gain.

Rules cost at least two symbols for every sentence, less what its beginning and end share with those
of others. So, given a partition, a cut at a place gains as many symbols as what follows it has in
common with the best of the other sentences' beginnings, and what precedes it with their ends; and
every cut has a price. The cuts of largest gain that keep the allowed lengths are found exactly, by
dynamic programming over the allowed places. Gains that are shaken at random lead elsewhere each
time; where only some places may be chosen anew and the rest stays, it is a large neighbourhood.

Sources: R. Bellman, "Dynamic Programming" (1957), for cheapest paths; D. Pisinger and S. Ropke,
"Large Neighborhood Search", Handbook of Metaheuristics (2010).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from numba import njit

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
_TOO_LONG = 1e3
_MOST_SHARED = 6
_LOCAL = 0.7
"""Share of recuts that leave everything outside one stretch as it is."""

_PRICE = 2.6
"""Symbols that a sentence costs about: its left side, a separator, its number among the others."""


def recut(
    symbols: IntArray,
    allowed: Sequence[int],
    bounds: Sequence[int],
    lengths: tuple[int, int],
    cuts: Sequence[int],
    rng: np.random.Generator,
) -> tuple[int, ...]:
    """All strings, or what lies in a stretch of two to eight sentences, cut anew.

    A cut costs ``_PRICE`` symbols, less a random part of what sentences there would share with
    present ones, less random symbols.

    Parameters
    ----------
    symbols : array (N,), joined strings. bounds : their begins, and N. allowed : places for cuts.
    lengths : the shortest sentence and the longest. cuts : the present ones.
    """
    shortest, longest = lengths
    places = np.union1d(np.array(allowed, dtype=np.int64), np.array(bounds))
    present = np.array(cuts, dtype=np.int64)
    fixed = np.isin(places, bounds)
    if rng.random() < _LOCAL:
        width = longest * int(rng.integers(2, 9))
        low = int(rng.integers(bounds[0] - width // 2, bounds[-1]))
        outside = (places < low) | (places > low + width)
        kept = ~outside | fixed | np.isin(places, present)
        places, fixed = places[kept], (fixed | outside)[kept]
    shared = shared_symbols(symbols, places, present)
    trust, shaken = rng.random(), 2.0 * rng.random()
    costs = _PRICE - trust * shared - shaken * rng.exponential(size=places.size)
    made = places[cheapest_cuts(places, fixed, costs, shortest, longest)]
    return tuple(made[~np.isin(made, bounds)].tolist())


@njit(cache=True)
def cheapest_cuts(
    places: IntArray, fixed: BoolArray, costs: FloatArray, shortest: int, longest: int
) -> IntArray:
    """Return the places of least cost, the fixed ones among them.

    Parameters
    ----------
    places : array (P,), rising; the first and the last are fixed.
    fixed : array (P,), whether a place must be chosen. costs : array (P,), of choosing it.
    shortest, longest : symbols from one chosen place to the next. Two fixed places may be nearer;
        each symbol above the longest costs as much as many cuts.

    Returns
    -------
    array, numbers of the chosen places, rising.
    """
    n = places.size
    least = np.full(n, np.inf)
    before = np.zeros(n, dtype=np.int64)
    least[0] = 0.0
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            length = places[j] - places[i]
            if length > longest and least[j] < np.inf:
                break
            if length >= shortest or (fixed[i] and fixed[j]):
                cost = least[i] + costs[j] + _TOO_LONG * max(0, length - longest)
                if cost < least[j]:
                    least[j], before[j] = cost, i
            if fixed[i]:
                break
    chosen = np.empty(n, dtype=np.int64)
    found = 0
    j = n - 1
    while j > 0:
        chosen[found] = j
        found += 1
        j = before[j]
    chosen[found] = 0
    return chosen[: found + 1][::-1].copy()


@njit(cache=True)
def shared_symbols(symbols: IntArray, places: IntArray, cuts: IntArray) -> FloatArray:
    """How many symbols after each place, and before it, are shared at the best of other cuts.

    places, cuts : arrays (P,) and (C,), of places in ``symbols``; beginnings and ends are compared
    each for itself, up to six symbols.
    """
    found = np.zeros(places.size)
    for k in range(places.size):
        a = places[k]
        after = before = 0
        for b in cuts:
            if a == b:
                continue
            n = 0
            while n < _MOST_SHARED and max(a, b) + n < symbols.size:
                if symbols[a + n] != symbols[b + n]:
                    break
                n += 1
            after = max(after, n)
            n = 0
            while n < _MOST_SHARED and min(a, b) - n > 0:
                if symbols[a - 1 - n] != symbols[b - 1 - n]:
                    break
                n += 1
            before = max(before, n)
        found[k] = after + before
    return found
