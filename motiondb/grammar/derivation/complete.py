"""Complete a pattern by the sentences of a grammar that match it.

The grammar is intersected with the automaton of the pattern (:mod:`.intersection`, whose W and V
are used here). The probability of the pattern is the sum of W(S, 0, t) over accepting
states t.

Trees that match are drawn from the root down by W: this is the distribution of the grammar, given
that the sentence matches. The most probable trees are found by A* search, in which V is the exact
remaining cost, so no step of the search is spent on other trees.

Source: P. E. Hart, N. J. Nilsson and B. Raphael, "A Formal Basis for the Heuristic Determination of
Minimum Cost Paths" (1968), for A*.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from math import exp, inf

import numpy as np

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.parse import AnyGrammar, log_probability
from motiondb.grammar.derivation.intersection import Intersection, intersect, weights_of
from motiondb.grammar.derivation.pattern import Pattern, Place
from motiondb.records import FloatArray

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
    """Return the error that says which place of a pattern no sentence reaches."""

    def possible(asked: Pattern) -> bool:
        return bool(intersect(compiled, asked, allowed).ends.sum() > 0)

    places = pattern.places
    reached = next(
        k for k in range(len(places), -1, -1) if k == 0 or possible(pattern.beginning(k))
    )
    done = Pattern(places[:reached], (*pattern.gaps[:reached], reached == 0 and pattern.gaps[0]))
    after = f" after {done.text!r}" if done.text else " at the beginning"
    if reached == len(places):
        return GrammarError(
            f"pattern: expected that a sentence can end{after}, found none that does."
            " Put '...' at the end, or another terminal."
        )
    before = pattern.gaps[: reached + 1]
    options = [
        name
        for name in compiled.names[compiled.terminals]
        if possible(Pattern((*places[:reached], Place(name, frozenset({name}))), (*before, True)))
    ]
    shown = ", ".join(options[:_SHOWN]) + (", ..." if len(options) > _SHOWN else "")
    how = "anywhere" if before[-1] else "at once"
    return GrammarError(
        f"pattern: expected {places[reached].text!r} {how}{after}, found no sentence of the grammar"
        f" that goes on so. There it can hold {shown or 'nothing'}."
    )
