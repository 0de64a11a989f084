"""Rules over classes of terminals: terminals that may stand for one action form a nonterminal.

If an action is shown by several terminals (a kick with either leg), every rule that holds the
action occurs in as many forms, and the search for rules loses its way: to make a class of two
terminals costs bits, and only a whole class saves them. Here a partition of the terminals into
classes is given (:mod:`motiondb.grammar.terminals.likeness`). Each terminal is replaced by its
class, rules are searched for these strings, and then each class X becomes a nonterminal with the
rules X -> t | t' | ... So the result is a grammar of the terminals, whose bits can be compared with
those of other rules. The description length decides whether classes are used, and which.

The laws of rule sets (:mod:`motiondb.grammar.rules.rule_set`) hold for the classes: if ten
sentences hold a class and none holds it twice, no string holds it twice.

Source: P. F. Brown et al., "Class-based n-gram models of natural language", Computational
Linguistics 18 (1992), for classes chosen by the bits of the whole.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import inf

from numpy.random import PCG64, Generator

from motiondb.grammar.induction.annealing import anneal
from motiondb.grammar.induction.induction import Induction, induce_with_bits
from motiondb.grammar.induction.rule_compaction import compact
from motiondb.grammar.rules.description_length import Sentence
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet, flat_rules
from motiondb.grammar.terminals.likeness import Classes

_SEED = 1
"""Seed of the search: the same for all sentences, as in
:mod:`motiondb.grammar.induction.rule_compaction`."""

_ANNEALINGS, _TRIES_A_SYMBOL = 20, 150
"""Annealings by which a partition is judged, and tries of each for each symbol. Chosen on takes of
the sample grammars: with them the rules of fights were found in terms of the right classes."""


def present(classes: Classes, strings: Sequence[Sentence]) -> Classes | None:
    """Return the classes of the names that strings hold; None if none has two names.

    >>> present((("a", "b"), ("c", "d")), [("a", "c"), ("b",)])
    (('a', 'b'), ('c',))
    """
    names = {name for string in strings for name in string}
    kept = tuple(tuple(name for name in members if name in names) for members in classes)
    kept = tuple(members for members in kept if members)
    return kept if any(len(members) > 1 for members in kept) else None


def by_class(strings: Sequence[Sentence], classes: Classes) -> list[Sentence]:
    """Replace each name by the first name of its class.

    >>> by_class([("a", "b", "c")], (("a", "c"), ("b",)))
    [('a', 'b', 'a')]
    """
    first = {name: members[0] for members in classes for name in members}
    return [tuple(first[name] for name in string) for string in strings]


def occurrences(strings: Sequence[Sentence]) -> Counter[str]:
    """Return how often each name occurs in strings."""
    return Counter(name for string in strings for name in string)


def spelled_out(rules: RuleSet, classes: Classes, counts: Mapping[str, int]) -> RuleSet:
    """Return rules over classes as rules over terminals.

    `rules`: Rules whose terminals are the classes, numbered in the order of their first names.
    """
    number_of = {name: k for k, name in enumerate(sorted(counts))}
    ordered = sorted(classes, key=lambda members: members[0])
    shift = len(number_of) - rules.n_terminals
    free = max(rules.rules) + shift + 1
    renamed: dict[int, int] = {left: left + shift for left in rules.rules}
    spelled: Rules = {}
    for k, members in enumerate(ordered):
        if len(members) == 1:
            renamed[k] = number_of[members[0]]
            continue
        renamed[k], free = free, free + 1
        spelled[renamed[k]] = {(number_of[name],): counts[name] for name in members}
    written: Rules = {
        renamed[left]: {tuple(renamed[s] for s in right): n for right, n in rights.items()}
        for left, rights in rules.rules.items()
    }
    return RuleSet(len(number_of), {**written, **spelled}, loops=rules.loops)


def induce_in_classes(
    sentences: Sequence[Sentence],
    levels: Sequence[Classes] = (),
    known: Sequence[RuleSet] = (),
) -> Induction:
    """Learn the grammar of fewest bits, with classes of terminals where they save bits.

    `known`: Rules found for these sentences before, terminals numbered in the order of their names.
    """
    classed = class_rules(sentences, levels)
    return induce_with_bits(sentences, known=[*known, *([] if classed is None else [classed])])


def class_rules(sentences: Sequence[Sentence], levels: Sequence[Classes]) -> RuleSet | None:
    """Search rules over the classes that save most bits.

    Each partition is judged by a few annealings, and the rules of the best one are searched in
    full.
    """
    rng = Generator(PCG64(_SEED))  # a fixed seed: the result depends on the sentences only
    counts = occurrences(sentences)
    best, least = None, inf
    for level in levels:
        classes = present(level, sentences)
        if classes is None:
            continue
        flat = flat_of(by_class(sentences, classes))
        tries = _TRIES_A_SYMBOL * sum(counts.values())
        annealed = min(
            (anneal(flat, rng, tries=tries) for _ in range(_ANNEALINGS)), key=RuleSet.bits
        )
        bits = spelled_out(annealed, classes, counts).bits()
        if bits < least:
            best, least = (classes, flat, annealed), bits
    if best is None:
        return None
    classes, flat, annealed = best
    return spelled_out(compact(flat, [annealed]), classes, counts)


def flat_of(sentences: Sequence[Sentence]) -> RuleSet:
    """Return flat rules of sentences, whose terminals are numbered in the order of their names."""
    names = sorted({name for sentence in sentences for name in sentence})
    number_of = {name: k for k, name in enumerate(names)}
    counted: Counter[Right] = Counter(tuple(number_of[s] for s in one) for one in sentences)
    return flat_rules(counted, len(names))
