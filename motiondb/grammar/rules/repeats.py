"""Repeated substrings of a string, from its suffix array.

The *suffix array* lists the starts of all suffixes in sorted order. ``lcp[r]`` is the length of the
prefix that the suffixes of rank r - 1 and r share. The array is built by induced sorting. First
the leftmost S-type (LMS) suffixes are sorted; an S-type suffix is smaller than the next one. This
takes a recursion, on a string of at most half the length, while names of LMS blocks are equal. Two
scans then sort all other suffixes. A scan in text order gives the shared lengths. Every step takes
time linear in the length of the string.

A *maximal repeat* occurs at least twice and cannot be extended on either side without losing an
occurrence. It is an interval of the suffix array with different symbols on the left. The *cover*
selects occurrences of repeats, the longest first, none of which overlaps another. The users of a
cover never cut a sentence inside an occurrence. In a run such as ``ababab`` an occurrence would
overlap its repetition. It is shortened to the period, so that a long run stays divisible.

Notation: N symbols, SA suffix array, LCP lengths of shared prefixes.

Sources: G. Nong, S. Zhang and W. H. Chan, "Linear suffix array construction by almost pure
induced-sorting", Data Compression Conference 2009; T. Kasai et al., "Linear-time longest-common-
prefix computation in suffix arrays and its applications", CPM 2001; M. I. Abouelhoda, S. Kurtz
and E. Ohlebusch, "Replacing suffix trees with enhanced suffix arrays", J. Discrete Algorithms 2
(2004), for the intervals; J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from
Human Motion Data", Computer Graphics Forum 30 (2011), section 5.2, for their use.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

IntArray = npt.NDArray[np.int64]

SHORTEST_REPEAT = 2
"""Least length of a repeat. A single symbol that occurs twice shows no structure."""


@dataclass(frozen=True, eq=False)
class Repeats:
    """Maximal repeats of a string."""

    starts: IntArray  # (repeats,): start of one occurrence of each repeat
    lengths: IntArray  # (repeats,): number of symbols of each repeat
    counts: IntArray  # (repeats,): number of occurrences of each repeat


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


def suffix_array(symbols: npt.ArrayLike) -> IntArray:
    """Return the starts of the suffixes in sorted order.

    Shapes: `symbols`, result (N,).

    >>> suffix_array([1, 0, 2, 0, 2, 0])  # banana
    array([5, 3, 1, 0, 4, 2])
    """
    text = np.asarray(symbols, dtype=np.int64)
    if text.size == 0:
        return np.zeros(0, dtype=np.int64)
    ended = np.append(text + 1, 0)
    return _sorted_suffixes(ended, int(ended.max()) + 1)[1:]


def common_prefixes(symbols: npt.ArrayLike, suffixes: IntArray) -> IntArray:
    """Return the lengths of the prefixes that neighbouring suffixes share (LCP).

    Shapes: `symbols`, `suffixes` (N,).

    >>> common_prefixes([1, 0, 2, 0, 2, 0], suffix_array([1, 0, 2, 0, 2, 0]))
    array([0, 1, 3, 0, 0, 2])
    """
    return _common_prefixes(np.asarray(symbols, dtype=np.int64), suffixes)


def maximal_repeats(symbols: npt.ArrayLike, shortest: int = SHORTEST_REPEAT) -> Repeats:
    """Return the maximal repeats of a string; there are at most N; `symbols` (N,)."""
    text = np.asarray(symbols, dtype=np.int64)
    suffixes = suffix_array(text)
    lcp = common_prefixes(text, suffixes)
    return Repeats(*_maximal_repeats(text, suffixes, lcp, shortest))


def cover_repeats(
    symbols: npt.ArrayLike, shortest: int = SHORTEST_REPEAT
) -> tuple[IntArray, IntArray]:
    """Select occurrences of repeats, the longest first, that do not overlap.

    Each selected occurrence equals another substring that it does not overlap. No symbol outside
    the cover can begin a further occurrence of `shortest` symbols or more.

    Shapes: `symbols` (N,); result (occurrences,).

    >>> cover_repeats([0, 1, 4, 2, 3, 0, 1, 5, 2, 3, 0, 1, 4, 2, 3])  # abxcdabycdabxcd
    (array([ 0,  5,  8, 10]), array([5, 2, 2, 5]))
    """
    text = np.asarray(symbols, dtype=np.int64)
    suffixes = suffix_array(text)
    lcp = common_prefixes(text, suffixes)
    return _cover(suffixes, lcp, max(1, shortest))


def _sorted_suffixes(text: IntArray, n_symbols: int) -> IntArray:
    """Return the suffix array of a text whose last symbol is its only 0."""
    rising = _rising(text)
    starts = _leftmost_rising(rising)
    suffixes = _induce(text, n_symbols, rising, starts)
    if starts.size > 1:
        names, n_names = _name_blocks(text, suffixes, rising)
        if n_names < starts.size:
            order = _sorted_suffixes(names[starts], n_names)
        else:
            order = np.empty(starts.size, dtype=np.int64)
            order[names[starts]] = np.arange(starts.size)
        suffixes = _induce(text, n_symbols, rising, starts[order])
    return suffixes


@njit(cache=True)
def _rising(text: IntArray) -> npt.NDArray[np.bool_]:
    """Whether each suffix is smaller than the next one (S-type), array (N,)."""
    rising = np.ones(text.size, dtype=np.bool_)
    for i in range(text.size - 2, -1, -1):
        rising[i] = text[i] < text[i + 1] or (text[i] == text[i + 1] and rising[i + 1])
    return rising


@njit(cache=True)
def _leftmost_rising(rising: npt.NDArray[np.bool_]) -> IntArray:
    """Return the starts of the LMS suffixes: S-type suffixes after one that is not."""
    starts = np.empty(rising.size // 2 + 1, dtype=np.int64)
    n = 0
    for i in range(1, rising.size):
        if rising[i] and not rising[i - 1]:
            starts[n] = i
            n += 1
    return starts[:n]


@njit(cache=True)
def _induce(
    text: IntArray, n_symbols: int, rising: npt.NDArray[np.bool_], starts: IntArray
) -> IntArray:
    """Sort all suffixes from the sorted starts of the LMS suffixes.

    If the starts are in any other order, only the LMS blocks come out sorted.
    """
    counts = np.zeros(n_symbols + 1, dtype=np.int64)
    for symbol in text:
        counts[symbol + 1] += 1
    begins = np.cumsum(counts)
    suffixes = np.full(text.size, -1, dtype=np.int64)
    tails = begins[1:].copy()
    for k in range(starts.size - 1, -1, -1):
        symbol = text[starts[k]]
        tails[symbol] -= 1
        suffixes[tails[symbol]] = starts[k]
    heads = begins[:-1].copy()
    for r in range(text.size):
        i = suffixes[r] - 1
        if i >= 0 and not rising[i]:
            suffixes[heads[text[i]]] = i
            heads[text[i]] += 1
    tails = begins[1:].copy()
    for r in range(text.size - 1, -1, -1):
        i = suffixes[r] - 1
        if i >= 0 and rising[i]:
            tails[text[i]] -= 1
            suffixes[tails[text[i]]] = i
    return suffixes


@njit(cache=True)
def _name_blocks(
    text: IntArray, suffixes: IntArray, rising: npt.NDArray[np.bool_]
) -> tuple[IntArray, int]:
    """Number the LMS blocks, each from one LMS start to the next, in sorted order.

    Equal blocks have the same number. The second value is how many numbers there are.
    """
    names = np.full(text.size, -1, dtype=np.int64)
    last, name = -1, -1
    for i in suffixes:
        if i == 0 or not rising[i] or rising[i - 1]:
            continue
        same = last >= 0
        k = 0
        while same:
            same = text[i + k] == text[last + k] and rising[i + k] == rising[last + k]
            if k > 0 and same:
                ends = rising[i + k] and not rising[i + k - 1]
                if ends == (rising[last + k] and not rising[last + k - 1]) and ends:
                    break
            k += 1
        if not same:
            name += 1
        names[i] = name
        last = i
    return names, name + 1


@njit(cache=True)
def _common_prefixes(text: IntArray, suffixes: IntArray) -> IntArray:
    """Return the LCP array by the algorithm of Kasai et al."""
    n = text.size
    rank = np.empty(n, dtype=np.int64)
    for r in range(n):
        rank[suffixes[r]] = r
    lcp = np.zeros(n, dtype=np.int64)
    common = 0
    for i in range(n):
        if rank[i] == 0:
            common = 0
            continue
        j = suffixes[rank[i] - 1]
        while i + common < n and j + common < n and text[i + common] == text[j + common]:
            common += 1
        lcp[rank[i]] = common
        common = max(0, common - 1)
    return lcp


@njit(cache=True)
def _maximal_repeats(
    text: IntArray, suffixes: IntArray, lcp: IntArray, shortest: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Return starts, lengths and counts of the maximal repeats, by a stack of intervals."""
    n = text.size
    starts = np.empty(n, dtype=np.int64)
    lengths = np.empty(n, dtype=np.int64)
    counts = np.empty(n, dtype=np.int64)
    n_repeats = 0
    changes = np.zeros(n, dtype=np.int64)  # changes of the symbol on the left, up to rank r
    for r in range(1, n):
        i, j = suffixes[r - 1], suffixes[r]
        differ = i == 0 or j == 0 or text[i - 1] != text[j - 1]
        changes[r] = changes[r - 1] + differ
    open_lengths = np.zeros(n + 1, dtype=np.int64)
    open_firsts = np.zeros(n + 1, dtype=np.int64)
    top = 0  # the bottom of the stack is the interval of all suffixes
    for r in range(1, n + 1):
        length = lcp[r] if r < n else 0
        first = r - 1
        while open_lengths[top] > length:
            first = open_firsts[top]
            if open_lengths[top] >= shortest and changes[r - 1] > changes[first]:
                starts[n_repeats] = suffixes[first]
                lengths[n_repeats] = open_lengths[top]
                counts[n_repeats] = r - first
                n_repeats += 1
            top -= 1
        if open_lengths[top] < length:
            top += 1
            open_lengths[top] = length
            open_firsts[top] = first
    return starts[:n_repeats], lengths[:n_repeats], counts[:n_repeats]


