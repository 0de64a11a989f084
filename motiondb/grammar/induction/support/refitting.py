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

from motiondb.grammar.induction.support.cheapest_parse import RULE, read_all
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet
from motiondb.records import IntArray

_MOST_REFITS = 20
"""Largest number of successive refits. Chosen by hand: a few are enough, and each saves bits."""

_SAVED = 1e-6
"""Bits that a further refit must save."""


def refit(donor: RuleSet, flat: RuleSet) -> RuleSet | None:
    """Return the rules of ``donor`` that the sentences use, and new rules for other sentences.

    Parameters
    ----------
    donor : RuleSet
        The rules to parse by.
    flat : RuleSet
        One rule for each sentence, and the laws.

    Returns
    -------
    RuleSet or None
        None if a sentence is too long, the donor has loops that the laws forbid, or the rules that
        are used break the laws.

    >>> from motiondb.grammar.rules.rule_set import flat_rules
    >>> donor = RuleSet(4, {4: {(0, 5, 3): 1}, 5: {(1,): 1, (2,): 1, (1, 1): 1}})
    >>> refit(donor, flat_rules({(0, 1, 3): 2, (0, 2, 3): 1, (2, 3): 1}, 4)).rules
    {4: {(0, 5, 3): 3, (2, 3): 1}, 5: {(1,): 2, (2,): 1}}
    """
    if not flat.loops and donor.order() is None:
        return None
    sentences = flat.rules[flat.start]
    parsed = read_all(donor, sentences)
    if parsed is None:
        return None
    rows, readings = parsed
    derived = np.zeros(len(rows), dtype=np.int64)  # uses by sentences that the rules derive
    covered = np.zeros(len(rows), dtype=np.int64)  # uses by the covers of others
    new: dict[Right, list[Right]] = {}
    for sentence, reading in readings.items():
        uses = covered if reading.cover else derived
        np.add.at(uses, reading.nodes[:, RULE], sentences[sentence])
        if reading.cover:
            new.setdefault(reading.cover, []).append(sentence)
    refitted = _counted(flat, rows, derived + covered)
    for cover, same_cover in new.items():
        refitted.add(refitted.start, cover, sum(sentences[sentence] for sentence in same_cover))
    if refitted.lawful():
        return refitted
    plain = _counted(flat, rows, derived)
    for sentence in (sentence for same_cover in new.values() for sentence in same_cover):
        plain.add(plain.start, sentence, sentences[sentence])
    return plain if plain.lawful() else None


def _counted(flat: RuleSet, rows: list[tuple[int, Right]], uses: IntArray) -> RuleSet:
    """Return the rules that are used, with their counts."""
    rules: Rules = {flat.start: {}}
    for (left, right), number in zip(rows, uses.tolist(), strict=True):
        if number:
            rules.setdefault(left, {})[right] = number
    return flat.with_rules(rules)


def refit_fully(donor: RuleSet, flat: RuleSet) -> RuleSet:
    """Refit rules again and again while this saves bits.

    Parameters
    ----------
    donor : RuleSet
        Rules that derive all sentences.
    flat : RuleSet
        One rule for each sentence, and the laws.

    Returns
    -------
    RuleSet
        The donor itself if refitting saves nothing.
    """
    best, bits = donor, donor.bits()
    for _ in range(_MOST_REFITS):
        refitted = refit(best, flat)
        if refitted is None or refitted.bits() > bits - _SAVED:
            break
        best, bits = refitted, refitted.bits()
    return best
