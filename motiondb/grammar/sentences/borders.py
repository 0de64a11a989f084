"""Changes of many cuts at once: cuts at borders of one kind are made, removed or moved together.

A border between two symbols is of three kinds at once: *before* the second symbol, *after* the
first, and *between* the two. Borders are of the same kind if sentences begin or end in the same way
there. Cuts at all places of a kind treat all occurrences of a repeat alike. Candidate partitions
are therefore made from one kind each, and a partition is changed kind by kind. A change of a single
cut hardly changes the bits, because a sentence that is cut differently from all others has nothing
in common with them. If one movement is shown by several terminals, sentences begin or end in
several ways, so kinds are also united.

A partition is given as the places of the inner cuts of each string, in ascending order. A cut at
place i is before symbol i of its string.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise
from math import inf

import numpy as np

from motiondb.grammar.rules.description_length import Sentence

Cuts = tuple[tuple[int, ...], ...]
"""A partition: the places of the inner cuts of each string, ascending."""

Kind = tuple[str, ...]
"""Kind of a border: ("before", symbol), ("after", symbol) or ("between", symbol, symbol)."""

Places = dict[Kind, list[tuple[int, int]]]
"""Borders of each kind, as number of the string and place in it."""

_FARTHEST = 3  # Largest number of symbols by which cuts are moved

_UNITED = 12  # Partitions of united kinds. Chosen by hand, to bound the time; not tuned


def kinds_at(string: Sentence, place: int) -> tuple[Kind, Kind, Kind]:
    """Return the three kinds of a border.

    `place`: The border is before the symbol at this place, which is not the first.
    """
    before, after = string[place - 1], string[place]
    return ("before", after), ("after", before), ("between", before, after)


def border_places(strings: Sequence[Sentence]) -> Places:
    """Return all borders between symbols of strings, grouped by kind."""
    places: Places = {}
    for k, string in enumerate(strings):
        for i in range(1, len(string)):
            for kind in kinds_at(string, i):
                places.setdefault(kind, []).append((k, i))
    return {kind: places[kind] for kind in sorted(places)}


def recurring_splits(strings: Sequence[Sentence], shortest: int, longest: int) -> list[Cuts]:
    """Return the partitions that cut at all borders of one kind, for each kind.

    A cut that would make a sentence too short is left out. Partitions are kept only if the mean
    length of their sentences is within the limits.

    `longest`: Limit of the mean length of the sentences, in symbols. Single sentences can be
    longer.
    """
    total = sum(map(len, strings))
    splits: dict[Cuts, None] = {}
    for places in border_places(strings).values():
        made: list[list[int]] = [[] for _ in strings]
        for k, i in places:
            made[k].append(i)
        cuts = spaced(strings, made, shortest)
        pieces = len(strings) + sum(map(len, cuts))
        if pieces > len(strings) and shortest <= total / pieces <= longest:
            splits[cuts] = None
    return list(splits)


def united_splits(strings: Sequence[Sentence], shortest: int, longest: int) -> list[Cuts]:
    """Return partitions that cut before two or three symbols, or after two or three symbols.

    Where takes show a movement in different ways, no single kind of border is in all of them. Of
    all pairs of kinds of one side, those are taken that give sentences of the most even lengths,
    and a third kind is added where it makes them more even.
    """
    places = {kind: p for kind, p in border_places(strings).items() if kind[0] != "between"}

    def cut(kinds: tuple[Kind, ...]) -> tuple[float, Cuts]:
        made: list[list[int]] = [[] for _ in strings]
        for kind in kinds:
            for k, i in places[kind]:
                made[k].append(i)
        cuts = spaced(strings, made, shortest)
        allowed = not too_long(strings, cuts, (shortest, longest))
        return unevenness(strings, cuts) if allowed else inf, cuts

    pairs = {pair: cut(pair) for pair in combinations(places, 2) if pair[0][0] == pair[1][0]}
    united: dict[Cuts, float] = {}
    for pair in sorted(pairs, key=lambda pair: pairs[pair])[:_UNITED]:
        others = [kind for kind in places if kind[0] == pair[0][0] and kind not in pair]
        least, cuts = min([pairs[pair], *(cut((*pair, kind)) for kind in others)])
        if least < inf:
            united[cuts] = least
    return sorted(united, key=lambda cuts: united[cuts])


def unevenness(strings: Sequence[Sentence], cuts: Cuts) -> float:
    """Return the standard deviation of the lengths of sentences, as a share of their mean.

    >>> unevenness(["abcdef", "abc"], ((2,), ()))
    0.2721655269759087
    """
    lengths = np.concatenate(
        [np.diff([0, *inner, len(s)]) for s, inner in zip(strings, cuts, strict=True)]
    )
    return float(lengths.std() / lengths.mean())


def spaced(strings: Sequence[Sentence], cuts: Sequence[Sequence[int]], shortest: int) -> Cuts:
    """Remove cuts that would make a sentence too short, from left to right.

    >>> spaced(["abcdefgh"], [[1, 3, 5, 7]], 3)
    ((3,),)
    """
    kept: list[tuple[int, ...]] = []
    for string, inner in zip(strings, cuts, strict=True):
        cuts_of_string: list[int] = []
        for place in sorted(inner):
            if (
                place - (cuts_of_string[-1] if cuts_of_string else 0) >= shortest
                and len(string) - place >= shortest
            ):
                cuts_of_string.append(place)
        kept.append(tuple(cuts_of_string))
    return tuple(kept)


def too_long(strings: Sequence[Sentence], cuts: Cuts, lengths: tuple[int, int]) -> bool:
    """Return whether a sentence is too long in a string that can be cut into allowed lengths.

    >>> too_long(["abcde"], ((),), (3, 4)), too_long(["abcdef"], ((),), (3, 4))
    (False, True)
    """
    shortest, longest = lengths
    return any(
        b - a > longest
        for string, inner in zip(strings, cuts, strict=True)
        if -(-len(string) // longest) * shortest <= len(string)
        for a, b in pairwise((0, *inner, len(string)))
    )


def change_alike(
    strings: Sequence[Sentence],
    places: Places,
    cuts: Cuts,
    shortest: int,
    rng: np.random.Generator,
) -> Cuts:
    """Make, remove or move cuts of one random kind, or move all cuts.

    The probabilities of the changes were chosen by hand; they are not tuned.

    `shortest`: Shortest sentence, in symbols; cuts that would make a shorter one are left out.
    """
    made = [set(inner) for inner in cuts]
    present = [(k, i) for k, inner in enumerate(cuts) for i in inner]
    change = rng.random()
    if change < 0.4 or not present:
        kinds = list(places)
        for k, i in places[kinds[int(rng.integers(len(kinds)))]]:
            made[k] -= set(range(i - shortest + 1, i + shortest))
            made[k].add(i)
        return spaced(strings, [sorted(inner) for inner in made], shortest)
    alike = set(present)
    if change < 0.9:
        k, i = present[int(rng.integers(len(present)))]
        alike &= set(places[kinds_at(strings[k], i)[int(rng.integers(3))]])
    for k, i in alike:
        made[k].discard(i)
    if change >= 0.65:
        step = int(rng.choice([s for s in range(-_FARTHEST, _FARTHEST + 1) if s]))
        for k, i in _inside(strings, alike, step):
            made[k].add(i)
    return spaced(strings, [sorted(inner) for inner in made], shortest)


def _inside(
    strings: Sequence[Sentence], places: set[tuple[int, int]], step: int
) -> Iterator[tuple[int, int]]:
    for k, i in places:
        if 0 < i + step < len(strings[k]):
            yield k, i + step
