"""Cut strings into sentences: the partition that is described in the fewest bits.

The ends of strings are cuts that always stand. Further cuts may stand anywhere but inside a chosen
occurrence of a repeat (``repeats.cover_repeats``) and no nearer to each other than the shortest
sentence; sentences longer than the longest are made only where nothing else is allowed. A
candidate is judged by the grammar that ``context_bits`` induces for it.

Where sentences begin and end alike, the border of two is a repeat itself, and the cover forbids
just the true cuts. So strings are also split first wherever one symbol follows another, or before
or after every occurrence of a symbol; a cut at all places alike divides no repeat in one
occurrence only. The cover is then that of the pieces. Which of these splits, or none, is best is
judged by the bits after a quick compaction of the rules.

The paper draws candidates at random and keeps the best. Here a fourth of the evaluations is spent
in that way, with the same draws. The rest goes on from the best: single cuts are moved, added and
taken out, and stretches of the strings, or all, are cut anew where the grammar of the present
sentences would gain most, its gains shaken at random (``recutting``). A change that costs bits is
still accepted with a probability that falls with the cost and with time (simulated annealing), for
the bits change by leaps. The best of all is returned: it is never worse than the fourth drawn.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.2.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from motiondb.grammar.annealing import anneal
from motiondb.grammar.cfg import Grammar, GrammarError
from motiondb.grammar.context_bits import CoveredString, context_bits, cover_string
from motiondb.grammar.description import DescriptionLength, Sentence
from motiondb.grammar.induction import Induction, induce_with_bits
from motiondb.grammar.recutting import recut
from motiondb.grammar.repeats import join_strings
from motiondb.grammar.rule_set import flat_rules

IntArray = npt.NDArray[np.int64]
Cuts = tuple[tuple[int, ...], ...]
"""For each string the places of its inner cuts, in rising order."""

Progress = Callable[[int, int], None]
"""Told how much is done, of how much."""

SHORTEST = 4
LONGEST = 20
EVALUATIONS = 4000
_DRAWN = 0.25
_SHORTER = 20
"""How many times fewer evaluations a split is given than strings that are not split."""

_SYMBOLS_COMPARED, _FEWEST_COMPARED = 6000, 5
"""Splits whose sentences are compacted, those of fewest bits, no split at all among them: so many
symbols of strings in all, but not fewer splits than six."""

_QUICK_TRIES, _TRIES = 5_000, 20_000
"""Tries of the annealing by which splits are compared, first all, then the finalists."""

_FULLY_SEARCHED = 400
"""Symbols of strings up to which as many evaluations are spent as are wished; then fewer."""

_SINGLE = 0.3
"""Share of changes that are of one cut."""

_FINALISTS, _SMALL = 3, 40
"""Symbols of strings up to which each finalist is learned from in full."""

_WARMTH = 0.004
"""First temperature, as a share of the bits of the best candidate drawn."""


@dataclass(frozen=True)
class Sentences:
    """A partition of strings and what was learned from it.

    cuts : for each string the places of its inner cuts, in rising order.
    sentences : all sentences, string by string.
    induction : the grammar, how it was found, and its bits with those of the sentences.
    """

    cuts: tuple[tuple[int, ...], ...]
    sentences: tuple[Sentence, ...]
    induction: Induction

    @property
    def grammar(self) -> Grammar:
        """The grammar learned from the sentences."""
        return self.induction.grammar

    @property
    def bits(self) -> DescriptionLength:
        """Bits of the rules, and of the sentences given the rules."""
        return self.induction.bits


@dataclass(frozen=True, eq=False)
class Room:
    """Where cuts may stand: the covered strings, their bounds, and what lengths are wished."""

    covered: CoveredString
    bounds: tuple[int, ...]
    allowed: tuple[int, ...]
    shortest: int
    longest: int

    def spans(self, cuts: Sequence[int]) -> tuple[IntArray, IntArray]:
        """Starts and ends of sentences; the separators at the ends of strings are left out."""
        starts = np.union1d(np.array(cuts, dtype=np.int64), np.array(self.bounds[:-1]))
        ends = np.append(starts[1:], self.bounds[-1])
        return starts, ends - np.isin(ends, self.bounds)

    def bits(self, cuts: Sequence[int]) -> float:
        """Description length of the partition."""
        return context_bits(self.covered, *self.spans(cuts))


def find_sentences(
    strings: Sequence[Sentence],
    rng: np.random.Generator,
    *,
    shortest: int = SHORTEST,
    longest: int = LONGEST,
    evaluations: int = EVALUATIONS,
    progress: Progress | None = None,
) -> Sentences:
    """Cut strings of terminals into sentences and learn their grammar.

    Raises
    ------
    GrammarError where there is no string, one is empty, lengths make no sense, or all strings hold
    one and the same symbol only.
    """
    cutting_room(strings, shortest, longest)  # faults, before any work
    splits = [tuple(() for _ in strings), *recurring_splits(strings, shortest, longest)]
    found: list[tuple[float, int, Cuts]] = []
    total = sum(map(len, strings))
    evaluations = max(1, round(evaluations * min(1.0, _FULLY_SEARCHED / total) ** 2))
    compared = max(_FEWEST_COMPARED, _SYMBOLS_COMPARED // total)
    steps = len(splits) + compared + 1
    for number, split in enumerate(splits):
        spent = evaluations if number == 0 else max(1, evaluations // _SHORTER)
        cuts, bits = _cuts_within(strings, split, (shortest, longest), rng, spent)
        found.append((bits, number, cuts))
        if progress is not None:
            progress(number + 1, steps)
    judged = []
    promising = [found[0], *sorted(found[1:])[: compared - 1]]
    for number, (_, place, cuts) in enumerate(promising):
        judged.append((_compacted_bits(strings, cuts, _QUICK_TRIES), place, cuts))
        if progress is not None:
            progress(len(splits) + number + 1, steps)
    finalists = sorted(judged)[:_FINALISTS]
    if total <= _SMALL:
        learned = [sentences_between(strings, cuts) for *_, cuts in finalists]
    else:
        best = min((_compacted_bits(strings, cuts, _TRIES), k, cuts) for _, k, cuts in finalists)
        learned = [sentences_between(strings, best[2])]
    if progress is not None:
        progress(steps, steps)
    return min(learned, key=lambda sentences: round(sentences.bits.total, 6))


def recurring_splits(strings: Sequence[Sentence], shortest: int, longest: int) -> list[Cuts]:
    """Cuts at every place where one symbol follows another, or before or after every symbol.

    A cut inside a repeat does harm where it divides one occurrence and not the others. A cut that
    is made at every occurrence divides all alike, and where sentences end and begin alike their
    border is a repeat itself, which no cover would let be cut. Only such places are given whose
    pieces are, in the mean, no shorter than the shortest sentence and no longer than the longest;
    pieces that would be too short stay with the one before.
    """
    places: dict[tuple[str, ...], list[tuple[int, int]]] = {}
    for k, string in enumerate(strings):
        for i in range(1, len(string)):
            pair = (string[i - 1], string[i])
            kinds: tuple[tuple[str, ...], ...] = (
                ("before", pair[1]),
                ("after", pair[0]),
                ("between", *pair),
            )
            for kind in kinds:
                places.setdefault(kind, []).append((k, i))
    total = sum(map(len, strings))
    splits: dict[Cuts, None] = {}
    for kind in sorted(places):
        cuts: list[list[int]] = [[] for _ in strings]
        for k, i in places[kind]:
            last = cuts[k][-1] if cuts[k] else 0
            if i - last >= shortest and len(strings[k]) - i >= shortest:
                cuts[k].append(i)
        pieces = len(strings) + sum(map(len, cuts))
        if pieces > len(strings) and shortest <= total / pieces <= longest:
            splits[tuple(map(tuple, cuts))] = None
    return list(splits)


def _cuts_within(
    strings: Sequence[Sentence],
    split: Cuts,
    lengths: tuple[int, int],
    rng: np.random.Generator,
    evaluations: int,
) -> tuple[Cuts, float]:
    """Cuts of strings that are split already: each piece is cut as a string of its own."""
    pieces: list[Sentence] = []
    origins: list[tuple[int, int]] = []
    for k, (string, inner) in enumerate(zip(strings, split, strict=True)):
        for a, b in pairwise((0, *inner, len(string))):
            pieces.append(tuple(string[a:b]))
            origins.append((k, a))
    room = cutting_room(pieces, *lengths)
    cuts, bits = search_cuts(room, rng, evaluations)
    made = [set(inner) for inner in split]
    for (k, offset), low, high in zip(origins, room.bounds[:-1], room.bounds[1:], strict=True):
        made[k].update(cut - low + offset for cut in cuts if low < cut < high)
    return tuple(tuple(sorted(inner)) for inner in made), bits


def _compacted_bits(strings: Sequence[Sentence], cuts: Cuts, tries: int) -> float:
    """Bits after a quick annealing of one rule a sentence."""
    names = sorted({name for string in strings for name in string})
    number = {name: place for place, name in enumerate(names)}
    counted: Counter[tuple[int, ...]] = Counter()
    for string, inner in zip(strings, cuts, strict=True):
        for a, b in pairwise((0, *inner, len(string))):
            counted[tuple(number[name] for name in string[a:b])] += 1
    return anneal(flat_rules(counted, len(names)), tries=tries).bits()


def sentences_between(strings: Sequence[Sentence], cuts: Sequence[Sequence[int]]) -> Sentences:
    """Learn from a partition that is given: by the user, or no cuts for strings that are sentences.

    Raises
    ------
    GrammarError where cuts are no rising places inside their string.
    """
    sentences: list[Sentence] = []
    for number, (string, inner) in enumerate(zip(strings, cuts, strict=True), start=1):
        edges = [0, *inner, len(string)]
        if any(low >= high for low, high in pairwise(edges)):
            raise GrammarError(
                f"string {number}: expected rising cuts between 1 and {len(string) - 1}, found"
                f" {', '.join(map(str, inner)) or 'none in an empty string'}."
                " Give each cut as the number of the symbol that begins a sentence."
            )
        sentences.extend(tuple(string[a:b]) for a, b in pairwise(edges))
    kept = tuple(tuple(int(cut) for cut in inner) for inner in cuts)
    return Sentences(kept, tuple(sentences), induce_with_bits(sentences))


def cutting_room(
    strings: Sequence[Sentence], shortest: int = SHORTEST, longest: int = LONGEST
) -> Room:
    """The cuts that strings allow; faults as in :func:`find_sentences`."""
    if not 1 <= shortest <= longest:
        raise GrammarError(
            f"sentence lengths: expected 1 <= shortest <= longest, found {shortest} and {longest}."
            " Give lengths in symbols."
        )
    for number, string in enumerate(strings, start=1):
        if not string:
            raise GrammarError(
                f"string {number}: expected at least one symbol, found none. Leave it out."
            )
    kinds = {symbol for string in strings for symbol in string}
    if len(kinds) < 2:
        raise GrammarError(
            f"strings: expected at least two different symbols, found {len(kinds)}."
            " A grammar of one symbol says nothing: find more terminals, or take longer captures."
        )
    symbols, bounds = join_strings(strings)
    covered = cover_string(symbols, len(kinds))
    allowed = [
        place
        for low, high in pairwise(bounds.tolist())
        for place in range(low + shortest, high - shortest)
        if not covered.inside[place]
    ]
    return Room(covered, tuple(bounds.tolist()), tuple(allowed), shortest, longest)


def search_cuts(
    room: Room, rng: np.random.Generator, evaluations: int, progress: Progress | None = None
) -> tuple[tuple[int, ...], float]:
    """The cuts of fewest bits that so many evaluations find, and their bits."""
    drawn = max(1, round(_DRAWN * evaluations))
    best, best_bits = draw_best(room, rng, drawn, progress, evaluations)
    current, bits = best, best_bits
    for number in range(drawn, evaluations):
        warmth = _WARMTH * best_bits * (1.0 - number / evaluations)
        change = _changed if rng.random() < _SINGLE else _recut
        changed = change(room, current, rng)
        changed_bits = room.bits(changed)
        if changed_bits <= bits or rng.random() < math.exp((bits - changed_bits) / warmth):
            current, bits = changed, changed_bits
            if bits < best_bits - 1e-9:
                best, best_bits = current, bits
        if progress is not None:
            progress(number + 1, evaluations)
    return best, best_bits


def draw_best(
    room: Room,
    rng: np.random.Generator,
    evaluations: int,
    progress: Progress | None = None,
    of: int = 0,
) -> tuple[tuple[int, ...], float]:
    """The best of so many random candidates: the paper's search."""
    best: tuple[int, ...] = ()
    best_bits = math.inf
    for number in range(evaluations):
        cuts = draw_cuts(room, rng)
        bits = room.bits(cuts)
        if bits < best_bits:
            best, best_bits = cuts, bits
        if progress is not None:
            progress(number + 1, of or evaluations)
    return best, best_bits


