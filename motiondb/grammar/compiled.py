"""A grammar as arrays of numbers, made once and parsed with often.

Symbols are numbered: nonterminals, terminals, then *tails*. A tail stands for two or more symbols
at the end of a rule, X Y Z = X (Y Z), and is shared by all rules that end so. Then a rule of the
grammar rewrites a nonterminal into one symbol (or into nothing), and a tail always splits into its
two children: trees over this form and trees of the grammar are the same, one to one, for any
grammar, with empty rules, unit cycles and left recursion.

p(rule)   probability of a rule, scaled to sum to 1 over the rules of its left side
e(X)      probability that X becomes empty; z(X) that X ends at all; both the least solution of
          x(A) = sum p(A -> Y) x(Y), x(Y Z) = x(Y) x(Z), found by Newton's method in each strongly
          connected component
w(A, B)   weight of a step that reads nothing: p(A -> B), e(Z) for (Y Z) to Y, e(Y) for (Y Z) to Z

Rules that no finished derivation can use (probability 0, a symbol that never ends, a left side
never reached) are left out.

Sources: A. Stolcke, "An Efficient Probabilistic Context-Free Parsing Algorithm that Computes
Prefix Probabilities", Computational Linguistics 21 (1995); K. Etessami and M. Yannakakis,
"Recursive Markov Chains", Journal of the ACM 56 (2009), for Newton's method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from motiondb.grammar.cfg import Grammar, GrammarError, check_grammar
from motiondb.grammar.closure import BEST, COUNT, SUM, close_graph, strong_components, transpose
from motiondb.records import FloatArray, IntArray

RULE_PENALTY = 1e-9
"""Each rule of a tree lowers its log-probability by this when trees are compared, so that of
equally probable trees the one with fewest rules is best, and no round trip is free."""

Sparse = tuple[IntArray, IntArray, FloatArray]


@dataclass(frozen=True, eq=False)
class CompiledGrammar:
    """A grammar in the numbered form; S symbols, R rules in use.

    ``names``: nonterminals, then terminals. ``left``, ``right`` (S,): children of a tail, else -1.
    ``rule_numbers`` (R,): numbers in ``grammar.rules``, sorted by left side, then number;
    ``rule_of`` (S + 1,): where the rules of a nonterminal begin. ``rule_left``, ``rule_right``
    (R,): its two sides, right -1 for the empty string. ``probabilities`` (R,).
    """

    grammar: Grammar
    names: tuple[str, ...]
    n_nonterminals: int
    left: IntArray
    right: IntArray
    rule_numbers: IntArray
    rule_of: IntArray
    rule_left: IntArray
    rule_right: IntArray
    probabilities: FloatArray

    @cached_property
    def ids(self) -> dict[str, int]:
        """Terminal -> its number."""
        first = self.n_nonterminals
        return {name: first + k for k, name in enumerate(self.names[first:])}

    @property
    def n_symbols(self) -> int:
        """S."""
        return len(self.left)

    @property
    def terminals(self) -> slice:
        """The numbers of the terminals."""
        return slice(self.n_nonterminals, len(self.names))

    @property
    def start(self) -> int:
        """The number of the start symbol."""
        return self.names.index(self.grammar.start, 0, self.n_nonterminals)

    @cached_property
    def ends(self) -> FloatArray:
        """z (S,): the probability that a symbol's derivation ends."""
        return _least_solution(self, 1.0, np.ones(self.n_symbols, bool))

    @cached_property
    def empties(self) -> FloatArray:
        """e (S,): the probability that a symbol becomes empty."""
        return _least_solution(self, 0.0, self.nullable)

    @cached_property
    def best_empties(self) -> FloatArray:
        """The probability (with penalty) of the best tree by which a symbol becomes empty."""
        found = np.zeros(self.n_symbols)
        weights = self.probabilities * np.exp(-RULE_PENALTY)
        while True:
            new = _one_step(self, found, weights, BEST)
            if np.array_equal(new, found):
                return found
            found = new

    @cached_property
    def empty_counts(self) -> FloatArray:
        """The number of trees by which a symbol becomes empty, perhaps infinite."""
        return _count_empties(self)

    @cached_property
    def nullable(self) -> np.ndarray:
        """(S,) whether a symbol derives the empty string."""
        return _grow(self, np.zeros(self.n_symbols, bool), all_parts=True)

    @cached_property
    def speaking(self) -> np.ndarray:
        """(S,) whether a symbol derives a string that is not empty."""
        seed = np.zeros(self.n_symbols, bool)
        seed[self.terminals] = True
        return _grow(self, seed, all_parts=False)

    @cached_property
    def best_chains(self) -> Sparse:
        """Best chain of steps that read nothing, by the symbol they end in."""
        weights = self.probabilities * np.exp(-RULE_PENALTY)
        return transpose(*close_graph(BEST, *_steps(self, weights, self.best_empties)))

    @cached_property
    def all_chains(self) -> Sparse:
        """Sum over all chains of steps that read nothing, by the symbol they end in."""
        return transpose(*close_graph(SUM, *_steps(self, self.probabilities, self.empties)))

    @cached_property
    def counted_chains(self) -> Sparse:
        """Number of chains of steps that read nothing, by the symbol they end in."""
        ones = np.ones(len(self.probabilities))
        return transpose(*close_graph(COUNT, *_steps(self, ones, self.empty_counts)))

    @cached_property
    def left_corners(self) -> Sparse:
        """Sum over all chains from a symbol to what its string can begin with, by the symbol."""
        steps = _steps(self, self.probabilities, self.empties, corners=True)
        return close_graph(SUM, *steps)

    @cached_property
    def by_right(self) -> tuple[IntArray, IntArray]:
        """For each symbol, the tails whose right child it is (both children not only empty)."""
        return _tails_by(self, self.right)

    @cached_property
    def by_left(self) -> tuple[IntArray, IntArray]:
        """For each symbol, the tails whose left child it is (both children not only empty)."""
        return _tails_by(self, self.left)


