"""Cut strings into sentences: search for the partition of shortest description length.

The description length of a partition is the bits of the rules learned from its sentences, and of
the sentences given the rules. Learning rules in full takes seconds, so partitions compete:

1. *Candidates.* The paper's candidates do not divide a chosen repeat (``cutting``). But in strings
   of ten and more sentences, repeats cover about nine true borders in ten by chance. So others are
   cut without regard to repeats, or at all borders of one kind (``borders``).
2. *Race.* Rules are annealed for each candidate. The third with the fewest bits is annealed three
   times as often, and so on, until a few finalists are left.
3. *Improvement.* Each finalist is changed many times: its strings are cut again by the present
   rules (``reparsing``), or cuts of one kind are changed (``borders``), then rules annealed.
   A change that costs bits is accepted with a probability that decreases with cost and time.
4. *Result.* The grammar of the best partition is learned in full.

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
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar, GrammarError
from motiondb.grammar.induction.annealing import WARMEST, anneal
from motiondb.grammar.induction.induction import Induction, induce_with_bits
from motiondb.grammar.induction.perturbation import REWARMED, perturb
from motiondb.grammar.induction.refitting import refit
from motiondb.grammar.rules.description_length import DescriptionLength, Sentence
from motiondb.grammar.rules.repeats import join_strings
from motiondb.grammar.rules.rule_set import RuleSet, flat_rules
from motiondb.grammar.sentences.borders import (
    Cuts,
    border_places,
    change_alike,
    recurring_splits,
    too_long,
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

EVALUATIONS = 4000
"""Evaluations, unless given. The numbers of evaluations, annealings and changes in this module were
chosen by hand on strings of known grammars (docs/grammar.md)."""
_SEARCHES = 3
"""Searches for candidates: one that respects repeats, and two that do not."""
_FULLY_SEARCHED = 200
"""Symbols of all strings up to which all evaluations are spent, then fewer, to limit the time."""
_FINALISTS, _STEPS = 4, 6
"""Partitions that are improved (then half, then the best), and steps. Chosen by hand."""
_TRIES_A_SYMBOL, _MOST_TRIES = 25, 5000
"""Tries of an annealing for each symbol of the right sides, and at most."""
_CHANGES_A_SYMBOL, _EVALUATIONS_A_CHANGE = 2, 20
"""Most changes of a round per symbol of the strings, and evaluations that a change counts as."""
_FIRST_ANNEALINGS = 6
"""Annealings of each candidate in the first round; then three times as many. Chosen by hand."""
_FRESH, _WARM, _AGAIN = 1, 1, 4
"""Annealings for a change: from sentences, from perturbed rules, and the same if the cuts stay."""
_WARMTH = 0.01
"""First temperature of the changes, as a share of the bits. Chosen by hand; not tuned."""
_BY_RULES, _BY_KINDS = 0.4, 0.4
"""Shares of changes by the rules and by kinds; others keep the cuts. Chosen by hand; not tuned."""


@dataclass(frozen=True)
class Sentences:
    """A partition of strings, and the grammar learned from it.

    Attributes
    ----------
    cuts : tuple of tuples of int
        Places of the inner cuts of each string, ascending.
    sentences : tuple of tuples of str
        All sentences, string by string.
    induction : Induction
        The grammar, how it was found, and the description length.
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
class Judged:
    """A partition, the best rules annealed for it so far, and their description length in bits."""

    cuts: Cuts
    rules: RuleSet
    bits: float


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

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    rng : numpy.random.Generator
        Draws candidates, changes and annealings.
    shortest : int, optional
        Shortest sentence, in symbols.
    longest : int, optional
        Longest sentence, in symbols.
    evaluations : int, optional
        Effort: evaluations of candidates, and changes in proportion; fewer for long strings.
    progress : callable, optional
        Called with the number of steps done and the number of all steps.

    Raises
    ------
    GrammarError
        See :func:`motiondb.grammar.sentences.cutting.cutting_room`.
    """
    lengths = shortest, longest
    total = sum(map(len, strings))
    tell = progress or (lambda _done, _of: None)
    room = cutting_room(strings, *lengths)
    evaluations = max(1, round(evaluations * min(1.0, _FULLY_SEARCHED / total) ** 2))
    candidates = [
        *_searched(strings, room, lengths, rng, evaluations),
        *recurring_splits(strings, *lengths),
    ]
    candidates = [cuts for cuts in candidates if not too_long(strings, cuts, lengths)] or candidates
    tell(1, _STEPS)
    improved = race(strings, candidates, rng)
    tell(2, _STEPS)
    changes = min(evaluations // _EVALUATIONS_A_CHANGE, _CHANGES_A_SYMBOL * total)
    for heat, number in enumerate((_FINALISTS, _FINALISTS // 2, 1), start=3):
        spent = changes // number
        improved = [improve(strings, one, lengths, rng, spent) for one in improved[:number]]
        improved.sort(key=lambda judged: judged.bits)
        tell(heat, _STEPS)
    sentences = _learned(strings, improved[0].cuts, [improved[0].rules])
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


def race(
    strings: Sequence[Sentence], candidates: Sequence[Cuts], rng: np.random.Generator
) -> list[Judged]:
    """Select the candidates for which annealing finds the fewest bits.

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    candidates : sequence of Cuts
        Partitions of the strings; equal ones count once.
    rng : numpy.random.Generator
        Draws the annealings.

    Returns
    -------
    list of Judged
        Finalists, best first; those with different numbers of sentences before others.
    """
    number = _numbers(strings)
    live = [
        _judged(cuts, _flat(strings, cuts, number), rng, (_FIRST_ANNEALINGS, 0))
        for cuts in dict.fromkeys(candidates)
    ]
    times = _FIRST_ANNEALINGS
    while True:
        live.sort(key=lambda judged: judged.bits)
        kept = live[: max(_FINALISTS, len(live) // 3)]
        if len(kept) <= _FINALISTS:
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
    first = list(chosen.values())[:_FINALISTS]
    return [*first, *(one for one in judged if one not in first)][:_FINALISTS]


def improve(
    strings: Sequence[Sentence],
    begun: Judged,
    lengths: tuple[int, int],
    rng: np.random.Generator,
    changes: int,
) -> Judged:
    """Improve a partition by random changes (simulated annealing).

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    begun : Judged
        The partition to begin with.
    lengths : tuple of int
        Shortest and longest sentence, in symbols.
    rng : numpy.random.Generator
        Draws changes and annealings.
    changes : int
        Number of changes that are tried.

    Returns
    -------
    Judged
        The partition of fewest bits that was found; at worst ``begun``.
    """
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
            flat = _flat(strings, cuts, number)
            changed = _judged(cuts, flat, rng, (1, _AGAIN), [current.rules])
        elif cuts in seen or too_long(strings, cuts, lengths):
            continue
        else:
            flat = _flat(strings, cuts, number)
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
    candidates = [_annealed(flat, rng) for _ in range(fresh)]
    candidates += known if annealed else [_annealed(rules, rng, REWARMED) for rules in known]
    best = min(candidates, key=RuleSet.bits)
    for _ in range(repeated):
        apart = perturb(best, flat, _tries(flat), rng)
        if apart is not None:
            best = min(best, _annealed(apart, rng, REWARMED), key=RuleSet.bits)
    return Judged(cuts, best, best.bits())


def _annealed(begun: RuleSet, rng: np.random.Generator, warmest: float = WARMEST) -> RuleSet:
    return anneal(begun, rng, tries=_tries(begun), warmest=warmest)


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


def sentences_between(strings: Sequence[Sentence], cuts: Sequence[Sequence[int]]) -> Sentences:
    """Learn the grammar of a given partition.

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    cuts : sequence of sequences of int
        Inner cuts of each string: the place of the symbol that begins a sentence, from 0 on.

    Raises
    ------
    GrammarError
        The cuts of a string are not ascending places inside it, or a string is empty.
    """
    for number, (string, inner) in enumerate(zip(strings, cuts, strict=True), start=1):
        edges = [0, *inner, len(string)]
        if any(low >= high for low, high in pairwise(edges)):
            raise GrammarError(
                f"string {number}: expected rising cuts between 1 and {len(string) - 1}, found"
                f" {', '.join(map(str, inner)) or 'none in an empty string'}."
                " Give each cut as the number of the symbol that begins a sentence."
            )
    return _learned(strings, tuple(tuple(int(cut) for cut in inner) for inner in cuts))


def _learned(strings: Sequence[Sentence], cuts: Cuts, known: Sequence[RuleSet] = ()) -> Sentences:
    sentences = tuple(
        tuple(string[a:b])
        for string, inner in zip(strings, cuts, strict=True)
        for a, b in pairwise((0, *inner, len(string)))
    )
    return Sentences(cuts, sentences, induce_with_bits(sentences, known=known))
