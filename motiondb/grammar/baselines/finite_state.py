"""The finite state machine of observed transitions, as a grammar.

Each terminal is a state. A transition leads to each terminal that was observed right after it, and
to the end if a sentence ended with it. The probability of a transition is its relative frequency.
As rules these are ``S -> a after_a`` and ``after_a -> b after_b | empty``, so the machine parses,
suggests and derives like any grammar. It models which symbol follows which, and nothing longer.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 7, where it is the baseline.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

from motiondb.grammar.baselines.flat import Sentences, counted, unused_name
from motiondb.grammar.cfg.context_free import Grammar, Rule

Transition = tuple[str | None, str | None]


def observed_transitions(sentences: Sentences) -> Counter[Transition]:
    """Count how often each symbol is followed by each other symbol.

    >>> observed_transitions(["ab", "b"])[None, "b"]
    1
    """
    counts: Counter[Transition] = Counter()
    for sentence in sentences:
        counts.update(pairwise([None, *sentence, None]))
    return counts


def finite_state_grammar(sentences: Sentences) -> Grammar:
    """Return the right-linear grammar of the machine, its rules in order of first appearance.

    Errors as in :func:`motiondb.grammar.baselines.flat.flat_grammar`.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(finite_state_grammar(["ab", "abb"])))
    S -> a after_a
    after_a -> b after_b
    after_b -> empty [0.6667] | b after_b [0.3333]
    """
    transitions = observed_transitions([*counted(sentences).elements()])
    states = [a for a in dict.fromkeys(before for before, _ in transitions) if a is not None]
    names: dict[str | None, str] = {None: unused_name("S", states)}
    for state in states:
        names[state] = unused_name(f"after_{state}", {*states, *names.values()})
    return Grammar(names[None], tuple(_rules(transitions, names)))


def _rules(transitions: Counter[Transition], names: dict[str | None, str]) -> Iterator[Rule]:
    """Yield the rule of each transition, with its relative frequency."""
    totals: Counter[str | None] = Counter()
    for (before, _), number in transitions.items():
        totals[before] += number
    for left in names:
        for (before, after), number in transitions.items():
            if before == left:
                right = () if after is None else (after, names[after])
                yield Rule(names[before], right, number / totals[before])
