"""The toy language of the paper, and small grammars for hypothesis."""

from __future__ import annotations

from math import log

from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import Grammar, Rule, Tree, read_grammar

TOY = read_grammar("""
S -> r X1 X2 m
X1 -> X3 X4 X3
X2 -> p | s
X3 -> f | empty
X4 -> d | empty
""")

rules = st.builds(
    Rule,
    st.sampled_from(["S", "A", "B"]),
    st.lists(st.sampled_from(["S", "A", "B", "a", "b"]), max_size=3).map(tuple),
    st.sampled_from([1.0, 2.0, 3.0]),
)


@st.composite
def grammars(draw: st.DrawFn) -> Grammar:
    """Small grammars that may go on for ever, with empty rules and cycles as they come.

    Every nonterminal has a rule that ends.
    """
    actual = [*draw(st.lists(rules, min_size=2, max_size=6))]
    for left in ("S", "A", "B"):
        actual.append(Rule(left, tuple(draw(st.lists(st.sampled_from(["a", "b"]), max_size=2)))))
    return Grammar("S", tuple(actual), ("a", "b")).with_probabilities(
        [r.probability for r in actual]
    )


def tree_log_probability(grammar: Grammar, tree: Tree) -> float:
    """Natural logarithm of a tree's probability: the sum over its rules."""
    return sum(log(grammar.rules[n.rule].probability) for n in tree.nodes() if not n.is_leaf)
