"""Cuts of strings drawn at random, and improved one by one: many partitions judged quickly.

The ends of strings are cuts that always stand. Further cuts may stand anywhere but inside a chosen
occurrence of a repeat (``repeats.cover_repeats``) and no nearer to each other than the shortest
sentence; sentences longer than the longest are made only where nothing else is allowed. A
candidate is judged by the grammar that ``context_bits`` induces for it. In a *free* room no repeat
is chosen, and cuts may stand anywhere: in a long string some repeat lies over almost every true
border by chance alone.

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.rules.description_length import Sentence
from motiondb.grammar.rules.repeats import join_strings
from motiondb.grammar.sentences.context_bits import CoveredString, context_bits, cover_string
from motiondb.grammar.sentences.recutting import recut

IntArray = npt.NDArray[np.int64]
Progress = Callable[[int, int], None]
"""Told how much is done, of how much."""

SHORTEST = 3
LONGEST = 20
_DRAWN = 0.25
_SINGLE = 0.3
"""Share of changes that are of one cut."""

_WARMTH = 0.004
"""First temperature, as a share of the bits of the best candidate drawn."""


@dataclass(frozen=True, eq=False)
class Room:
    """Where cuts may stand: the covered strings, their bounds, and what lengths are wished."""

    covered: CoveredString
    bounds: tuple[int, ...]
    allowed: tuple[int, ...]
    shortest: int
    longest: int

    def spans(self, cuts: Sequence[int]) -> tuple[IntArray, IntArray]:
        """Return starts and ends of sentences.

        The separators at the ends of strings are left out.
        """
        starts = np.union1d(np.array(cuts, dtype=np.int64), np.array(self.bounds[:-1]))
        ends = np.append(starts[1:], self.bounds[-1])
        return starts, ends - np.isin(ends, self.bounds)

    def bits(self, cuts: Sequence[int]) -> float:
        """Return description length of the partition."""
        return context_bits(self.covered, *self.spans(cuts))


def cutting_room(
    strings: Sequence[Sentence],
    shortest: int = SHORTEST,
    longest: int = LONGEST,
    *,
    free: bool = False,
) -> Room:
    """Return the cuts that strings allow; in a free room, repeats forbid none.

    Raises
    ------
    GrammarError where there is no string, one is empty, lengths make no sense, or all strings hold
    one and the same symbol only.
    """
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
    return replace(
        covered,
        repeat_at=np.full_like(covered.repeat_at, -1),
        repeat_starts=none,
        repeat_lengths=none,
        inside=np.zeros_like(covered.inside),
    )


def search_cuts(
    room: Room, rng: np.random.Generator, evaluations: int, progress: Progress | None = None
) -> tuple[tuple[int, ...], float]:
    """Return the cuts of fewest bits that so many evaluations find, and their bits."""
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
    """Return the best of so many random candidates: the paper's search."""
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
    """Return a random candidate.

    From each cut to the next, a wished length, as near as is allowed.
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
    """Add a random cut between two neighbouring edges; neither sentence becomes too long."""
    places = _between(room.allowed, low + room.shortest, high - room.shortest + 1)
    fitting = [
        place for place in places if max(place - low, high - place) <= room.longest
    ] or places
    if not fitting:
        return cuts
    return tuple(sorted((*cuts, int(fitting[int(rng.integers(len(fitting)))]))))


def _between(places: Sequence[int], low: int, high: int) -> Sequence[int]:
    """Return the rising places from low up to, not including, high."""
    return places[bisect_left(places, low) : bisect_right(places, high - 1)]
