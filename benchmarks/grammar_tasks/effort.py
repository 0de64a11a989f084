"""How near the search of rules comes to the true grammar's bits, and in what time.

    PYTHONPATH=benchmarks python -m grammar_tasks.effort \
        [--seeds 300 301 302] [--grammars 12] [--sentences 10 20 40]

Sentences are drawn from the sample data's three grammars, with other seeds than those that
``docs/measured/grammar.md`` reports, and from small random grammars: 6 to 10 terminals, 3 to 5
nonterminals
of 2 or 3 alternatives, none deriving itself. The efforts of ``compaction`` were chosen by what this
prints. Fewer bits than the true grammar's are possible: the language may have a shorter grammar, or
a few sentences one that fits them better.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

import numpy as np

from grammar_tasks.language_match import match_languages
from grammar_tasks.truth import load_truth
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce_with_bits
from motiondb.grammar.languages import finite_language
from motiondb.grammar.rules.description_length import description_length

LEAST_STRINGS, MOST_STRINGS, LONGEST = 60, 200_000, 20
"""Strings of a random language at least and at most, and symbols of its longest string. Chosen by
hand, so that a language can be enumerated; not tuned."""
OF_RANDOM = 40
"""Sentences drawn from every random language. Chosen by hand; not tuned."""


def random_grammar(seed: int) -> Grammar:
    """A grammar of 60 or more strings of at most 20 symbols, all its nonterminals used."""
    rng = np.random.default_rng(seed)
    while True:
        grammar = _drawn_grammar(rng)
        known = {symbol for rule in grammar.rules for symbol in rule.right}
        if any(rule.left not in known for rule in grammar.rules if rule.left != grammar.start):
            continue
        language = finite_language(grammar, MOST_STRINGS)
        if language is None or len(language) < LEAST_STRINGS:
            continue
        if max(map(len, language)) <= LONGEST:
            return grammar


def _drawn_grammar(rng: np.random.Generator) -> Grammar:
    n_terminals, n_lefts = int(rng.integers(6, 11)), int(rng.integers(3, 6))
    lefts = ["S", *(f"N{k}" for k in range(1, n_lefts))]
    rules = []
    for k, left in enumerate(lefts):
        number = 1 if k == 0 and rng.random() < 0.7 else int(rng.integers(2, 4))
        rights = set()
        for _ in range(number):
            length = int(rng.integers(3, 6)) if k == 0 else int(rng.integers(1, 4))
            rights.add(tuple(_symbol(rng, lefts[k + 1 :], n_terminals) for _ in range(length)))
        rules += [Rule(left, right, 1.0 / len(rights)) for right in sorted(rights)]
    return Grammar("S", tuple(rules))


def _symbol(rng: np.random.Generator, below: Sequence[str], n_terminals: int) -> str:
    if below and rng.random() < 0.5:
        return below[int(rng.integers(len(below)))]
    return f"t{rng.integers(n_terminals)}"


def judged(name: str, truth: Grammar, n: int, seed: int) -> float:
    """Print one row; the bits above the true grammar's, as a share of those."""
    rng = np.random.default_rng(seed)
    sentences = [derive(truth, rng).leaves() for _ in range(n)]
    started = time.process_time()
    induced = induce_with_bits(sentences)
    spent = time.process_time() - started
    match = match_languages(induced.grammar, truth, np.random.default_rng(0))
    bits = description_length(truth, sentences).total
    print(
        f"{name:>10} {n:>4} {seed:>5} {bits:9.1f} {induced.bits.total:9.1f}"
        f" {match.precision:9.2f} {match.recall:6.2f} {spent:8.2f}",
        flush=True,
    )
    return max(0.0, induced.bits.total / bits - 1.0)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print all rows."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="*", default=[300, 301, 302])
    parser.add_argument("--grammars", type=int, default=12)
    parser.add_argument("--sentences", type=int, nargs="+", default=[10, 20, 40])
    chosen = parser.parse_args(arguments)
    print("   grammar    n  seed true bits     found precision recall  seconds")
    above = [
        judged(name, truth, n, seed)
        for name, truth in load_truth()[0].items()
        for n in chosen.sentences
        for seed in chosen.seeds
    ]
    above += [
        judged(f"random {seed}", random_grammar(seed), OF_RANDOM, seed)
        for seed in range(10, 10 + chosen.grammars)
    ]
    reached = sum(share <= 0.0 for share in above)
    print(f"{reached} of {len(above)} no more bits; {np.mean(above):.2%} above on average")


if __name__ == "__main__":
    main()
