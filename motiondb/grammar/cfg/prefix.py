"""What may come next: probabilities of the next terminal after the beginning of a sentence.

P(w ...) is the probability that a sentence begins with w: the sum over all trees of all sentences
that do, also through left recursion, which is summed in closed form over the chains of left
corners. Then P(t | w) = P(w t ...) / P(w ...) for a terminal t, and P(end | w) = P(w) / P(w ...);
they sum to 1. All probabilities are given that the derivation ends: of a grammar that goes on for
ever with some probability, only the finite sentences count.

Sources: F. Jelinek and J. D. Lafferty, "Computation of the Probability of Initial Substring
Generation by Stochastic Context-Free Grammars", Computational Linguistics 17 (1991); A. Stolcke,
"An Efficient Probabilistic Context-Free Parsing Algorithm that Computes Prefix Probabilities",
Computational Linguistics 21 (1995).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log

from motiondb.grammar.cfg.compiled import finite_part
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, fault_at, read_sentence

END = None
"""Stands for the end of the sentence among suggestions."""


def suggest(grammar: AnyGrammar, prefix: Sequence[str]) -> tuple[tuple[str | None, float], ...]:
    """The terminals that may come next with their probabilities, and the end (None).

    Most probable first, equal ones in the grammar's order, the end after them; the probabilities
    sum to 1.

    Raises
    ------
    ParseError where no sentence of the grammar begins so.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> hold A\\nA -> dribble A [0.5] | shoot [0.3] | empty [0.2]")
    >>> [(symbol, round(p, 4)) for symbol, p in suggest(toy, ["hold", "dribble"])]
    [('dribble', 0.5), ('shoot', 0.3), (None, 0.2)]
    """
    compiled = finite_part(compiled_form(grammar))
    reading = read_sentence(compiled, prefix)
    if reading.position < len(prefix):
        raise fault_at(compiled, tuple(prefix), reading)
    names = compiled.names[compiled.terminals]
    pairs: list[tuple[str | None, float]] = [*zip(names, reading.weights.tolist(), strict=True)]
    pairs.append((END, reading.end))
    total = sum(weight for _, weight in pairs)
    found = [(name, weight / total) for name, weight in pairs if weight > 0]
    return tuple(sorted(found, key=lambda pair: -pair[1]))


def prefix_log_probability(grammar: AnyGrammar, prefix: Sequence[str]) -> float:
    """Natural logarithm of the probability that a sentence begins so; -inf where none does.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> left = read_grammar("S -> S a [0.5] | b [0.5]")
    >>> round(prefix_log_probability(left, ["b", "a"]) / log(0.5), 4)
    1.0
    """
    compiled = finite_part(compiled_form(grammar))
    reading = read_sentence(compiled, prefix)
    total = float(reading.weights.sum()) + reading.end
    if reading.position < len(prefix) or total <= 0:
        return -inf
    return log(total) + reading.exponent * log(2.0)
