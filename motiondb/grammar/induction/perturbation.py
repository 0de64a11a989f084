"""Perturb rules at random, so that a search that has stopped can continue from there.

Annealing ends in rules from which no small change saves bits. Five larger changes leave such a
minimum:

* *plant*: some nonterminals are put into the plain sentences (below);
* *forget*: some rules are removed, and new rules made for the sentences that used them;
* *split one*, *split all*: a nonterminal that occurs in several places is copied for one of them,
  or for each, so that symbols that were merged too early can become different;
* *sample*: the rules are annealed on some of the sentences only, without the constraints of others.

After each change the sentences are parsed again (:mod:`.refitting`), so that copies keep only the
rules that they use.

*Planting.* A search that has merged too much rarely splits it again, for rules do not record which
sentence uses which. Therefore it starts again from the sentences, with some of the nonterminals of
good rules. Each is put into the sentences, those it needs first, wherever one of its alternatives
occurs, so that as few symbols as possible are left. Among equally short results one is drawn at
random. Rules with loops are planted by parsing the sentences instead.

Sources: H. R. Lourenço, O. C. Martin and T. Stützle, "Iterated Local Search", Handbook of
Metaheuristics (2003); G. Schrimpf, J. Schneider, H. Stamm-Wilbrandt and G. Dueck, "Record Breaking
Optimization Results Using the Ruin and Recreate Principle", Journal of Computational Physics 159
(2000), for rules that are removed and built again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from motiondb.grammar.induction.annealing import anneal
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.refitting import refit
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
    return planted if is_lawful(planted) else None


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


REWARMED = 2.0
"""First temperature, bits, of an annealing that begins with learned rules: lower than for plain
sentences, so that the rules are not all lost."""

_PLANT, _FORGET, _SPLIT_ONE, _SPLIT_ALL, _SAMPLE = range(5)
"""The changes. Each is drawn equally often; their shares were not tuned."""

_MOST_FORGOTTEN = 3  # Largest number of rules that are removed at once

_LEAST_SHARE, _LARGEST_SHARE = 0.4, 0.9  # Share of the sentences in a sample


_BY_LENGTH = 0.5
"""Share of the samples that are the shortest sentences, where loops are allowed: these show what
repeats or nests with the fewest rounds."""


def perturb(
    rule_set: RuleSet, flat: RuleSet, tries: int, rng: np.random.Generator
) -> RuleSet | None:
    """Make one random change."""
    kind = int(rng.integers(5))
    if kind == _PLANT:
        return plant(flat, rule_set, rng)
    if kind == _SAMPLE:
        return _by_sample(rule_set, flat, tries, rng)
    if kind == _FORGET:
        return refit(forget(rule_set, int(rng.integers(1, _MOST_FORGOTTEN + 1)), rng), flat)
    copied = split(rule_set, kind == _SPLIT_ONE, rng)
    return None if copied is None else refit(copied, flat)


def forget(rule_set: RuleSet, number: int, rng: np.random.Generator) -> RuleSet:
    """Remove random rules, and the rules that need nonterminals without rules."""
    changed = rule_set.copy()
    for _ in range(number):
        rows = sorted(changed.uses())
        if not rows:
            break
        left, right = rows[int(rng.integers(len(rows)))]
        del changed.rules[left][right]
        lost = _without_rules(changed)
        while lost:
            for gone in lost:
                del changed.rules[gone]
            for rights in changed.rules.values():
                for right in [right for right in rights if not lost.isdisjoint(right)]:
                    del rights[right]
            lost = _without_rules(changed)
    return changed


def _without_rules(rule_set: RuleSet) -> set[int]:
    return {x for x, rights in rule_set.rules.items() if not rights and x != rule_set.start}


def split(rule_set: RuleSet, once: bool, rng: np.random.Generator) -> RuleSet | None:
    """Copy a random nonterminal that occurs in several places, for one or for each of them.

    >>> rules = RuleSet(2, {2: {(3, 0, 3): 2}, 3: {(0,): 2, (1,): 2}})
    >>> split(rules, False, np.random.default_rng(1)).rules
    {2: {(4, 0, 5): 2}, 4: {(0,): 2, (1,): 2}, 5: {(0,): 2, (1,): 2}}
    """
    references = rule_set.references()
    shared = [x for x in sorted(rule_set.rules) if x != rule_set.start and references[x] > 1]
    if not shared:
        return None
    symbol = shared[int(rng.integers(len(shared)))]
    chosen = int(rng.integers(references[symbol])) if once else -1
    changed = rule_set.copy()
    changed.rules = {left: {} for left in rule_set.rules}
    new, place = max(rule_set.rules) + 1, 0
    for left, right in sorted(rule_set.uses()):
        written = list(right)
        for k, old in enumerate(right):
            if old == symbol:
                if place == chosen or not once:
                    written[k] = new
                    changed.rules[new] = {}
                    new += 1
                place += 1
        changed.rules[left][tuple(written)] = rule_set.rules[left][right]
    for copy in range(max(rule_set.rules) + 1, new):
        changed.rules[copy] = dict(changed.rules[symbol])
    if not once:
        del changed.rules[symbol]
    return changed


def sample(flat: RuleSet, number: int, rng: np.random.Generator) -> RuleSet:
    """Return the flat rules of ``number`` random sentences; the laws are those of all."""
    rights = flat.rules[flat.start]
    order = sorted(rights)
    chosen = sorted(order[k] for k in rng.choice(len(order), number, replace=False))
    some = flat.copy()
    some.rules = {flat.start: {sentence: rights[sentence] for sentence in chosen}}
    return some


def shortest(flat: RuleSet, number: int) -> RuleSet:
    """Return the flat rules of the ``number`` shortest sentences; the laws are those of all.

    >>> shortest(RuleSet(2, {2: {(0, 0): 1, (0, 0, 1): 2, (1,): 4}}), 2).rules
    {2: {(1,): 4, (0, 0): 1}}
    """
    rights = flat.rules[flat.start]
    chosen = sorted(rights, key=lambda right: (len(right), right))[:number]
    return flat.with_rules({flat.start: {sentence: rights[sentence] for sentence in chosen}})


def _by_sample(
    rule_set: RuleSet, flat: RuleSet, tries: int, rng: np.random.Generator
) -> RuleSet | None:
    """Anneal the rules on a sample, then refit them to all sentences."""
    n = len(flat.rules[flat.start])
    share = rng.uniform(_LEAST_SHARE, _LARGEST_SHARE)
    number = min(n, max(2, int(n * share)))
    by_length = flat.loops and rng.random() < _BY_LENGTH
    begun = refit(rule_set, shortest(flat, number) if by_length else sample(flat, number, rng))
    if begun is None:
        return None
    return refit(anneal(begun, rng, tries=tries, warmest=REWARMED), flat)
