"""Compare two languages: precision, recall, over-generation.

Precision is the share of the learned grammar's strings that the true grammar derives. Recall is the
share of the true grammar's strings that the learned grammar derives. A finite language of moderate
size is tested completely, each string once (exact). Any other language is tested by strings that
are derived at random, repetitions included (sampled). Each result states which of the two it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.parse import AnyGrammar
from motiondb.grammar.languages import Sentences, coverage, derived_strings, finite_language


@dataclass(frozen=True)
class LanguageMatch:
    """Precision and recall of a learned grammar."""

    precision: float  # Share of the learned grammar's strings that the true grammar derives
    recall: float  # Share of the true grammar's strings that the learned grammar derives
    # Whether the learned language was tested completely; otherwise it was sampled
    precision_is_exact: bool
    # Whether the true language was tested completely; otherwise it was sampled
    recall_is_exact: bool
    n_learned: int  # Number of tested strings of the learned grammar
    n_true: int  # Number of tested strings of the true grammar


def match_languages(
    learned: AnyGrammar,
    truth: AnyGrammar,
    rng: np.random.Generator,
    *,
    n: int = 1000,
    limit: int = 10_000,
) -> LanguageMatch:
    """Return precision and recall of a learned grammar against the true one.

    A language of at most `limit` strings is tested completely, another by `n` strings.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> found = match_languages(read_grammar("S -> a | b | c | d"),
    ...     read_grammar("S -> a | b | x"), np.random.default_rng(0))
    >>> found.precision, round(found.recall, 4), found.recall_is_exact
    (0.5, 0.6667, True)
    """
    asked = []
    for grammar, other in ((learned, truth), (truth, learned)):
        whole = finite_language(grammar, limit)
        strings = sorted(whole) if whole is not None else derived_strings(grammar, rng, n)
        asked.append((coverage(other, strings), whole is not None, len(strings)))
    (precision, exact, n_learned), (recall, recall_exact, n_true) = asked
    return LanguageMatch(precision, recall, exact, recall_exact, n_learned, n_true)


def share_with_unseen_pairs(strings: Sentences, observed: Sentences) -> float:
    """Return the share of strings that hold an unobserved transition.

    A transition is a pair of neighbouring symbols, or a first or a last symbol.

    >>> share_with_unseen_pairs(["abc", "ac"], ["abc"])
    0.5
    """
    seen = {pair for sentence in observed for pair in pairwise([None, *sentence, None])}
    return sum(not seen >= {*pairwise([None, *s, None])} for s in strings) / len(strings)
