"""Rules rewritten as long as the description length falls.

Alignment-based learning proposes; description length disposes. The plain sentences are annealed
many times over (``annealing``), each time with other random numbers. Then again, each time with
some of the nonterminals planted into them that one of the best rule sets so far has, or that
alignment-based learning has found (``planting``). What takes the fewest bits is returned.

The random numbers are the same each time, so the result depends on the sentences alone. The more
symbols there are, the longer and the fewer are the searches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.annealing import anneal
from motiondb.grammar.planting import plant
from motiondb.grammar.proposals import draw
from motiondb.grammar.rule_set import Right, RuleSet

_ELITE = 16
"""Rule sets, those of fewest bits, whose nonterminals are planted."""

_SEED = 1
"""Of the random numbers, which are the same for all sentences (``proposals.next_bits``)."""


@dataclass(frozen=True)
class Effort:
    """Searches from the plain sentences, rounds of searches from planted ones, searches a round;
    and tries of each search."""

    begun: int
    rounds: int
    planted: int
    tries: int


def effort_for(flat: RuleSet) -> Effort:
    """What is spent on so many symbols: a second or two at most, where the machine is idle."""
    size = sum(len(right) + 2 for _, right in flat.uses())
    for most, begun, rounds, planted in _EFFORTS:
        if size <= most:
            return Effort(begun, rounds, planted, max(200, _TRIES_A_SYMBOL * size))
    return Effort(2, 1, 2, 40_000)


_TRIES_A_SYMBOL = 60
_EFFORTS = ((20, 10, 2, 10), (50, 60, 4, 40), (150, 80, 12, 60), (300, 20, 3, 20), (600, 4, 2, 4))


def compact(
    flat: RuleSet, donors: Sequence[RuleSet] = (), *, effort: Effort | None = None
) -> RuleSet:
    """The rule set of fewest bits that annealing from the plain sentences finds.

    donors : further rule sets, of the same terminals, whose nonterminals may be planted.
    """
    effort = effort or effort_for(flat)
    state = np.array([_SEED], dtype=np.uint64)
    pool: dict[float, RuleSet] = {round(flat.bits(), 6): flat}

    def search(begin: RuleSet | None) -> None:
        if begin is not None:
            found = anneal(begin, tries=effort.tries, seed=int(draw(state, 1 << 30)))
            pool.setdefault(round(found.bits(), 6), found)

    for _ in range(effort.begun):
        search(flat)
    for donor in donors:
        search(plant(flat, donor, state))
    for _ in range(effort.rounds):
        elite = [pool[bits] for bits in sorted(pool)[:_ELITE]]
        for _ in range(effort.planted):
            search(plant(flat, elite[draw(state, len(elite))], state))
    return pool[min(pool)]


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
