"""Repeated substrings of a string, and a cover by repeats that do not overlap.

The *cover* selects occurrences of substrings that occur twice or more, the longest first, none of
which overlaps another. The users of a cover never cut a sentence inside an occurrence. In a run
such as ``ababab`` an occurrence would overlap its repetition. It is shortened to the period, so
that a long run stays divisible. The longest repeat that begins at a place is found from the
neighbours of its suffix among all suffixes in sorted order.

Sources: U. Manber and G. Myers, "Suffix arrays: a new method for on-line string searches", SIAM
Journal on Computing 22 (1993), for sorting by doubled prefixes; T. Kasai et al., "Linear-time
longest-common-prefix computation in suffix arrays and its applications", CPM 2001; J. P. Park, K.
H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data", Computer Graphics Forum 30
(2011), section 5.2, for the use of repeats.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from heapq import heapify, heappop, heappush

import numpy as np
import numpy.typing as npt

from motiondb.records import IntArray

SHORTEST_REPEAT = 2  # A single symbol that occurs twice shows no structure


def join_strings(strings: Sequence[Sequence[Hashable]]) -> tuple[IntArray, IntArray]:
    """Join strings into one array of numbers, with a different separator after each.

    The K symbols become 0..K-1 in the order of their names; the separators are K, K+1, ... A repeat
    cannot hold a separator, because each occurs once. So no repeat crosses the end of a string.

    >>> join_strings(["ab", "ba"])
    (array([0, 1, 2, 1, 0, 3]), array([0, 3, 6]))
    """
    names = sorted({symbol for string in strings for symbol in string}, key=str)
    number = {name: place for place, name in enumerate(names)}
    joined: list[int] = []
    bounds = [0]
    for place, string in enumerate(strings):
        joined.extend(number[symbol] for symbol in string)
        joined.append(len(names) + place)
        bounds.append(len(joined))
    return np.array(joined, dtype=np.int64), np.array(bounds, dtype=np.int64)


def sorted_suffixes(symbols: npt.ArrayLike) -> IntArray:
    """Return the starts of the suffixes in sorted order; `symbols` and result (N,).

    >>> sorted_suffixes([1, 0, 2, 0, 2, 0])  # banana
    array([5, 3, 1, 0, 4, 2])
    """
    text = np.asarray(symbols, dtype=np.int64)
    rank, known = np.unique(text, return_inverse=True)[1], 1  # order by the first `known` symbols
    while len(text) and rank.max() < len(text) - 1:
        after = np.append(rank[known:] + 1, np.zeros(min(known, len(text)), dtype=np.int64))
        rank = np.unique(rank * (len(text) + 1) + after, return_inverse=True)[1]
        known *= 2
    return np.argsort(rank)


def common_prefixes(symbols: npt.ArrayLike, suffixes: IntArray) -> list[int]:
    """Return the lengths of the prefixes that neighbouring suffixes share; all of N.

    >>> common_prefixes([1, 0, 2, 0, 2, 0], sorted_suffixes([1, 0, 2, 0, 2, 0]))
    [0, 1, 3, 0, 0, 2]
    """
    text = np.asarray(symbols).tolist()
    before = dict(zip(suffixes[1:].tolist(), suffixes[:-1].tolist()))
    shared, common = [0] * len(text), 0
    for i in range(len(text)):  # without its first symbol, a suffix shares at most one symbol less
        if (j := before.get(i)) is None:
            common = 0
            continue
        while max(i, j) + common < len(text) and text[i + common] == text[j + common]:
            common += 1
        shared[i] = common
        common = max(0, common - 1)
    return [shared[i] for i in suffixes.tolist()]


def cover_repeats(symbols: npt.ArrayLike) -> tuple[IntArray, IntArray]:
    """Select occurrences of repeats, the longest first, that do not overlap: starts and lengths.

    Each selected occurrence equals another substring that it does not overlap. No symbol outside
    the cover can begin a further occurrence of :data:`SHORTEST_REPEAT` symbols or more. Of equally
    long ones the first is selected.

    >>> cover_repeats([0, 1, 4, 2, 3, 0, 1, 5, 2, 3, 0, 1, 4, 2, 3])  # abxcdabycdabxcd
    (array([ 0,  5,  8, 10]), array([5, 2, 2, 5]))
    """
    suffixes = sorted_suffixes(symbols)
    shared, ranked = common_prefixes(symbols, suffixes), suffixes.tolist()
    reach = [0] * len(ranked)  # length of the longest repeat that begins at each place
    for i, j, common in zip(ranked, ranked[1:], shared[1:]):
        length = min(common, abs(i - j))  # an occurrence must not overlap its repetition
        reach[i], reach[j] = max(reach[i], length), max(reach[j], length)
    waiting = [(-length, i, i) for i, length in enumerate(reach) if length >= SHORTEST_REPEAT]
    heapify(waiting)
    owner = [-1] * len(ranked)  # start of the occurrence that covers each place
    chosen: dict[int, int] = {}
    shortened = 0
    while waiting:
        negative, _, i = heappop(waiting)
        length = -negative
        if owner[i] >= 0:
            continue
        # Chosen occurrences are at least as long. One that overlaps covers the last symbol.
        blocker = owner[i + length - 1]
        if blocker < 0:
            owner[i : i + length] = [i] * length
            chosen[i] = length
        elif blocker - i >= SHORTEST_REPEAT:
            shortened += 1  # the last one that was shortened comes first among equally long ones
            heappush(waiting, (i - blocker, -shortened, i))
    starts = np.array(sorted(chosen), dtype=np.int64)
    return starts, np.array([chosen[i] for i in starts.tolist()], dtype=np.int64)
