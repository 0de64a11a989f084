"""Put nonterminals of one rule set into plain sentences: another beginning for a search.

A search that has merged too much rarely splits it again, for rules do not record which sentence
uses which. Therefore it starts again from the sentences, with some of the nonterminals of good
rules. Each is put into the sentences, those it needs first, wherever one of its alternatives
occurs, so that as few symbols as possible are left. Among equally short results one is drawn at
random. Rules with loops are planted by parsing the sentences instead.

Source: to begin again from parts of the best result so far is iterated local search; H. R.
Lourenço, O. C. Martin and T. Stützle, "Iterated Local Search", Handbook of Metaheuristics (2003).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from motiondb.grammar.induction.support.refitting import refit
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet

_SHARE = 0.5  # Probability that a nonterminal is planted: any subset is equally likely

_TIE = 1e-6  # Random cost by which ties are broken: far less than one symbol


def plant(flat: RuleSet, donor: RuleSet, rng: np.random.Generator) -> RuleSet | None:
    """Put random nonterminals of a donor into sentences."""
    lefts = sorted(left for left in donor.rules if left != donor.start)
    if not lefts:
        return None
    chosen: set[int] = set()
    for left in lefts:
        if rng.random() < _SHARE:
            chosen.update(_descendants(donor, left))
    order = donor.order()
    if order is None:  # sentences are covered by the chosen nonterminals
        rules: Rules = {left: donor.rules[left] for left in sorted(chosen - {donor.start})}
        return refit(donor.with_rules({donor.start: {}, **rules}), flat)
    rights = flat.rules[flat.start]
    planted = flat.copy()
    for left in reversed(order):
        if left not in chosen:
            continue
        rights, used = _shorten_all(rights, left, donor.rules[left], rng)
        if used:
            planted.rules[left] = dict(used)
    planted.rules[planted.start] = dict(rights)
    planted.drop_unused()
    return planted if planted.lawful() else None


def _descendants(donor: RuleSet, left: int) -> list[int]:
    """Return a nonterminal and all nonterminals that it leads to."""
    reached = [left]
    for symbol in reached:
        for right in donor.rules[symbol]:
            reached.extend(s for s in dict.fromkeys(right) if s in donor.rules and s not in reached)
    return reached


def _shorten_all(
    rights: Mapping[Right, int],
    left: int,
    alternatives: Mapping[Right, int],
    rng: np.random.Generator,
) -> tuple[Counter[Right], Counter[Right]]:
    """Put ``left`` into right sides; return them, and how often each alternative was replaced."""
    shortened: Counter[Right] = Counter()
    used: Counter[Right] = Counter()
    parts = [part for part in alternatives if part]
    for right, count in rights.items():
        written, replaced = _shorten(right, left, parts, rng)
        shortened[written] += count
        for part in replaced:
            used[part] += count
    return shortened, used


def _shorten(
    right: Right, left: int, parts: list[Right], rng: np.random.Generator
) -> tuple[Right, list[Right]]:
    """Return the right side in the fewest symbols, and the parts that ``left`` replaces."""
    n = len(right)
    fewest = [0.0] * (n + 1)
    chosen: list[Right | None] = [None] * n
    for i in range(n - 1, -1, -1):
        least = 1.0 + fewest[i + 1]
        best: Right | None = None
        for part in parts:
            if right[i] == part[0] and right[i : i + len(part)] == part:
                cost = 1.0 - _TIE * rng.random() + fewest[i + len(part)]
                if cost < least:
                    least, best = cost, part
        fewest[i], chosen[i] = least, best
    written: list[int] = []
    replaced: list[Right] = []
    i = 0
    while i < n:
        taken = chosen[i]
        if taken is None:
            written.append(right[i])
            i += 1
        else:
            written.append(left)
            replaced.append(taken)
            i += len(taken)
    return tuple(written), replaced
