"""Rules rewritten as long as the description length falls.

Alignment-based learning proposes; description length disposes. From a rule set, the moves are

* *exchange*: two right sides of one nonterminal are aligned and become one; each pair of unequal
  parts becomes the alternatives of a nonterminal (an existing one where its rules allow);
* *chunk*: a string that occurs repeatedly in right sides becomes a nonterminal of its own;
* *fold*: an alternative of a nonterminal is replaced by it wherever else it occurs;
* *class*: two strings that stand between the same neighbours become alternatives wherever they are;
* *unite*: two nonterminals that share a right side become one;
* *unfold*: a nonterminal with one rule, or used once, is written out again.

A beam keeps the rule sets of fewest bits and tries the most promising moves on each. No move may
break the laws of the rule set, so nothing becomes cyclic. The order in which moves are looked at
depends on the rules alone, never on the order in which sentences came.

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, for exchange; P. Langley and
S. Stromsten, "Learning Context-Free Grammars with a Simplicity Bias", ECML 2000, for moves that
are judged by description length.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from motiondb.grammar.moves import (
    chunk_saves,
    chunks,
    classes,
    exchanges,
    foldings,
    unfoldings,
    unions,
)
from motiondb.grammar.rule_set import Right, RuleSet

_TRIED = 10
"""Moves of each kind that are counted exactly in a step, the most promising by symbols saved."""

_NOISE = 3.0
"""Bits by which a randomised search may misjudge a rule set."""

_LEAST_GAIN = 1e-9


def compact(
    rule_set: RuleSet,
    *,
    width: int = 4,
    patience: int = 3,
    rng: np.random.Generator | None = None,
) -> RuleSet:
    """The rule set of fewest bits that a beam of moves finds.

    The ``width`` best rule sets are kept and all moves tried on each; a step may lose bits, since
    some structures pay only once they are complete. It ends when ``patience`` steps in a row have
    found nothing better than the best.
    """
    best = rule_set
    best_bits = rule_set.bits()
    beam = [(best_bits, best)]
    seen: set[tuple[float, int]] = set()
    idle = 0
    while beam and idle < patience:
        found: list[tuple[float, RuleSet]] = []
        for _, current in beam:
            for changed in _neighbours(current):
                bits = changed.bits()
                key = round(bits, 6), sum(map(len, changed.rules.values()))
                if key not in seen:
                    seen.add(key)
                    found.append((bits, changed))
        noise = np.zeros(len(found)) if rng is None else rng.normal(0.0, _NOISE, len(found))
        order = sorted(range(len(found)), key=lambda k: found[k][0] + noise[k])
        beam = []
        for bits, changed in (found[k] for k in order):
            if changed.lawful():
                beam.append((bits, changed))
                if len(beam) == width:
                    break
        idle += 1
        least = min(beam, key=lambda pair: pair[0], default=(best_bits, best))
        if least[0] < best_bits - _LEAST_GAIN:
            best_bits, best = least
            idle = 0
    return best


def trim(rule_set: RuleSet) -> RuleSet:
    """Write out, all at once, the nonterminals of one rule that cost more than they save."""
    current = rule_set.copy()
    while True:
        references = current.references()
        idle = [
            left
            for left, rights in current.rules.items()
            if left != current.start
            and len(rights) == 1
            and chunk_saves(len(next(iter(rights))), references[left]) <= 0
        ]
        if not idle:
            return current
        spelled = {left: current.rules.pop(left).popitem()[0] for left in idle}
        old, current.rules = current.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                current.add(left, _spelled_out(right, spelled), count)


def _spelled_out(right: Right, spelled: Mapping[int, Right]) -> Right:
    while any(symbol in spelled for symbol in right):
        right = tuple(s for old in right for s in spelled.get(old, (old,)))
    return right


def _neighbours(current: RuleSet) -> Iterator[RuleSet]:
    for kind in (exchanges, chunks, classes, unions, foldings, unfoldings):
        promising = sorted(kind(current), key=lambda scored: -scored[0])[:_TRIED]
        for _, move in promising:
            changed = move(current)
            if changed is not None:
                yield changed
