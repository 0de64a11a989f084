"""A passage: sentences one after another, as a long take holds them, nothing marking their ends.

For a grammar with the start symbol S, the passages are the strings of

    P -> S P | S

so cutting a passage into sentences is parsing it with two more rules, and the most probable tree
gives the most probable cuts. The rules of the grammar keep their numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.grammar.cfg.context_free import Grammar, Rule, Tree
from motiondb.grammar.cfg.parse import parse


def passage_grammar(grammar: Grammar) -> Grammar:
    """The grammar of passages: two more rules at the end, and a start symbol that is new."""
    name = f"{grammar.start}+"
    while name in grammar.nonterminals or name in grammar.terminals:
        name += "+"
    rules = (Rule(name, (grammar.start, name), 0.5), Rule(name, (grammar.start,), 0.5))
    return Grammar(name, (*grammar.rules, *rules), grammar.terminals)


def parse_passage(grammar: Grammar, string: Sequence[str]) -> tuple[Tree, ...]:
    """The most probable sentences of a passage, each with its tree.

    Raises
    ------
    ParseError where the string is no passage, with the first place where none goes on so.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a B\\nB -> b | c c")
    >>> [" ".join(tree.leaves()) for tree in parse_passage(toy, "a b a c c".split())]
    ['a b', 'a c c']
    """
    tree = parse(passage_grammar(grammar), string)
    found = [tree.children[0]]
    while len(tree.children) == 2:
        tree = tree.children[1]
        found.append(tree.children[0])
    return tuple(found)
