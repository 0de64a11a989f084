"""Hypotheses: which parts of sentences may be constituents, and which of them are believed.

Every slot of an alignment proposes two spans, one of each sentence, that can be exchanged: two
*hypotheses* of one type. A span that was proposed more than once, by alignments with different
sentences, has one type: the types are united (*clustering*). Hypotheses of a sentence may cross
each other, which no tree allows; *selection* keeps some that do not cross:

* ``first``: what was proposed earlier is believed;
* ``leaf``: the more probable words are believed, P(words) = how many hypotheses have these words
  over all hypotheses;
* ``branch``: the words more probable for their type, P(words | type) = how many hypotheses of
  the type have these words over all of the type.

Sentences are taken in one order (by their symbols), pairs in the order of their sentences, so
that even ``first`` does not depend on the order in which sentences came. Of equally believable
hypotheses the longer and then the earlier is kept.

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

    sentence: int
    start: int
    end: int


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """Places in the order they were proposed, each with its type; and the pairs that made them."""

    sentences: tuple[Words, ...]
    types: dict[Place, int]
    pairs: Counter[tuple[Place, Place]]

    def words(self, place: Place) -> Words:
        """Return the words of a place."""
        return self.sentences[place.sentence][place.start : place.end]


def propose(
    sentences: Sequence[Words], slots: Iterable[tuple[int, int, Sequence[Slot]]]
) -> Hypotheses:
    """Hypotheses from the slots of pairs of sentences, clustered.

    Whole sentences are no hypotheses: they are of the start symbol's type already.
    """
    group = _Groups()
    pairs: Counter[tuple[Place, Place]] = Counter()
    for i, j, found in slots:
        for one, other in found:
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
    return span == (0, len(sentence))


class _Groups:
    """Disjoint sets of places, in the order in which places were met."""

    def __init__(self) -> None:
        self.parents: dict[Place, Place] = {}

    def root(self, place: Place) -> Place:
        self.parents.setdefault(place, place)
        while self.parents[place] != place:
            self.parents[place] = self.parents[self.parents[place]]
            place = self.parents[place]
        return place

    def unite(self, one: Place, other: Place) -> None:
        low, high = sorted((self.root(one), self.root(other)))
        self.parents[high] = low


def select(hypotheses: Hypotheses, selection: Selection) -> tuple[tuple[Place, ...], ...]:
    """For each sentence the places that are believed, none crossing another, in text order.

    Raises
    ------
    KeyError for an unknown selection.
    """
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
    low, high = (one, other) if one.start <= other.start else (other, one)
    return low.start < high.start < low.end < high.end


def _earlier(hypotheses: Hypotheses) -> dict[Place, float]:
    return {place: -float(number) for number, place in enumerate(hypotheses.types)}


def _by_leaf(hypotheses: Hypotheses) -> dict[Place, float]:
    counts = Counter(map(hypotheses.words, hypotheses.types))
    total = len(hypotheses.types)
    return {place: counts[hypotheses.words(place)] / total for place in hypotheses.types}


def _by_branch(hypotheses: Hypotheses) -> dict[Place, float]:
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
