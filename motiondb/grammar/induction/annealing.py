"""Simulated annealing of rules: a search for the rule set of fewest bits.

From a rule set, changes are tried at random:

* *exchange*: two right sides of one nonterminal become one, and their differing parts become the
  alternatives of a nonterminal;
* *class*: two parts that occur between the same neighbours become alternatives, in these two places
  or wherever they occur; one may be empty;
* *chunk*: a part that occurs repeatedly becomes a nonterminal, or an alternative of one; where
  loops are allowed, also of a nonterminal that it contains;
* *fold*: an alternative is replaced by its nonterminal elsewhere;
* *merge*: two nonterminals become one;
* *substitute*: a nonterminal that is not needed is replaced by its right side.

A change that costs d bits is accepted with probability exp(-d / t). The temperature t falls
geometrically. This finds structures that save bits only when they are complete, which a greedy
search does not reach. A change that breaks the laws of the rule set is never accepted. A try takes
a few microseconds: rules are arrays, and rules that do not change are only copied
(:mod:`.rule_arrays`, :mod:`.rewriting`, :mod:`.proposals`).

Sources: S. Kirkpatrick, C. D. Gelatt and M. P. Vecchi, "Optimization by Simulated Annealing",
Science 220 (1983); M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, for exchange;
P. Langley and S. Stromsten, "Learning Context-Free Grammars with a Simplicity Bias", ECML 2000,
for changes judged by description length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.law_checks import WEIGHT_BITS, Laws, keeps_laws, laws_of
from motiondb.grammar.induction.proposals import Workspace, change
from motiondb.grammar.induction.rewriting import tidy
from motiondb.grammar.induction.rule_arrays import (
    LENGTH,
    OFFSET,
    ROWS,
    SYMBOLS,
    RuleTable,
    bits_of,
    copy_numbers,
    copy_rows,
    rules_of,
    table_of,
)
from motiondb.grammar.kernels import maker, merged
from motiondb.grammar.rules.rule_set import RuleSet, recursive_lefts
from motiondb.records import FloatArray, IntArray

WARMEST, COLDEST = 3.0, 0.4
"""First and last temperature in bits: a change of the size of one symbol is accepted often at first
and rarely at the end."""


class Schedule(NamedTuple):
    """How long to anneal: number of tries, first and last temperature in bits."""

    tries: int
    warmest: float
    coldest: float


def anneal(
    rule_set: RuleSet,
    rng: np.random.Generator,
    *,
    tries: int = 50_000,
    warmest: float = WARMEST,
    coldest: float = COLDEST,
    new_loops: bool = True,
) -> RuleSet:
    """The rule set of fewest bits that the search visits; the given one if none is better."""
    size = sum(len(right) + 2 for _, right in rule_set.uses())
    n_rows = 2 * len(list(rule_set.uses())) + size // 4 + 32
    table = table_of(rule_set, n_rows, 8 * size + 512)
    n_lefts = min(len(rule_set.rules) + size // 4 + 8, n_rows)
    logs = np.log2(np.maximum(np.arange(n_rows + n_lefts + rule_set.n_terminals + 4), 1))
    may_loop = np.full(n_lefts, rule_set.loops and new_loops)
    if rule_set.loops and not new_loops:
        recursive = recursive_lefts(rule_set.rules)
        for k, left in enumerate(sorted(rule_set.rules)):
            may_loop[k] = left in recursive
    weights = [int(rng.integers(1 << WEIGHT_BITS)) for _ in rule_set.constants]
    laws = laws_of(rule_set, may_loop, weights)
    bits = _anneal(table, n_lefts, laws, logs, Schedule(tries, warmest, coldest), rng)
    return rule_set if bits >= rule_set.bits() - 1e-9 else rules_of(table, rule_set)


@maker
def _anneal(
    best: RuleTable,
    n_lefts: int,
    laws: Laws,
    logs: FloatArray,
    schedule: Schedule,
    rng: np.random.Generator,
) -> float:
    """Replace a table by the best one that the search finds; return its bits."""
    nodes, numbers = np.zeros(n_lefts, np.int64), np.zeros(n_lefts, np.int64)
    current = _like(best, best.text.copy())
    work = Workspace(
        np.zeros(n_lefts, np.int64),
        np.zeros(n_lefts, np.bool_),
        (_like(best, current.text), _like(best, current.text)),
        _like(best, current.text),
    )
    copy_rows(best, current)
    bits = best_bits = bits_of(best, nodes, work.alternatives, logs)
    alternatives = work.alternatives.copy()  # of the current rules
    for number in range(schedule.tries):
        if current.used[SYMBOLS] > 3 * current.text.size // 4:
            _pack(current)
        copy_numbers(alternatives, 0, n_lefts, work.alternatives, 0)
        place = change(current, work, laws.loops, rng)
        if place < 0:
            continue
        tried = work.goals[place]
        if not tidy(tried, work.spare, work.alternatives, numbers):
            continue
        new_bits = bits_of(tried, nodes, work.alternatives, logs)
        if new_bits > bits:
            cooled = (schedule.coldest / schedule.warmest) ** (number / schedule.tries)
            temperature = schedule.warmest * cooled
            if rng.random() >= np.exp((bits - new_bits) / temperature):
                continue
        if not keeps_laws(tried, work.alternatives, laws):
            continue
        copy_rows(tried, current)
        copy_numbers(work.alternatives, 0, n_lefts, alternatives, 0)
        bits = new_bits
        if bits < best_bits - 1e-9:
            best_bits = bits
            copy_rows(current, best)
            copy_numbers(current.text, 0, best.used[SYMBOLS], best.text, 0)
    return best_bits


@maker
def _like(table: RuleTable, text: IntArray) -> RuleTable:
    """Make a table of the same size over a text."""
    return RuleTable(np.empty_like(table.rows), text, np.zeros(2, np.int64), table.n_terminals)


@merged
def _pack(table: RuleTable) -> None:
    """Keep only those symbols of the text that rows use, at its beginning."""
    copy = table.text.copy()
    end = 0
    for r in range(table.used[ROWS]):
        offset, length = table.rows[r, OFFSET], table.rows[r, LENGTH]
        copy_numbers(copy, offset, length, table.text, end)
        table.rows[r, OFFSET] = end
        end += length
    table.used[SYMBOLS] = end
