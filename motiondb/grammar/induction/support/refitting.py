"""Refit rules to sentences: parse all sentences by the rules of another rule set.

A rule set counts how often its rules are used, but not by which sentence, so a search cannot split
what it has merged. Here each sentence is parsed again in the fewest bits (:mod:`.cheapest_parse`).
Only rules that are used remain, with their new counts. A sentence that the rules do not derive gets
a rule of the start symbol of the fewest bits, made of terminals and of nonterminals that derive
parts of it. Rules may therefore be removed, copied, or learned from some of the sentences only;
afterwards all sentences are derived again.
"""

from __future__ import annotations

import numpy as np

from motiondb.grammar.induction.support.cheapest_parse import RULE, Parsed, read_all
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet
from motiondb.records import IntArray

_MOST_REFITS = 20
"""Largest number of successive refits. Chosen by hand: a few are enough, and each saves bits."""

_SAVED = 1e-6  # Bits that a further refit must save


def refit(donor: RuleSet, flat: RuleSet) -> RuleSet | None:
    """Return the rules of ``donor`` that the sentences use, and new rules for other sentences.

    >>> from motiondb.grammar.rules.rule_set import flat_rules
    >>> donor = RuleSet(4, {4: {(0, 5, 3): 1}, 5: {(1,): 1, (2,): 1, (1, 1): 1}})
    >>> refit(donor, flat_rules({(0, 1, 3): 2, (0, 2, 3): 1, (2, 3): 1}, 4)).rules
    {4: {(0, 5, 3): 3, (2, 3): 1}, 5: {(1,): 2, (2,): 1}}
    """
    parsed = _parsed(donor, flat)
    return None if parsed is None else _refitted(parsed, flat)


def _parsed(donor: RuleSet, flat: RuleSet) -> Parsed | None:
    if not flat.loops and donor.order() is None:
        return None
    return read_all(donor, flat.rules[flat.start])


def _refitted(parsed: Parsed, flat: RuleSet, lawful: bool = False) -> RuleSet | None:
    """Return the rules that the trees use; None if they break the laws.

    If the donor is ``lawful``, so are those of its rules that trees of the start symbol use.
    """
    sentences = flat.rules[flat.start]
    rows, readings = parsed
    new: dict[Right, list[Right]] = {}
    used: tuple[list[IntArray], list[IntArray]] = ([], [])  # by derived sentences, and by covers
    weights: tuple[list[int], list[int]] = ([], [])
    for sentence, reading in readings.items():
        is_cover = bool(reading.cover)
        used[is_cover].append(reading.nodes[:, RULE])
        weights[is_cover].append(sentences[sentence])
        if is_cover:
            new.setdefault(reading.cover, []).append(sentence)
    derived, covered = (_uses(*of_kind, len(rows)) for of_kind in zip(used, weights, strict=True))
    refitted = _counted(flat, rows, derived + covered)
    for cover, same_cover in new.items():
        refitted.add(refitted.start, cover, sum(sentences[sentence] for sentence in same_cover))
    if (lawful and not new) or refitted.lawful():
        return refitted
    plain = _counted(flat, rows, derived)
    for sentence in (sentence for same_cover in new.values() for sentence in same_cover):
        plain.add(plain.start, sentence, sentences[sentence])
    return plain if plain.lawful() else None


def _uses(used: list[IntArray], weights: list[int], n_rules: int) -> IntArray:
    """Return how often each rule is used by sentences, each with its weight."""
    if not used:
        return np.zeros(n_rules, dtype=np.int64)
    repeated = np.repeat(weights, [len(rules) for rules in used])
    counts = np.bincount(np.concatenate(used), weights=repeated, minlength=n_rules)
    return counts.astype(np.int64)


def _counted(flat: RuleSet, rows: list[tuple[int, Right]], uses: IntArray) -> RuleSet:
    """Return the rules that are used, with their counts."""
    rules: Rules = {flat.start: {}}
    for (left, right), number in zip(rows, uses.tolist(), strict=True):
        if number:
            rules.setdefault(left, {})[right] = number
    return flat.with_rules(rules)


def refit_fully(donor: RuleSet, flat: RuleSet) -> RuleSet:
    """Refit rules again and again while this saves bits."""
    return refit_and_read(donor, flat)[0]


def refit_and_read(donor: RuleSet, flat: RuleSet) -> tuple[RuleSet, Parsed | None]:
    """Refit rules as :func:`refit_fully` does, and keep the trees."""
    best, bits = donor, donor.bits()
    for _ in range(_MOST_REFITS):
        parsed = _parsed(best, flat)
        refitted = None if parsed is None else _refitted(parsed, flat, lawful=True)
        if refitted is None or refitted.bits() > bits - _SAVED:
            return best, parsed
        best, bits = refitted, refitted.bits()
    return best, None