@njit(cache=True)
def _cover(suffixes: IntArray, lcp: IntArray, shortest: int) -> tuple[IntArray, IntArray]:
    """Return starts and lengths of the cover, by buckets of positions for each length."""
    n = suffixes.size
    first_of = np.full(n + 1, -1, dtype=np.int64)  # length -> first position in its bucket
    next_of = np.full(n, -1, dtype=np.int64)
    reach = np.zeros(n, dtype=np.int64)
    for r in range(1, n):
        i, j = suffixes[r - 1], suffixes[r]
        length = min(lcp[r], abs(i - j))
        reach[i] = max(reach[i], length)
        reach[j] = max(reach[j], length)
    for i in range(n - 1, -1, -1):
        next_of[i] = first_of[reach[i]]
        first_of[reach[i]] = i
    owner = np.full(n, -1, dtype=np.int64)  # position -> start of the occurrence that covers it
    chosen = np.zeros(n, dtype=np.int64)
    for length in range(n, shortest - 1, -1):
        i = first_of[length]
        while i >= 0:
            following = next_of[i]
            if owner[i] < 0:
                # Chosen occurrences are at least as long. One that overlaps covers the last symbol.
                blocker = owner[i + length - 1]
                if blocker < 0:
                    owner[i : i + length] = i
                    chosen[i] = length
                else:
                    next_of[i] = first_of[blocker - i]
                    first_of[blocker - i] = i
            i = following
    starts = np.flatnonzero(chosen)
    return starts, chosen[starts]
