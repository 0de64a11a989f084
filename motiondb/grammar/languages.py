"""Measures of languages, and the finite state machine with which a learned grammar is compared.

In the machine each terminal is a state. A transition leads to each terminal that was observed right
after it, and to the end if a sentence ended with it. The probability of a transition is its
relative frequency. As rules these are ``S -> a after_a`` and ``after_a -> b after_b | empty``, so
the machine parses, suggests and derives like any grammar. It models which symbol follows which, and
nothing longer.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 7, where the machine is the baseline.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule
from motiondb.grammar.cfg.least_solution import part_groups
from motiondb.grammar.cfg.parse import AnyGrammar, accepts, compiled_form
from motiondb.grammar.derivation.derive import MEAN_LENGTH, derive

String = tuple[str, ...]
Sentences = Sequence[Sequence[str]]


def finite_state_grammar(sentences: Sentences) -> Grammar:
    """Return the right-linear grammar of the machine, its rules in order of first appearance.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(finite_state_grammar(["ab", "abb"])))
    S -> a after_a
    after_a -> b after_b
    after_b -> empty [0.6667] | b after_b [0.3333]
    """
    if not sentences:
        raise GrammarError(
            "sentences: expected at least one, found none. Give captures that hold a sentence."
        )
    # Equal sentences are counted together, at the place of the first: it decides the order of rules
    repeated = Counter(tuple(sentence) for sentence in sentences).elements()
    transitions = Counter(pair for s in repeated for pair in pairwise([None, *s, None]))
    states = [a for a in dict.fromkeys(before for before, _ in transitions) if a is not None]
    names: dict[str | None, str] = {None: _unused_name("S", states)}
    for state in states:
        names[state] = _unused_name(f"after_{state}", {*states, *names.values()})
    totals: Counter[str | None] = Counter()
    for (before, _), number in transitions.items():
        totals[before] += number
    return Grammar(
        names[None],
        tuple(
            Rule(names[left], () if b is None else (b, names[b]), number / totals[left])
            for left in names
            for (a, b), number in transitions.items()
            if a == left
        ),
    )


def _unused_name(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken, by adding primes to the given one."""
    while name in taken:
        name += "'"
    return name


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
