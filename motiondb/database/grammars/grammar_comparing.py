"""A learned grammar beside simpler ones learned from the same sentences.

The flat grammar repeats the sentences, Sequitur says them again in fewer symbols, the finite state
machine knows only what follows what. Of each: its size and bits, whether it derives sentences that
were left out when it was learned, how many of the strings it makes are new, and how many the
learned grammar would not make.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.grammar.baselines.finite_state import finite_state_grammar
from motiondb.grammar.baselines.flat import flat_grammar
from motiondb.grammar.baselines.language_measures import (
    coverage,
    derived_strings,
    finite_language,
    held_out_coverage,
)
from motiondb.grammar.baselines.sequitur import sequitur_grammar
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.rules.description_length import description_length

Sentences = Sequence[tuple[str, ...]]
N_STRINGS = 500
FOLDS = 5
LIMIT = 10_000


@dataclass(frozen=True)
class ComparedGrammar:
    """A grammar and what it makes of the sentences.

    Attributes
    ----------
    nonterminals, rules : how many. bits : of the rules, and of the sentences given the rules.
    strings : how many different ones it derives; None where more than 10,000 or no end.
    held_out : share of sentences derived by a grammar of its kind learned from the others (5 parts
        in turn); None where there is only one sentence.
    new : share of its strings that are none of the sentences. outside : share of its strings that
        the learned grammar does not derive. mean_length : of its strings, terminals.
    """

    kind: str
    nonterminals: int
    rules: int
    bits: float
    strings: int | None
    held_out: float | None
    new: float
    outside: float
    mean_length: float


def compare(learned: store.LearnedGrammar, seed: int = 0) -> tuple[ComparedGrammar, ...]:
    """Return the learned grammar, then the finite state machine, Sequitur and the flat grammar."""
    sentences = learned.strings
    kinds: dict[str, tuple[Grammar, Callable[[list[tuple[str, ...]]], Grammar]]] = {
        "learned": (learned.grammar, induce),
        "finite state machine": (finite_state_grammar(sentences), finite_state_grammar),
        "Sequitur": (sequitur_grammar(sentences), sequitur_grammar),
        "flat": (flat_grammar(sentences), flat_grammar),
    }
    return tuple(
        _compared(kind, grammar, learn, learned, np.random.default_rng(seed))
        for kind, (grammar, learn) in kinds.items()
    )


def _compared(
    kind: str,
    grammar: Grammar,
    learn: Callable[[list[tuple[str, ...]]], Grammar],
    learned: store.LearnedGrammar,
    rng: np.random.Generator,
) -> ComparedGrammar:
    sentences: Sentences = learned.strings
    used = Grammar(grammar.start, grammar.rules)  # bits count the terminals that rules use
    language = finite_language(grammar, LIMIT)
    strings = derived_strings(grammar, rng, N_STRINGS)
    known = set(sentences)
    folds = min(FOLDS, len(sentences))
    return ComparedGrammar(
        kind,
        len(grammar.nonterminals),
        len(grammar.rules),
        description_length(used, sentences).total,
        None if language is None else len(language),
        held_out_coverage(learn, sentences, rng, folds=folds) if folds > 1 else None,
        sum(string not in known for string in strings) / len(strings),
        1.0 - coverage(learned.grammar, strings),
        float(np.mean([len(string) for string in strings])),
    )
