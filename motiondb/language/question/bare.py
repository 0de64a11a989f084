"""Pieces of a question that name no action by themselves, and the action that they belong to.

A piece is bare when its words are directions, limbs or sizes alone (``vocabulary.MODIFIERS``), or
when it holds nothing but a manner or an amount: "forward", "left hand", "slowly", "three times".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motiondb.language.question.tree import (
    LIMBS,
    SIDES,
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Joined,
    Lasting,
    Node,
    Repeated,
    Without,
    actions_of,
    at_once,
    join,
    map_actions,
    without,
)
from motiondb.language.vocabulary import MODIFIERS


def is_bare(node: Node) -> bool:
    """Whether a node names no action by itself.

    >>> is_bare(Action(("left", "hand"))), is_bare(Repeated(Action(()), 2, 2))
    (True, True)
    >>> is_bare(Action(("walk", "left")))
    False
    """
    action = _core(node)
    return action is not None and MODIFIERS.issuperset(action.words)


def names_words(node: Node) -> bool:
    """Whether a bare node holds words or manners, not amounts alone."""
    action = _core(node)
    return action is not None and bool(action.words or action.manner)


def attach(node: Node, bare: Node) -> Node:
    """A node with the words, manner and amounts of a bare one; ``AtOnce`` if it has no action.

    >>> attach(Action(("walk",)), Action(("forward",), ("slow",)))
    Action(words=('walk', 'forward'), manner=('slow',))
    """
    added = _core(bare)
    assert added is not None

    if not actions_of(node):
        return at_once([node, bare]) if names_words(bare) else _with_amounts(node, bare)

    def extended(action: Action) -> Action:
        return Action((*action.words, *added.words), (*action.manner, *added.manner))

    return _with_amounts(map_actions(node, extended), bare)


def say_again(before: Node, bare: Node) -> Node:
    """The action before with the directions, limbs, manner and amounts of a bare node.

    >>> say_again(Action(("turn", "left")), Action(("right",)))
    Action(words=('turn', 'right'), manner=())
    """
    added = _core(bare)
    said = actions_of(before)
    if added is None or not said:
        return bare
    verbs = tuple(word for word in said[-1].words if word not in MODIFIERS)
    return _with_amounts(Action((*verbs, *added.words), added.manner), bare)


def share_limb(before: Node, bare: Node) -> Node:
    """The action before, with the limb that both sides share: "wave left or right hand".

    >>> share_limb(Action(("wave", "left")), Action(("right", "hand")))
    Action(words=('wave', 'left', 'hand'), manner=())
    """
    added = _core(bare)
    if not isinstance(before, Action) or added is None or len(added.words) < 2:
        return before
    shared = before.words[-1:] and before.words[-1] in SIDES and added.words[0] in SIDES
    if shared and added.words[1] in LIMBS:
        return replace(before, words=(*before.words, added.words[1]))
    return before


def drop_empty(node: Node) -> tuple[Node | None, list[Node]]:
    """A tree without amounts that belong to no action; and these amounts.

    >>> drop_empty(AnyOf((Repeated(Action(()), 2, 2), Action(("run",)))))[0]
    Action(words=('run',), manner=())
    """
    if is_bare(node) and not names_words(node):
        return None, [node]
    dropped: list[Node] = []

    def kept(nodes: Sequence[Node]) -> list[Node]:
        pairs = [drop_empty(part) for part in nodes]
        dropped.extend(lost for _, each in pairs for lost in each)
        return [part for part, _ in pairs if part is not None]

    match node:
        case InOrder() | AtOnce() | Both() | AnyOf():
            parts = kept(node.parts)
            return (join(type(node), parts) if parts else None), dropped
        case Without():
            part = kept([node.part])
            return without(part[0] if part else Anything(), kept(node.excluded)), dropped
        case Repeated() | Lasting():
            part = kept([node.part])
            return (replace(node, part=part[0]) if part else None), dropped
    return node, []


def _core(node: Node) -> Action | None:
    """The action within amounts, None if there is anything else."""
    while isinstance(node, (Repeated, Lasting)):
        node = node.part
    return node if isinstance(node, Action) else None


def _with_amounts(node: Node, bare: Node) -> Node:
    """A node within the amounts of a bare one."""
    if isinstance(bare, (Repeated, Lasting)):
        return replace(bare, part=_with_amounts(node, bare.part))
    return node


# The parts of a question in order, collected from left to right.


class Chain:
    """Parts read so far.

    A chain receives one part after the other, each with the separator before it, and returns the
    tree. The last connective of a list determines its meaning: with "or" all parts back to the last
    "then" are alternatives.
    """

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
