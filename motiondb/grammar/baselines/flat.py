"""The grammar that only remembers: one rule for each different sentence.

It derives what was seen and nothing else; the baseline for coverage and for description length.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule

Sentences = Sequence[Sequence[str]]


def flat_grammar(sentences: Sentences) -> Grammar:
    """S -> each different sentence, as likely as it was frequent, in order of appearance.

    Raises
    ------
    GrammarError where there is no sentence.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(flat_grammar([("a", "b"), ("c",), ("a", "b"), ("c", "c")])))
    S -> a b [0.5] | c [0.25] | c c [0.25]
    """
    counts = counted(sentences)
    start = unused_name("S", {symbol for sentence in counts for symbol in sentence})
    rules = (Rule(start, sentence, n / counts.total()) for sentence, n in counts.items())
    return Grammar(start, tuple(rules))


def counted(sentences: Sentences) -> Counter[tuple[str, ...]]:
    """Return the different sentences with their numbers, in order of appearance.

    Raises
    ------
    GrammarError where there is none.
    """
    counts = Counter(tuple(sentence) for sentence in sentences)
    if not counts:
        raise GrammarError(
            "sentences: expected at least one, found none. Give captures that hold a sentence."
        )
    return counts


def unused_name(name: str, taken: Collection[str]) -> str:
    """Return the name, with as many primes as set it apart from those taken."""
    while name in taken:
        name += "'"
    return name