@lru_cache(maxsize=16)
def compile_grammar(grammar: Grammar) -> CompiledGrammar:
    """The numbered form of a grammar; the latest few are remembered.

    Raises
    ------
    GrammarError where the start symbol derives no string.

    >>> from motiondb.grammar.cfg import read_grammar
    >>> compiled = compile_grammar(read_grammar("S -> S S [0.6] | a [0.3] | empty [0.1]"))
    >>> round(float(compiled.empties[0]), 4), round(float(compiled.ends[0]), 4)
    (0.1069, 0.6667)
    """
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
    table: dict[tuple[str, ...], int] = {(name,): k for k, name in enumerate(names)}
    pairs: list[tuple[int, int]] = []
    rights = [_number_tail(grammar.rules[r].right, table, pairs) for r in order]
    rule_left = np.array([number[grammar.rules[r].left] for r in order], np.int64)
    blank = [(-1, -1)] * len(names)
    children = np.array(blank + pairs, np.int64)
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


def _useful_rules(grammar: Grammar) -> list[int]:
    likely = [r for r, rule in enumerate(grammar.rules) if rule.probability > 0]
    ending: set[str] = {s for s in grammar.terminals if not grammar.is_nonterminal(s)}
    while True:
        found = {
            grammar.rules[r].left
            for r in likely
            if all(symbol in ending for symbol in grammar.rules[r].right)
        }
        if found <= ending:
            break
        ending |= found
    likely = [r for r in likely if ending.issuperset(grammar.rules[r].right)]
    by_left: dict[str, list[int]] = {}
    for r in likely:
        by_left.setdefault(grammar.rules[r].left, []).append(r)
    reached, waiting = {grammar.start}, [grammar.start]
    while waiting:
        for r in by_left.get(waiting.pop(), ()):
            new = set(grammar.rules[r].right) - reached
            reached |= new
            waiting.extend(sorted(new))
    return [r for r in likely if grammar.rules[r].left in reached]


