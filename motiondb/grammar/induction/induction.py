"""Rules from example sentences: alignment-based learning, judged by description length.

Every pair of sentences is aligned (*family*), unequal parts become hypotheses of one type
(*clustering*), those that do not cross are believed (*selection*), and the trees are read off as
rules. Which family and selection suit the sentences, the description length says; and from what
each of them gives, and from the plain sentences, a search goes on to fewer bits (see
``compaction``). What is returned derives every example.

Two types are only made one where no nonterminal then derives itself and every terminal that
stands equally often in all examples keeps its number. Alignment-based learning unites without
looking, and its cycles let a basketball player shoot twice where each example has one shot.

The result depends on the set of sentences and on how often each occurs, not on their order.

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000; J. P. Park, K. H. Lee and
J. Lee, "Finding Syntactic Structures from Human Motion Data", Computer Graphics Forum 30 (2011),
section 5.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

from motiondb.errors import suggestion
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, choices_of
from motiondb.grammar.induction.rule_compaction import Effort, compact, trim
from motiondb.grammar.rules.description_length import (
    DescriptionLength,
    Sentence,
    description_length,
    most_economical_tree,
)
from motiondb.grammar.rules.hypotheses import (
    SELECTIONS,
    Hypotheses,
    Place,
    Selection,
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
from motiondb.grammar.rules.sentence_alignment import Slot, align
from motiondb.grammar.rules.suffix_alignment import align_all

Family = Literal["edit", "biased", "suffix"]
FAMILIES: tuple[Family, ...] = get_args(Family)
AUTO = "auto"
FLAT = "flat"


@dataclass(frozen=True)
class Induction:
    """A grammar, how it was found, and the bits of it and of the sentences it was learned from."""

    grammar: Grammar
    family: str
    selection: str
    bits: DescriptionLength


def induce(
    sentences: Sequence[Sentence],
    *,
    family: str = AUTO,
    selection: str = AUTO,
    compacted: bool = True,
    effort: Effort | None = None,
) -> Grammar:
    """The grammar of fewest bits that alignment-based learning and compaction find.

    Parameters
    ----------
    sentences : the examples; equal ones count as often as they stand there.
    family : "edit", "biased", "suffix", or "auto" for the one of fewest bits.
    selection : "first", "leaf", "branch", or "auto".
    compacted : False stops at what alignment-based learning itself gives.
    effort : of the search; what suits so many symbols unless given.

    Raises
    ------
    GrammarError where there is no sentence, one is empty, or a family or selection is unknown.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(induce([tuple("abxcd"), tuple("abycd"), tuple("abxcd")])))
    S -> a b A c d
    A -> x [0.6667] | y [0.3333]
    """
    return induce_with_bits(
        sentences, family=family, selection=selection, compacted=compacted, effort=effort
    ).grammar


def induce_with_bits(
    sentences: Sequence[Sentence],
    *,
    family: str = AUTO,
    selection: str = AUTO,
    compacted: bool = True,
    effort: Effort | None = None,
    known: Sequence[RuleSet] = (),
) -> Induction:
    """What :func:`induce` finds, with the family, the selection and the bits; same faults.

    known : rules found for these sentences before, terminals numbered in the order of their names;
    what is returned takes no more bits.
    """
    names, counted = _numbered(sentences)
    families = _among(FAMILIES, family, "family")
    selections = _among(SELECTIONS, selection, "selection")
    aligned_ones = [
        Candidate(learned.bits(), chosen, way, learned)
        for chosen, way, learned in aligned_rules(counted, len(names), families, selections)
    ]
    candidates = aligned_ones
    if compacted:
        flat = flat_rules(counted, len(names))
        donors = [one.rule_set for one in aligned_ones if one.bits < _WORTH_PLANTING * flat.bits()]
        found = compact(flat, [*donors, *known], effort=effort)
        candidates = [
            *aligned_ones,
            *(Candidate(rules.bits(), FLAT, FLAT, rules) for rules in (found, *known)),
        ]
    best = min(candidates, key=lambda candidate: round(candidate.bits, 6))
    return _finished(best, names, sentences)


@dataclass(frozen=True)
class Candidate:
    """A rule set with its bits, and the family and selection that it began from."""

    bits: float
    family: str
    selection: str
    rule_set: RuleSet


_MOST_NODES = 10_000
"""Unions tried one by one, times nodes: a bound on time, those seen most come first."""

_WORTH_PLANTING = 4.0
"""Where alignment-based learning takes this many times the bits of flat rules, it goes astray."""


def aligned_rules(
    counted: Mapping[Right, int],
    n_terminals: int,
    families: Sequence[Family] = FAMILIES,
    selections: Sequence[Selection] = SELECTIONS,
) -> Iterator[tuple[Family, Selection, RuleSet]]:
    """What alignment-based learning gives for each family and selection, its types kept lawful."""
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


def read_rules(
    hypotheses: Hypotheses,
    kept: Sequence[Sequence[Place]],
    weights: Sequence[int],
    n_terminals: int,
    lawful: bool = True,
) -> RuleSet:
    """The rules of the trees that the places make, places of one type under one nonterminal.

    With ``lawful`` types are united only as far as the laws of the rule set allow: all of them
    where that is lawful, else type by type, else pair by pair, the pairs of words that were
    exchanged most often first.
    """
    symbols = {
        place: n_terminals + 1 + number
        for number, place in enumerate(place for places in kept for place in places)
    }
    rules: Rules = {}
    start: dict[Right, int] = {}
    for i, (sentence, places) in enumerate(zip(hypotheses.sentences, kept, strict=True)):
        whole = Place(i, 0, len(sentence))
        for node, right in _tree_rules(sentence, whole, places, symbols):
            if node == whole and node not in symbols:
                start[right] = start.get(right, 0) + weights[i]
            else:
                rules[symbols[node]] = {right: weights[i]}
    rules = {n_terminals: start, **rules}
    sentences = dict(zip(hypotheses.sentences, weights, strict=True))
    constants, singles = constant_terminals(sentences), single_terminals(sentences)
    finest = RuleSet(n_terminals, rules, constants, singles=singles)
    of_type: dict[int, list[int]] = {}
    for place, symbol in symbols.items():
        of_type.setdefault(hypotheses.types[place], []).append(symbol)
    everything = {symbol: group[0] for group in of_type.values() for symbol in group}
    united = _renamed(finest, everything)
    if not lawful or united.lawful():
        return trim(united)
    return trim(_united_where_lawful(finest, of_type, hypotheses, symbols))


def _tree_rules(
    sentence: Right, whole: Place, places: Sequence[Place], symbols: Mapping[Place, int]
) -> Iterator[tuple[Place, Right]]:
    """Each node of the tree that nested places make, with the right side it is rewritten to."""
    children: dict[Place, list[Place]] = {whole: []}
    smallest_first = sorted(places, key=lambda place: place.end - place.start)
    for place in smallest_first:
        children.setdefault(place, [])
        around = (
            outer
            for outer in smallest_first
            if outer != place
            and outer.start <= place.start
            and place.end <= outer.end
            and (place.start < place.end or outer.start < place.start < outer.end)
        )
        children.setdefault(next(around, whole), []).append(place)
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


def _united_where_lawful(
    finest: RuleSet,
    of_type: Mapping[int, Sequence[int]],
    hypotheses: Hypotheses,
    symbols: Mapping[Place, int],
) -> RuleSet:
    """Whole types, those of most places first; of the others the words exchanged most often."""
    evidence: dict[int, Counter[tuple[Right, Right]]] = {}
    for (place, twin), number in hypotheses.pairs.items():
        pair = hypotheses.words(place), hypotheses.words(twin)
        evidence.setdefault(hypotheses.types[place], Counter())[min(pair), max(pair)] += number
    spoken: dict[tuple[int, Right], list[int]] = {}
    for place, symbol in symbols.items():
        spoken.setdefault((hypotheses.types[place], hypotheses.words(place)), []).append(symbol)
    current = finest
    tries = max(5, _MOST_NODES // len(symbols))
    most_types = max(20, _MOST_NODES // len(symbols))
    for kind in sorted(of_type, key=lambda kind: -len(of_type[kind]))[:most_types]:
        group = of_type[kind]
        together = _renamed(current, dict.fromkeys(group, group[0]))
        if together.lawful():
            current = together
            continue
        names = {symbol: symbol for symbol in group}
        for (x, y), _ in sorted(evidence[kind].items(), key=lambda item: (-item[1], item[0])):
            places = (*spoken.get((kind, x), ()), *spoken.get((kind, y), ()))
            same = {names[symbol] for symbol in places}
            if len(same) < 2 or tries == 0:
                continue
            tries -= 1
            renaming = {symbol: min(same) for symbol in same}
            changed = _renamed(current, renaming)
            if changed.lawful():
                current = changed
                names = {symbol: renaming.get(name, name) for symbol, name in names.items()}
    return current


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


def _among(known: tuple, wanted: str, kind: str) -> tuple:
    if wanted == AUTO:
        return known
    if wanted not in known:
        raise GrammarError(
            f"{kind}: expected {', '.join(known)} or {AUTO}, found {wanted!r}."
            f"{suggestion(wanted, (*known, AUTO))}"
        )
    return (wanted,)


def _finished(best: Candidate, names: Sequence[str], sentences: Sequence[Sentence]) -> Induction:
    """Names for the nonterminals; rules that no most economical parse uses are left out."""
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
