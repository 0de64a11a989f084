"""Three small context-free grammars from which long takes are made, so that their truth is known.

``play`` is the basketball player of the toy grammar S -> r X1 X2 m, X1 -> X3 X4 X3, X2 -> p | s,
X3 -> f | empty, X4 -> d | empty (receive, fake, dribble, pass, shoot, move without the ball).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .repertoire import Move

Rules = dict[str, tuple[tuple[str, ...], ...]]
Tree = tuple[str, tuple["Tree | str", ...]]

GRAMMARS: dict[str, Rules] = {
    "dance": {
        "S": (("dance_sway", "Figure", "Figure", "dance_dip"),),
        "Figure": (("Side", "Middle", "Side"), ("Side", "dance_clap")),
        "Side": (("dance_left", "dance_right"), ("dance_right", "dance_left")),
        "Middle": (("dance_twirl",), ("dance_clap",)),
    },
    "fight": {
        "S": (("ready", "Round", "Round", "Round", "idle"),),
        "Round": (("Defence", "Attack"), ("Attack",)),
        "Attack": (("punch", "punch"), ("punch", "kick"), ("kick",)),
        "Defence": (("parry",), ("duck",)),
    },
    "play": {
        "S": (("catch", "X1", "X2", "run"),),
        "X1": (("X3", "X4", "X3"),),
        "X2": (("pass",), ("shoot",)),
        "X3": (("fake_shot",), ()),
        "X4": (("dribble",), ()),
    },
}
"""Rules by non-terminal, "S" first; whatever has no rule is a terminal, the label of a segment."""

_ARGUMENTS: dict[str, dict[str, object]] = {"run": {"steps": 5}, "dribble": {"bounces": 4}}


@dataclass(frozen=True)
class Derivation:
    """A sentence of a grammar with the tree that derives it."""

    tree: Tree

    def words(self) -> list[str]:
        """The terminals, left to right.

        >>> Derivation(("S", ("catch", ("X2", ("pass",)), "run"))).words()
        ['catch', 'pass', 'run']
        """
        return _leaves(self.tree)

    def moves(self) -> list[Move]:
        """The actions that perform the sentence."""
        names = {"idle": "lower"}
        return [(names.get(word, word), _ARGUMENTS.get(word, {})) for word in self.words()]


def derive(grammar: str, random: np.random.RandomState) -> Derivation:
    """Draw a sentence: every non-terminal is rewritten by one of its rules, all equally likely."""
    return Derivation(_expand(GRAMMARS[grammar], "S", random))


def _expand(rules: Rules, symbol: str, random: np.random.RandomState) -> Tree:
    chosen = rules[symbol][random.randint(len(rules[symbol]))]
    return symbol, tuple(_expand(rules, s, random) if s in rules else s for s in chosen)


def _leaves(tree: Tree) -> list[str]:
    leaves: list[str] = []
    for child in tree[1]:
        leaves += [child] if isinstance(child, str) else _leaves(child)
    return leaves
