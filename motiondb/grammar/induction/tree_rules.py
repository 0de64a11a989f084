"""Read rules from the trees that selected hypotheses form over the sentences.

Each selected place is a node of the tree of its sentence. Nodes of one type become one nonterminal
as far as the laws of the rule set allow.

Source: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from motiondb.grammar.induction.rule_compaction import trim
from motiondb.grammar.rules.hypotheses import Hypotheses, Place
from motiondb.grammar.rules.rule_set import (
    Right,
    Rules,
    RuleSet,
    constant_terminals,
    single_terminals,
)

_MOST_NODES = 10_000
"""Bound on the time of merging types: merges tried one by one, times nodes. The pairs exchanged
most often come first."""


def read_rules(
    hypotheses: Hypotheses,
    kept: Sequence[Sequence[Place]],
    weights: Sequence[int],
    n_terminals: int,
    lawful: bool = True,
) -> RuleSet:
    """Read rules from the trees that selected places make.

    `lawful`: Whether types are merged only as far as the laws of the rule set allow: all types if
    that is lawful, else type by type, else pair by pair, the pairs of words that were exchanged
    most often first.
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
    merged = _renamed(finest, everything)
    if not lawful or merged.lawful():
        return trim(merged)
    return trim(_merged_where_lawful(finest, of_type, hypotheses, symbols))


def _tree_rules(
    sentence: Right, whole: Place, places: Sequence[Place], symbols: Mapping[Place, int]
) -> Iterator[tuple[Place, Right]]:
    """Yield each node of the tree that nested places make, and its right side."""
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


def _merged_where_lawful(
    finest: RuleSet,
    of_type: Mapping[int, Sequence[int]],
    hypotheses: Hypotheses,
    symbols: Mapping[Place, int],
) -> RuleSet:
    """Merge whole types, the largest first; else pairs of words, the most exchanged first."""
    evidence: dict[int, Counter[tuple[Right, Right]]] = {}
    for (place, twin), number in hypotheses.pairs.items():
        pair = hypotheses.words(place), hypotheses.words(twin)
        evidence.setdefault(hypotheses.types[place], Counter())[min(pair), max(pair)] += number
    symbols_of: dict[tuple[int, Right], list[int]] = {}
    for place, symbol in symbols.items():
        symbols_of.setdefault((hypotheses.types[place], hypotheses.words(place)), []).append(symbol)
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
            places = (*symbols_of.get((kind, x), ()), *symbols_of.get((kind, y), ()))
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
