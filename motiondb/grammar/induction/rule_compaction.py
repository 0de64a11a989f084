"""Rules rewritten as long as the description length falls.

Alignment-based learning proposes; description length disposes. The plain sentences are annealed
some times over (``annealing``), each time with other random numbers; then again and again one of
the best rule sets so far is taken apart somewhere and annealed anew (``perturbation``). What takes
the fewest bits is returned.

Of many sentences only a sample is searched so, several times with other samples: what a search
from all the plain sentences unites wrongly in its first steps, it seldom parts again, and the more
sentences there are, the more wrong steps save bits. The rules of each sample are then made those
of all sentences (``refitting``), and the search goes on from the best of them.

The random numbers are the same each time, so the result depends on the sentences alone. The more
symbols there are, the fewer are the searches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from motiondb.grammar.induction.annealing import WARMEST, anneal
from motiondb.grammar.induction.perturbation import perturb, sample
from motiondb.grammar.induction.planting import plant
from motiondb.grammar.induction.proposals import draw
from motiondb.grammar.induction.refitting import refit
from motiondb.grammar.rules.rule_set import Right, RuleSet

SeedArray = npt.NDArray[np.uint64]
Pool = dict[float, RuleSet]
"""Rule sets by their bits, rounded."""

_ELITE = 16
"""Rule sets, those of fewest bits, that are taken apart."""

_CARRIED = 2
"""Rule sets of a sample, those of fewest bits, that are made those of all sentences."""

_WARM = 2.0
"""Bits: the first temperature where the search does not begin with plain sentences."""

_SEED = 1
"""Of the random numbers, which are the same for all sentences (``proposals.next_bits``)."""


@dataclass(frozen=True)
class Effort:
    """Searches from the plain sentences, from rules taken apart, and tries of each search;
    samples that are searched first, if any, and of how many sentences each."""

    begun: int
    repeated: int
    tries: int
    samples: int = 0
    sampled: int = 0


def effort_for(flat: RuleSet) -> Effort:
    """What is spent on so many symbols: some seconds at most, where the machine is idle."""
    size = _size(flat)
    for most, begun, repeated, tries in _EFFORTS:
        if size <= most:
            return Effort(begun, repeated, max(200, tries * size))
    n = len(flat.rules[flat.start])
    sampled = max(2, n * _SAMPLE_SIZE // size)
    tries = min(_TRIES_A_SYMBOL * size, _MOST_TRIES)
    begun, repeated = (max(2, min(times, times * _LARGE // size)) for times in _OF_ALL)
    return Effort(begun, repeated, tries, _SAMPLES if sampled < n else 0, sampled)


_TRIES_A_SYMBOL = 30
_MOST_TRIES = 40_000
_EFFORTS = ((20, 10, 20, 30), (50, 60, 160, 30), (170, 80, 600, 20))
_SAMPLES, _SAMPLE_SIZE = 6, 160
_OF_SAMPLE = 10, 60
"""Searches begun and repeated of each sample, and, below, of all sentences after the samples."""

_OF_ALL = 20, 100
_LARGE = 800
"""Symbols from which on there are fewer searches of all sentences."""


def compact(
    flat: RuleSet, donors: Sequence[RuleSet] = (), *, effort: Effort | None = None
) -> RuleSet:
    """The rule set of fewest bits that annealing from the plain sentences finds.

    donors : further rule sets, of the same terminals, whose nonterminals may be planted.
    """
    effort = effort or effort_for(flat)
    state = np.array([_SEED], dtype=np.uint64)
    pool: Pool = {}
    _keep(pool, flat)
    for _ in range(effort.samples):
        _grow(pool, flat, effort, state)
    for _ in range(effort.begun):
        _keep(pool, _annealed(flat, effort.tries, WARMEST, state))
    for donor in donors:
        planted = plant(flat, donor, state)
        if planted is not None:
            _keep(pool, _annealed(planted, effort.tries, WARMEST, state))
    _search(pool, flat, effort.repeated, effort.tries, state)
    return pool[min(pool)]


def _search(pool: Pool, flat: RuleSet, times: int, tries: int, state: SeedArray) -> None:
    """Take one of the best apart and anneal it, so many times; the pool is filled."""
    for _ in range(times):
        best = sorted(pool)[:_ELITE]
        begun = perturb(pool[best[draw(state, len(best))]], flat, tries, state)
        if begun is not None:
            _keep(pool, _annealed(begun, tries, _WARM, state))


def _grow(pool: Pool, flat: RuleSet, effort: Effort, state: SeedArray) -> None:
    """Search a sample, and make its best rules those of all sentences."""
    some = sample(flat, effort.sampled, state)
    size = _size(some)
    tries = min(_TRIES_A_SYMBOL * size, effort.tries)
    begun, repeated = (max(2, min(n, n * _SAMPLE_SIZE // size)) for n in _OF_SAMPLE)
    found: Pool = {}
    _keep(found, some)
    for _ in range(begun):
        _keep(found, _annealed(some, tries, WARMEST, state))
    _search(found, some, repeated, tries, state)
    for bits in sorted(found)[:_CARRIED]:
        grown = refit(found[bits], flat)
        if grown is not None:
            _keep(pool, _annealed(grown, effort.tries, _WARM, state))


def _annealed(begun: RuleSet, tries: int, warmest: float, state: SeedArray) -> RuleSet:
    return anneal(begun, tries=tries, warmest=warmest, seed=int(draw(state, 1 << 30)))


def _keep(pool: Pool, found: RuleSet) -> None:
    pool.setdefault(round(found.bits(), 6), found)


def _size(rule_set: RuleSet) -> int:
    return sum(len(right) + 2 for _, right in rule_set.uses())


def trim(rule_set: RuleSet) -> RuleSet:
    """Write out, all at once, the nonterminals of one rule that cost more than they save."""
    current = rule_set.copy()
    while True:
        references = current.references()
        idle = [
            left
            for left, rights in current.rules.items()
            if left != current.start
            and len(rights) == 1
            and _saved(len(next(iter(rights))), references[left]) <= 0
        ]
        if not idle:
            return current
        spelled = {left: current.rules.pop(left).popitem()[0] for left in idle}
        old, current.rules = current.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                current.add(left, _spelled_out(right, spelled), count)


def _saved(length: int, number: int) -> int:
    """Symbols saved by a nonterminal that stands for so many occurrences of a string."""
    return number * (length - 1) - length - 2


def _spelled_out(right: Right, spelled: Mapping[int, Right]) -> Right:
    while any(symbol in spelled for symbol in right):
        right = tuple(s for old in right for s in spelled.get(old, (old,)))
    return right
