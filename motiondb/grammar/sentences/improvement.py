"""Improve partitions of strings: races of annealings, and random changes of the cuts.

A partition is judged by the best rules that annealing finds for its sentences. Where loops are
allowed, loops that the sentences do not support are written out first
(:mod:`motiondb.grammar.induction.support.loop_evidence`), so that a partition does not win by loops
that it cannot keep.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.grammar.induction.annealing import WARMEST, anneal
from motiondb.grammar.induction.perturbation import REWARMED, perturb
from motiondb.grammar.induction.support.loop_evidence import keep_supported, rounds_asked
from motiondb.grammar.induction.support.refitting import refit, refit_fully
from motiondb.grammar.rules.description_length import Sentence
from motiondb.grammar.rules.repeats import join_strings
from motiondb.grammar.rules.rule_laws import recursive_lefts
from motiondb.grammar.rules.rule_set import RuleSet, flat_rules
from motiondb.grammar.sentences.borders import Cuts, border_places, change_alike, too_long
from motiondb.grammar.sentences.reparsing import cut_by_rules

FINALISTS = 4
"""Number of partitions that are improved. This and the numbers of annealings below were chosen
by hand on strings of known grammars (docs/grammar.md)."""
_TRIES_A_SYMBOL, _MOST_TRIES = 25, 5000
"""Number of tries of an annealing for each symbol of the right sides, and the largest number."""
_FIRST_ANNEALINGS = 6
"""Annealings of each candidate in the first round of the race; three times as many in the next."""
_FRESH, _WARM, _AGAIN = 1, 1, 4
"""Number of annealings for a change: from sentences, from perturbed rules, and the same if the
cuts stay."""
_WARMTH = 0.01  # First temperature of the changes, as a share of the bits
_BY_RULES, _BY_KINDS = 0.4, 0.4  # Shares of changes by the rules and by kinds; others keep the cuts


@dataclass(frozen=True, eq=False)
class Judged:
    """A partition, the best rules annealed for it so far, and their description length in bits."""

    cuts: Cuts
    rules: RuleSet
    bits: float


def race(
    strings: Sequence[Sentence], candidates: Sequence[Cuts], rng: np.random.Generator
) -> list[Judged]:
    """Select the candidates for which annealing finds the fewest bits."""
    number = _numbers(strings)
    live = [
        _judged(cuts, _flat(strings, cuts, number), rng, (_FIRST_ANNEALINGS, 0))
        for cuts in dict.fromkeys(candidates)
    ]
    times = _FIRST_ANNEALINGS
    while True:
        live.sort(key=lambda judged: judged.bits)
        kept = live[: max(FINALISTS, len(live) // 3)]
        if len(kept) <= FINALISTS:
            return _unlike(live)
        times *= 3
        live = [
            _judged(
                one.cuts,
                _flat(strings, one.cuts, number),
                rng,
                (times // 2, times // 2),
                [one.rules],
            )
            for one in kept
        ]


def _unlike(judged: Sequence[Judged]) -> list[Judged]:
    """Return finalists: the best of each number of sentences, then others if these are too few."""
    chosen: dict[int, Judged] = {}
    for one in judged:
        chosen.setdefault(sum(map(len, one.cuts)), one)
    first = list(chosen.values())[:FINALISTS]
    return [*first, *(one for one in judged if one not in first)][:FINALISTS]


def improve(
    strings: Sequence[Sentence],
    begun: Judged,
    lengths: tuple[int, int],
    rng: np.random.Generator,
    changes: int,
    *,
    loops: bool = False,
) -> Judged:
    """Improve a partition by random changes (simulated annealing)."""
    number, places = _numbers(strings), border_places(strings)
    current = best = begun
    seen = {begun.cuts}
    for done in range(changes):
        kind = rng.random()
        if kind < _BY_RULES:
            cuts = _cut_anew(strings, current.rules, lengths, rng)
        elif kind < _BY_RULES + _BY_KINDS:
            cuts = change_alike(strings, places, current.cuts, lengths[0], rng)
        else:
            cuts = current.cuts
        if cuts == current.cuts:
            flat = replace(_flat(strings, cuts, number), loops=loops)
            changed = _judged(cuts, flat, rng, (1, _AGAIN), [current.rules])
        elif cuts in seen or too_long(strings, cuts, lengths):
            continue
        else:
            flat = replace(_flat(strings, cuts, number), loops=loops)
            refitted = refit(current.rules, flat)
            known = [] if refitted is None else [refitted]
            changed = _judged(cuts, flat, rng, (_FRESH, _WARM), known, annealed=False)
        seen.add(cuts)
        warmth = _WARMTH * best.bits * (1.0 - done / changes)
        if changed.bits <= current.bits or rng.random() < math.exp(
            (current.bits - changed.bits) / warmth
        ):
            current = changed
            best = min(best, current, key=lambda judged: judged.bits)
    return best


def _cut_anew(
    strings: Sequence[Sentence],
    rules: RuleSet,
    lengths: tuple[int, int],
    rng: np.random.Generator,
) -> Cuts:
    """Cut by the rules with random prices, whose ranges were chosen by hand and are not tuned."""
    symbols, bounds = join_strings(strings)
    shaken = 4.0 * rng.random() * rng.exponential(size=symbols.size)
    novelty = rng.uniform(0.3, 1.2)
    return cut_by_rules(
        symbols, bounds, rules, lengths, novelty=novelty, shaken=shaken - shaken.mean()
    )


def _judged(
    cuts: Cuts,
    flat: RuleSet,
    rng: np.random.Generator,
    times: tuple[int, int],
    known: Sequence[RuleSet] = (),
    annealed: bool = True,
) -> Judged:
    """Return a partition with the best rules that are known or annealed for it.

    ``flat`` has one rule for each sentence; ``times`` are the annealings from it, and then from
    perturbed rules; ``annealed`` says whether the ``known`` rules were annealed before.
    """
    fresh, repeated = times
    best = flat
    for _ in range(fresh):
        best = _better(best, flat, flat, rng, WARMEST)
    for rules in known:
        if annealed:
            best = min(best, rules, key=RuleSet.bits)
        else:
            best = _better(best, replace(rules, loops=flat.loops), flat, rng, REWARMED)
    for _ in range(repeated):
        apart = perturb(best, flat, _tries(flat), rng)
        if apart is not None:
            best = _better(best, apart, flat, rng, REWARMED)
    return Judged(cuts, best, best.bits())


def _better(
    best: RuleSet, begun: RuleSet, flat: RuleSet, rng: np.random.Generator, warmest: float
) -> RuleSet:
    """Anneal rules; return the result, with its loops, if it takes fewer bits than the best."""
    annealed = anneal(begun, rng, tries=_tries(begun), warmest=warmest)
    if annealed.bits() >= best.bits():
        return best
    if not recursive_lefts(annealed.rules):
        return annealed
    kept = keep_supported(refit_fully(annealed, flat), flat, rounds_asked(flat))
    return best if kept is None else min(best, kept, key=RuleSet.bits)


def _tries(begun: RuleSet) -> int:
    size = sum(len(right) for _, right in begun.uses())
    return min(_MOST_TRIES, max(200, _TRIES_A_SYMBOL * size))


def _numbers(strings: Sequence[Sentence]) -> dict[str, int]:
    names = sorted({name for string in strings for name in string})
    return {name: place for place, name in enumerate(names)}


def _flat(strings: Sequence[Sentence], cuts: Cuts, number: dict[str, int]) -> RuleSet:
    """Return the rules with one right side of the start symbol for each different sentence."""
    counted: Counter[tuple[int, ...]] = Counter()
    for string, inner in zip(strings, cuts, strict=True):
        for a, b in pairwise((0, *inner, len(string))):
            counted[tuple(number[name] for name in string[a:b])] += 1
    return flat_rules(counted, len(number))
