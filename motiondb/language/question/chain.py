"""The parts of a question in order, collected from left to right.

A chain receives one part after the other, each with the separator before it, and returns the tree.
The last connective of a list determines its meaning: with "or" all parts back to the last "then"
are alternatives.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.language.question.bare import attach, is_bare, names_words, say_again
from motiondb.language.question.tree import (
    AnyOf,
    Anything,
    Both,
    InOrder,
    Joined,
    Node,
    Without,
    actions_of,
    at_once,
    join,
    without,
)


class Chain:
    """Parts read so far."""

    def __init__(self) -> None:
        self.parts: list[Node] = []  # in order
        self.front: list[Node] = []  # exclusions that stand before every part
        self.waiting: list[Node] = []  # bare pieces before the first action
        self.list_start = 0  # part with which the present list, separated by commas alone, begins

    def add(self, node: Node, separator: str, closing: str = "") -> None:
        """Put a part at the end."""
        if is_bare(node) and self._add_bare(node, separator):
            return
        for bare in self.waiting if actions_of(node) else ():
            node = attach(node, bare)
            self.waiting = []
        listed = separator == "comma" and self.list_start < len(self.parts)
        if closing == "or" and listed:
            self.parts[self.list_start :] = [join(AnyOf, [*self.parts[self.list_start :], node])]
            return
        if not listed:
            self.list_start = len(self.parts)
        self.parts.extend(
            node.parts if closing == "and" and listed and isinstance(node, Both) else [node]
        )
        if isinstance(node, Anything):
            self.list_start = len(self.parts)

    def _add_bare(self, node: Node, separator: str) -> bool:
        """Add a bare node to the action before it; return False if it must be a separate part."""
        if self.parts and actions_of(self.parts[-1]):
            if separator == "then" and names_words(node):
                self.parts.append(say_again(self.parts[-1], node))
                self.list_start = len(self.parts) - 1
            else:
                self.parts[-1] = attach(self.parts[-1], node)
            return True
        if any(action.words for action in actions_of(node)):
            return False
        self.waiting.append(node)
        return True

    def put_before_last(self, node: Node) -> None:
        """Put a part before the last one."""
        self.parts.insert(max(len(self.parts) - 1, 0), node)

    def join_last(self, kind: Joined, node: Node) -> None:
        """Join a node with the last part, or with the exclusions if there is no part."""
        if not self.parts and kind is AnyOf and self.front:
            self.parts, self.front = [without(Anything(), self.front)], []
        if not self.parts:
            self.parts = [node]
        elif kind is AnyOf:
            self.parts[-1] = join(AnyOf, [self.parts[-1], node])
        else:
            self.parts[-1] = together(self.parts[-1], node)

    def exclude(self, excluded: Sequence[Node]) -> None:
        """Exclude from everything so far, or, at the beginning, from everything that follows."""
        if self.parts:
            self.parts = [without(join(InOrder, self.parts), excluded)]
            self.list_start = 1
        else:
            self.front.extend(excluded)

    def tree(self) -> tuple[Node | None, list[Node]]:
        """The node that was read, None if there is none; and bare pieces without an action."""
        waiting = self.waiting
        if not self.parts:
            self.parts = [bare for bare in waiting if names_words(bare)][:1]
            waiting = [bare for bare in waiting if bare not in self.parts]
        if not self.parts:
            return (without(Anything(), self.front) if self.front else None), waiting
        return without(join(InOrder, self.parts), self.front), waiting


def together(left: Node, right: Node) -> Node:
    """Two simultaneous parts; if one has exclusions only, they apply to the other.

    A bare second part belongs to the first.
    """
    if is_bare(right):
        return attach(left, right)
    for part, other in ((right, left), (left, right)):
        if isinstance(part, Without) and isinstance(part.part, Anything):
            return without(other, part.excluded)
    return at_once([left, right])