def draw_cuts(room: Room, rng: np.random.Generator) -> tuple[int, ...]:
    """A random candidate: from each cut to the next, a wished length, as near as is allowed."""
    cuts: list[int] = []
    typical = int(rng.integers(room.shortest, room.longest + 1))
    for low, high in pairwise(room.bounds):
        last = low
        places = _between(room.allowed, low, high)
        while True:
            reach = max(room.shortest, round(typical * rng.uniform(0.5, 1.5)))
            near = _between(places, last + room.shortest, last + room.longest + 1)
            later = places[bisect_left(places, last + room.shortest) :]
            if not later:
                break
            last = min(near or later[:1], key=lambda place: abs(place - last - reach))
            cuts.append(last)
    return tuple(cuts)


def _changed(room: Room, cuts: tuple[int, ...], rng: np.random.Generator) -> tuple[int, ...]:
    """One cut moved, added or taken out at random; the same cuts where that is not allowed."""
    kind = rng.random()
    edges = sorted({*cuts, *room.bounds})
    if kind < 0.6 and cuts:
        place = cuts[rng.integers(len(cuts))]
        around = bisect_left(edges, place)
        rest = tuple(cut for cut in cuts if cut != place)
        return _placed(room, rest, edges[around - 1], edges[around + 1], rng)
    if kind < 0.8 or not cuts:
        first = int(rng.integers(len(edges) - 1))
        return _placed(room, cuts, edges[first], edges[first + 1], rng)
    place = cuts[rng.integers(len(cuts))]
    around = bisect_left(edges, place)
    if edges[around + 1] - edges[around - 1] > room.longest + 1:
        return cuts
    return tuple(cut for cut in cuts if cut != place)


def _recut(room: Room, cuts: tuple[int, ...], rng: np.random.Generator) -> tuple[int, ...]:
    lengths = room.shortest, room.longest
    return recut(room.covered.symbols, room.allowed, room.bounds, lengths, cuts, rng)


def _placed(
    room: Room, cuts: tuple[int, ...], low: int, high: int, rng: np.random.Generator
) -> tuple[int, ...]:
    """A cut added somewhere between two neighbouring edges, neither sentence growing too long."""
    places = _between(room.allowed, low + room.shortest, high - room.shortest + 1)
    fitting = [
        place for place in places if max(place - low, high - place) <= room.longest
    ] or places
    if not fitting:
        return cuts
    return tuple(sorted((*cuts, int(fitting[int(rng.integers(len(fitting)))]))))


def _between(places: Sequence[int], low: int, high: int) -> Sequence[int]:
    """The rising places from low up to, not including, high."""
    return places[bisect_left(places, low) : bisect_right(places, high - 1)]
