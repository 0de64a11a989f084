"""Alignment of two sentences by edit distance: what is equal is linked, the rest is exchangeable.

Alignment-based learning holds that parts of sentences which can be exchanged for each other are
constituents of one type. Two sentences are aligned; between neighbouring links stand pairs of
unequal parts, one of each sentence, of which one may be empty: the *slots*.

Two costs of an alignment, from which the two families of edit distance come:

* ``edit``: insertions and deletions cost 1, so as many symbols as possible are linked (the longest
  common subsequence);
* ``biased``: a link between places that lie apart in the two sentences, relative to their lengths,
  costs their relative distance too, so that a symbol is rather linked to the one at the same place.

Among alignments of equal cost the one whose links stand furthest to the left is taken, in the
sentence that comes first in the order of symbols: the slots do not depend on who comes first.

Source: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, section 2.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

IntArray = npt.NDArray[np.int64]
Span = tuple[int, int]
Slot = tuple[Span, Span]

_BIAS = 0.999
"""Relative distance times this: never so much that two links are worth less than none."""


def align(one: tuple[int, ...], other: tuple[int, ...], biased: bool = False) -> tuple[Slot, ...]:
    """Return the slots of two sentences, as half-open spans of both, left to right.

    >>> align((0, 1, 2, 3), (0, 4, 5, 3))
    (((1, 3), (1, 3)),)
    >>> align((0, 1, 3), (0, 3))
    (((1, 2), (1, 1)),)
    """
    if other < one:
        return tuple((span, twin) for twin, span in align(other, one, biased))
    links = _links(np.array(one, dtype=np.int64), np.array(other, dtype=np.int64), biased)
    return slots_between(links, len(one), len(other))


def slots_between(links: IntArray, length: int, other_length: int) -> tuple[Slot, ...]:
    """Return the unequal parts that links, array (n, 2) in rising order, leave of two sentences."""
    slots = []
    i = j = 0
    for next_i, next_j in [*links.tolist(), (length, other_length)]:
        if next_i > i or next_j > j:
            slots.append(((i, next_i), (j, next_j)))
        i, j = next_i + 1, next_j + 1
    return tuple(slots)


@njit(cache=True)
def _links(one: IntArray, other: IntArray, biased: bool) -> IntArray:
    n, m = one.size, other.size
    # gain[i, j]: the best sum over links of one[i:] with other[j:]; a link saves two edits
    gain = np.zeros((n + 1, m + 1))
    for i in range(n - 1, -1, -1):
        for j in range(m - 1, -1, -1):
            best = max(gain[i + 1, j], gain[i, j + 1])
            if one[i] == other[j]:
                best = max(best, _worth(i, j, n, m, biased) + gain[i + 1, j + 1])
            gain[i, j] = best
    links = np.empty((min(n, m), 2), dtype=np.int64)
    found = i = j = 0
    while i < n and j < m:
        linked = -1.0
        if one[i] == other[j]:
            linked = _worth(i, j, n, m, biased) + gain[i + 1, j + 1]
        if linked >= gain[i, j] - 1e-12:
            links[found] = i, j
            found += 1
            i += 1
            j += 1
        elif gain[i, j + 1] >= gain[i, j] - 1e-12:
            j += 1
        else:
            i += 1
    return links[:found]


@njit(cache=True)
def _worth(i: int, j: int, n: int, m: int, biased: bool) -> float:
    return 1.0 - _BIAS * abs(i / n - j / m) if biased else 1.0
