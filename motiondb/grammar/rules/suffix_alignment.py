"""Alignment of many sentences at once by the suffixes and prefixes that they share.

Where edit distance compares sentences two by two, a suffix structure over all of them shows at
once which begin or end alike. Two sentences that begin alike differ in what follows; two that end
alike differ in what stands before; and what stands between a common beginning and a common end
can be exchanged. Each of the three gives a slot, unless nothing is common or nothing differs.

The suffix array of all sentences, joined with separators, gives the common beginnings as the
smallest LCP between the ranks of two sentences; the same array over the reversed sentences gives
the common ends. Sentences in these orders need one running minimum per pair.

Sources: J. Geertzen and M. van Zaanen, "Grammatical Inference Using Suffix Trees", ICGI 2004, for
the idea of reading alignments off a suffix structure; the three kinds of slots are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt

from motiondb.grammar.rules.repeats import common_prefixes, join_strings, suffix_array
from motiondb.grammar.rules.sentence_alignment import Slot

IntArray = npt.NDArray[np.int64]


def align_all(sentences: Sequence[tuple[int, ...]]) -> dict[tuple[int, int], tuple[Slot, ...]]:
    """Slots of every pair i < j of sentences that begin or end alike.

    >>> align_all([(0, 1, 3), (0, 2, 3)])
    {(0, 1): (((0, 2), (0, 2)), ((1, 2), (1, 2)), ((1, 3), (1, 3)))}
    """
    begins = _common_beginnings(sentences)
    ends = _common_beginnings([sentence[::-1] for sentence in sentences])
    found = {}
    for i, j in combinations(range(len(sentences)), 2):
        n, m = len(sentences[i]), len(sentences[j])
        p = int(begins[i, j])
        q = min(int(ends[i, j]), min(n, m) - p)
        slots = set()
        if p:
            slots.add(((p, n), (p, m)))
        if q:
            slots.add(((0, n - q), (0, m - q)))
        if p and q:
            slots.add(((p, n - q), (p, m - q)))
        if slots:
            found[i, j] = tuple(sorted(slots))
    return found


def _common_beginnings(sentences: Sequence[tuple[int, ...]]) -> IntArray:
    """Array (n, n): the length of the beginning that each two sentences share."""
    joined, bounds = join_strings(sentences)
    suffixes = suffix_array(joined)
    lcp = common_prefixes(joined, suffixes)
    rank = np.empty(joined.size, dtype=np.int64)
    rank[suffixes] = np.arange(joined.size)
    ranks = rank[bounds[:-1]]
    order = np.argsort(ranks)
    shared = np.zeros((len(sentences), len(sentences)), dtype=np.int64)
    steps = [int(lcp[ranks[a] + 1 : ranks[b] + 1].min()) for a, b in pairwise(order)]
    for first in range(len(order)):
        least = len(sentences[order[first]])
        for second in range(first + 1, len(order)):
            least = min(least, steps[second - 1])
            shared[order[first], order[second]] = shared[order[second], order[first]] = least
    return shared
