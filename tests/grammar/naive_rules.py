"""Rule sets drawn at random, their strings by applying rules, and the search's check of laws."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from motiondb.grammar.induction.law_checks import keeps_laws, laws_of
from motiondb.grammar.induction.rule_arrays import LEFT, ROWS, table_of
from motiondb.grammar.induction.rule_compaction import Effort
from motiondb.grammar.rules.rule_set import RuleSet

# terminals 0, 1, 2; start 3; nonterminals 4 and 5
T, S, A, B = 3, 3, 4, 5
LITTLE = Effort(begun=8, repeated=8, tries=2000)
STRING = st.lists(st.integers(0, T - 1), min_size=1, max_size=6).map(tuple)


@st.composite
def acyclic_rules(draw, least=1, most=5):
    """Rules of which 4 may use 5 and nobody the start, with counts."""
    rules = {}
    for left, symbols in ((S, [0, 1, 2, A, B]), (A, [0, 1, 2, B]), (B, [0, 1, 2])):
        shortest = 1 if left == S else least
        rights = st.lists(st.sampled_from(symbols), min_size=shortest, max_size=most)
        counted = st.dictionaries(rights.map(tuple), st.integers(1, 4), min_size=1, max_size=4)
        rules[left] = draw(counted)
    return RuleSet(T, rules)


@st.composite
def looping_rules(draw, symbols=(0, 1, 2, A, B)):
    """Rules of any kind: loops, empty right sides, symbols that never end or are not reached."""
    rules = {}
    for left in (S, A, B):
        part = st.sampled_from(symbols)
        rights = st.lists(part, min_size=int(left == S), max_size=3).map(tuple)
        rights = rights.filter(lambda right, left=left: right != (left,))
        rules[left] = draw(st.dictionaries(rights, st.integers(1, 4), min_size=1, max_size=3))
    constants = draw(st.dictionaries(st.integers(0, 2), st.integers(0, 2), max_size=3))
    singles = draw(st.frozensets(st.integers(0, 2), max_size=2))
    return RuleSet(T, rules, constants, draw(st.booleans()), singles, loops=True)


def strings_of(rules, start=S, longest=10):
    """All strings of at most ``longest`` terminals, by applying rules until nothing is new."""
    known = {left: set() for left in rules}
    while True:
        size = sum(map(len, known.values()))
        for left, rights in rules.items():
            for right in rights:
                actual = {()}
                for part in right:
                    ends = known.get(part, {(part,)})
                    actual = {a + b for a in actual for b in ends if len(a + b) <= longest}
                known[left] |= actual
        if sum(map(len, known.values())) == size:
            return known[start]


def keeps_laws_of(rules, may_loop):
    """Whether the search would keep rules, some of whose nonterminals may loop."""
    table = table_of(rules, 32, 200)
    lefts = table.rows[: table.used[ROWS], LEFT]
    alternatives = np.bincount(lefts - T, minlength=8)
    mask = np.zeros(8, dtype=np.bool_)
    mask[: len(may_loop)] = may_loop
    laws = laws_of(rules, mask, [10_007 ** (terminal + 1) for terminal in rules.constants])
    return bool(keeps_laws(table, alternatives, laws))
