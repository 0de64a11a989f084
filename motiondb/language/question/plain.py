"""A question's tree as a plain order of actions, for functions that accept only that.

Generation and the search by symbols decode words in order; they support nothing else.
"""

from __future__ import annotations

from motiondb.language.question.say import say, say_count, say_duration
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Lasting,
    Node,
    NotUsed,
    Repeated,
    Without,
)


def plain_actions(tree: Node) -> tuple[tuple[tuple[str, ...], ...], tuple[NotUsed, ...]]:
    """The actions of a tree in order, () for anything; and the unused parts of the tree.

    For functions that accept only an order of actions: only the first alternative is used,
    simultaneous actions become one action, a repeated action is used once, and exclusions, counts
    and durations are listed as unused.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> plain_actions(Without(AnyOf((walk, run)), (sit,)))[1]
    (NotUsed(text='not sit', reason='nothing can be excluded'), NotUsed(text='or run', \
reason='only the first alternative is used'))
    """
    left: list[NotUsed] = []
    return tuple(_plain(tree, left)), tuple(dict.fromkeys(left))


def _plain(node: Node, left: list[NotUsed]) -> list[tuple[str, ...]]:
    match node:
        case Action():
            return [node.all_words]
        case Anything():
            return [()]
        case AnyOf():
            left += [
                NotUsed(f"or {say(p)}", "only the first alternative is used")
                for p in node.parts[1:]
            ]
            return _plain(node.parts[0], left)
        case Without():
            left += [NotUsed(f"not {say(one)}", "nothing can be excluded") for one in node.excluded]
            return _plain(node.part, left)
        case Repeated():
            left.append(NotUsed(say_count(node.least, node.most), "it is used once"))
            return _plain(node.part, left)
        case Lasting():
            left.append(NotUsed(say_duration(node.least, node.most), "no duration can be set"))
            return _plain(node.part, left)
        case AtOnce():
            words = [
                word for part in node.parts for action in _plain(part, left) for word in action
            ]
            return [tuple(words)]
        case _:
            return [action for part in node.parts for action in _plain(part, left)]
