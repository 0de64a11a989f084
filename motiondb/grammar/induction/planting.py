"""Nonterminals of one grammar planted into the plain sentences: what a new search may begin from.

A search that has united too much seldom parts it again, for the rules do not tell which sentence
used which. So it begins anew from the sentences, with some of the nonterminals that a good grammar
has: each, those it needs first, is put into the sentences wherever one of its alternatives stands,
so that as few symbols as possible are left; of equally short readings one is drawn at random.

The idea of beginning anew from parts of the best found so far is iterated local search; H. R.
Lourenço, O. C. Martin and T. Stützle, "Iterated Local Search", Handbook of Metaheuristics (2003).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from motiondb.grammar.induction.proposals import chance
from motiondb.grammar.rules.rule_set import Right, RuleSet

SeedArray = npt.NDArray[np.uint64]
_CHANCE = 0.5


def plant(flat: RuleSet, donor: RuleSet, state: SeedArray) -> RuleSet | None:
    """The flat rules with some of the donor's nonterminals, drawn at random, in place of strings.

    state : array (1,), of the random numbers (``proposals.next_bits``); it goes on.

    None where the donor has no nonterminals, or what results breaks the laws.
    """
    lefts = sorted(left for left in donor.rules if left != donor.start)
    order = donor.order()
    if not lefts or order is None:
        return None
    chosen: set[int] = set()
    for left in lefts:
        if chance(state) < _CHANCE:
            chosen.update(_below(donor, left))
    rights = flat.rules[flat.start]
    planted = flat.copy()
    for left in reversed(order):
        if left not in chosen:
            continue
        rights, used = _read(rights, left, donor.rules[left], state)
        if used:
            planted.rules[left] = dict(used)
    planted.rules[planted.start] = dict(rights)
    planted.drop_unused()
    return planted if planted.lawful() else None


def _below(donor: RuleSet, left: int) -> list[int]:
    found = [left]
    for symbol in found:
        for right in donor.rules[symbol]:
            found.extend(s for s in dict.fromkeys(right) if s in donor.rules and s not in found)
    return found


def _read(
    rights: Mapping[Right, int],
    left: int,
    alternatives: Mapping[Right, int],
    state: SeedArray,
) -> tuple[Counter[Right], Counter[Right]]:
    """Right sides with ``left`` for its alternatives, and how often each alternative was read."""
    found: Counter[Right] = Counter()
    used: Counter[Right] = Counter()
    parts = [part for part in alternatives if part]
    for right, count in rights.items():
        written, pieces = _shortest(right, left, parts, state)
        found[written] += count
        for part in pieces:
            used[part] += count
    return found, used


def _shortest(
    right: Right, left: int, parts: list[Right], state: SeedArray
) -> tuple[Right, list[Right]]:
    """The right side in the fewest symbols, and the parts for which ``left`` stands."""
    n = len(right)
    fewest = [0.0] * (n + 1)
    chosen: list[Right | None] = [None] * n
    for i in range(n - 1, -1, -1):
        least = 1.0 + fewest[i + 1]
        best: Right | None = None
        for part in parts:
            if right[i] == part[0] and right[i : i + len(part)] == part:
                # a hair less than a symbol left as it is; equals part by chance
                cost = 1.0 - 1e-6 * chance(state) + fewest[i + len(part)]
                if cost < least:
                    least, best = cost, part
        fewest[i], chosen[i] = least, best
    written: list[int] = []
    pieces: list[Right] = []
    i = 0
    while i < n:
        taken = chosen[i]
        if taken is None:
            written.append(right[i])
            i += 1
        else:
            written.append(left)
            pieces.append(taken)
            i += len(taken)
    return tuple(written), pieces
