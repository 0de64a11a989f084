"""Rewrite rules as long as the description length falls.

The plain sentences are annealed several times with different random numbers (:mod:`.annealing`).
Then, again and again, one of the best rule sets so far is perturbed and annealed
(:mod:`.perturbation`). The rule set of fewest bits is returned.

Many sentences are searched by samples first. A search that begins with all plain sentences rarely
splits what it merged wrongly in its first steps, and with more sentences, more wrong steps save
bits. The rules of each sample are then refitted to all sentences (:mod:`.refitting`), and the
search continues from the best of them.

Rules without loops are searched first. Then the search is repeated with loops allowed, into the
same pool. Half of its annealings begin with the shortest sentences and continue with more and more
of them, because nesting is easiest to recognise in short sentences. Rules that are found are
refitted, and loops that the sentences do not support are written out (:mod:`.loop_evidence`).

The random numbers are the same each time, so that the result depends on the sentences alone. The
more symbols the sentences have, the fewer searches there are.

At last, neighbours of recursive nonterminals are moved into their rules or out of them. If every
occurrence of A is followed by x, then A x derives the same strings as a nonterminal whose rules end
with x. This shortens rules such as ``S -> A b, A -> a A b | a`` to ``S -> a S b | a b``, which
annealing reaches only through rules of more bits. The language and the use of every rule stay the
same, so that whatever supports the loops still does. Conversely, ``S -> a A, A -> b A | b x``
becomes ``S -> a A x, A -> b A | b`` where this costs no bits, because the second A is a repetition
and is shown as one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.random import PCG64, Generator

from motiondb.grammar.induction.annealing import WARMEST, anneal
from motiondb.grammar.induction.loop_evidence import keep_supported, rounds_asked
from motiondb.grammar.induction.perturbation import REWARMED, perturb, plant, sample, shortest
from motiondb.grammar.induction.refitting import refit, refit_and_read
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet, recursive_lefts


def absorb_neighbours(rule_set: RuleSet) -> RuleSet:
    """Move common neighbours into recursive nonterminals as long as this saves bits.

    Constants and singles are left where they are: no loop may hold them.

    >>> rules = {2: {(3, 1): 2}, 3: {(0, 3, 1): 1, (0,): 2}}
    >>> absorb_neighbours(RuleSet(2, rules, loops=True)).rules
    {2: {(0, 2, 1): 1, (0, 1): 2}}
    """
    current = rule_set
    while True:
        tried = [
            absorbed
            for left in sorted(recursive_lefts(current.rules))
            for after in (True, False)
            if (absorbed := _absorb(current, left, after)) is not None
        ]
        best = min(tried, key=RuleSet.bits, default=current)
        if best.bits() >= current.bits() - 1e-9:
            return current
        current = best


def release_ends(rule_set: RuleSet) -> RuleSet:
    """Move the common end of a repetition out of its rules where this costs no bits.

    >>> rules = {3: {(0, 4): 2}, 4: {(1, 4): 1, (1, 2): 2}}
    >>> release_ends(RuleSet(3, rules, loops=True)).rules
    {3: {(0, 4, 2): 2}, 4: {(1, 4): 1, (1,): 2}}
    """
    current = rule_set
    for left in sorted(recursive_lefts(rule_set.rules) - {rule_set.start}):
        for after in (True, False):
            released = _release(current, left, after)
            if released is not None and released.bits() <= current.bits() + 1e-9:
                current = released
    return current


def _release(rule_set: RuleSet, left: int, after: bool) -> RuleSet | None:
    """Return the rules with the common end of ``left`` outside; None if it has none.

    ``after`` tells whether it is the end of a repetition to the right, or the begin of one to the
    left.
    """
    edge = -1 if after else 0
    rights = rule_set.rules[left]
    again = [right for right in rights if left in right]
    others = [right for right in rights if left not in right]
    if any(right.count(left) > 1 or right[edge] != left for right in again):
        return None
    if not again or any(len(right) < 2 for right in others):
        return None
    ends = {right[edge] for right in others}
    (end,) = ends if len(ends) == 1 else (None,)
    if end is None or end >= rule_set.n_terminals:
        return None
    kept = slice(None, -1) if after else slice(1, None)
    rules: Rules = {}
    for symbol, uses in rule_set.rules.items():
        rules[symbol] = {}
        for right, count in uses.items():
            if symbol != left:
                changed = _with(right, left, end, after)
            else:
                changed = right if left in right else right[kept]
            rules[symbol][changed] = rules[symbol].get(changed, 0) + count
    return rule_set.with_rules(rules)


def _with(right: Right, left: int, end: int, after: bool) -> Right:
    """The right side with ``end`` beside each occurrence of ``left``."""
    pair = (left, end) if after else (end, left)
    return tuple(one for symbol in right for one in (pair if symbol == left else (symbol,)))


def _absorb(rule_set: RuleSet, left: int, after: bool) -> RuleSet | None:
    """Return the rules with the neighbour in the rules of ``left``; None if there is no common one.

    ``after`` tells whether it is the neighbour that follows, or the one that precedes.
    """
    neighbours = {
        _neighbour(right, k, after)
        for _, right in rule_set.uses()
        for k, symbol in enumerate(right)
        if symbol == left
    }
    (neighbour,) = neighbours if len(neighbours) == 1 else (None,)
    held = {*rule_set.constants, *rule_set.singles}
    if neighbour is None or neighbour == left or neighbour in held or left == rule_set.start:
        return None
    if neighbour >= rule_set.n_terminals:
        return None
    rules: Rules = {}
    for symbol, rights in rule_set.rules.items():
        changed: dict[Right, int] = {}
        for right, count in rights.items():
            short = _without(right, left, after)
            if symbol == left:
                short = (*short, neighbour) if after else (neighbour, *short)
            changed[short] = changed.get(short, 0) + count
        rules[symbol] = changed
    return rule_set.with_rules(rules).without_idle_start()


def _neighbour(right: Right, k: int, after: bool) -> int | None:
    beside = k + 1 if after else k - 1
    return right[beside] if 0 <= beside < len(right) else None


def _without(right: Right, left: int, after: bool) -> Right:
    """The right side without the neighbour of each occurrence of ``left``."""
    dropped = {k + 1 if after else k - 1 for k, symbol in enumerate(right) if symbol == left}
    return tuple(symbol for k, symbol in enumerate(right) if k not in dropped)


Pool = dict[float, RuleSet]  # Rule sets by their bits without an idle start symbol, rounded

_ELITE = 16  # Number of rule sets of fewest bits from which one is drawn to be perturbed

_CARRIED = 2  # Number of rule sets of a sample that are refitted to all sentences

_SEED = 1  # Seed of the search: the same for all sentences

_EFFORTS = ((20, 10, 20, 30), (50, 60, 160, 30), (170, 80, 600, 20))
"""Symbols up to which an effort is spent; searches from plain sentences, searches from perturbed
rules, and tries of each search for each symbol. Chosen by ``benchmarks/grammar_tasks/effort.py`` as
the least effort that reaches the true grammar's bits as often as more does."""

