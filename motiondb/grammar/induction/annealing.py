"""Rules rewritten at random, ever more reluctantly for the worse: a search for the fewest bits.

From a rule set, changes are tried at random:

* *exchange*: two right sides of one nonterminal become one, what they do not share becoming the
  alternatives of a nonterminal;
* *class*: two parts that stand between the same neighbours become alternatives, in these two
  places or wherever they stand; one may be empty;
* *chunk*: a part that occurs repeatedly becomes a nonterminal, or joins one;
* *fold*: an alternative is replaced by its nonterminal elsewhere;
* *unite*: two nonterminals become one; *write out*: one that need not be goes.

A change that costs d bits is accepted with probability exp(-d / t); the temperature t falls from
some bits to less than one. Structures that pay only once they are complete are found so, where
a search that always takes the best next step is stuck after the first. Nothing is accepted that
breaks the laws of the rule set. A try takes some microseconds: rules are arrays, and what does not
change is not touched (``rule_arrays``, ``rewriting``).

Sources: S. Kirkpatrick, C. D. Gelatt and M. P. Vecchi, "Optimization by Simulated Annealing",
Science 220 (1983); M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, for exchange;
P. Langley and S. Stromsten, "Learning Context-Free Grammars with a Simplicity Bias", ECML 2000,
for changes judged by description length; S. Vigna's splitmix64 for the random numbers.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.grammar.induction.proposals import chance, change, next_bits
from motiondb.grammar.induction.rewriting import tidy
from motiondb.grammar.induction.rule_arrays import (
    LENGTH,
    OFFSET,
    bits_of,
    lawful,
    rules_of,
    table_of,
)
from motiondb.grammar.rules.rule_set import RuleSet

WARMEST, COLDEST = 3.0, 0.4
"""Bits: the first temperature and the last."""


def anneal(
    rule_set: RuleSet,
    *,
    tries: int = 50_000,
    warmest: float = WARMEST,
    coldest: float = COLDEST,
    seed: int = 0,
) -> RuleSet:
    """The rule set of fewest bits that so many tries come upon; the one given at worst.

    Parameters
    ----------
    warmest, coldest : temperatures in bits.
    seed : the same seed gives the same rules.
    """
    size = sum(len(right) + 2 for _, right in rule_set.uses())
    n_rows = 2 * len(list(rule_set.uses())) + size // 4 + 32
    table, text, filled, end = table_of(rule_set, n_rows, 8 * size + 512)
    n_lefts = min(len(rule_set.rules) + size // 4 + 8, n_rows)
    logs = np.log2(np.maximum(np.arange(n_rows + n_lefts + rule_set.n_terminals + 4), 1))
    weights = np.zeros(rule_set.n_terminals, dtype=np.int64)
    state = np.array([seed + 1], dtype=np.uint64)
    for terminal in rule_set.constants:
        weights[terminal] = next_bits(state) >> np.uint64(16)
    marks = np.zeros(rule_set.n_terminals, dtype=np.int64)
    for place, terminal in enumerate(sorted(rule_set.singles)):
        marks[terminal] = 1 << place
    laws = weights, marks
    total = int(sum(int(weights[c]) * number for c, number in rule_set.constants.items()))
    schedule = tries, warmest, coldest
    limits = rule_set.n_terminals, n_lefts, rule_set.empties
    filled, bits = _anneal(table, text, filled, end, limits, laws, total, logs, schedule, state)
    if bits >= rule_set.bits() - 1e-9:
        return rule_set
    return rules_of(table, text, filled, rule_set.n_terminals, rule_set)


@njit(cache=True)
def _anneal(table, text, filled, end, limits, laws, total, logs, schedule, state):  # type: ignore[no-untyped-def]
    """Anneal in place; the rows of the best, which the table then holds, and its bits."""
    n_terminals, n_lefts, empties = limits
    weights, marks = laws
    tries, warmest, coldest = schedule
    nodes = np.zeros(n_lefts, dtype=np.int64)
    alternatives = np.zeros(n_lefts, dtype=np.int64)
    numbers = np.zeros(n_lefts, dtype=np.int64)
    spared = np.zeros(n_lefts, dtype=np.bool_)
    tables = np.empty((3, *table.shape), dtype=np.int64)
    best_table, best_text = table.copy(), text.copy()
    bits = bits_of(table, filled, n_terminals, nodes, alternatives, logs)
    best_bits, best_filled, best_end = bits, filled, end
    current = table.copy()
    for number in range(tries):
        if end > 3 * text.size // 4:
            end = _packed(current, text, filled)
        temperature = warmest * (coldest / warmest) ** (number / tries)
        bits_of(current, filled, n_terminals, nodes, alternatives, logs)
        found, new_end, place = change(
            current, text, filled, end, n_terminals, alternatives, spared, tables, state
        )
        if found <= 0:
            continue
        goal = tables[place]
        found, new_end = tidy(
            goal, text, found, new_end, tables[2], n_terminals, alternatives, numbers
        )
        if found <= 0:
            continue
        changed = bits_of(goal, found, n_terminals, nodes, alternatives, logs)
        if changed > bits and chance(state) >= np.exp((bits - changed) / temperature):
            continue
        if not lawful(goal, text, found, n_terminals, alternatives, weights, marks, total, empties):
            continue
        current[:found] = goal[:found]
        filled, end, bits = found, new_end, changed
        if bits < best_bits - 1e-9:
            best_bits, best_filled, best_end = bits, filled, end
            best_table[:filled] = current[:filled]
            best_text[:end] = text[:end]
    table[:best_filled] = best_table[:best_filled]
    text[:best_end] = best_text[:best_end]
    return best_filled, best_bits


@njit(cache=True)
def _packed(table, text, filled):  # type: ignore[no-untyped-def]
    """Only what the rows use is kept at the beginning of the text; its new end."""
    copy = text.copy()
    end = 0
    for r in range(filled):
        offset, length = table[r, OFFSET], table[r, LENGTH]
        text[end : end + length] = copy[offset : offset + length]
        table[r, OFFSET] = end
        end += length
    return end
