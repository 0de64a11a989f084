"""Measures that compare two languages: precision, recall, coverage, over-generation.

Precision is the share of the learned grammar's strings that the true grammar derives. Recall is the
share of the true grammar's strings that the learned grammar derives. A finite language of moderate
size is tested completely, each string once (exact). Any other language is tested by strings that
are derived at random, repetitions included (sampled). Each result states which of the two it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.baselines.finite_state import observed_transitions
from motiondb.grammar.baselines.flat import Sentences
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import Grammar, GrammarError
from motiondb.grammar.cfg.least_solution import part_groups
from motiondb.grammar.cfg.parse import AnyGrammar, accepts, compiled_form
from motiondb.grammar.derivation.derive import MEAN_LENGTH, derive

String = tuple[str, ...]


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

    `n`: Number of strings to sample from a language that is not tested completely. Chosen by hand;
    not tuned.

    `limit`: A language of at most this many strings is tested completely. Chosen by hand; not
    tuned.

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


def coverage(grammar: AnyGrammar, sentences: Sentences) -> float:
    """Return the share of the sentences that the grammar derives."""
    if not len(sentences):
        raise GrammarError("sentences: expected at least one to cover, found none. Give some.")
    known: dict[String, bool] = {}
    for sentence in map(tuple, sentences):
        if sentence not in known:
            known[sentence] = accepts(grammar, sentence)
    return sum(known[tuple(sentence)] for sentence in sentences) / len(sentences)


def held_out_coverage(
    learn: Callable[[list[String]], Grammar],
    sentences: Sentences,
    rng: np.random.Generator,
    *,
    folds: int = 5,
) -> float:
    """Return the share of sentences that a grammar learned without them derives.

    The sentences are divided into folds at random (cross-validation). Each sentence is tested with
    the grammar learned from the other folds. With as many folds as sentences, each is left out
    once.
    """
    if not 2 <= folds <= len(sentences):
        raise GrammarError(
            f"folds: expected 2 to {len(sentences)}, the number of sentences, found {folds}."
            " Use fewer folds or more sentences."
        )
    order = rng.permutation(len(sentences))
    n_derived = 0
    for fold in range(folds):
        held = set(order[fold::folds].tolist())
        grammar = learn([tuple(s) for k, s in enumerate(sentences) if k not in held])
        n_derived += sum(accepts(grammar, sentences[k]) for k in held)
    return n_derived / len(sentences)


def derived_strings(
    grammar: AnyGrammar, rng: np.random.Generator, n: int, *, most: float = MEAN_LENGTH
) -> list[String]:
    """Return the strings of random derivations."""
    compiled = compiled_form(grammar)
    return [derive(compiled, rng, most=most).leaves() for _ in range(n)]


def share_with_unseen_pairs(strings: Sentences, observed: Sentences) -> float:
    """Return the share of strings that hold an unobserved transition.

    A transition is a pair of neighbouring symbols, or a first or a last symbol.

    >>> share_with_unseen_pairs(["abc", "ac"], ["abc"])
    0.5
    """
    if not len(strings):
        raise GrammarError("strings: expected at least one, found none. Derive some.")
    seen = set(observed_transitions(observed))
    return sum(not seen >= set(observed_transitions([s])) for s in strings) / len(strings)


def finite_language(grammar: AnyGrammar, limit: int = 10_000) -> frozenset[String] | None:
    r"""Return all strings of a grammar.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> sorted("".join(s) for s in finite_language(read_grammar("S -> A A c\nA -> a | empty")))
    ['aac', 'ac', 'c']
    """
    compiled = compiled_form(grammar)
    known: list[frozenset[String]] = [frozenset()] * compiled.n_symbols
    for name, symbol in compiled.ids.items():
        known[symbol] = frozenset([(name,)])
    for group, cyclic in part_groups(compiled, np.ones(compiled.n_symbols, bool)):
        if cyclic and _grows(compiled, set(group.tolist())):
            return None
        while True:
            before = [known[symbol] for symbol in group]
            for symbol in group:
                if not compiled.terminals.start <= symbol < compiled.terminals.stop:
                    strings = _strings_of(compiled, int(symbol), known, limit)
                    if strings is None:
                        return None
                    known[symbol] = strings
            if not cyclic or before == [known[symbol] for symbol in group]:
                break
    return known[compiled.start]


def _grows(compiled: CompiledGrammar, group: set[int]) -> bool:
    """Whether a cycle among the symbols of a component adds terminals."""
    for tail in group:
        left, right = int(compiled.left[tail]), int(compiled.right[tail])
        if left in group and compiled.speaking[right]:
            return True
        if right in group and left >= 0 and compiled.speaking[left]:
            return True
    return False


def _strings_of(
    compiled: CompiledGrammar, symbol: int, known: Sequence[frozenset[String]], limit: int
) -> frozenset[String] | None:
    """Return the strings of a symbol from those of its parts; None above `limit`.

    The limit applies to each symbol: no useful symbol has more strings than the start symbol.
    """
    strings: set[String] = set()
    left, right = compiled.left[symbol], compiled.right[symbol]
    if left >= 0:
        for first in known[left]:
            strings.update(first + second for second in known[right])
            if len(strings) > limit:
                return None
        return frozenset(strings)
    for rule in range(compiled.rule_of[symbol], compiled.rule_of[symbol + 1]):
        below = compiled.rule_right[rule]
        strings.update([()] if below < 0 else known[below])
    return frozenset(strings) if len(strings) <= limit else None
