"""Whether a language foresees held-out sentences, at equal over-generation.

A language that allows more holds more held-out sentences. So languages are compared at equal size:
a held-out sentence counts only if it is among the n most probable strings of the language. For a
sentence of probability p, the number of strings that are at least as probable is the sum of 1 over
these strings. With strings s drawn from the language it is estimated as the mean of 1 / P(s) over
those with P(s) >= p, and of 0 over the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, inf

import numpy as np

from grammar_tasks.tables import table
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.cfg.parse import compiled_form, log_probability
from motiondb.grammar.languages import derived_strings

String = tuple[str, ...]
Learn = Callable[[Sequence[String]], Grammar]
SIZES = (100, 10_000, 1_000_000)
"""Numbers of most probable strings among which a held-out sentence is counted. Chosen by hand."""
DRAWN, MOST = 300, 40.0
"""Strings drawn, and their largest mean length. Chosen by hand; not tuned."""


def foreseen_rows(learners: dict[str, Learn], sentences: Sequence[String], folds: int) -> str:
    """A row for each learner: held-out sentences in its language, and among the most probable."""
    if len(sentences) < 2:
        return "One sentence only: nothing can be held out."
    rows = []
    for kind, learn in learners.items():
        ranks = held_out_ranks(learn, sentences, min(folds, len(sentences)))
        cells = [f"{np.mean([rank <= size for rank in ranks]):.0%}" for size in SIZES]
        rows.append([kind, f"{np.mean([rank < inf for rank in ranks]):.0%}", *cells])
    heads = ["held-out sentences", "in the language"]
    return table([*heads, *(f"among {size:,} most probable" for size in SIZES)], rows)


def held_out_ranks(learn: Learn, sentences: Sequence[String], folds: int) -> list[float]:
    """The rank of each sentence in the language of the others; infinite where it is not in it."""
    order = np.random.default_rng(0).permutation(len(sentences))
    ranks = []
    for part in np.array_split(order, folds):
        held = set(part.tolist())
        grammar = learn([s for k, s in enumerate(sentences) if k not in held])
        ranks += learned_ranks(grammar, [sentences[k] for k in part.tolist()])
    return ranks


def learned_ranks(grammar: Grammar, tested: Sequence[String]) -> list[float]:
    """The rank of each sentence in a language; infinite where it is not in it."""
    compiled = compiled_form(grammar)
    strings = derived_strings(grammar, np.random.default_rng(1), DRAWN, most=MOST)
    drawn = np.array([log_probability(compiled, string) for string in strings])
    return [_rank(log_probability_of(grammar, string), drawn) for string in tested]


def log_probability_of(grammar: Grammar, string: String) -> float:
    """The log-probability; -inf for a string that is not in the language."""
    if not set(string) <= set(grammar.terminals):
        return -inf
    return log_probability(compiled_form(grammar), string)


def _rank(log_p: float, drawn: np.ndarray) -> float:
    if log_p == -inf:
        return inf
    as_probable = drawn[drawn >= log_p - 1e-9]
    return max(1.0, sum(exp(-one) for one in as_probable.tolist()) / len(drawn))
