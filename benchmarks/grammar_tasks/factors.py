"""Two languages compared by their passages, wherever sentences are cut.

A *passage* of a grammar is one or more of its sentences, one after another: a string of L+. Its
*factors* are the strings that occur somewhere in passages. Two grammars that cut the same movement
into sentences at other places have other sentences, but the same passages but for the ends, and so
the same factors. So

* factor precision: the share of windows of W symbols, cut at random places out of passages derived
  by the learned grammar, that are factors of the true one;
* factor recall: the share of windows of the true grammar that are factors of the learned one.

Windows begin anywhere within a first sentence, drawn as often as the grammar derives it; sentences
are appended until the window is full. W is twice the mean length of the true sentences, so a window
holds one to three borders or so.

Factors of a context-free language are context-free: Y. Bar-Hillel, M. Perles and E. Shamir, "On
formal properties of simple phrase structure grammars", Zeitschrift für Phonetik 14 (1961). For
every symbol X there are, besides X, its endings, its beginnings and its parts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.grammar.cfg.parse import compiled_form
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.languages import coverage

String = tuple[str, ...]
_MOST_SENTENCES = 1000
"""Windows drawn at most. Chosen by hand; not tuned."""


def factor_grammar(grammar: Grammar) -> Grammar:
    """The grammar of the non-empty factors of passages.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> from motiondb.grammar.cfg.parse import accepts
    >>> found = factor_grammar(read_grammar("S -> a b c"))
    >>> [accepts(found, tuple(word)) for word in ("b", "bcab", "ac", "cabcabca", "cb")]
    [True, True, False, True, False]
    """
    pairs = list(_binary(grammar))
    known = {left for left, _ in pairs}
    rules: list[tuple[str, String]] = [(f"{left}:", _full(right, known)) for left, right in pairs]
    for left, right in pairs:
        for kind in ("end", "begin", "part"):
            for part in _parts(right, kind, known):
                rules.append((f"{left}:{kind}", part))
    start = grammar.start
    rules += [
        ("P", (f"{start}:part",)),
        ("P", (f"{start}:end", "M", f"{start}:begin")),
        ("M", ()),
        ("M", (f"{start}:", "M")),
    ]
    return Grammar("P", tuple(Rule(*rule) for rule in dict.fromkeys(rules)), grammar.terminals)


def _binary(grammar: Grammar) -> Iterator[tuple[str, String]]:
    """Rules of at most two symbols on the right, for the same strings."""
    for number, rule in enumerate(grammar.rules):
        left, right = rule.left, rule.right
        for place in range(len(right) - 2):
            rest = f"{number}.{place}"
            yield left, (right[place], rest)
            left = rest
        yield left, right[-2:]


def _full(right: String, known: set[str]) -> String:
    return tuple(f"{symbol}:" if symbol in known else symbol for symbol in right)


def _parts(right: String, kind: str, known: set[str]) -> Iterator[String]:
    """Right sides for the endings, beginnings or parts of one: all may be empty."""

    def of(symbol: str, what: str) -> String:
        return (f"{symbol}:{what}",) if symbol in known else (symbol,)

    yield ()
    if not right:
        return
    first, last = right[0], right[-1]
    if len(right) == 1:
        yield of(first, kind)
    elif kind == "end":
        yield of(last, kind)
        yield of(first, kind) + _full((last,), known)
    elif kind == "begin":
        yield of(first, kind)
        yield _full((first,), known) + of(last, kind)
    else:
        yield of(first, kind)
        yield of(last, kind)
        yield of(first, "end") + of(last, "begin")


def windows(grammar: Grammar, width: int, n: int, rng: np.random.Generator) -> list[String]:
    """So many windows of ``width`` symbols, out of passages drawn at random.

    Shorter ones only where a thousand sentences do not fill one: the grammar says next to nothing.
    """
    compiled = compiled_form(grammar)
    sentences = []
    for _ in range(n):
        passage = derive(compiled, rng).leaves()
        start = int(rng.integers(max(1, len(passage))))
        for _ in range(_MOST_SENTENCES):
            if len(passage) >= start + width:
                break
            passage += derive(compiled, rng).leaves()
        sentences.append(tuple(passage[start : start + width]))
    return sentences


def match_factors(
    learned: Grammar, truth: Grammar, width: int, rng: np.random.Generator, n: int = 200
) -> tuple[float, float]:
    """Factor precision and factor recall, by so many windows each."""
    precision = coverage(compiled_form(factor_grammar(truth)), windows(learned, width, n, rng))
    recall = coverage(compiled_form(factor_grammar(learned)), windows(truth, width, n, rng))
    return precision, recall
