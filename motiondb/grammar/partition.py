"""Cut strings into sentences: the partition that is described in the fewest bits.

The ends of strings are cuts that always stand. Further cuts may stand anywhere but inside a chosen
occurrence of a repeat (``repeats.cover_repeats``) and no nearer to each other than the shortest
sentence; sentences longer than the longest are made only where nothing else is allowed. A
candidate is judged by the grammar that ``context_bits`` induces for it.

The paper draws candidates at random and keeps the best. Here a fourth of the evaluations is spent
in that way; the rest moves, adds and takes out single cuts of the best so far. A change that costs
bits is still accepted with a probability that falls with the cost and with time (simulated
annealing), for the bits change by leaps. The best of all is returned.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.2.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from motiondb.grammar.cfg import Grammar, GrammarError
from motiondb.grammar.context_bits import CoveredString, context_bits, cover_string
from motiondb.grammar.description import DescriptionLength, Sentence
from motiondb.grammar.induction import Induction, induce_with_bits
from motiondb.grammar.repeats import join_strings

IntArray = npt.NDArray[np.int64]
Progress = Callable[[int, int], None]
"""Told how much is done, of how much."""

SHORTEST = 4
LONGEST = 20
EVALUATIONS = 4000
_DRAWN = 0.25
_WARMTH = 0.01
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
    room = cutting_room(strings, shortest, longest)
    cuts, _ = search_cuts(room, rng, evaluations, progress)
    inner = tuple(
        tuple(cut - low for cut in cuts if low < cut < high)
        for low, high in zip(room.bounds[:-1], room.bounds[1:])
    )
    return sentences_between(strings, inner)


def sentences_between(strings: Sequence[Sentence], cuts: Sequence[Sequence[int]]) -> Sentences:
    """Learn from a partition that is given: by the user, or no cuts for strings that are sentences.

    Raises
    ------
    GrammarError where cuts are no rising places inside their string.
    """
    sentences: list[Sentence] = []
    for number, (string, inner) in enumerate(zip(strings, cuts, strict=True), start=1):
        edges = [0, *inner, len(string)]
        if any(low >= high for low, high in zip(edges[:-1], edges[1:])):
            raise GrammarError(
                f"string {number}: expected rising cuts between 1 and {len(string) - 1}, found"
                f" {', '.join(map(str, inner)) or 'none in an empty string'}."
                " Give each cut as the number of the symbol that begins a sentence."
            )
        sentences.extend(tuple(string[a:b]) for a, b in zip(edges[:-1], edges[1:]))
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
        for low, high in zip(bounds[:-1].tolist(), bounds[1:].tolist())
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
        changed = _changed(room, current, rng)
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
    for low, high in zip(room.bounds[:-1], room.bounds[1:]):
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
    return tuple(sorted((*cuts, int(fitting[rng.integers(len(fitting))]))))


def _between(places: Sequence[int], low: int, high: int) -> Sequence[int]:
    """The rising places from low up to, not including, high."""
    return places[bisect_left(places, low) : bisect_right(places, high - 1)]
