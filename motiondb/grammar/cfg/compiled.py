"""A grammar as arrays of numbers, made once and used for many parses.

Symbols are numbered: nonterminals, terminals, then *tails*. A tail replaces two or more symbols at
the end of a rule, X Y Z = X (Y Z), and is shared by all rules that end with them. Then a rule of
the grammar rewrites a nonterminal into one symbol (or into nothing), and a tail always splits into
its two children. Trees over this form and trees of the grammar correspond one to one, for any
grammar, with empty rules, unit cycles and left recursion.

p(rule)   probability of a rule, scaled to sum to 1 over the rules of its left side
e(X)      probability that X becomes empty; z(X) that X ends at all; both the least solution of
          x(A) = sum p(A -> Y) x(Y), x(Y Z) = x(Y) x(Z), found by Newton's method in each strongly
          connected component
w(A, B)   weight of a step that reads nothing: p(A -> B), e(Z) for (Y Z) to Y, e(Y) for (Y Z) to Z

Rules that no finished derivation can use (probability 0, a symbol that never ends, a left side that
is never reached) are left out.

Sources: A. Stolcke, "An Efficient Probabilistic Context-Free Parsing Algorithm that Computes Prefix
Probabilities", Computational Linguistics 21 (1995); K. Etessami and M. Yannakakis, "Recursive
Markov Chains", Journal of the ACM 56 (2009), for Newton's method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from motiondb.grammar.cfg.closure import BEST, COUNT, SUM, Sparse, close_graph
from motiondb.grammar.cfg.context_free import (
    Grammar,
    GrammarError,
    check_grammar,
    derived_symbols,
    reachable_symbols,
)
from motiondb.grammar.cfg.least_solution import (
    best_solution,
    count_empties,
    grow,
    least_solution,
    part_groups,
    sparse_graph,
)
from motiondb.records import BoolArray, FloatArray, IntArray

RULE_PENALTY = 1e-9
"""Each rule of a tree lowers its log-probability by this when trees are
compared, so that of equally probable trees the one with the fewest rules is best, and no cycle is
free. It is small compared with relevant differences of probability, and large compared with
rounding errors."""


MOST_SYMBOLS = 1_000
"""Largest number of symbols of a sentence. 1,000 take less than a second with a learned grammar;
a grammar in which many symbols derive every span is refused earlier
(:data:`.inside.MOST_PRODUCTS`)."""
MOST_NONTERMINALS = 1_000
"""Largest number of nonterminals of a grammar. The time of the equations of e and z, and of the
chains, grows with their third power if each derives every other; 1,000 take 2 to 5 s."""
LONGEST_RULE = 1_000  # Largest number of symbols on the right side of a rule: that of a sentence
LARGEST_GRAMMAR = 20_000
"""Largest number of symbols on all right sides. Learned grammars have some hundreds."""


class Tails(NamedTuple):
    """Tails by one of their children: ``tails[starts[s]:starts[s + 1]]`` have the child s."""

    starts: IntArray
    tails: IntArray


class Steps(NamedTuple):
    """Steps from a symbol to a part, beside which at most one other part stays in a state."""

    starts: IntArray  # (S + 1,): the steps of each symbol
    targets: IntArray  # (steps,): the part
    rules: IntArray  # (steps,): the rule of a step from a nonterminal, else -1
    before: IntArray  # (steps,): the part that stays in the first state, -1 if none
    after: IntArray  # (steps,): the part that stays in the last state, -1 if none


class Parts(NamedTuple):
    """The symbols in strong components, parts first."""

    members: IntArray  # (S,)
    bounds: IntArray  # (components + 1,): index of the first member of each component
    cyclic: BoolArray  # (components,): whether a component has a cycle


@dataclass(frozen=True, eq=False)
class CompiledGrammar:
    """A grammar in the numbered form; S symbols, R rules in use."""

    grammar: Grammar
    names: tuple[str, ...]
    n_nonterminals: int
    left: IntArray  # (S,): left child of each symbol that is a tail, else -1
    right: IntArray  # (S,): right child of each symbol that is a tail, else -1
    rule_numbers: IntArray  # (R,): numbers in ``grammar.rules``, sorted by left side, then number
    rule_of: IntArray  # (S + 1,): index of the first rule of each nonterminal
    rule_left: IntArray  # (R,): left side of a rule
    rule_right: IntArray  # (R,): right side of a rule, -1 for the empty string
    probabilities: FloatArray  # (R,): p

    @cached_property
    def ids(self) -> dict[str, int]:
        """Number of each terminal."""
        first = self.n_nonterminals
        return {name: first + k for k, name in enumerate(self.names[first:])}

    @property
    def n_symbols(self) -> int:
        """Number of symbols, S."""
        return len(self.left)

    @property
    def terminals(self) -> slice:
        """The numbers of the terminals, as a slice."""
        return slice(self.n_nonterminals, len(self.names))

    @property
    def start(self) -> int:
        """The number of the start symbol."""
        return self.names.index(self.grammar.start, 0, self.n_nonterminals)

    @cached_property
    def ends(self) -> FloatArray:
        """The probability z (S,) that a symbol's derivation ends."""
        return least_solution(self, 1.0, np.ones(self.n_symbols, bool))

    @cached_property
    def empties(self) -> FloatArray:
        """The probability e (S,) that a symbol becomes empty."""
        return least_solution(self, 0.0, self.nullable)

    def staying(self, kind: int, terminals: FloatArray) -> FloatArray:
        """Return the weight (S,) of strings of terminals that have weights (terminals,)."""
        if kind == BEST:
            return best_solution(self, self.weights(BEST), terminals)
        if (terminals == 1.0).all():
            return self.ends
        if terminals.any():
            return least_solution(self, terminals, np.ones(self.n_symbols, bool))
        return self.empties if kind == SUM else count_empties(self)

    @cached_property
    def nullable(self) -> BoolArray:
        """Whether a symbol (S,) derives the empty string."""
        return grow(self, np.zeros(self.n_symbols, bool), all_parts=True)

    @cached_property
    def speaking(self) -> BoolArray:
        """Whether a symbol (S,) derives a string that is not empty."""
        seed = np.zeros(self.n_symbols, bool)
        seed[self.terminals] = True
        return grow(self, seed, all_parts=False)

    @cached_property
    def steps(self) -> Steps:
        """The steps from a symbol to one of its parts that can leave a state."""
        return _list_steps(self)

    def chains(self, kind: int, first: FloatArray, last: FloatArray) -> Sparse:
        """Return the chains of steps that leave neither of two states, by the symbol below.

        Shapes: `first`, `last` (S,), the weights of staying in each.
        """
        steps, weights = self.steps, self.weights(kind)
        values = np.where(steps.rules >= 0, weights[steps.rules], 1.0)
        values *= np.where(steps.before >= 0, first[steps.before], 1.0)
        values *= np.where(steps.after >= 0, last[steps.after], 1.0)
        return close_graph(kind, Sparse(steps.starts, steps.targets, values))

    @cached_property
    def parts_first(self) -> Parts:
        """The symbols component by component, parts first."""
        groups = part_groups(self, np.ones(self.n_symbols, bool))
        members = np.concatenate([group for group, _ in groups])
        bounds = np.cumsum([0, *(len(group) for group, _ in groups)])
        return Parts(members, bounds, np.array([cyclic for _, cyclic in groups]))

    def weights(self, kind: int) -> FloatArray:
        """Return the weight (R,) of each rule in a semiring."""
        if kind == COUNT:
            return np.ones(len(self.probabilities))
        return self.probabilities * (np.exp(-RULE_PENALTY) if kind == BEST else 1.0)

    @cached_property
    def by_right(self) -> Tails:
        """Tails by their right child (tails of which a child is always empty left out)."""
        return _tails_by(self, self.right)

    @cached_property
    def by_left(self) -> Tails:
        """Tails by their left child, in the same way."""
        return _tails_by(self, self.left)


