"""Description length: the bits that hold a grammar and, given it, the sentences.

The grammar: all rules as one sequence, left side then right side, a separator between rules, each
symbol log2(n(V) + n(Sigma) + 1) bits for n(V) nonterminals and n(Sigma) terminals. The sentences:
at every node of each parse, in preorder, the number of the rule among the h rules of that
nonterminal, log2 h bits. The most economical parse counts, so that an ambiguous grammar is not
charged for a tree that nobody would send.

DL(Z) = B(G) + B(Z | G), for sentences Z and grammar G.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Tree, choices_of, derive_by
from motiondb.grammar.cfg.parse import parse

Sentence = tuple[str, ...]
Code = tuple[int, ...]
"""A sentence sent: at each node in preorder, which of the nonterminal's rules, from 0."""


@dataclass(frozen=True)
class DescriptionLength:
    """Bits of the rules and bits of the sentences given the rules."""

    grammar: float
    sentences: float

    @property
    def total(self) -> float:
        """B(G) + B(Z | G)."""
        return self.grammar + self.sentences


def grammar_bits(grammar: Grammar) -> float:
    r"""B(G): symbols and separators of all rules, log2(n(V) + n(Sigma) + 1) bits each.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> round(grammar_bits(read_grammar("S -> a b A c d\nA -> x | y")), 4)
    38.0391
    """
    alphabet = len(grammar.nonterminals) + len(grammar.terminals) + 1
    return sequence_length(len(rule.right) for rule in grammar.rules) * math.log2(alphabet)


def sequence_length(right_lengths: Iterable[int]) -> int:
    """Symbols of rules with right sides of these lengths, the separators between them counted.

    >>> sequence_length([5, 1, 1])
    12
    """
    lengths = list(right_lengths)
    return sum(lengths) + 2 * len(lengths) - 1 if lengths else 0


def tree_bits(grammar: Grammar, tree: Tree) -> float:
    """Bits that name the rules of a tree: log2 of the number of alternatives at each node."""
    lefts = (grammar.rules[number].left for number in choices_of(tree))
    return sum(math.log2(len(grammar.rules_of[left])) for left in lefts)


def most_economical_tree(grammar: Grammar, sentence: Sentence) -> Tree:
    """Return the parse of the fewest bits: the most probable one if alternatives are equal.

    Raises
    ------
    GrammarError where the sentence is not in the language.
    """
    return parse(grammar.with_probabilities([1.0] * len(grammar.rules)), sentence)


def description_length(
    grammar: Grammar, sentences: Iterable[Sentence] = (), *, trees: Sequence[Tree] | None = None
) -> DescriptionLength:
    """DL of sentences under a grammar; their most economical parses are found unless given.

    Raises
    ------
    GrammarError where a sentence is not in the language.
    """
    if trees is None:
        known: dict[Sentence, float] = {}
        bits = 0.0
        for sentence in sentences:
            if sentence not in known:
                known[sentence] = tree_bits(grammar, most_economical_tree(grammar, sentence))
            bits += known[sentence]
    else:
        bits = sum(tree_bits(grammar, tree) for tree in trees)
    return DescriptionLength(grammar_bits(grammar), bits)


def encode(grammar: Grammar, trees: Iterable[Tree]) -> tuple[Code, ...]:
    """Return the codes that send sentences, given by their parses: S1 A2 is (0, 1)."""
    rank = {
        number: place
        for numbers in grammar.rules_of.values()
        for place, number in enumerate(numbers)
    }
    return tuple(tuple(rank[number] for number in choices_of(tree)) for tree in trees)


def decode(grammar: Grammar, codes: Iterable[Code]) -> tuple[Sentence, ...]:
    """Return the sentences back from their codes, exactly.

    Raises
    ------
    GrammarError where a code is of another grammar.
    """
    return tuple(_decode(grammar, code).leaves() for code in codes)


def _decode(grammar: Grammar, code: Code) -> Tree:
    choices: list[int] = []
    waiting = [grammar.start]
    for place in code:
        while waiting and not grammar.is_nonterminal(waiting[-1]):
            waiting.pop()
        numbers = grammar.rules_of[waiting.pop()] if waiting else ()
        if not 0 <= place < len(numbers):
            raise GrammarError(
                f"code: expected one of {len(numbers)} alternatives, found number {place}."
                " The code belongs to another grammar: encode again."
            )
        choices.append(numbers[place])
        waiting.extend(reversed(grammar.rules[numbers[place]].right))
    return derive_by(grammar, choices)