def _number_tail(
    right: tuple[str, ...], table: dict[tuple[str, ...], int], pairs: list[tuple[int, int]]
) -> int:
    if not right:
        return -1
    n_names = len(table) - len(pairs)
    for first in range(len(right) - 2, -1, -1):
        tail = right[first:]
        if tail not in table:
            pairs.append((table[tail[:1]], table[tail[1:]]))
            table[tail] = n_names + len(pairs) - 1
    return table[right]


def _grow(compiled: CompiledGrammar, seed: np.ndarray, *, all_parts: bool) -> np.ndarray:
    """Least set of symbols with a part (or all parts) of a right side in it; empty has all."""
    found, tails = seed.copy(), np.flatnonzero(compiled.left >= 0)
    rule_left, rule_right = compiled.rule_left, compiled.rule_right
    while True:
        new = found.copy()
        a, b = new[compiled.left[tails]], new[compiled.right[tails]]
        new[tails] |= (a & b) if all_parts else (a | b)
        new[rule_left[np.where(rule_right < 0, all_parts, new[rule_right])]] = True
        if np.array_equal(new, found):
            return found
        found = new


def _one_step(
    compiled: CompiledGrammar, values: FloatArray, weights: FloatArray, kind: int
) -> FloatArray:
    """Values of all symbols from those of their parts; terminals keep theirs."""
    right = compiled.rule_right
    terms = weights * np.where(right < 0, 1.0, values[right])
    new = values.copy()
    new[: compiled.n_nonterminals] = 0.0
    tails = compiled.left >= 0
    new[tails] = values[compiled.left[tails]] * values[compiled.right[tails]]
    plus = np.maximum if kind == BEST else np.add
    plus.at(new, compiled.rule_left, terms)
    return new


def _graph(
    n: int, sources: IntArray, targets: IntArray, weights: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    order = np.argsort(sources, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(sources, minlength=n))))
    return starts.astype(np.int64), targets[order], weights[order]


def _parts(compiled: CompiledGrammar, inside: np.ndarray) -> tuple[IntArray, IntArray]:
    """Graph from every symbol to its parts, within a set of symbols."""
    tails = np.flatnonzero(compiled.left >= 0)
    real = compiled.rule_right >= 0
    sources = np.concatenate((compiled.rule_left[real], tails, tails))
    targets = np.concatenate(
        (compiled.rule_right[real], compiled.left[tails], compiled.right[tails])
    )
    keep = inside[sources] & inside[targets]
    sources, targets = sources[keep], targets[keep]
    starts, targets, _ = _graph(compiled.n_symbols, sources, targets, np.ones(len(sources)))
    return starts, targets


def _groups(compiled: CompiledGrammar, inside: np.ndarray) -> list[tuple[IntArray, bool]]:
    """Strong components of the parts, parts first, and whether each leads back to itself."""
    starts, targets = _parts(compiled, inside)
    label = strong_components(starts, targets)
    members = np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label))[:-1])
    sources = np.repeat(np.arange(compiled.n_symbols), np.diff(starts))
    cyclic = np.zeros(len(members), bool)
    cyclic[label[sources[label[sources] == label[targets]]]] = True
    return [(group, bool(c)) for group, c in zip(members, cyclic) if inside[group[0]]]


def _value(compiled: CompiledGrammar, symbol: int, x: FloatArray, weights: FloatArray) -> float:
    if compiled.left[symbol] >= 0:
        parts = x[compiled.left[symbol]], x[compiled.right[symbol]]
        return 0.0 if 0.0 in parts else float(parts[0] * parts[1])
    rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
    right = compiled.rule_right[rules]
    return float(weights[rules] @ np.where(right < 0, 1.0, x[right]))


