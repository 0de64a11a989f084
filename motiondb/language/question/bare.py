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