_FEWEST_TRIES = 200  # Smallest number of tries of each search

_TRIES_A_SYMBOL, _MOST_TRIES = 30, 40_000
"""Tries of each search for each symbol, and at most, for more symbols than ``_EFFORTS`` knows.
Chosen by ``benchmarks/grammar_tasks/effort.py``."""

_SAMPLES, _SAMPLE_SIZE = 6, 160
"""Samples, and symbols of each. Chosen by ``benchmarks/grammar_tasks/effort.py``: about as many
symbols as are searched well without samples."""

_SHORTEST_SIZE = 80, 240  # Symbols of a sample of the shortest sentences, between these

_FIRST_SIZE = 50, 170
"""Symbols of the shortest sentences that a search with loops begins with, between these. It is the
size at which the rules of nested languages were found most often."""

_FIRST_TRIES_A_SYMBOL = 1000
"""Tries for each symbol of these sentences. With 30, rules that nest in two ways (arithmetic, two
kinds of brackets) were never found in ten searches, with 400 once, with 1,000 four times."""

_THOROUGH = 8  # Number of searches with this many tries. Chosen by hand, to bound the time

_OF_SAMPLE = 10, 60  # Searches from plain sentences and from perturbed rules of each sample

_OF_ALL = 20, 100  # Searches of all sentences after the samples

_FIRST_LOOPS = 1 / 3
"""Share of the searches from perturbed rules with loops after which the search ends if no loop is
among the best rules: languages without loops then take less time."""

_WORTH_REFITTING = 1.05
"""Rules with loops of more than this many times the bits of those that are perturbed further are
dropped at once, also while their loops are written out: refitting rarely saves so much."""

