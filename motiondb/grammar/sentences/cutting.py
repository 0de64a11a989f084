"""Random search of cuts: many partitions are drawn, changed and judged quickly.

The ends of strings are always cuts. Further cuts are allowed anywhere except inside a chosen
occurrence of a repeat (``repeats.cover_repeats``), and no nearer to each other than the shortest
sentence. Sentences longer than the longest are made only if no other cut is allowed. A candidate
is judged by the grammar that ``context_bits`` induces for it. In a *free* room no repeats are
chosen, so that cuts are allowed anywhere: in a long string, nearly every true border lies inside
some repeat by chance.

The paper draws candidates at random and keeps the best. Here a quarter of the evaluations does the
same. The others change the best candidate: single cuts are moved, added and removed, or some or all
of the strings are cut again by the symbols that sentences share, with random changes of these
gains. A change that costs bits is accepted with a probability that decreases with its cost and with
time (simulated annealing), because the bits have many local minima. The best candidate of all is
returned, so the result is never worse than the best one drawn.

*Cutting again.* Rules cost at least two symbols for every sentence, less the symbols that its
beginning and end share with other sentences. Given a partition, the gain of a cut at a place is the
number of symbols that the following part shares with the best beginning of another sentence, plus
the number that the preceding part shares with the best end. Every cut also has a price. The cuts of
least total cost that keep the allowed lengths are found exactly, by dynamic programming over the
allowed places. Random changes of the gains give different cuts each time. If only some places are
chosen again and the others are kept, this is a large neighbourhood search.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.2; R. Bellman, "Dynamic Programming" (1957), for
shortest paths; D. Pisinger and S. Ropke, "Large Neighborhood Search", Handbook of Metaheuristics
(2010).
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.kernels import maker
from motiondb.grammar.rules.description_length import Sentence
from motiondb.grammar.sentences.context_bits import CoveredString, context_bits, cover_string
from motiondb.grammar.sentences.repeats import join_strings
from motiondb.records import BoolArray, FloatArray, IntArray

_TOO_LONG = 1e3
"""Cost, in symbols, of each symbol above the longest sentence: more than many cuts cost."""
_MOST_SHARED = 6  # Largest number of symbols that are compared at a beginning or an end
_LOCAL = 0.7  # Share of recuts that change cuts only in one part of the strings

_PRICE = 2.6
"""Approximate cost of a sentence in symbols: its left side, a separator, and its number among the
alternatives."""


def recut(
    symbols: IntArray,
    allowed: Sequence[int],
    bounds: Sequence[int],
    lengths: tuple[int, int],
    cuts: Sequence[int],
    rng: np.random.Generator,
) -> tuple[int, ...]:
    """Cut strings again: all of them, or a part as long as two to eight of the longest sentences.

    A cut costs ``_PRICE`` symbols, less a random share of the symbols that the sentences there
    would have in common with current ones, less a random number of symbols.

    Shapes: `symbols` (N,).
    """
    shortest, longest = lengths
    places = np.union1d(np.array(allowed, dtype=np.int64), np.array(bounds))
    present = np.array(cuts, dtype=np.int64)
    fixed = np.isin(places, bounds)
    if rng.random() < _LOCAL:
        width = longest * int(rng.integers(2, 9))
        low = int(rng.integers(bounds[0] - width // 2, bounds[-1]))
        outside = (places < low) | (places > low + width)
        kept = ~outside | fixed | np.isin(places, present)
        places, fixed = places[kept], (fixed | outside)[kept]
    shared = shared_symbols(symbols, places, present)
    trust, shaken = rng.random(), 2.0 * rng.random()
    costs = _PRICE - trust * shared - shaken * rng.exponential(size=places.size)
    made = places[cheapest_cuts(places, fixed, costs, shortest, longest)]
    return tuple(made[~np.isin(made, bounds)].tolist())


@maker
def cheapest_cuts(
    places: IntArray, fixed: BoolArray, costs: FloatArray, shortest: int, longest: int
) -> IntArray:
    """Choose places of least total cost, with all fixed places among them.

    Parameters
    ----------
    places : array (P,)
        Places, ascending; the first and the last are fixed.
    fixed : array (P,)
        Whether the place must be chosen.
    costs : array (P,)
        Cost of choosing the place, in symbols; it can be negative.
    shortest : int
        Least distance between neighbouring chosen places, in symbols. Two fixed places can be
        nearer.
    longest : int
        Greatest distance, in symbols. Each symbol above it costs as much as many cuts.

    Returns
    -------
    array (chosen places,)
        Indices of the chosen places, ascending.
    """
    n = places.size
    least = np.full(n, np.inf)
    before = np.zeros(n, dtype=np.int64)
    least[0] = 0.0
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            length = places[j] - places[i]
            if length > longest and least[j] < 0.5 * _TOO_LONG:  # reached without a long one
                break
            if length >= shortest or (fixed[i] and fixed[j]):
                cost = least[i] + costs[j] + _TOO_LONG * max(0, length - longest)
                if cost < least[j]:
                    least[j], before[j] = cost, i
            if fixed[i]:
                break
    chosen = np.empty(n, dtype=np.int64)
    n_cuts = 0
    j = n - 1
    while j > 0:
        chosen[n_cuts] = j
        n_cuts += 1
        j = before[j]
    chosen[n_cuts] = 0
    return chosen[: n_cuts + 1][::-1].copy()


@maker
def shared_symbols(symbols: IntArray, places: IntArray, cuts: IntArray) -> FloatArray:
    """Count the symbols that the surroundings of each place share with those of the best cuts.

    The symbols after a place and those before it are compared separately, so that each can have
    another best cut; at most six symbols are counted on each side.

    Parameters
    ----------
    symbols : array (N,)
        Joined strings.
    places : array (P,)
        Places in ``symbols``.
    cuts : array (C,)
        Cuts to compare with, as places in ``symbols``; a place is not compared with itself.

    Returns
    -------
    array (P,)
        Number of shared symbols, after and before together.
    """
    shared = np.zeros(places.size)
    for k in range(places.size):
        a = places[k]
        after = before = 0
        for b in cuts:
            if a == b:
                continue
            n = 0
            while n < _MOST_SHARED and max(a, b) + n < symbols.size:
                if symbols[a + n] != symbols[b + n]:
                    break
                n += 1
            after = max(after, n)
            n = 0
            while n < _MOST_SHARED and min(a, b) - n > 0:
                if symbols[a - 1 - n] != symbols[b - 1 - n]:
                    break
                n += 1
            before = max(before, n)
        shared[k] = after + before
    return shared


Progress = Callable[[int, int], None]
"""Called with the number of steps done, and the number of all steps."""

SHORTEST = 3  # Shortest sentence, in symbols, unless given
LONGEST = 20  # Longest sentence, in symbols, unless given
_DRAWN = 0.25  # Share of the evaluations that are spent on random candidates
_SINGLE = 0.3  # Share of the changes that change one cut

_WARMTH = 0.004  # First temperature of the annealing, as a share of the bits of the best candidate


@dataclass(frozen=True, eq=False)
class Room:
    """Strings with the places where cuts are allowed, and the limits of sentence lengths."""

    covered: CoveredString  # The joined strings with their cover
    bounds: tuple[int, ...]  # Start of each string, and the length of the joined strings
    allowed: tuple[int, ...]  # Places in the joined strings where inner cuts are allowed, ascending
    shortest: int  # Shortest sentence, in symbols
    longest: int  # Longest sentence, in symbols

    def spans(self, cuts: Sequence[int]) -> tuple[IntArray, IntArray]:
        """Return the spans of the sentences between cuts; result (sentences,)."""
        starts = np.union1d(np.array(cuts, dtype=np.int64), np.array(self.bounds[:-1]))
        ends = np.append(starts[1:], self.bounds[-1])
        return starts, ends - np.isin(ends, self.bounds)

    def bits(self, cuts: Sequence[int]) -> float:
        """Return the description length of a partition."""
        return context_bits(self.covered, *self.spans(cuts))


def cutting_room(
    strings: Sequence[Sentence],
    shortest: int = SHORTEST,
    longest: int = LONGEST,
    *,
    free: bool = False,
) -> Room:
    """Find the places of strings where cuts are allowed."""
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
    if free:
        covered = _uncovered(covered)
    allowed = [
        place
        for low, high in pairwise(bounds.tolist())
        for place in range(low + shortest, high - shortest)
        if not covered.inside[place]
    ]
    return Room(covered, tuple(bounds.tolist()), tuple(allowed), shortest, longest)


def _uncovered(covered: CoveredString) -> CoveredString:
    none = np.zeros(0, dtype=np.int64)
    return covered._replace(
        repeat_at=np.full_like(covered.repeat_at, -1),
        repeat_starts=none,
        repeat_lengths=none,
        inside=np.zeros_like(covered.inside),
    )


def search_cuts(
    room: Room, rng: np.random.Generator, evaluations: int, progress: Progress | None = None
) -> tuple[tuple[int, ...], float]:
    """Search for the cuts of fewest bits: first at random, then by simulated annealing."""
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
    """Return the best of many random candidates: the search of the paper."""
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
    """Draw a random candidate, from left to right.

    A typical length is drawn for the candidate, and for each sentence a length of 0.5 to 1.5 times
    that. The next cut is at the allowed place that is nearest to this length.
    """
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
    """Return the cuts with one moved, added or removed; unchanged if that is not allowed."""
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
    low, high = edges[around - 1], edges[around + 1]
    if high - (high in room.bounds) - low > room.longest:  # a separator ends a string
        return cuts
    return tuple(cut for cut in cuts if cut != place)


def _recut(room: Room, cuts: tuple[int, ...], rng: np.random.Generator) -> tuple[int, ...]:
    lengths = room.shortest, room.longest
    return recut(room.covered.symbols, room.allowed, room.bounds, lengths, cuts, rng)


def _placed(
    room: Room, cuts: tuple[int, ...], low: int, high: int, rng: np.random.Generator
) -> tuple[int, ...]:
    """Add a random cut between two neighbouring edges.

    Neither sentence becomes too long if an allowed place permits it.
    """
    places = _between(room.allowed, low + room.shortest, high - room.shortest + 1)
    fitting = [
        place for place in places if max(place - low, high - place) <= room.longest
    ] or places
    if not fitting:
        return cuts
    return tuple(sorted((*cuts, int(fitting[int(rng.integers(len(fitting)))]))))


def _between(places: Sequence[int], low: int, high: int) -> Sequence[int]:
    """Return those of ascending places that are at least ``low`` and less than ``high``."""
    return places[bisect_left(places, low) : bisect_right(places, high - 1)]
