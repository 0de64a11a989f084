"""The nodes of a player's tree, and which of their rules count."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from motiondb.grammar.cfg.context_free import Tree
from motiondb.scene.language.semantic_rules import END, START, SemanticRule


@dataclass(frozen=True)
class Node:
    """A node with the actions [first, last) that it derives and its ancestors."""

    symbol: str
    is_leaf: bool
    first: int
    last: int
    above: frozenset[str]


def nodes_of(tree: Tree) -> Iterator[Node]:
    """Yield all nodes with the actions [first, last) that they derive and their ancestors.

    The order is postorder. There is no recursion, because the depth of nesting may equal the length
    of the string.
    """
    done = 0
    waiting: list[tuple[Tree, frozenset[str], int]] = [(tree, frozenset(), -1)]
    while waiting:
        node, above, first = waiting.pop()
        if node.is_leaf:
            yield Node(node.symbol, True, done, done + 1, above)
            done += 1
        elif first >= 0:
            yield Node(node.symbol, False, first, done, above)
        else:
            waiting.append((node, above, done))
            below = above | {node.symbol}
            waiting.extend((child, below, -1) for child in reversed(node.children))


def counts_elsewhere(
    rule: SemanticRule,
    k: int,
    item_of: Sequence[int],
    of_action: Sequence[tuple[SemanticRule, ...]],
) -> bool:
    """Return whether the next (for ``at start`` the previous) action of the item has the rule."""
    step = {END: 1, START: -1}.get(rule.moment.name, 0)
    m = k + step
    if step == 0 or not 0 <= m < len(of_action):
        return False
    return item_of[m] == item_of[k] and rule in of_action[m]
