"""The flat grammar: one rule for each different sentence.

It derives the given sentences and nothing else. It is the baseline for coverage and for description
length.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule

Sentences = Sequence[Sequence[str]]


def flat_grammar(sentences: Sentences) -> Grammar:
    """Return the grammar with one rule for each different sentence, in order of appearance.

    The probability of a rule is the relative frequency of its sentence.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(flat_grammar([("a", "b"), ("c",), ("a", "b"), ("c", "c")])))
    S -> a b [0.5] | c [0.25] | c c [0.25]
    """
    counts = counted(sentences)
    start = unused_name("S", {symbol for sentence in counts for symbol in sentence})
    rules = (Rule(start, sentence, n / counts.total()) for sentence, n in counts.items())
    return Grammar(start, tuple(rules))


def counted(sentences: Sentences) -> Counter[tuple[str, ...]]:
    """Count the different sentences, in order of appearance; errors as :func:`flat_grammar`."""
    counts = Counter(tuple(sentence) for sentence in sentences)
    if not counts:
        raise GrammarError(
            "sentences: expected at least one, found none. Give captures that hold a sentence."
        )
    return counts


def unused_name(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken, by adding primes to the given one."""
    while name in taken:
        name += "'"
    return name