@lru_cache(maxsize=16)
def compile_grammar(grammar: Grammar) -> CompiledGrammar:
    """Compile a grammar; the latest few are cached.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> compiled = compile_grammar(read_grammar("S -> S S [0.6] | a [0.3] | empty [0.1]"))
    >>> round(float(compiled.empties[0]), 4), round(float(compiled.ends[0]), 4)
    (0.1069, 0.6667)
    """
    _check_size(grammar)
    totals: dict[str, float] = {}
    for rule in grammar.rules:
        totals[rule.left] = totals.get(rule.left, 0.0) + rule.probability
    used = _useful_rules(grammar)
    if not used:
        check_grammar(grammar)
        raise GrammarError(
            f"grammar: expected a derivation of {grammar.start!r} with a probability above 0,"
            " found none. Give its rules probabilities."
        )
    lefts = dict.fromkeys([grammar.start, *(grammar.rules[r].left for r in used)])
    number = {name: k for k, name in enumerate(lefts)}
    order = sorted(used, key=lambda r: (number[grammar.rules[r].left], r))
    names = (*number, *(t for t in grammar.terminals if not grammar.is_nonterminal(t)))
    numbers = {name: k for k, name in enumerate(names)}
    pairs: dict[tuple[int, int], int] = {}
    rights = [_number_tail(grammar.rules[r].right, numbers, pairs) for r in order]
    rule_left = np.array([number[grammar.rules[r].left] for r in order], np.int64)
    blank = [(-1, -1)] * len(names)
    children = np.array([*blank, *pairs], np.int64)
    chance = [grammar.rules[r].probability / totals[grammar.rules[r].left] for r in order]
    rule_of = np.searchsorted(rule_left, np.arange(len(children) + 1))
    return CompiledGrammar(
        grammar,
        names,
        len(number),
        np.ascontiguousarray(children[:, 0]),
        np.ascontiguousarray(children[:, 1]),
        np.array(order, np.int64),
        rule_of.astype(np.int64),
        rule_left,
        np.array(rights, np.int64),
        np.array(chance),
    )


