"""Cut strings again: exact search of the cheapest cuts, given a gain for each place.

Rules cost at least two symbols for every sentence, less the symbols that its beginning and end
share with other sentences. Given a partition, the gain of a cut at a place is the number of symbols
that the following part shares with the best beginning of another sentence, plus the number that the
preceding part shares with the best end. Every cut also has a price. The cuts of least total cost
that keep the allowed lengths are found exactly, by dynamic programming over the allowed places.
Random changes of the gains give different cuts each time. If only some places are chosen again and
the others are kept, this is a large neighbourhood search.

Sources: R. Bellman, "Dynamic Programming" (1957), for shortest paths; D. Pisinger and S. Ropke,
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
"""Cost, in symbols, of each symbol above the longest sentence: more than many cuts cost."""
_MOST_SHARED = 6  # Largest number of symbols that are compared at a beginning or an end
_LOCAL = 0.7  # Share of recuts that change cuts only in one part of the strings

_PRICE = 2.6
"""Approximate cost of a sentence in symbols: its left side, a separator, and its number among the
alternatives."""


def recut(
    symbols: IntArray,
    allowed: Sequence[int],
    bounds: Sequence[int],
    lengths: tuple[int, int],
    cuts: Sequence[int],
    rng: np.random.Generator,
) -> tuple[int, ...]:
    """Cut strings again: all of them, or a part as long as two to eight of the longest sentences.

    A cut costs ``_PRICE`` symbols, less a random share of the symbols that the sentences there
    would have in common with current ones, less a random number of symbols.

    Shapes: `symbols` (N,).
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
    """Choose places of least total cost, with all fixed places among them.

    Parameters
    ----------
    places : array (P,)
        Places, ascending; the first and the last are fixed.
    fixed : array (P,)
        Whether the place must be chosen.
    costs : array (P,)
        Cost of choosing the place, in symbols; it can be negative.
    shortest : int
        Least distance between neighbouring chosen places, in symbols. Two fixed places can be
        nearer.
    longest : int
        Greatest distance, in symbols. Each symbol above it costs as much as many cuts.

    Returns
    -------
    array (chosen places,)
        Indices of the chosen places, ascending.
    """
    n = places.size
    least = np.full(n, np.inf)
    before = np.zeros(n, dtype=np.int64)
    least[0] = 0.0
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            length = places[j] - places[i]
            if length > longest and least[j] < 0.5 * _TOO_LONG:  # reached without a long one
                break
            if length >= shortest or (fixed[i] and fixed[j]):
                cost = least[i] + costs[j] + _TOO_LONG * max(0, length - longest)
                if cost < least[j]:
                    least[j], before[j] = cost, i
            if fixed[i]:
                break
    chosen = np.empty(n, dtype=np.int64)
    n_cuts = 0
    j = n - 1
    while j > 0:
        chosen[n_cuts] = j
        n_cuts += 1
        j = before[j]
    chosen[n_cuts] = 0
    return chosen[: n_cuts + 1][::-1].copy()


@njit(cache=True)
def shared_symbols(symbols: IntArray, places: IntArray, cuts: IntArray) -> FloatArray:
    """Count the symbols that the surroundings of each place share with those of the best cuts.

    The symbols after a place and those before it are compared separately, so that each can have
    another best cut; at most six symbols are counted on each side.

    Parameters
    ----------
    symbols : array (N,)
        Joined strings.
    places : array (P,)
        Places in ``symbols``.
    cuts : array (C,)
        Cuts to compare with, as places in ``symbols``; a place is not compared with itself.

    Returns
    -------
    array (P,)
        Number of shared symbols, after and before together.
    """
    shared = np.zeros(places.size)
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
        shared[k] = after + before
    return shared
