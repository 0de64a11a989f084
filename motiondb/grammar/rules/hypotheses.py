"""Alignments of sentences, the hypotheses that they propose, and the selection among these.

Each slot of an alignment pairs two spans, one in each sentence, that can replace each other. Both
spans become *hypotheses* of the same type. A span may occur in several slots; then the types of
all its partners are merged (*clustering*). Hypotheses of one sentence may cross, which no tree
allows. *Selection* keeps hypotheses that do not cross. It prefers, by the method:

* ``first``: the hypotheses that were proposed earlier;
* ``leaf``: the hypotheses with the more probable words. P(words) is the number of hypotheses with
  these words, divided by the number of all hypotheses;
* ``branch``: the hypotheses with the more probable words for their type. P(words | type) is the
  number of hypotheses of the type with these words, divided by all hypotheses of the type.

At equal preference the longer hypothesis comes first, then the earlier one in the sentence. The
caller is expected to order the sentences by their symbols, and the pairs by their sentences. Then
even ``first`` does not depend on the order in which the sentences were given.

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

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, sections 2 to 4; J. Geertzen
and M. van Zaanen, "Grammatical Inference Using Suffix Trees", ICGI 2004, for alignment by shared
ends. The three kinds of slots of :func:`align_all` are specific to motiondb.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from numba import njit

from motiondb.records import IntArray

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


Words = tuple[int, ...]
Selection = Literal["first", "leaf", "branch"]
SELECTIONS: tuple[Selection, ...] = ("first", "leaf", "branch")


@dataclass(frozen=True, order=True)
class Constituent:
    """A span of a sentence that may be a constituent: the span of a hypothesis."""

    sentence: int  # Number of the sentence, from 0
    start: int  # First word of the span
    end: int  # The word after the last one of the span


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """The hypotheses of a set of sentences."""

    sentences: tuple[Words, ...]  # Words of each sentence, as numbers
    # Type of each hypothesis, in the order in which the hypotheses were proposed
    types: dict[Constituent, int]
    pairs: Counter[
        tuple[Constituent, Constituent]
    ]  # How many slots proposed each pair of hypotheses

    def words(self, span: Constituent) -> Words:
        """Return the words of a span."""
        return self.sentences[span.sentence][span.start : span.end]


def propose(
    sentences: Sequence[Words], slots: Iterable[tuple[int, int, Sequence[Slot]]]
) -> Hypotheses:
    """Return the hypotheses that slots propose, with merged types.

    A whole sentence is not a hypothesis, because it already has the type of the start symbol.
    """
    group = _Groups()
    pairs: Counter[tuple[Constituent, Constituent]] = Counter()
    for i, j, slot in slots:
        for one, other in slot:
            if _is_whole(sentences[i], one) or _is_whole(sentences[j], other):
                continue
            span, twin = Constituent(i, *one), Constituent(j, *other)
            group.unite(span, twin)
            pairs[span, twin] += 1
    types: dict[Constituent, int] = {}
    numbers: dict[Constituent, int] = {}
    for span in group.parents:
        types[span] = numbers.setdefault(group.root(span), len(numbers))
    return Hypotheses(tuple(sentences), types, pairs)


def _is_whole(sentence: Words, span: Span) -> bool:
    """Whether a span covers its sentence."""
    return span == (0, len(sentence))


class _Groups:
    """Disjoint sets of spans (union-find), in the order in which the spans were added."""

    def __init__(self) -> None:
        self.parents: dict[Constituent, Constituent] = {}

    def root(self, span: Constituent) -> Constituent:
        """Return the representative of the set of a span; a new span is its own set."""
        self.parents.setdefault(span, span)
        while self.parents[span] != span:
            self.parents[span] = self.parents[self.parents[span]]
            span = self.parents[span]
        return span

    def unite(self, one: Constituent, other: Constituent) -> None:
        """Merge the sets of two spans; the smaller representative stays."""
        low, high = sorted((self.root(one), self.root(other)))
        self.parents[high] = low


def select(hypotheses: Hypotheses, selection: Selection) -> tuple[tuple[Constituent, ...], ...]:
    """Select hypotheses that do not cross."""
    belief = _BELIEFS[selection](hypotheses)
    of_sentence: list[list[Constituent]] = [[] for _ in hypotheses.sentences]
    for span in hypotheses.types:
        of_sentence[span.sentence].append(span)
    chosen = []
    for spans in of_sentence:
        spans.sort(key=lambda span: (-belief[span], span.start - span.end, span.start))
        kept: list[Constituent] = []
        for span in spans:
            if not any(_cross(span, other) for other in kept):
                kept.append(span)
        chosen.append(tuple(sorted(kept, key=lambda span: (span.start, -span.end))))
    return tuple(chosen)


def _cross(one: Constituent, other: Constituent) -> bool:
    """Whether two spans overlap and neither contains the other."""
    low, high = (one, other) if one.start <= other.start else (other, one)
    return low.start < high.start < low.end < high.end


def _earlier(hypotheses: Hypotheses) -> dict[Constituent, float]:
    """Return the preference of each span by the order of proposal."""
    return {span: -float(number) for number, span in enumerate(hypotheses.types)}


def _by_leaf(hypotheses: Hypotheses) -> dict[Constituent, float]:
    """Return P(words) of each span."""
    counts = Counter(map(hypotheses.words, hypotheses.types))
    total = len(hypotheses.types)
    return {span: counts[hypotheses.words(span)] / total for span in hypotheses.types}


def _by_branch(hypotheses: Hypotheses) -> dict[Constituent, float]:
    """Return P(words | type) of each span."""
    kinds = Counter(hypotheses.types.values())
    counts = Counter((kind, hypotheses.words(span)) for span, kind in hypotheses.types.items())
    return {
        span: counts[kind, hypotheses.words(span)] / kinds[kind]
        for span, kind in hypotheses.types.items()
    }


_BELIEFS: dict[Selection, Callable[[Hypotheses], dict[Constituent, float]]] = {
    "first": _earlier,
    "leaf": _by_leaf,
    "branch": _by_branch,
}
