"""Sentences that look like errors: seen once, and one terminal away from what the others say.

A sentence that no other repeats is tried without itself: rules that only its tree uses are left
out, and the grammar of the others is read along an automaton that allows one edit,

    (k, e) -> (k + 1, e)  on terminal k;    (k, 0) -> (k + 1, 1)  on another one (exchanged);
    (k, 0) -> (k, 1)      on any (left out);    (k, 0) -> (k + 2, 1)  on terminal k + 1 (too many)

where k terminals are read and e edits are made. If the others derive the sentence, nothing is said.
If one edit makes a sentence of theirs, it is doubtful, and the most probable one is what was
expected.

Source: A. V. Aho and T. G. Peterson, "A minimum distance error-correcting parser for context-free
languages", SIAM Journal on Computing 1 (1972).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import BEST
from motiondb.grammar.cfg.context_free import Grammar, derive_by
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.parse import accepts, compiled_form
from motiondb.grammar.cfg.trees import Trees

String = tuple[str, ...]
FEWEST = 8  # Sentences below which nothing is said: each may be the only one of its kind
MOST_SHARE = 0.2  # Largest share of the sentences that may be errors; more are a language


@dataclass(frozen=True)
class Doubtful:
    """A sentence that looks like an error."""

    sentence: int  # Its number, from 0
    position: int  # First terminal that differs, from 0
    found: str  # The terminal there; empty at the end, or where one is missing
    expected: str  # What the others have there; empty where there is one too many
    instead: String  # The sentence of the others


def find_doubtful(
    grammar: Grammar, sentences: Sequence[String], parses: Sequence[Sequence[int]]
) -> list[Doubtful]:
    r"""Return the sentences that look like errors, in their order.

    `parses`: The numbers of the rules of the tree of each sentence (``choices_of``).

    >>> from motiondb.grammar.cfg.context_free import choices_of, read_grammar
    >>> from motiondb.grammar.cfg.parse import parse
    >>> toy = read_grammar("S -> a B c\nB -> b | x")
    >>> sentences = [tuple("abc")] * 9 + [tuple("axc")]
    >>> found, = find_doubtful(toy, sentences, [choices_of(parse(toy, s)) for s in sentences])
    >>> found.sentence, found.position, found.found, found.expected
    (9, 1, 'x', 'b')
    """
    counts = Counter(sentences)
    if len(sentences) < FEWEST:
        return []
    used = [np.bincount(rules, minlength=len(grammar.rules)) for rules in parses]
    uses = np.sum(used, axis=0)
    found = []
    for number, sentence in enumerate(sentences):
        if counts[sentence] > 1:
            continue
        left = uses - used[number]
        kept = [rule for rule, n in zip(grammar.rules, left) if n > 0]
        others = Grammar(grammar.start, tuple(kept), grammar.terminals).with_probabilities(
            left[left > 0].tolist()
        )
        instead = None if accepts(others, sentence) else nearest_sentence(others, sentence)
        if instead is not None:
            found.append(_doubtful(number, sentence, instead))
    return found if len(found) <= MOST_SHARE * len(sentences) else []


def nearest_sentence(grammar: Grammar, sentence: String) -> String | None:
    """Return the most probable sentence one edit away; None if the grammar derives none."""
    compiled = compiled_form(grammar)
    names = compiled.names[compiled.terminals]
    number = {name: n for n, name in enumerate(names)}
    n, symbols = len(sentence), [number.get(name, -1) for name in sentence]
    steps = np.zeros((2 * n + 2, len(names), 2 * n + 2), dtype=np.bool_)  # state 2 k + e
    for k in range(n + 1):
        steps[2 * k, :, 2 * k + 1] = True
        if k < n:
            steps[2 * k, :, 2 * k + 3] = True
            if symbols[k] >= 0:
                steps[2 * k : 2 * k + 2, symbols[k], :] = False
                steps[2 * k, symbols[k], [2 * k + 1, 2 * k + 2]] = True
                steps[2 * k + 1, symbols[k], 2 * k + 3] = True
        if k + 1 < n and symbols[k + 1] >= 0:
            steps[2 * k, symbols[k + 1], 2 * k + 5] = True
    final = np.zeros(2 * n + 2, dtype=np.bool_)
    final[[2 * n + 1, *([2 * n - 2] if n else [])]] = True
    automaton = automata.from_steps(steps, final, np.arange(2 * n + 3))
    best = inside(compiled, automaton, BEST)
    tops = [(compiled.start, 0, t) for t in np.flatnonzero(final).tolist()]
    for choices in Trees(compiled, best, compiled.weights(BEST)).in_order(tops):
        return derive_by(compiled.grammar, choices).leaves()
    return None


def _doubtful(number: int, sentence: String, instead: String) -> Doubtful:
    position = next(
        (n for n, (a, b) in enumerate(zip(sentence, instead)) if a != b),
        min(len(sentence), len(instead)),
    )
    longer = len(sentence) - len(instead)
    found = sentence[position] if longer >= 0 else ""
    expected = instead[position] if longer <= 0 else ""
    return Doubtful(number, position, found, expected, instead)
