"""Rules taken apart at random: where a search that has come to rest begins again.

Annealing ends in rules from which no small change saves bits. Four larger ones lead out:

* *forget*: some rules are taken away, the sentences that used them told anew;
* *part*: a nonterminal gets a copy for one of the places where it stands, or for each of them, so
  that what was united too early can be different things;
* *sample*: the rules go on with some of the sentences only, which others no longer hold back;
* *plant*: some nonterminals are put into the plain sentences (``planting``).

After each the sentences are read again (``refitting``), so that copies keep only what they use.

Sources: H. R. Lourenço, O. C. Martin and T. Stützle, "Iterated Local Search", Handbook of
Metaheuristics (2003); G. Schrimpf, J. Schneider, H. Stamm-Wilbrandt and G. Dueck, "Record Breaking
Optimization Results Using the Ruin and Recreate Principle", Journal of Computational Physics 159
(2000), for what is taken away and built again.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from motiondb.grammar.induction.annealing import anneal
from motiondb.grammar.induction.planting import plant
from motiondb.grammar.induction.proposals import chance, draw
from motiondb.grammar.induction.refitting import refit
from motiondb.grammar.rules.rule_set import RuleSet

SeedArray = npt.NDArray[np.uint64]
_MOST_FORGOTTEN = 3
_LEAST_SHARE, _LARGEST_SHARE = 0.4, 0.9


def perturb(rule_set: RuleSet, flat: RuleSet, tries: int, state: SeedArray) -> RuleSet | None:
    """One of the changes, drawn at random, of rules for the sentences of the flat rules.

    tries : of the annealing of a sample. state : array (1,), of the random numbers
    (``proposals.next_bits``); it goes on.

    None where there is nothing to change.
    """
    kind = draw(state, 5)
    if kind == 0:
        return plant(flat, rule_set, state)
    if kind == 4:
        return _by_sample(rule_set, flat, tries, state)
    if kind == 1:
        return refit(forget(rule_set, 1 + draw(state, _MOST_FORGOTTEN), state), flat)
    copied = part(rule_set, kind == 2, state)
    return None if copied is None else refit(copied, flat)


def forget(rule_set: RuleSet, number: int, state: SeedArray) -> RuleSet:
    """Without so many rules, drawn at random, and those that need nonterminals thus lost."""
    changed = rule_set.copy()
    for _ in range(number):
        rows = sorted(changed.uses())
        if not rows:
            break
        left, right = rows[draw(state, len(rows))]
        del changed.rules[left][right]
        lost = _without_rules(changed)
        while lost:
            for gone in lost:
                del changed.rules[gone]
            for rights in changed.rules.values():
                for right in [right for right in rights if not lost.isdisjoint(right)]:
                    del rights[right]
            lost = _without_rules(changed)
    return changed


def _without_rules(rule_set: RuleSet) -> set[int]:
    return {x for x, rights in rule_set.rules.items() if not rights and x != rule_set.start}


def part(rule_set: RuleSet, once: bool, state: SeedArray) -> RuleSet | None:
    """A nonterminal that stands in several places, drawn at random, copied for one or each of them.

    >>> rules = RuleSet(2, {2: {(3, 0, 3): 2}, 3: {(0,): 2, (1,): 2}})
    >>> part(rules, False, np.array([1], dtype=np.uint64)).rules
    {2: {(4, 0, 5): 2}, 4: {(0,): 2, (1,): 2}, 5: {(0,): 2, (1,): 2}}
    """
    references = rule_set.references()
    shared = [x for x in sorted(rule_set.rules) if x != rule_set.start and references[x] > 1]
    if not shared:
        return None
    symbol = shared[draw(state, len(shared))]
    chosen = draw(state, references[symbol]) if once else -1
    changed = rule_set.copy()
    changed.rules = {left: {} for left in rule_set.rules}
    new, place = max(rule_set.rules) + 1, 0
    for left, right in sorted(rule_set.uses()):
        written = list(right)
        for k, old in enumerate(right):
            if old == symbol:
                if place == chosen or not once:
                    written[k] = new
                    changed.rules[new] = {}
                    new += 1
                place += 1
        changed.rules[left][tuple(written)] = rule_set.rules[left][right]
    for copy in range(max(rule_set.rules) + 1, new):
        changed.rules[copy] = dict(changed.rules[symbol])
    if not once:
        del changed.rules[symbol]
    return changed


def sample(flat: RuleSet, number: int, state: SeedArray) -> RuleSet:
    """The flat rules of so many of the sentences, drawn at random; the laws are those of all."""
    rights = flat.rules[flat.start]
    left_over = sorted(rights)
    chosen = [left_over.pop(draw(state, len(left_over))) for _ in range(number)]
    some = flat.copy()
    some.rules = {flat.start: {sentence: rights[sentence] for sentence in sorted(chosen)}}
    return some


def _by_sample(rule_set: RuleSet, flat: RuleSet, tries: int, state: SeedArray) -> RuleSet | None:
    n = len(flat.rules[flat.start])
    share = _LEAST_SHARE + (_LARGEST_SHARE - _LEAST_SHARE) * chance(state)
    some = sample(flat, min(n, max(2, int(n * share))), state)
    begun = refit(rule_set, some)
    if begun is None:
        return None
    return refit(anneal(begun, tries=tries, warmest=2.0, seed=int(draw(state, 1 << 30))), flat)
