"""Cut strings into sentences: search for the partition of shortest description length.

The description length of a partition is the bits of the rules learned from its sentences, and of
the sentences given the rules. Learning rules in full takes seconds, so partitions compete:

1. *Candidates.* The paper's candidates do not divide a chosen repeat (``cutting``). But in strings
   of ten and more sentences, repeats cover about nine true borders in ten by chance. So others are
   cut without regard to repeats, or at all borders of one kind or of several (``borders``).
2. *Race.* Rules are annealed for each candidate. The third with the fewest bits is annealed three
   times as often, and so on, until a few finalists are left.
3. *Improvement.* Each finalist is changed many times: its strings are cut again by the present
   rules (``reparsing``), or cuts of one kind are changed (``borders``), then rules annealed.
   A change that costs bits is accepted with a probability that decreases with cost and time.
4. *Loops.* The best one is changed further, with rules that may loop. Loops that the sentences do
   not support are written out (:mod:`motiondb.grammar.induction.loop_evidence`), so that a
   partition does not win by loops that it cannot keep.
5. *Result.* The grammar of the partition of fewest bits is learned in full.

Ends of strings are always cuts. A sentence is shorter than the shortest only if it is a whole
string, and longer than the longest only if no other cut is allowed.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.2, for the description length of partitions and the
cover of repeats; O. Maron and A. W. Moore, "The Racing Algorithm", Artificial Intelligence Review
11 (1997), for races.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar, GrammarError
from motiondb.grammar.induction.annealing import WARMEST, anneal
from motiondb.grammar.induction.induction import Induction, induce_with_bits
from motiondb.grammar.induction.loop_evidence import keep_supported, rounds_asked
from motiondb.grammar.induction.perturbation import REWARMED, perturb
from motiondb.grammar.induction.refitting import refit, refit_fully
from motiondb.grammar.rules.description_length import DescriptionLength, Sentence
from motiondb.grammar.rules.rule_set import RuleSet, flat_rules, recursive_lefts
from motiondb.grammar.sentences.borders import (
    Cuts,
    border_places,
    change_alike,
    recurring_splits,
    too_long,
    united_splits,
)
from motiondb.grammar.sentences.cutting import (
    LONGEST,
    SHORTEST,
    Progress,
    Room,
    cutting_room,
    search_cuts,
)
from motiondb.grammar.sentences.reparsing import cut_by_rules
from motiondb.grammar.sentences.repeats import join_strings

FINALISTS = 4
"""Number of partitions that are improved. This and the numbers of annealings below were chosen
by hand on strings of known grammars (docs/measured/grammar.md)."""
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


EVALUATIONS = 4000
"""Default number of evaluations. The numbers of evaluations, annealings and changes in this
module were chosen by hand on strings of known grammars (docs/measured/grammar.md)."""
_SEARCHES = 3  # Searches for candidates: one that respects repeats, and two that do not
_FULLY_SEARCHED = 200
"""Number of symbols of all strings up to which all evaluations are made; for more symbols fewer,
to limit the time."""
_STEPS = 7  # Steps that the progress bar shows: candidates, race, three heats, loops, result
_CHANGES_A_SYMBOL, _EVALUATIONS_A_CHANGE = 2, 20
"""Largest number of changes of a round per symbol of the strings, and the number of evaluations
that a change counts as."""
_WITH_LOOPS = 0.5
"""Changes with loops allowed, as a share of those of a round. Chosen by hand, to bound the time."""


@dataclass(frozen=True)
class Sentences:
    """A partition of strings, and the grammar learned from it."""

    cuts: tuple[tuple[int, ...], ...]  # Places of the inner cuts of each string, ascending
    sentences: tuple[Sentence, ...]  # All sentences, string by string
    induction: Induction  # The grammar, how it was found, and the description length

    @property
    def grammar(self) -> Grammar:
        """The grammar learned from the sentences."""
        return self.induction.grammar

    @property
    def bits(self) -> DescriptionLength:
        """Bits of the rules, and of the sentences given the rules."""
        return self.induction.bits


def find_sentences(
    strings: Sequence[Sentence],
    rng: np.random.Generator,
    *,
    lengths: tuple[int, int] = (SHORTEST, LONGEST),
    evaluations: int = EVALUATIONS,
    progress: Progress | None = None,
) -> Sentences:
    """Cut strings of terminals into sentences and learn their grammar."""
    tell = progress or (lambda _done, _of: None)
    total = sum(map(len, strings))
    room = cutting_room(strings, *lengths)
    evaluations = max(1, round(evaluations * min(1.0, _FULLY_SEARCHED / total) ** 2))
    candidates = [
        *_searched(strings, room, lengths, rng, evaluations),
        *recurring_splits(strings, *lengths),
        *united_splits(strings, *lengths),
    ]
    candidates = [cuts for cuts in candidates if not too_long(strings, cuts, lengths)] or candidates
    tell(1, _STEPS)
    runs = race(strings, candidates, rng)
    tell(2, _STEPS)
    changes = min(evaluations // _EVALUATIONS_A_CHANGE, _CHANGES_A_SYMBOL * total)
    for heat, number in enumerate((FINALISTS, FINALISTS // 2, 1), start=1):
        some = [improve(strings, run, lengths, rng, changes // number) for run in runs[:number]]
        runs = sorted(some, key=lambda run: run.bits)
        tell(2 + heat, _STEPS)
    spent = math.ceil(_WITH_LOOPS * changes)
    best = improve(strings, runs[0], lengths, rng, spent, loops=True)
    tell(_STEPS - 1, _STEPS)
    sentences = _learned(strings, best.cuts, [best.rules])
    tell(_STEPS, _STEPS)
    return sentences


def _searched(
    strings: Sequence[Sentence],
    room: Room,
    lengths: tuple[int, int],
    rng: np.random.Generator,
    evaluations: int,
) -> Iterator[Cuts]:
    """Yield the best partition of each search: one in the covered room, two in the free room."""
    free = cutting_room(strings, *lengths, free=True)
    for searched in (room, free, free):
        cuts, _ = search_cuts(searched, rng, max(1, evaluations // _SEARCHES))
        yield _by_string(cuts, room)


def _by_string(cuts: Sequence[int], room: Room) -> Cuts:
    bounds = pairwise(room.bounds)
    return tuple(tuple(c - low for c in cuts if low < c < high) for low, high in bounds)


def sentences_between(
    strings: Sequence[Sentence],
    cuts: Sequence[Sequence[int]],
) -> Sentences:
    """Learn the grammar of a given partition.

    `cuts` holds the inner cuts of each string: the places, from 0, of symbols that begin a
    sentence.
    """
    for number, (string, inner) in enumerate(zip(strings, cuts, strict=True), start=1):
        edges = [0, *inner, len(string)]
        if any(low >= high for low, high in pairwise(edges)):
            raise GrammarError(
                f"string {number}: expected rising cuts between 1 and {len(string) - 1}, found"
                f" {', '.join(map(str, inner)) or 'none in an empty string'}."
                " Give each cut as the number of the symbol that begins a sentence."
            )
    return _learned(strings, tuple(tuple(int(cut) for cut in inner) for inner in cuts), ())


def _learned(strings: Sequence[Sentence], cuts: Cuts, known: Sequence[RuleSet]) -> Sentences:
    """Cut the strings and learn the grammar of the sentences; `known` are rules found before."""
    sentences = tuple(
        tuple(string[a:b])
        for string, inner in zip(strings, cuts, strict=True)
        for a, b in pairwise((0, *inner, len(string)))
    )
    return Sentences(cuts, sentences, induce_with_bits(sentences, known=known))
