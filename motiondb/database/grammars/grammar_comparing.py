"""Compare a learned grammar with simpler grammars learned from the same sentences.

The flat grammar has one rule for each sentence. Sequitur rewrites the sentences with fewer symbols.
The finite state machine stores which terminal follows which. For each grammar the comparison gives
its size, its description length, the share of held-out sentences that it derives, the share of its
strings that are new, and the share of its strings that the learned grammar does not derive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.database.learned_grammar import LearnedGrammar
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
N_STRINGS = 500  # Number of strings that are derived at random from each grammar
FOLDS = 5  # Most parts of the sentences in the cross-validation
LIMIT = 10_000  # Largest language whose strings are counted


@dataclass(frozen=True)
class ComparedGrammar:
    """A grammar with the measures by which it is compared."""

    kind: str  # Name of the method by which the grammar was learned
    nonterminals: int
    rules: int
    bits: float  # Description length in bits: the rules, and the sentences given the rules
    # Number of different strings that the grammar derives. None if there are more than ``LIMIT``,
    # or infinitely many
    strings: int | None
    # Share of the sentences that are derived by a grammar of this kind learned from the other
    # parts, by cross-validation with at most ``FOLDS`` parts. None if there is only one sentence
    held_out: float | None
    new: float  # Share of the strings derived at random that are not among the sentences
    # Share of the strings derived at random that the learned grammar does not derive
    outside: float
    mean_length: float  # Mean length of the strings derived at random, in terminals


def compare(learned: LearnedGrammar, seed: int = 0) -> tuple[ComparedGrammar, ...]:
    """Compare a learned grammar with a finite state machine, Sequitur and a flat grammar."""
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
    learned: LearnedGrammar,
    rng: np.random.Generator,
) -> ComparedGrammar:
    """Measure one grammar; ``learn`` learns another of its kind from a list of sentences."""
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
