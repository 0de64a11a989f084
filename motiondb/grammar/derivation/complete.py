"""Complete a pattern by the sentences of a grammar that match it.

The grammar meets the automaton of the pattern (:func:`motiondb.grammar.cfg.inside.inside`). The
probability of the pattern is the sum of W(S, 0, t) over accepting states t. The automaton reads
each string in one way at most, so no string is counted twice. Trees that match are drawn by the
sums, and found in the order of their weights by the greatest weights
(:class:`motiondb.grammar.cfg.trees.Trees`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import exp, fsum, log

import numpy as np

from motiondb.grammar.cfg.automata import Automaton
from motiondb.grammar.cfg.closure import BEST, SUM
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.inside import Inside, inside
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, log_probability
from motiondb.grammar.cfg.trees import Trees, drawn
from motiondb.grammar.derivation.pattern import Pattern, PatternSymbol, acceptor_of
from motiondb.records import FloatArray


@dataclass(frozen=True, eq=False)
class Intersection:
    """A grammar and an automaton."""

    compiled: CompiledGrammar
    automaton: Automaton  # The automaton over its terminals

    @cached_property
    def sums(self) -> Inside:
        """The sums between its states."""
        return inside(self.compiled, self.automaton, SUM)

    @property
    def ends(self) -> FloatArray:
        """The probability (states,) of sentences that lead to each accepting state, else 0."""
        weights = [self.sums.weight(self.compiled.start, 0, t) for t in range(len(self.sums.loops))]
        return np.where(self.automaton.final, weights, 0.0)


def intersect(
    grammar: AnyGrammar, pattern: Pattern, allowed: frozenset[str] | None = None
) -> Intersection:
    """Intersect a grammar with the automaton of a pattern."""
    compiled = compiled_form(grammar)
    automaton = acceptor_of(pattern, compiled.names[compiled.terminals], allowed)
    return Intersection(compiled, automaton)


_TREES_A_STRING = 20
"""Largest number of trees that are examined for each requested string. Chosen by hand, to bound the
time."""

_SHOWN = 20  # largest number of possible terminals in a message


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
    compiled, rules = meeting.compiled, meeting.compiled.grammar.rules
    best = inside(compiled, meeting.automaton, BEST)
    tops = [(compiled.start, 0, t) for t in np.flatnonzero(meeting.automaton.final).tolist()]
    chances = np.zeros(len(rules))
    chances[compiled.rule_numbers] = compiled.probabilities
    for choices in Trees(compiled, best, compiled.weights(BEST)).in_order(tops):
        chance = exp(fsum(log(chances[rule]) for rule in choices))
        yield derive_by(compiled.grammar, choices), chance


def sample_completions(
    grammar: AnyGrammar,
    pattern: Pattern,
    rng: np.random.Generator,
    *,
    allowed: frozenset[str] | None = None,
) -> Iterator[Tree]:
    """Draw trees of sentences that match a pattern, by their probabilities, endlessly."""
    meeting = intersect(grammar, pattern, allowed)
    compiled, ends = meeting.compiled, meeting.ends
    if ends.sum() <= 0.0:
        raise _impossible(compiled, pattern, allowed)
    trees = Trees(compiled, meeting.sums, compiled.weights(SUM))
    while True:
        tree = trees.draw((compiled.start, 0, drawn(ends, rng)), rng)
        assert tree is not None
        yield derive_by(compiled.grammar, tree[0])


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