def _check_size(grammar: Grammar) -> None:
    """Refuse a grammar that would take too long to compile."""
    lengths = [len(rule.right) for rule in grammar.rules]
    for what, count, most in (
        ("nonterminals", len(grammar.nonterminals), MOST_NONTERMINALS + 1),  # that of passages
        ("symbols on a right side", max(lengths, default=0), LONGEST_RULE),
        ("symbols on all right sides", sum(lengths), LARGEST_GRAMMAR),
    ):
        if count > most:
            raise GrammarError(
                f"grammar: expected at most {most:,} {what}, found {count:,}. Divide it into"
                " smaller grammars."
            )


def _useful_rules(grammar: Grammar) -> list[int]:
    """Return the rules that a finished derivation can use."""
    likely = [r for r, rule in enumerate(grammar.rules) if rule.probability > 0]
    leaves = (s for s in grammar.terminals if not grammar.is_nonterminal(s))
    ending = derived_symbols((grammar.rules[r] for r in likely), leaves)
    likely = [r for r in likely if ending.issuperset(grammar.rules[r].right)]
    reached = reachable_symbols(Grammar(grammar.start, tuple(grammar.rules[r] for r in likely)))
    return [r for r in likely if grammar.rules[r].left in reached]


def _number_tail(
    right: tuple[str, ...], numbers: dict[str, int], pairs: dict[tuple[int, int], int]
) -> int:
    """Return the number of a right side, -1 if it is empty.

    New tails go into ``pairs``: the children of each tail -> its number.
    """
    if not right:
        return -1
    number = numbers[right[-1]]
    for name in reversed(right[:-1]):
        number = pairs.setdefault((numbers[name], number), len(numbers) + len(pairs))
    return number


def _list_steps(compiled: CompiledGrammar) -> Steps:
    """List the steps from symbols to parts of which some string is not empty."""
    tails = np.flatnonzero(compiled.left >= 0)
    left, right = compiled.left[tails], compiled.right[tails]
    real = np.flatnonzero(compiled.rule_right >= 0)
    none = np.full(len(tails), -1)
    sources = np.concatenate((compiled.rule_left[real], tails, tails))
    targets = np.concatenate((compiled.rule_right[real], left, right))
    rules = np.concatenate((real, none, none))
    before = np.concatenate((np.full(len(real), -1), none, left))
    after = np.concatenate((np.full(len(real), -1), right, none))
    order = np.argsort(sources, kind="stable")
    order = order[compiled.speaking[targets[order]]]
    starts = np.searchsorted(sources[order], np.arange(compiled.n_symbols + 1))
    return Steps(starts, targets[order], rules[order], before[order], after[order])


def _tails_by(compiled: CompiledGrammar, child: IntArray) -> Tails:
    """Return tails by one of their children, those of which a child is always empty left out."""
    speaking = compiled.speaking
    full = (compiled.left >= 0) & speaking[compiled.left] & speaking[compiled.right]
    tails = np.flatnonzero(full)
    graph = sparse_graph(compiled.n_symbols, child[tails], tails, np.ones(len(tails)))
    return Tails(graph.starts, graph.columns)


def finite_part(compiled: CompiledGrammar) -> CompiledGrammar:
    """Return the grammar with probabilities given that the derivation ends.

    p'(A -> X Y ...) = p(A -> X Y ...) z(X) z(Y) ... / z(A): trees keep their proportions, and if
    all derivations end with probability 1 nothing changes (Z. Chi, "Statistical Properties of
    Probabilistic Context-Free Grammars", Computational Linguistics 25, 1999).
    """
    if (compiled.ends[: compiled.n_nonterminals] > 1 - 1e-12).all():
        return compiled
    return with_chances(compiled, ending_chances(compiled))


def ending_chances(compiled: CompiledGrammar) -> FloatArray:
    """Return the probability (R,) of each rule in use, given that the derivation ends."""
    z, right = compiled.ends, compiled.rule_right
    return compiled.probabilities * np.where(right < 0, 1.0, z[right]) / z[compiled.rule_left]


def with_chances(compiled: CompiledGrammar, chances: FloatArray) -> CompiledGrammar:
    """Return the same rules with other probabilities (R,), scaled for each left side."""
    chance = np.zeros(len(compiled.grammar.rules))
    chance[compiled.rule_numbers] = chances
    rules = (replace(r, probability=float(p)) for r, p in zip(compiled.grammar.rules, chance))
    return compile_grammar(replace(compiled.grammar, rules=tuple(rules)))


def numbered(compiled: CompiledGrammar, sentence: Sequence[str]) -> IntArray:
    """Return a sentence as symbol numbers, -1 for a name that is not a terminal of the grammar."""
    if len(sentence) > MOST_SYMBOLS:
        raise GrammarError(
            f"sentence: expected at most {MOST_SYMBOLS:,} symbols, found {len(sentence):,}. Time"
            " grows with the third power of the length: give it in parts."
        )
    return np.array([compiled.ids.get(symbol, -1) for symbol in sentence], np.int64)
