"""Learn the rules of a grammar from example sentences.

Alignment-based learning: every pair of sentences is aligned (*family* of alignments), unequal parts
become hypotheses of one type, hypotheses that do not cross are kept (*selection*), and the trees
that they make are read as rules: each selected span is a node of the tree of its sentence, and
nodes of one type become one nonterminal as far as the laws of the rule set allow. The family and
the selection with the fewest bits are used. From the results of all of them, and from the plain
sentences, a search for fewer bits begins (:mod:`.rule_compaction`). The grammar that is returned
derives every example.

Two types are merged only if no nonterminal then derives itself, and if every terminal that occurs
equally often in all examples keeps its number. Plain alignment-based learning merges without this
check; its cycles let a basketball player shoot twice where each example has one shot.

The result depends on the set of sentences and on how often each occurs, not on their order.

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000; J. P. Park, K. H. Lee and
J. Lee, "Finding Syntactic Structures from Human Motion Data", Computer Graphics Forum 30 (2011),
section 5.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, TypeVar, get_args

from motiondb.errors import suggestion
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, choices_of
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.rule_compaction import Effort, compact, effort_for, trim
from motiondb.grammar.rules.description_length import (
    DescriptionLength,
    Sentence,
    description_length,
    most_economical_tree,
)
from motiondb.grammar.rules.hypotheses import (
    SELECTIONS,
    Constituent,
    Hypotheses,
    Selection,
    Slot,
    align,
    align_all,
    propose,
    select,
)
from motiondb.grammar.rules.rule_set import (
    Right,
    Rules,
    RuleSet,
    as_grammar,
    constant_terminals,
    flat_rules,
    single_terminals,
)

_MOST_NODES = 10_000
"""Bound on the time of merging types: merges tried one by one, times nodes. The pairs exchanged
most often come first."""


def read_rules(
    hypotheses: Hypotheses,
    kept: Sequence[Sequence[Constituent]],
    weights: Sequence[int],
    n_terminals: int,
    lawful: bool = True,
) -> RuleSet:
    """Read rules from the trees that selected spans make.

    `lawful`: Whether types are merged only as far as the laws of the rule set allow: all types if
    that is lawful, else type by type, else pair by pair, the pairs of words that were exchanged
    most often first.
    """
    symbols = {
        span: n_terminals + 1 + number
        for number, span in enumerate(span for spans in kept for span in spans)
    }
    rules: Rules = {}
    start: dict[Right, int] = {}
    for i, (sentence, spans) in enumerate(zip(hypotheses.sentences, kept, strict=True)):
        whole = Constituent(i, 0, len(sentence))
        for node, right in _tree_rules(sentence, whole, spans, symbols):
            if node == whole and node not in symbols:
                start[right] = start.get(right, 0) + weights[i]
            else:
                rules[symbols[node]] = {right: weights[i]}
    rules = {n_terminals: start, **rules}
    sentences = dict(zip(hypotheses.sentences, weights, strict=True))
    constants, singles = constant_terminals(sentences), single_terminals(sentences)
    finest = RuleSet(n_terminals, rules, constants, singles=singles)
    of_type: dict[int, list[int]] = {}
    for span, symbol in symbols.items():
        of_type.setdefault(hypotheses.types[span], []).append(symbol)
    everything = {symbol: group[0] for group in of_type.values() for symbol in group}
    merged = _renamed(finest, everything)
    if not lawful or is_lawful(merged):
        return trim(merged)
    return trim(_merged_where_lawful(finest, of_type, hypotheses, symbols))


def _tree_rules(
    sentence: Right,
    whole: Constituent,
    spans: Sequence[Constituent],
    symbols: Mapping[Constituent, int],
) -> Iterator[tuple[Constituent, Right]]:
    """Yield each node of the tree that nested spans make, and its right side."""
    children: dict[Constituent, list[Constituent]] = {whole: []}
    smallest_first = sorted(spans, key=lambda span: span.end - span.start)
    for span in smallest_first:
        children.setdefault(span, [])
        around = (
            outer
            for outer in smallest_first
            if outer != span
            and outer.start <= span.start
            and span.end <= outer.end
            and (span.start < span.end or outer.start < span.start < outer.end)
        )
        children.setdefault(next(around, whole), []).append(span)
    for node, inner in children.items():
        right: list[int] = []
        i = node.start
        for child in sorted(inner):
            right.extend(sentence[i : child.start])
            right.append(symbols[child])
            i = child.end
        right.extend(sentence[i : node.end])
        yield node, tuple(right)


def _renamed(rule_set: RuleSet, names: Mapping[int, int]) -> RuleSet:
    changed = rule_set.copy()
    changed.rename(names)
    return changed


def _merged_where_lawful(
    finest: RuleSet,
    of_type: Mapping[int, Sequence[int]],
    hypotheses: Hypotheses,
    symbols: Mapping[Constituent, int],
) -> RuleSet:
    """Merge whole types, the largest first; else pairs of words, the most exchanged first."""
    evidence: dict[int, Counter[tuple[Right, Right]]] = {}
    for (span, twin), number in hypotheses.pairs.items():
        pair = hypotheses.words(span), hypotheses.words(twin)
        evidence.setdefault(hypotheses.types[span], Counter())[min(pair), max(pair)] += number
    symbols_of: dict[tuple[int, Right], list[int]] = {}
    for span, symbol in symbols.items():
        symbols_of.setdefault((hypotheses.types[span], hypotheses.words(span)), []).append(symbol)
    current = finest
    tries = max(5, _MOST_NODES // len(symbols))
    most_types = max(20, _MOST_NODES // len(symbols))
    for kind in sorted(of_type, key=lambda kind: -len(of_type[kind]))[:most_types]:
        group = of_type[kind]
        together = _renamed(current, dict.fromkeys(group, group[0]))
        if is_lawful(together):
            current = together
            continue
        names = {symbol: symbol for symbol in group}
        for (x, y), _ in sorted(evidence[kind].items(), key=lambda item: (-item[1], item[0])):
            merged = (*symbols_of.get((kind, x), ()), *symbols_of.get((kind, y), ()))
            same = {names[symbol] for symbol in merged}
            if len(same) < 2 or tries == 0:
                continue
            tries -= 1
            renaming = {symbol: min(same) for symbol in same}
            changed = _renamed(current, renaming)
            if is_lawful(changed):
                current = changed
                names = {symbol: renaming.get(name, name) for symbol, name in names.items()}
    return current


Name = TypeVar("Name", bound=str)
Family = Literal["edit", "biased", "suffix"]
FAMILIES: tuple[Family, ...] = get_args(Family)
AUTO = "auto"  # Family or selection: the one of the fewest bits

FLAT = "flat"  # Family and selection of rules that were found from the plain sentences

_WORTH_PLANTING = 4.0
"""Alignment-based learning that takes more than this many times the bits of plain rules is not used
further."""


@dataclass(frozen=True)
class Induction:
    """A learned grammar."""

    grammar: Grammar  # The grammar; probabilities are the shares of the uses of each rule
    # Method by which its hypotheses were found; "flat" for rules found from the plain sentences
    family: str
    # Method by which they were selected; "flat" for rules found from the plain sentences
    selection: str
    bits: DescriptionLength  # Bits of the grammar and of the sentences it was learned from


def induce(
    sentences: Sequence[Sentence],
    *,
    family: str = AUTO,
    selection: str = AUTO,
    compacted: bool = True,
    effort: Effort | None = None,
    loops: bool = True,
) -> Grammar:
    """Learn the grammar of the fewest bits that the search finds.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(induce([tuple("abxcd"), tuple("abycd"), tuple("abxcd")])))
    S -> a b A c d
    A -> x [0.6667] | y [0.3333]
    """
    return induce_with_bits(
        sentences,
        family=family,
        selection=selection,
        compacted=compacted,
        effort=effort if loops else without_loops(sentences, effort),
    ).grammar


def without_loops(sentences: Sequence[Sentence], effort: Effort | None = None) -> Effort:
    """Return an effort that searches rules without loops only."""
    if effort is None:
        names, counted = _numbered(sentences)
        effort = effort_for(flat_rules(counted, len(names)))
    return replace(effort, loops=False)


def induce_with_bits(
    sentences: Sequence[Sentence],
    *,
    family: str = AUTO,
    selection: str = AUTO,
    compacted: bool = True,
    effort: Effort | None = None,
    known: Sequence[RuleSet] = (),
) -> Induction:
    """Learn a grammar, and say how it was found and how many bits it takes.

    Parameters and errors are those of :func:`induce`.

    `known`: Rules found for these sentences before, terminals numbered in the order of their names.
    The result takes no more bits than any of them.
    """
    names, counted = _numbered(sentences)
    families = _among(FAMILIES, family, "family")
    selections = _among(SELECTIONS, selection, "selection")
    candidates = [
        Candidate(rules.bits(), used_family, used_selection, rules)
        for used_family, used_selection, rules in aligned_rules(
            counted, len(names), families, selections
        )
    ]
    if compacted:
        flat = flat_rules(counted, len(names))
        donors = [one.rule_set for one in candidates if one.bits < _WORTH_PLANTING * flat.bits()]
        searched = compact(flat, [*donors, *known], effort=effort)
        rule_sets = [rules.without_idle_start() for rules in (searched, *known)]
        candidates += [Candidate(rules.bits(), FLAT, FLAT, rules) for rules in rule_sets]
    best = min(candidates, key=lambda candidate: round(candidate.bits, 6))
    return _finished(best, names, sentences)


@dataclass(frozen=True)
class Candidate:
    """A rule set with its bits, and the family and selection that it comes from."""

    bits: float
    family: str
    selection: str
    rule_set: RuleSet


def aligned_rules(
    counted: Mapping[Right, int],
    n_terminals: int,
    families: Sequence[Family] = FAMILIES,
    selections: Sequence[Selection] = SELECTIONS,
) -> Iterator[tuple[Family, Selection, RuleSet]]:
    """Yield the rules of alignment-based learning for each family and selection."""
    ordered = sorted(counted)
    weights = [counted[sentence] for sentence in ordered]
    for family in families:
        hypotheses = propose(ordered, _slots(ordered, family))
        for selection in selections:
            kept = select(hypotheses, selection)
            yield family, selection, read_rules(hypotheses, kept, weights, n_terminals)


def _slots(ordered: Sequence[Right], family: Family) -> Iterator[tuple[int, int, Sequence[Slot]]]:
    if family == "suffix":
        for (i, j), slots in align_all(ordered).items():
            yield i, j, slots
        return
    for i, j in combinations(range(len(ordered)), 2):
        if not set(ordered[i]).isdisjoint(ordered[j]):
            yield i, j, align(ordered[i], ordered[j], biased=family == "biased")


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


def _among(known: tuple[Name, ...], wanted: str, kind: str) -> tuple[Name, ...]:
    """Return all known names for "auto", else the given one."""
    if wanted == AUTO:
        return known
    chosen = tuple(name for name in known if name == wanted)
    if not chosen:
        raise GrammarError(
            f"{kind}: expected {', '.join(known)} or {AUTO}, found {wanted!r}."
            f"{suggestion(wanted, (*known, AUTO))}"
        )
    return chosen


def _finished(best: Candidate, names: Sequence[str], sentences: Sequence[Sentence]) -> Induction:
    """Name the nonterminals and drop rules that no parse of fewest bits uses."""
    grammar = as_grammar(best.rule_set, names)
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
    return Induction(learned, best.family, best.selection, bits)
