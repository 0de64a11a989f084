"""Description length: the bits of a grammar plus the bits of the sentences, given the grammar.

The rules are written as one sequence: left side, right side, and a separator between rules. Each
symbol of it costs log2(n(V) + n(Sigma) + 1) bits, for n(V) nonterminals and n(Sigma) terminals. A
sentence is sent as its parse: each node, in preorder, names one of the h rules of its nonterminal
and costs log2 h bits. An ambiguous grammar allows several parses; the cheapest one is used.

DL(Z) = B(G) + B(Z | G), for sentences Z and grammar G.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from motiondb.grammar.cfg.context_free import Grammar, Tree, choices_of
from motiondb.grammar.cfg.parse import parse

Sentence = tuple[str, ...]


@dataclass(frozen=True)
class DescriptionLength:
    """The two parts of a description length."""

    grammar: float  # Bits of the rules, B(G)
    sentences: float  # Bits of the sentences given the rules, B(Z | G)

    @property
    def total(self) -> float:
        """The sum B(G) + B(Z | G), in bits."""
        return self.grammar + self.sentences


def grammar_bits(grammar: Grammar) -> float:
    r"""Return B(G), the bits of all rules.

    Each symbol and each separator costs log2(n(V) + n(Sigma) + 1) bits.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> round(grammar_bits(read_grammar("S -> a b A c d\nA -> x | y")), 4)
    38.0391
    """
    alphabet = len(grammar.nonterminals) + len(grammar.terminals) + 1
    return sequence_length(len(rule.right) for rule in grammar.rules) * math.log2(alphabet)


def sequence_length(right_lengths: Iterable[int]) -> int:
    """Return the number of symbols in rules that are written one after another.

    `right_lengths`: Length of each right side. Each rule also has one left side, and there is one
    separator between two rules.

    >>> sequence_length([5, 1, 1])
    12
    """
    lengths = list(right_lengths)
    return sum(lengths) + 2 * len(lengths) - 1 if lengths else 0


def tree_bits(grammar: Grammar, tree: Tree) -> float:
    """Return the bits that name the rules of a tree.

    Each node costs log2 of the number of rules of its nonterminal.
    """
    lefts = (grammar.rules[number].left for number in choices_of(tree))
    return sum(math.log2(len(grammar.rules_of[left])) for left in lefts)


def most_economical_tree(grammar: Grammar, sentence: Sentence) -> Tree:
    """Return the parse of a sentence that costs the fewest bits.

    It is the most probable parse when all rules of each nonterminal are equally probable.
    """
    return parse(grammar.with_probabilities([1.0] * len(grammar.rules)), sentence)


def description_length(
    grammar: Grammar, sentences: Iterable[Sentence] = (), *, trees: Sequence[Tree] | None = None
) -> DescriptionLength:
    """Return the description length of sentences under a grammar.

    `sentences`: Sentences to parse; for each, the cheapest parse is used. Ignored if `trees` is
    given.
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
