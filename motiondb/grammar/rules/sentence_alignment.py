"""Alignment of sentences: links between equal symbols, and slots between.

Alignment-based learning assumes that parts of sentences which can replace each other are
constituents of one type. An alignment links equal symbols of two sentences. Between neighbouring
links lie pairs of unequal parts, one part in each sentence; one of the two may be empty. These
pairs are the *slots*.

There are two costs of an alignment:

* ``edit``: insertions and deletions cost 1 each. This links as many symbols as possible (the
  longest common subsequence);
* ``biased``: a link also costs the distance between its two places, each relative to the length of
  its sentence. This prefers links between symbols at similar places.

Among alignments of equal cost, the one with the leftmost links is taken. The sentence
that is smaller in the order of symbols decides, so the order of the arguments does not matter.

Many sentences are also aligned at once by the beginnings and ends that they share
(:func:`align_all`).

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, section 2; J. Geertzen and M.
van Zaanen, "Grammatical Inference Using Suffix Trees", ICGI 2004, for alignment by shared ends. The
three kinds of slots of :func:`align_all` are specific to motiondb.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt
from numba import njit

IntArray = npt.NDArray[np.int64]
Span = tuple[int, int]
Slot = tuple[Span, Span]

_BIAS = 0.999
"""Weight of the relative distance. It is just below 1, so that every link has a positive value."""


def align(one: tuple[int, ...], other: tuple[int, ...], biased: bool = False) -> tuple[Slot, ...]:
    """Return the slots of two sentences.

    >>> align((0, 1, 2, 3), (0, 4, 5, 3))
    (((1, 3), (1, 3)),)
    >>> align((0, 1, 3), (0, 3))
    (((1, 2), (1, 1)),)
    """
    if other < one:
        return tuple((span, twin) for twin, span in align(other, one, biased))
    links = _links(np.array(one, dtype=np.int64), np.array(other, dtype=np.int64), biased)
    return slots_between(links, len(one), len(other))


def align_all(sentences: Sequence[tuple[int, ...]]) -> dict[tuple[int, int], tuple[Slot, ...]]:
    """Return the slots of every pair of sentences that begin or end alike.

    They are what follows a common beginning, what comes before a common end, and what lies between
    both.

    >>> align_all([(0, 1, 3), (0, 2, 3)])
    {(0, 1): (((0, 2), (0, 2)), ((1, 2), (1, 2)), ((1, 3), (1, 3)))}
    """
    slots_of = {}
    for (i, one), (j, other) in combinations(enumerate(sentences), 2):
        n, m = len(one), len(other)
        p = _common_length(one, other)
        q = min(_common_length(one[::-1], other[::-1]), min(n, m) - p)
        slots = set()
        if p:
            slots.add(((p, n), (p, m)))
        if q:
            slots.add(((0, n - q), (0, m - q)))
        if p and q:
            slots.add(((p, n - q), (p, m - q)))
        if slots:
            slots_of[i, j] = tuple(sorted(slots))
    return slots_of


def _common_length(one: tuple[int, ...], other: tuple[int, ...]) -> int:
    """Return how many first symbols are equal."""
    unequal = (k for k, (a, b) in enumerate(zip(one, other)) if a != b)
    return next(unequal, min(len(one), len(other)))


def slots_between(links: IntArray, length: int, other_length: int) -> tuple[Slot, ...]:
    """Return the unequal parts between the links of two sentences; `links` (links, 2)."""
    slots = []
    i = j = 0
    for next_i, next_j in [*links.tolist(), (length, other_length)]:
        if next_i > i or next_j > j:
            slots.append(((i, next_i), (j, next_j)))
        i, j = next_i + 1, next_j + 1
    return tuple(slots)


@njit(cache=True)
def _links(one: IntArray, other: IntArray, biased: bool) -> IntArray:
    """Return the links of the best alignment, array (links, 2), from left to right."""
    n, m = one.size, other.size
    # gain[i, j] is the greatest sum of worths over links of one[i:] with other[j:].
    # A link saves two edits.
    gain = np.zeros((n + 1, m + 1))
    for i in range(n - 1, -1, -1):
        for j in range(m - 1, -1, -1):
            best = max(gain[i + 1, j], gain[i, j + 1])
            if one[i] == other[j]:
                best = max(best, _worth(i, j, n, m, biased) + gain[i + 1, j + 1])
            gain[i, j] = best
    links = np.empty((min(n, m), 2), dtype=np.int64)
    n_links = i = j = 0
    while i < n and j < m:
        linked = -1.0
        if one[i] == other[j]:
            linked = _worth(i, j, n, m, biased) + gain[i + 1, j + 1]
        if linked >= gain[i, j] - 1e-12:
            links[n_links] = i, j
            n_links += 1
            i += 1
            j += 1
        elif gain[i, j + 1] >= gain[i, j] - 1e-12:
            j += 1
        else:
            i += 1
    return links[:n_links]


@njit(cache=True)
def _worth(i: int, j: int, n: int, m: int, biased: bool) -> float:
    """Return the value of the link of places i and j, in (0, 1]; n and m are the lengths."""
    return 1.0 - _BIAS * abs(i / n - j / m) if biased else 1.0
