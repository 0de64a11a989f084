"""Hypotheses: spans of sentences that may be constituents, and the selection among them.

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

Source: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, sections 2 to 4.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from motiondb.grammar.rules.sentence_alignment import Slot, Span

Words = tuple[int, ...]
Selection = Literal["first", "leaf", "branch"]
SELECTIONS: tuple[Selection, ...] = ("first", "leaf", "branch")


@dataclass(frozen=True, order=True)
class Place:
    """A span of a sentence."""

    sentence: int  # Number of the sentence, from 0
    start: int  # First word of the span
    end: int  # The word after the last one of the span


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """The hypotheses of a set of sentences."""

    sentences: tuple[Words, ...]  # Words of each sentence, as numbers
    # Type of each hypothesis, in the order in which the hypotheses were proposed
    types: dict[Place, int]
    pairs: Counter[tuple[Place, Place]]  # How many slots proposed each pair of hypotheses

    def words(self, place: Place) -> Words:
        """Return the words of a place."""
        return self.sentences[place.sentence][place.start : place.end]


def propose(
    sentences: Sequence[Words], slots: Iterable[tuple[int, int, Sequence[Slot]]]
) -> Hypotheses:
    """Return the hypotheses that slots propose, with merged types.

    A whole sentence is not a hypothesis, because it already has the type of the start symbol.
    """
    group = _Groups()
    pairs: Counter[tuple[Place, Place]] = Counter()
    for i, j, slot in slots:
        for one, other in slot:
            if _is_whole(sentences[i], one) or _is_whole(sentences[j], other):
                continue
            place, twin = Place(i, *one), Place(j, *other)
            group.unite(place, twin)
            pairs[place, twin] += 1
    types: dict[Place, int] = {}
    numbers: dict[Place, int] = {}
    for place in group.parents:
        types[place] = numbers.setdefault(group.root(place), len(numbers))
    return Hypotheses(tuple(sentences), types, pairs)


def _is_whole(sentence: Words, span: Span) -> bool:
    """Whether a span covers its sentence."""
    return span == (0, len(sentence))


class _Groups:
    """Disjoint sets of places (union-find), in the order in which the places were added."""

    def __init__(self) -> None:
        self.parents: dict[Place, Place] = {}

    def root(self, place: Place) -> Place:
        """Return the representative of the set of a place; a new place is its own set."""
        self.parents.setdefault(place, place)
        while self.parents[place] != place:
            self.parents[place] = self.parents[self.parents[place]]
            place = self.parents[place]
        return place

    def unite(self, one: Place, other: Place) -> None:
        """Merge the sets of two places; the smaller representative stays."""
        low, high = sorted((self.root(one), self.root(other)))
        self.parents[high] = low


def select(hypotheses: Hypotheses, selection: Selection) -> tuple[tuple[Place, ...], ...]:
    """Select hypotheses that do not cross."""
    belief = _BELIEFS[selection](hypotheses)
    of_sentence: list[list[Place]] = [[] for _ in hypotheses.sentences]
    for place in hypotheses.types:
        of_sentence[place.sentence].append(place)
    chosen = []
    for places in of_sentence:
        places.sort(key=lambda place: (-belief[place], place.start - place.end, place.start))
        kept: list[Place] = []
        for place in places:
            if not any(_cross(place, other) for other in kept):
                kept.append(place)
        chosen.append(tuple(sorted(kept, key=lambda place: (place.start, -place.end))))
    return tuple(chosen)


def _cross(one: Place, other: Place) -> bool:
    """Whether two spans overlap and neither contains the other."""
    low, high = (one, other) if one.start <= other.start else (other, one)
    return low.start < high.start < low.end < high.end


def _earlier(hypotheses: Hypotheses) -> dict[Place, float]:
    """Return the preference of each place by the order of proposal."""
    return {place: -float(number) for number, place in enumerate(hypotheses.types)}


def _by_leaf(hypotheses: Hypotheses) -> dict[Place, float]:
    """Return P(words) of each place."""
    counts = Counter(map(hypotheses.words, hypotheses.types))
    total = len(hypotheses.types)
    return {place: counts[hypotheses.words(place)] / total for place in hypotheses.types}


def _by_branch(hypotheses: Hypotheses) -> dict[Place, float]:
    """Return P(words | type) of each place."""
    kinds = Counter(hypotheses.types.values())
    counts = Counter((kind, hypotheses.words(place)) for place, kind in hypotheses.types.items())
    return {
        place: counts[kind, hypotheses.words(place)] / kinds[kind]
        for place, kind in hypotheses.types.items()
    }


_BELIEFS: dict[Selection, Callable[[Hypotheses], dict[Place, float]]] = {
    "first": _earlier,
    "leaf": _by_leaf,
    "branch": _by_branch,
}
