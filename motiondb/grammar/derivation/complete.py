"""Complete a pattern by the sentences of a grammar that match it.

The grammar is intersected with the automaton of the pattern. The probability of the pattern is the
sum of W(S, 0, t) over accepting states t.

Trees that match are drawn from the root down by W: this is the distribution of the grammar, given
that the sentence matches. The most probable trees are found by A* search, in which V is the exact
remaining cost, so no step of the search is spent on other trees.

*Intersection.* An item (X, s, t) is the set of strings that a symbol X derives and that lead the
automaton from state s to state t. Its weight W is the sum of the probabilities of these
derivations, and V the greatest of them:

    W(A, s, t) = sum p(A -> Y) W(Y, s, t),    W(Y Z, s, t) = sum over u of W(Y, s, u) W(Z, u, t),

and V with the maximum for the sum. The automaton reads each string in one way at most, so no string
is counted twice.

The states are in blocks that steps never leave backwards (:class:`.pattern.Acceptor`). The weights
between two blocks depend only on those between blocks that lie from the one to the other, so pairs
of blocks are solved one after another, the nearest first. What blocks strictly between them give is
computed once. The remainder is a least solution, found by iteration component by component of the
symbols. Most blocks have one state, and an iteration is then as short as the list of rules. Strings
that lead from such a state to itself hold the terminals of its gap only; W of these is found by
Newton's method (:mod:`motiondb.grammar.cfg.least_solution`).

Sources: Y. Bar-Hillel, M. Perles and E. Shamir, "On Formal Properties of Simple Phrase Structure
Grammars" (1961); M.-J. Nederhof and G. Satta, "Probabilistic Parsing as Intersection", IWPT 2003;
P. E. Hart, N. J. Nilsson and B. Raphael, "A Formal Basis for the Heuristic Determination of Minimum
Cost Paths" (1968), for A*.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from math import exp, inf
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.least_solution import least_solution, part_groups
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, log_probability
from motiondb.grammar.derivation.pattern import Acceptor, Pattern, PatternSymbol, acceptor_of
from motiondb.records import BoolArray, FloatArray, IntArray

_CLOSE = 1e-13  # Relative change of a weight below which an iteration has converged

_MOST_ROUNDS = 100_000
"""Largest number of iterations. Chosen by hand: a loop that continues with probability 0.999
needs 30,000."""


_Pair = tuple[int, int, int, int]
"""First state of a block and the state after its last one, and the same of another block."""


@dataclass(frozen=True, eq=False)
class Intersection:
    """A grammar and an automaton."""

    compiled: CompiledGrammar
    automaton: Acceptor  # The automaton over its terminals
    sums: FloatArray  # (symbols, states, states): w

    @property
    def ends(self) -> FloatArray:
        """The probability (states,) of sentences that lead to each accepting state, else 0."""
        return np.where(self.automaton.accepting, self.sums[self.compiled.start, 0], 0.0)


def intersect(
    grammar: AnyGrammar, pattern: Pattern, allowed: frozenset[str] | None = None
) -> Intersection:
    """Intersect a grammar with the automaton of a pattern."""
    compiled = compiled_form(grammar)
    automaton = acceptor_of(pattern, compiled.names[compiled.terminals], allowed)
    return Intersection(compiled, automaton, weights_of(compiled, automaton, best=False))


def weights_of(compiled: CompiledGrammar, automaton: Acceptor, *, best: bool) -> FloatArray:
    """Return the weights of all items; result (symbols, states, states)."""
    n = len(automaton.steps)
    weights = np.zeros((compiled.n_symbols, n, n))
    weights[compiled.terminals] = automaton.steps.transpose(1, 0, 2)
    groups = part_groups(compiled, np.ones(compiled.n_symbols, bool))
    equations = _Equations(
        np.concatenate([group for group, _ in groups]),
        np.cumsum([0, *(len(group) for group, _ in groups)]),
        np.array([c for _, c in groups]),
        compiled.rule_of,
        compiled.rule_right,
        compiled.probabilities,
        compiled.left,
        compiled.right,
    )
    alone = np.zeros(n, dtype=np.bool_)
    if not best:
        alone[automaton.bounds[:-1][np.diff(automaton.bounds) == 1]] = True
        for state in np.flatnonzero(alone).tolist():
            weights[:, state, state] = _staying(compiled, automaton.steps[state, :, state])
    _solve(equations, automaton.bounds, alone, weights, best)
    return weights


def _staying(compiled: CompiledGrammar, terminals: BoolArray) -> FloatArray:
    """Return the probability (symbols,) of strings of certain terminals only."""
    if terminals.all():
        return compiled.ends
    if not terminals.any():
        return compiled.empties
    return least_solution(compiled, terminals, np.ones(compiled.n_symbols, bool))


class _Equations(NamedTuple):
    """The equations of the symbols.

    rule_of, rule_right, probabilities, left, right : array
        As in :class:`motiondb.grammar.cfg.compiled.CompiledGrammar`.
    """

    members: IntArray  # (S,): the symbols, component by component, parts first
    bounds: IntArray  # (components + 1,): index of the first member of each component
    cyclic: BoolArray  # (components,): whether a component has a cycle
    rule_of: IntArray
    rule_right: IntArray
    probabilities: FloatArray
    left: IntArray
    right: IntArray


@njit(cache=True)
def _solve(
    equations: _Equations, blocks: IntArray, alone: BoolArray, weights: FloatArray, best: bool
) -> None:
    """Fill the weights of pairs of blocks, the nearest first; ``blocks`` (blocks + 1,) bounds them.

    Given are the weights of terminals, and those from a state to itself for the states ``alone``.
    """
    largest = np.diff(blocks).max()
    between = np.zeros((weights.shape[0], largest, largest))
    new = np.empty((largest, largest))
    for apart in range(blocks.size - 1):
        for b in range(blocks.size - 1 - apart):
            c = b + apart
            pair = blocks[b], blocks[b + 1], blocks[c], blocks[c + 1]
            if apart > 1:
                _add_between(equations, pair, weights, between, best)
            if b < c or not alone[blocks[b]]:
                _solve_pair(equations, pair, weights, (between, new), best)


@njit(cache=True)
def _add_between(
    equations: _Equations, pair: _Pair, weights: FloatArray, between: FloatArray, best: bool
) -> None:
    """Fill ``between`` (symbols, s, t) with what states strictly between two blocks give."""
    first, first_end, last, last_end = pair
    for symbol in range(weights.shape[0]):
        left, right = equations.left[symbol], equations.right[symbol]
        if left < 0:
            continue
        for s in range(first, first_end):
            total = between[symbol, s - first]
            total[:] = 0.0
            for u in range(first_end, last):
                if weights[left, s, u] > 0.0:
                    _add(total, weights[left, s, u], weights[right, u, last:last_end], best)


@njit(cache=True)
def _solve_pair(
    equations: _Equations,
    pair: _Pair,
    weights: FloatArray,
    work: tuple[FloatArray, FloatArray],
    best: bool,
) -> None:
    """Fill the weights between two blocks, component by component of the symbols."""
    first, first_end, last, last_end = pair
    new = work[1]
    for g in range(equations.cyclic.size):
        for _ in range(_MOST_ROUNDS):
            changed = False
            for symbol in equations.members[equations.bounds[g] : equations.bounds[g + 1]]:
                if not _evaluate(symbol, equations, pair, weights, work, best):
                    continue
                for s in range(first, first_end):
                    for t in range(last, last_end):
                        old, risen = weights[symbol, s, t], new[s - first, t - last]
                        if risen > old:
                            changed = changed or risen - old > _CLOSE * risen
                            weights[symbol, s, t] = risen
            if not changed or not equations.cyclic[g]:
                break


@njit(cache=True)
def _evaluate(
    symbol: int,
    equations: _Equations,
    pair: _Pair,
    weights: FloatArray,
    work: tuple[FloatArray, FloatArray],
    best: bool,
) -> bool:
    """Fill ``new`` with the right side of the equation of a symbol; False for a terminal."""
    first, first_end, last, last_end = pair
    between, new = work
    n = last_end - last
    if equations.left[symbol] >= 0:
        for s in range(first, first_end):
            row = new[s - first, :n]
            row[:] = 0.0
            if first_end < last:
                row[:] = between[symbol, s - first, :n]
            _add_tail(row, symbol, s, (equations, pair), weights, best)
        return True
    rules = range(equations.rule_of[symbol], equations.rule_of[symbol + 1])
    for s in range(first, first_end):
        row = new[s - first, :n]
        row[:] = 0.0
        for r in rules:
            below, chance = equations.rule_right[r], equations.probabilities[r]
            if below >= 0:
                _add(row, chance, weights[below, s, last:last_end], best)
            elif first == last:
                row[s - first] = max(row[s - first], chance) if best else row[s - first] + chance
    return len(rules) > 0


@njit(cache=True)
def _add_tail(
    row: FloatArray,
    symbol: int,
    s: int,
    where: tuple[_Equations, _Pair],
    weights: FloatArray,
    best: bool,
) -> None:
    """Add what a tail gives from state s by way of the two blocks of a pair themselves."""
    equations, (first, first_end, last, last_end) = where
    left, right = equations.left[symbol], equations.right[symbol]
    for u in range(first, first_end):
        if weights[left, s, u] > 0.0:
            _add(row, weights[left, s, u], weights[right, u, last:last_end], best)
    for u in range(max(last, first_end), last_end):
        if weights[left, s, u] > 0.0:
            _add(row, weights[left, s, u], weights[right, u, last:last_end], best)


@njit(cache=True)
def _add(new: FloatArray, factor: float, values: FloatArray, best: bool) -> None:
    """Add the product of a factor and values to ``new``, or take the greater of both."""
    for t in range(new.size):
        value = factor * values[t]
        new[t] = max(new[t], value) if best else new[t] + value


_TREES_A_STRING = 20
"""Largest number of trees that are examined for each requested string. Chosen by hand, to bound the
time."""

_SHOWN = 20  # largest number of possible terminals in a message

Item = tuple[int, int, int]
_Stack = tuple[Item, "_Stack"] | None
_Rules = tuple[int, "_Rules"] | None


@dataclass(frozen=True)
class Completion:
    """A sentence that matches a pattern."""

    tree: Tree  # Its most probable tree
    probability: float  # Probability of the sentence among all sentences that match

    @property
    def string(self) -> tuple[str, ...]:
        """The sentence."""
        return self.tree.leaves()


@dataclass(frozen=True)
class Completions:
    """The most probable sentences that match a pattern."""

    sentences: tuple[Completion, ...]  # The sentences, most probable first
    probability: float  # Probability that a sentence of the grammar matches
    # Whether no other sentence is more probable than the last of these. This always holds if every
    # sentence has one tree. Otherwise it may be unknown, because a sentence that was not found
    # might have many trees
    proven: bool


def complete(
    grammar: AnyGrammar, pattern: Pattern, n: int = 5, *, allowed: frozenset[str] | None = None
) -> Completions:
    r"""Return the most probable sentences that match a pattern.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> from motiondb.grammar.derivation.pattern import read_pattern
    >>> toy = read_grammar("S -> walk A shoot\nA -> dribble A [0.5] | pass [0.3] | empty [0.2]")
    >>> completions = complete(toy, read_pattern("walk ... ? shoot".split()), n=2)
    >>> [(" ".join(c.string), round(c.probability, 4)) for c in completions.sentences]
    [('walk pass shoot', 0.375), ('walk dribble pass shoot', 0.1875)]
    """
    meeting = intersect(grammar, pattern, allowed)
    total = float(meeting.ends.sum())
    if total <= 0.0:
        raise _impossible(meeting.compiled, pattern, allowed)
    best: dict[tuple[str, ...], Completion] = {}
    seen, proven, one_tree = 0.0, False, True
    for looked, (tree, chance) in enumerate(_best_trees(meeting), start=1):
        string = tree.leaves()
        if string not in best:
            exact = exp(log_probability(meeting.compiled, string))
            one_tree = one_tree and exact <= chance * (1 + 1e-6)
            seen += exact
            best[string] = Completion(tree, exact / total)
        last = sorted((c.probability for c in best.values()), reverse=True)[:n][-1] * total
        left_over = max(total - seen, 0.0)
        if len(best) >= n and (last >= left_over or (one_tree and len(best) > n)):
            proven = last >= left_over
            break
        if looked >= _TREES_A_STRING * n:
            break
    else:
        proven = True
    ranked = sorted(best.values(), key=lambda c: -c.probability)  # ties in search order
    return Completions(tuple(ranked[:n]), total, proven)


def _best_trees(meeting: Intersection) -> Iterator[tuple[Tree, float]]:
    """Yield the trees that match, the most probable first, with their probabilities."""
    compiled, automaton = meeting.compiled, meeting.automaton
    with np.errstate(divide="ignore"):
        costs = -np.log(weights_of(compiled, automaton, best=True))
        of_rules = -np.log(compiled.probabilities)
    order = count()
    agenda: list[tuple[float, int, float, _Stack, _Rules]] = []
    for state in np.flatnonzero(automaton.accepting).tolist():
        item = (compiled.start, 0, state)
        if costs[item] < inf:
            heappush(agenda, (float(costs[item]), -next(order), 0.0, (item, None), None))
    while agenda:
        ahead, _, spent, stack, rules = heappop(agenda)
        if stack is None:
            choices = compiled.rule_numbers[_listed(rules)].tolist()
            yield derive_by(compiled.grammar, choices), exp(-spent)
            continue
        item, rest = stack
        later = ahead - spent - float(costs[item])  # of the items below in the stack
        for rule, parts in _expansions(meeting, item):
            inner = sum(float(costs[part]) for part in parts)
            if inner == inf:
                continue
            more = spent + (float(of_rules[rule]) if rule >= 0 else 0.0)
            below = rest
            for part in reversed(parts):
                below = (part, below)
            taken = (rule, rules) if rule >= 0 else rules
            heappush(agenda, (more + inner + max(later, 0.0), -next(order), more, below, taken))


def _expansions(meeting: Intersection, item: Item) -> Iterator[tuple[int, tuple[Item, ...]]]:
    """Yield the rule (-1 for none) and the parts of each way to derive an item."""
    compiled, (symbol, s, t) = meeting.compiled, item
    left, right = int(compiled.left[symbol]), int(compiled.right[symbol])
    if left >= 0:
        middle = np.flatnonzero((meeting.sums[left, s] > 0) & (meeting.sums[right, :, t] > 0))
        for u in middle.tolist():
            yield -1, ((left, s, u), (right, u, t))
    elif symbol >= compiled.n_nonterminals:
        yield -1, ()
    else:
        for rule in range(compiled.rule_of[symbol], compiled.rule_of[symbol + 1]):
            below = int(compiled.rule_right[rule])
            if below >= 0:
                yield rule, ((below, s, t),)
            elif s == t:
                yield rule, ()


def _listed(rules: _Rules) -> list[int]:
    """Return linked rules in the order in which they were taken."""
    chosen = []
    while rules is not None:
        rule, rules = rules
        chosen.append(rule)
    return chosen[::-1]


def sample_completion(
    grammar: AnyGrammar,
    pattern: Pattern,
    rng: np.random.Generator,
    *,
    allowed: frozenset[str] | None = None,
) -> Tree:
    """Draw a tree from those of sentences that match a pattern, by their probabilities."""
    meeting = intersect(grammar, pattern, allowed)
    compiled, sums = meeting.compiled, meeting.sums
    if meeting.ends.sum() <= 0.0:
        raise _impossible(compiled, pattern, allowed)
    waiting: list[Item] = [(compiled.start, 0, _draw(meeting.ends, rng))]
    choices: list[int] = []
    while waiting:
        ways = list(_expansions(meeting, waiting.pop()))
        weights = np.array(
            [
                (compiled.probabilities[rule] if rule >= 0 else 1.0)
                * np.prod([sums[part] for part in parts])
                for rule, parts in ways
            ]
        )
        rule, parts = ways[_draw(weights, rng) if len(ways) > 1 else 0]
        if rule >= 0:
            choices.append(int(compiled.rule_numbers[rule]))
        waiting.extend(reversed(parts))
    return derive_by(compiled.grammar, choices)


def _draw(weights: FloatArray, rng: np.random.Generator) -> int:
    """Return a random index by weights, never one of weight 0."""
    sums = np.cumsum(weights)
    drawn = int(np.searchsorted(sums, rng.random() * sums[-1], "right"))
    return min(drawn, int(np.flatnonzero(weights)[-1]))


def _impossible(
    compiled: CompiledGrammar, pattern: Pattern, allowed: frozenset[str] | None
) -> GrammarError:
    """Return the error that says which symbol of a pattern no sentence reaches."""

    def possible(asked: Pattern) -> bool:
        return bool(intersect(compiled, asked, allowed).ends.sum() > 0)

    symbols = pattern.symbols
    reached = next(
        k for k in range(len(symbols), -1, -1) if k == 0 or possible(pattern.beginning(k))
    )
    done = Pattern(symbols[:reached], (*pattern.gaps[:reached], reached == 0 and pattern.gaps[0]))
    after = f" after {done.text!r}" if done.text else " at the beginning"
    if reached == len(symbols):
        return GrammarError(
            f"pattern: expected that a sentence can end{after}, found none that does."
            " Put '...' at the end, or another terminal."
        )
    before = pattern.gaps[: reached + 1]
    options = [
        name
        for name in compiled.names[compiled.terminals]
        if possible(
            Pattern((*symbols[:reached], PatternSymbol(name, frozenset({name}))), (*before, True))
        )
    ]
    shown = ", ".join(options[:_SHOWN]) + (", ..." if len(options) > _SHOWN else "")
    how = "anywhere" if before[-1] else "at once"
    return GrammarError(
        f"pattern: expected {symbols[reached].text!r} {how}{after}, found no sentence of the"
        f" grammar that goes on so. There it can hold {shown or 'nothing'}."
    )