def _least_solution(
    compiled: CompiledGrammar, terminal_value: float, inside: np.ndarray
) -> FloatArray:
    x = np.zeros(compiled.n_symbols)
    x[compiled.terminals] = terminal_value
    for group, cyclic in _groups(compiled, inside):
        if cyclic:
            _newton(compiled, group, x)
        elif not compiled.n_nonterminals <= group[0] < len(compiled.names):
            x[group[0]] = _value(compiled, group[0], x, compiled.probabilities)
    return x


def _newton(compiled: CompiledGrammar, group: IntArray, x: FloatArray) -> None:
    """Least solution of a component in place; exactly 1 where it is 1 (also where critical)."""
    identity = np.eye(len(group))
    x[group] = 1.0
    value, slope = _value_and_slope(compiled, group, x)
    if np.abs(value - 1.0).max() < 1e-12 and np.abs(np.linalg.eigvals(slope)).max() <= 1 + 1e-9:
        return
    x[group] = 0.0
    for _ in range(200):
        value, slope = _value_and_slope(compiled, group, x)
        step = np.linalg.solve(identity - slope, value - x[group])
        x[group] = np.clip(x[group] + step, 0.0, 1.0)
        if np.abs(step).max() < 1e-15:
            return


def _value_and_slope(
    compiled: CompiledGrammar, group: IntArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    value, slope = np.zeros(len(group)), np.zeros((len(group), compiled.n_symbols))
    for row, symbol in enumerate(group):
        value[row] = _value(compiled, symbol, x, compiled.probabilities)
        a, b = compiled.left[symbol], compiled.right[symbol]
        if a >= 0:
            slope[row, a] += x[b]
            slope[row, b] += x[a]
            continue
        rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
        right, chance = compiled.rule_right[rules], compiled.probabilities[rules]
        np.add.at(slope[row], right[right >= 0], chance[right >= 0])
    return value, slope[:, group]


def _count_empties(compiled: CompiledGrammar) -> FloatArray:
    x = np.zeros(compiled.n_symbols)
    for group, cyclic in _groups(compiled, compiled.nullable):
        for symbol in group:
            rules = slice(compiled.rule_of[symbol], compiled.rule_of[symbol + 1])
            right = compiled.rule_right[rules]
            weights = np.zeros(len(compiled.probabilities))
            weights[rules] = (right < 0) | compiled.nullable[right]
            if cyclic:
                x[symbol] = np.inf
            elif compiled.left[symbol] >= 0:
                x[symbol] = x[compiled.left[symbol]] * x[compiled.right[symbol]]
            else:
                x[symbol] = np.where(right < 0, 1.0, x[right])[weights[rules] > 0].sum()
    return x


def _steps(
    compiled: CompiledGrammar, weights: FloatArray, empties: FloatArray, corners: bool = False
) -> Sparse:
    """Graph of steps that read nothing; with ``corners``, of steps to what a string begins with."""
    tails = np.flatnonzero(compiled.left >= 0)
    left, right = compiled.left[tails], compiled.right[tails]
    real = compiled.rule_right >= 0
    to_left = np.ones(len(tails)) if corners else empties[right]
    sources = np.concatenate((compiled.rule_left[real], tails, tails))
    targets = np.concatenate((compiled.rule_right[real], left, right))
    values = np.concatenate((weights[real], to_left, empties[left]))
    keep = (values > 0) & compiled.speaking[targets]
    return _graph(compiled.n_symbols, sources[keep], targets[keep], values[keep])


def _tails_by(compiled: CompiledGrammar, child: IntArray) -> tuple[IntArray, IntArray]:
    speaking = compiled.speaking
    full = (compiled.left >= 0) & speaking[compiled.left] & speaking[compiled.right]
    tails = np.flatnonzero(full)
    starts, found, _ = _graph(compiled.n_symbols, child[tails], tails, np.ones(len(tails)))
    return starts, found


def numbered(compiled: CompiledGrammar, sentence: Sequence[str]) -> IntArray:
    """A sentence as symbol numbers, -1 for what is no terminal of the grammar."""
    return np.array([compiled.ids.get(symbol, -1) for symbol in sentence], np.int64)
