"""Learn the rules of a grammar from example sentences.

From the plain sentences, a search for rules of fewer bits begins (:mod:`.rule_compaction`). The
grammar that is returned derives every example. It depends on the set of sentences and on how often
each occurs, not on their order.

Alignment-based learning, with which the paper begins, is not part of the search: with its rules as
further starting points the search found the same bits, or more.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, choices_of
from motiondb.grammar.induction.rule_compaction import Effort, compact, effort_for
from motiondb.grammar.rules.description_length import (
    DescriptionLength,
    Sentence,
    description_length,
    most_economical_tree,
)
from motiondb.grammar.rules.rule_set import Right, RuleSet, as_grammar, flat_rules


@dataclass(frozen=True)
class Induction:
    """A learned grammar."""

    grammar: Grammar  # The grammar; probabilities are the shares of the uses of each rule
    bits: DescriptionLength  # Bits of the grammar and of the sentences it was learned from


def induce(
    sentences: Sequence[Sentence], *, effort: Effort | None = None, loops: bool = True
) -> Grammar:
    """Learn the grammar of the fewest bits that the search finds.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(induce([tuple("abxcd"), tuple("abycd"), tuple("abxcd")])))
    S -> a b A c d
    A -> x [0.6667] | y [0.3333]
    """
    return induce_with_bits(
        sentences, effort=effort if loops else without_loops(sentences, effort)
    ).grammar


def induce_quickly(sentences: Sequence[Sentence]) -> Grammar:
    """Learn rules with little effort, to judge them: foresight is that of full effort.

    Basketball: 78 % of windows foreseen in 3 s of processor time, 77 % in 62 s with full effort.
    """
    return induce(sentences, effort=_QUICK)


_QUICK = Effort(begun=1, repeated=1, tries=1000)


def without_loops(sentences: Sequence[Sentence], effort: Effort | None = None) -> Effort:
    """Return an effort that searches rules without loops only."""
    if effort is None:
        names, counted = _numbered(sentences)
        effort = effort_for(flat_rules(counted, len(names)))
    return replace(effort, loops=False)


def induce_with_bits(
    sentences: Sequence[Sentence],
    *,
    effort: Effort | None = None,
    known: Sequence[RuleSet] = (),
) -> Induction:
    """Learn a grammar, and say how many bits it takes.

    Parameters and errors are those of :func:`induce`.

    `known`: Rules found for these sentences before, terminals numbered in the order of their names.
    The result takes no more bits than any of them.
    """
    names, counted = _numbered(sentences)
    searched = compact(flat_rules(counted, len(names)), known, effort=effort)
    candidates = [rules.without_idle_start() for rules in (searched, *known)]
    best = min(candidates, key=lambda rules: round(rules.bits(), 6))
    return _finished(best, names, sentences)


def _numbered(sentences: Sequence[Sentence]) -> tuple[tuple[str, ...], Counter[Right]]:
    if not sentences:
        raise GrammarError(
            "sentences: expected at least one, found none. Learn from a capture that can be cut"
            " into sentences, or give the sentences."
        )
    for number, sentence in enumerate(sentences, start=1):
        if not sentence:
            raise GrammarError(
                f"sentence {number}: expected at least one terminal, found an empty sentence."
                " Leave it out."
            )
    names = tuple(sorted({name for sentence in sentences for name in sentence}))
    number_of = {name: number for number, name in enumerate(names)}
    coded = (tuple(number_of[name] for name in sentence) for sentence in sentences)
    return names, Counter(coded)


def _finished(best: RuleSet, names: Sequence[str], sentences: Sequence[Sentence]) -> Induction:
    """Name the nonterminals and drop rules that no parse of fewest bits uses."""
    grammar = as_grammar(best, names)
    counts = Counter(sentences)
    while True:
        uses = [0.0] * len(grammar.rules)
        trees = {sentence: most_economical_tree(grammar, sentence) for sentence in counts}
        for sentence, tree in trees.items():
            for rule in choices_of(tree):
                uses[rule] += counts[sentence]
        if all(uses):
            break
        used = [rule for rule, number in zip(grammar.rules, uses, strict=True) if number]
        grammar = Grammar(grammar.start, tuple(used), grammar.terminals)
    bits = description_length(grammar, trees=[trees[sentence] for sentence in sentences])
    learned = grammar.with_probabilities(uses)
    return Induction(learned, bits)
