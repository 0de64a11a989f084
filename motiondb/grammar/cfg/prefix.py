"""Probabilities of the next terminal after a prefix of a sentence.

P(w ...) is the probability that a sentence begins with w: the sum over all trees of all sentences
that do, left recursion included, which is summed in closed form over the chains of left corners.
Then P(t | w) = P(w t ...) / P(w ...) for a terminal t, and P(end | w) = P(w) / P(w ...); they sum
to 1. All probabilities are given that the derivation ends: for a grammar with infinite derivations,
only the finite sentences count.

A string is at most as probable as its prefixes. A search that always extends the most probable
prefix therefore yields the strings of a language in the order of their probability
(:func:`best_strings`).

Sources: F. Jelinek and J. D. Lafferty, "Computation of the Probability of Initial Substring
Generation by Stochastic Context-Free Grammars", Computational Linguistics 17 (1991); A. Stolcke,
"An Efficient Probabilistic Context-Free Parsing Algorithm that Computes Prefix Probabilities",
Computational Linguistics 21 (1995).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import count
from math import inf, log

from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, fault_at, read_sentence

END = None  # The end of the sentence among suggestions


def suggest(grammar: AnyGrammar, prefix: Sequence[str]) -> tuple[tuple[str | None, float], ...]:
    r"""Return the terminals that may come next, and the end (None), with their probabilities.

    Most probable first; equal ones in the grammar's order, the end after them. The probabilities
    sum to 1.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> hold A\nA -> dribble A [0.5] | shoot [0.3] | empty [0.2]")
    >>> [(symbol, round(p, 4)) for symbol, p in suggest(toy, ["hold", "dribble"])]
    [('dribble', 0.5), ('shoot', 0.3), (None, 0.2)]
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    if viable.position < len(prefix):
        raise fault_at(compiled, tuple(prefix), viable)
    names = compiled.names[compiled.terminals]
    pairs: list[tuple[str | None, float]] = [*zip(names, viable.weights.tolist(), strict=True)]
    pairs.append((END, viable.end))
    total = sum(weight for _, weight in pairs)
    possible = [(name, weight / total) for name, weight in pairs if weight > 0]
    return tuple(sorted(possible, key=lambda pair: -pair[1]))


def prefix_log_probability(grammar: AnyGrammar, prefix: Sequence[str]) -> float:
    """Return the log-probability that a sentence begins with a prefix; -inf if none does.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> left = read_grammar("S -> S a [0.5] | b [0.5]")
    >>> round(prefix_log_probability(left, ["b", "a"]) / log(0.5), 4)
    1.0
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    total = float(viable.weights.sum()) + viable.end
    if viable.position < len(prefix) or total <= 0:
        return -inf
    whole = compiled.ends[compiled.start]
    return log(total) + viable.exponent * log(2.0) - log(whole)


def best_strings(
    grammar: AnyGrammar, n: int, *, steps: int | float = inf
) -> Iterator[tuple[tuple[str, ...], float]]:
    """Yield the most probable strings with their log-probabilities, given that derivations end.

    Equal ones come in the order of the grammar's terminals. A finite language is yielded
    completely.

    `steps`: Bound on the number of prefixes that are extended; the search may then stop before the
    n-th string.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a S [0.6] | b [0.4]")
    >>> ["".join(string) for string, _ in best_strings(toy, 3)]
    ['b', 'ab', 'aab']
    """
    compiled = compiled_form(grammar)
    order = count()
    agenda: list[tuple[float, int, tuple[str, ...], bool]] = [(0.0, next(order), (), False)]
    n_yielded = n_extended = 0
    while agenda and n_yielded < n:
        cost, _, string, complete = heappop(agenda)
        if complete:
            n_yielded += 1
            yield string, -cost
            continue
        n_extended += 1
        if n_extended > steps:
            return
        for symbol, chance in suggest(compiled, string):
            longer = string if symbol is None else (*string, symbol)
            heappush(agenda, (cost - log(chance), next(order), longer, symbol is None))
