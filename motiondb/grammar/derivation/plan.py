"""Plan from the beginning of a sentence to goals: the best continuation.

The string begins with a prefix w and then passes goals in order; anything may come between them and
after the last. Such strings are those of a small automaton: a state for
each symbol of w, then a state for each goal, which stays on what does not meet it. The best tree
over it is the most probable one, or that of the shortest string; the other of the two breaks ties.

For the shortest string a symbol costs more than any tree that fits into a plan: 1/16 bit, where a
rule of probability p costs a millionth of -log2 p. These sums are as exact as floating-point
numbers for trees of up to 60,000 bits.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from motiondb.errors import suggestion
from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import BEST
from motiondb.grammar.cfg.compiled import RULE_PENALTY, CompiledGrammar
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, fault_at, read_sentence
from motiondb.grammar.cfg.trees import best_rules
from motiondb.records import IntArray

_SYMBOL = 2.0**-0.0625  # Weight of a symbol where the shortest string is wanted
_SMALL = 1e-6  # Exponent of a rule's probability there


@dataclass(frozen=True)
class Plan:
    """A continuation of a prefix."""

    # Terminals after the prefix, up to and including the goal. Empty without a goal
    to_goal: tuple[str, ...]
    then: tuple[str, ...]  # Terminals after the goal that complete the sentence
    tree: Tree  # The tree of the whole sentence, with the prefix
    log_probability: float  # Natural logarithm of the probability of the tree


def plan(
    grammar: AnyGrammar, prefix: Sequence[str], goal: str | None = None, *, shortest: bool = False
) -> Plan:
    r"""Return the most probable, or the shortest, continuation to a goal and to a full sentence.

    The most probable tree is chosen, not the most probable string. Of the shortest continuations,
    the one with the most probable tree is chosen.

    `goal`: A terminal that must follow. If the prefix holds it already, it must occur again.
    Without a goal the sentence is only completed.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> hold A\nA -> dribble A [0.6] | shoot [0.3] | pass S [0.1]")
    >>> found = plan(toy, ["hold"], "pass")
    >>> found.to_goal, found.then
    (('pass',), ('hold', 'shoot'))
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    if viable.position < len(prefix):
        raise fault_at(compiled, tuple(prefix), viable)
    if goal is not None and goal not in compiled.ids:
        near = suggestion(goal, compiled.ids) or " Use a terminal of the grammar."
        raise GrammarError(f"goal: expected a terminal of the grammar, found {goal!r}.{near}")
    goals = [] if goal is None else [{goal}]
    choices = best_plan(_for_shortest(compiled) if shortest else compiled, prefix, goals, shortest)
    if isinstance(choices, int):
        raise GrammarError(
            f"goal: expected that {goal!r} can come after {' '.join(prefix) or 'the beginning'!r},"
            " found no sentence of the grammar in which it does. Choose another goal, or plan"
            " from an earlier place."
        )
    tree = derive_by(compiled.grammar, compiled.rule_numbers[choices].tolist())
    rest = tree.leaves()[len(prefix) :]
    cut = 0 if goal is None else rest.index(goal) + 1
    chance = float(np.log(compiled.probabilities[choices]).sum())
    return Plan(rest[:cut], rest[cut:], tree, chance)


@lru_cache(maxsize=16)
def _for_shortest(compiled: CompiledGrammar) -> CompiledGrammar:
    return replace(compiled, probabilities=compiled.probabilities**_SMALL)


def best_plan(
    compiled: CompiledGrammar,
    prefix: Sequence[str],
    goals: Sequence[Collection[str]],
    shortest: bool,
) -> IntArray | int:
    """Return the rules in use of the best tree that passes a prefix and goals.

    Without one, return how many symbols and goals a sentence can pass; -1 if no sentence begins
    with the prefix.
    """
    terminals = np.arange(len(compiled.ids))
    wanted = [
        np.array([compiled.ids[name] for name in passed if name in compiled.ids], dtype=np.int64)
        - compiled.n_nonterminals
        for passed in (*([name] for name in prefix), *map(sorted, goals))
    ]
    n = len(prefix)
    stays = [terminals[:0]] * n + [np.setdiff1d(terminals, goal) for goal in wanted[n:]]
    weight = _SYMBOL if shortest else np.exp(-RULE_PENALTY)
    weights = np.full(len(terminals), weight)
    made = inside(compiled, automata.items(wanted, [*stays, terminals], weights), BEST)
    choices = best_rules(compiled, made, compiled.weights(BEST))
    if choices is not None:
        return choices
    passed = [t for t in range(n, len(wanted) + 1) if made.weight(compiled.start, 0, t) > 0]
    return max(passed, default=-1)