_NEW_LOOPS = 0.5  # Share of the annealings of rules with loops that may make further loops

_LARGE = 800
"""Number of symbols above which there are fewer searches of all sentences, to bound the time."""


@dataclass(frozen=True)
class Effort:
    """Effort of the search."""

    begun: int  # Searches from the plain sentences
    repeated: int  # Searches from perturbed rules
    tries: int  # Tries of each search
    samples: int = 0  # Samples that are searched first, 0 for none
    sampled: int = 0  # Sentences of each sample
    # Whether nonterminals may derive themselves where the sentences support it
    # (:mod:`.loop_evidence`). The search is then repeated with loops allowed
    loops: bool = True


def effort_for(flat: RuleSet) -> Effort:
    """Return the effort for flat rules of this size: a few seconds on an idle machine."""
    size = _size(flat)
    for most, begun, repeated, tries in _EFFORTS:
        if size <= most:
            return Effort(begun, repeated, max(_FEWEST_TRIES, tries * size))
    n = len(flat.rules[flat.start])
    sampled = max(2, n * _SAMPLE_SIZE // size)
    tries = min(_TRIES_A_SYMBOL * size, _MOST_TRIES)
    begun, repeated = (max(2, min(times, times * _LARGE // size)) for times in _OF_ALL)
    return Effort(begun, repeated, tries, _SAMPLES if sampled < n else 0, sampled)


def compact(
    flat: RuleSet,
    donors: Sequence[RuleSet] = (),
    *,
    effort: Effort | None = None,
) -> RuleSet:
    """Search the rule set of fewest bits.

    Parameters
    ----------
    flat : RuleSet
        One rule for each sentence.
    donors : sequence of RuleSet
        Rule sets of the same terminals whose nonterminals may be put into the sentences.
    effort : Effort, optional
        Effort of the search; by default that of :func:`effort_for`.
    """
    effort = effort or effort_for(flat)
    rng = Generator(PCG64(_SEED))  # a fixed seed: the result depends on the sentences only
    pool: Pool = {}
    _keep(pool, flat)
    _search_all(pool, Search(flat, effort, rounds=0, rng=rng), donors)
    if effort.loops:
        looping = replace(flat, loops=True)
        _search_all(pool, Search(looping, effort, rounds=rounds_asked(flat), rng=rng), donors)
    return release_ends(absorb_neighbours(pool[min(pool)]))


@dataclass(frozen=True, eq=False)
class Search:
    """Settings and data of a search."""

    flat: RuleSet  # One rule for each sentence, and the laws
    effort: Effort  # Effort of the search
    rounds: int  # Rounds of a loop that some sentence must have
    rng: np.random.Generator
    # Bits and empty right sides of the rules with loops that were judged. Rules that agree in both
    # are assumed to be the same and are not judged again
    judged: set[tuple[float, int]] = field(default_factory=set)

    def anneal(self, pool: Pool, begun: RuleSet, tries: int, warmest: float) -> None:
        """Anneal rules; the result is added to the pool.

        If loops are allowed, rules as good as the best of the pool are refitted first, and loops
        that the sentences do not support are written out.
        """
        if not self.flat.loops:
            _keep(pool, anneal(begun, self.rng, tries=tries, warmest=warmest))
            return
        new_loops = not recursive_lefts(begun.rules) or self.rng.random() < _NEW_LOOPS
        annealed = anneal(begun, self.rng, tries=tries, warmest=warmest, new_loops=new_loops)
        bits = round(annealed.bits(), 6)
        key = bits, _n_empty(annealed)
        worst = _WORTH_REFITTING * max(sorted(pool)[:_ELITE])
        if key not in self.judged and bits < worst:
            self.judged.add(key)
            fitted, parsed = refit_and_read(annealed, self.flat)
            most = worst if len(pool) >= _ELITE else math.inf
            kept = keep_supported(fitted, self.flat, self.rounds, parsed, most)
            if kept is not None:
                _keep(pool, kept)


def _search_all(pool: Pool, search: Search, donors: Sequence[RuleSet]) -> None:
    """Search by samples, from the plain sentences, from donors, and from perturbed rules."""
    flat, effort = search.flat, search.effort
    n = len(flat.rules[flat.start])
    for number in range(effort.samples):
        by_length = flat.loops and number % 2 == 0
        some = shortest(flat, _fitting(flat, _SHORTEST_SIZE, search.rng)) if by_length else None
        _search_sample(pool, search, some or sample(flat, effort.sampled, search.rng))
    for number in range(effort.begun):
        if flat.loops and number % 2 == 0 and n > 2:
            many = number < 2 * _THOROUGH
            _search_shortest(pool, search, _FIRST_TRIES_A_SYMBOL if many else _TRIES_A_SYMBOL)
        else:
            search.anneal(pool, flat, effort.tries, WARMEST)
    for donor in donors:
        planted = plant(flat, donor, search.rng)
        if planted is not None:
            search.anneal(pool, planted, effort.tries, WARMEST)
    if not flat.loops:
        _search_perturbed(pool, search, effort.repeated)
        return
    first = math.ceil(effort.repeated * _FIRST_LOOPS)
    _search_perturbed(pool, search, first)
    if any(recursive_lefts(pool[bits].rules) for bits in sorted(pool)[:_ELITE]):
        _search_perturbed(pool, search, effort.repeated - first)


def _search_perturbed(pool: Pool, search: Search, times: int) -> None:
    """Perturb and anneal one of the best ``times`` times; the results go into the pool."""
    for _ in range(times):
        best = sorted(pool)[:_ELITE]
        chosen = pool[best[int(search.rng.integers(len(best)))]]
        begun = perturb(chosen, search.flat, search.effort.tries, search.rng)
        if begun is not None:
            search.anneal(pool, begun, search.effort.tries, REWARMED)


def _fitting(flat: RuleSet, between: tuple[int, int], rng: np.random.Generator) -> int:
    """Return how many of the shortest sentences have a random number of symbols together."""
    sizes = np.cumsum(sorted(len(right) + 2 for right in flat.rules[flat.start]))
    most = rng.uniform(*between)
    return max(2, int(np.searchsorted(sizes, most, side="right")))


def _search_shortest(pool: Pool, search: Search, first_tries: int) -> None:
    """Anneal the rules of the shortest sentences, then these rules for more and more sentences.

    ``first_tries`` are the tries for each symbol of the shortest sentences.
    """
    flat, n = search.flat, len(search.flat.rules[search.flat.start])
    number = min(n, _fitting(flat, _FIRST_SIZE, search.rng))
    best = shortest(flat, number)
    tries, warmest = first_tries, WARMEST
    while number < n:
        best = anneal(best, search.rng, tries=tries * _size(best), warmest=warmest)
        number, tries, warmest = min(n, 1 + number * 3 // 2), _TRIES_A_SYMBOL, REWARMED
        refitted = refit(best, shortest(flat, number))
        if refitted is None:
            return
        best = refitted
    tries = max(search.effort.tries, tries * _size(best))
    search.anneal(pool, best, tries, warmest)


def _search_sample(pool: Pool, search: Search, some: RuleSet) -> None:
    """Search a sample and refit its best rules to all sentences; they go into the pool."""
    flat, effort = search.flat, search.effort
    size = _size(some)
    tries = min(_TRIES_A_SYMBOL * size, effort.tries)
    begun, repeated = (max(2, min(n, n * _SAMPLE_SIZE // size)) for n in _OF_SAMPLE)
    of_sample: Pool = {}
    _keep(of_sample, some)
    inner = replace(search, flat=some, effort=replace(effort, tries=tries), judged=set())
    for _ in range(begun):
        inner.anneal(of_sample, some, tries, WARMEST)
    _search_perturbed(of_sample, inner, repeated)
    for bits in sorted(of_sample)[:_CARRIED]:
        refitted = refit(of_sample[bits], flat)
        if refitted is not None:
            search.anneal(pool, refitted, effort.tries, REWARMED)


def _keep(pool: Pool, rules: RuleSet) -> None:
    """Add rules to the pool; of rules of equal bits, those with fewer empty right sides."""
    bits = round(rules.without_idle_start().bits(), 6)
    if bits not in pool or _n_empty(rules) < _n_empty(pool[bits]):
        pool[bits] = rules


def _n_empty(rules: RuleSet) -> int:
    return sum(not right for _, right in rules.uses())


def _size(rule_set: RuleSet) -> int:
    """Symbols of all rules, with left sides and separators."""
    return sum(len(right) + 2 for _, right in rule_set.uses())
