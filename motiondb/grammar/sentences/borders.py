"""Cuts of one kind, made or taken or moved together wherever they stand.

A border between two symbols is of three kinds at once: *before* the one, *after* the other, and
*between* both. Where sentences begin or end alike, their borders are all of one kind, and a cut at
every place of a kind divides no repeat in one occurrence only. So whole partitions are made from
one kind, and a partition is changed by kinds: single cuts hardly change the bits, for a sentence
that is cut unlike all others shares nothing with them.

A partition is given, string by string, by the places of its inner cuts, in rising order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from motiondb.grammar.rules.description_length import Sentence

Cuts = tuple[tuple[int, ...], ...]
Kind = tuple[str, ...]
Places = dict[Kind, list[tuple[int, int]]]
"""Where borders of each kind stand: number of the string, place in it."""

_FARTHEST = 3
"""Symbols by which cuts are moved at most."""


def kinds_at(string: Sentence, place: int) -> tuple[Kind, Kind, Kind]:
    """Return the kinds of the border before the symbol at a place."""
    before, after = string[place - 1], string[place]
    return ("before", after), ("after", before), ("between", before, after)


def border_places(strings: Sequence[Sentence]) -> Places:
    """All borders of strings by their kinds, the kinds in order."""
    found: Places = {}
    for k, string in enumerate(strings):
        for i in range(1, len(string)):
            for kind in kinds_at(string, i):
                found.setdefault(kind, []).append((k, i))
    return {kind: found[kind] for kind in sorted(found)}


def recurring_splits(strings: Sequence[Sentence], shortest: int, longest: int) -> list[Cuts]:
    """Cuts at every place where one symbol follows another, or before or after every symbol.

    Only such partitions are given whose sentences are, in the mean, no shorter than the shortest
    and no longer than the longest; those that would be too short stay with the one before.
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


def spaced(strings: Sequence[Sentence], cuts: Sequence[Sequence[int]], shortest: int) -> Cuts:
    """Return the cuts without those that would make a sentence too short.

    >>> spaced(["abcdefgh"], [[1, 3, 5, 7]], 3)
    ((3,),)
    """
    kept: list[tuple[int, ...]] = []
    for string, inner in zip(strings, cuts, strict=True):
        own: list[int] = []
        for place in sorted(inner):
            if place - (own[-1] if own else 0) >= shortest and len(string) - place >= shortest:
                own.append(place)
        kept.append(tuple(own))
    return tuple(kept)


def too_long(strings: Sequence[Sentence], cuts: Cuts, lengths: tuple[int, int]) -> bool:
    """Whether a sentence is longer than the longest, in a string that allows shorter ones.

    lengths : the shortest and the longest. Five symbols cannot be cut into sentences of 3 or 4:

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
    """Return the cuts of a kind, drawn at random, taken away, or moved, or made.

    Or all cuts moved.
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
