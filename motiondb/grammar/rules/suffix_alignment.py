"""Alignment of many sentences at once, by the prefixes and suffixes that they share.

Edit distance compares sentences in pairs. Suffix arrays over all sentences show at once which of
them begin or end alike. For two sentences there are up to three slots:

* what follows a common beginning;
* what comes before a common end;
* what lies between a common beginning and a common end.

The common beginning of two sentences is the smallest LCP between their ranks in the suffix array
of all sentences, joined with separators. The common end is the same in the array of the reversed
sentences. In the order of ranks, one running minimum for each first sentence gives all pairs.

Sources: J. Geertzen and M. van Zaanen, "Grammatical Inference Using Suffix Trees", ICGI 2004, for
reading alignments from a suffix structure. The three kinds of slots are specific to motiondb.
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
    """Return the slots of every pair of sentences that begin or end alike.

    >>> align_all([(0, 1, 3), (0, 2, 3)])
    {(0, 1): (((0, 2), (0, 2)), ((1, 2), (1, 2)), ((1, 3), (1, 3)))}
    """
    begins = _common_beginnings(sentences)
    ends = _common_beginnings([sentence[::-1] for sentence in sentences])
    slots_of = {}
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
            slots_of[i, j] = tuple(sorted(slots))
    return slots_of


def _common_beginnings(sentences: Sequence[tuple[int, ...]]) -> IntArray:
    """Return the length of the prefix that each two sentences share, array (n, n).

    The diagonal is 0.
    """
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
