"""A question's tree as one line, which is itself a question with the same tree.

``walk, then (run or jump), not sit``: a node that joins parts is written in parentheses if it is a
part of another one.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.language.question.amounts import adverb_of, manner_of, match_number
from motiondb.language.question.tokens import match_connective
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Lasting,
    Node,
    NotUsed,
    Repeated,
    Without,
)


def say(node: Node) -> str:
    """One line for a tree.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> say(Without(InOrder((walk, AnyOf((run, Repeated(sit, 2, None))))), (Action(("wave",)),)))
    'walk, then (run or (sit at least 2 times)), not wave'
    """
    match node:
        case Action(words, manner):
            return " ".join((*_quoted(words), *map(adverb_of, manner)))
        case Anything():
            return "?"
        case InOrder(parts):
            return ", then ".join(_inside(part) for part in parts)
        case AtOnce(parts):
            return " while ".join(_inside(part) for part in parts)
        case Both(parts):
            return " and ".join(_inside(part) for part in parts)
        case AnyOf(parts):
            return " or ".join(_inside(part) for part in parts)
        case Without(part, excluded):
            kept = [] if isinstance(part, Anything) else [_before_exclusion(part)]
            return ", ".join([*kept, *(f"not {_inside(one)}" for one in excluded)])
        case Repeated(part, least, most):
            return f"{_inside(part)} {say_count(least, most)}"
        case Lasting(part, shortest, longest):
            return f"{_inside(part)} {say_duration(shortest, longest)}"


def _quoted(words: Sequence[str]) -> Sequence[str]:
    """Words, in quotation marks where one of them would be read as something else."""
    if any(match_connective(w, 0) or match_number(w) or manner_of(w) for w in words):
        return [f'"{" ".join(words)}"']
    return words


def say_count(least: int, most: int | None) -> str:
    """A number of repeats.

    >>> say_count(3, 3), say_count(1, 1), say_count(0, 2), say_count(2, 4)
    ('3 times', 'once', 'at most 2 times', '2 to 4 times')
    """
    if most is None:
        return f"at least {least} times"
    if least == most:
        return "once" if least == 1 else f"{least} times"
    return f"{least} to {most} times" if least > 0 else f"at most {most} times"


def say_duration(least: float, most: float | None) -> str:
    """A length of time.

    >>> say_duration(10.0, 10.0), say_duration(5.0, None), say_duration(0.0, 2.5)
    ('for 10 s', 'for at least 5 s', 'for at most 2.5 s')
    """
    if most is None:
        return f"for at least {least:.10g} s"
    if least == most:
        return f"for {least:.10g} s"
    return f"for {least:.10g} to {most:.10g} s" if least > 0 else f"for at most {most:.10g} s"


def _inside(node: Node) -> str:
    """A node as a part of another one."""
    text = say(node)
    return text if isinstance(node, (Action, Anything)) else f"({text})"


def _before_exclusion(node: Node) -> str:
    """The base of an exclusion: an order needs no parentheses there."""
    return say(node) if isinstance(node, InOrder) else _inside(node)


# A question's tree as a plain order of actions, for functions that accept only that.


def plain_actions(tree: Node) -> tuple[tuple[tuple[str, ...], ...], tuple[NotUsed, ...]]:
    """The actions of a tree in order, () for anything; and the unused parts of the tree.

    For functions that accept only an order of actions: only the first alternative is used,
    simultaneous actions become one action, a repeated action is used once, and exclusions, counts
    and durations are listed as unused.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> plain_actions(Without(AnyOf((walk, run)), (sit,)))[1]
    (NotUsed(text='not sit', reason='nothing can be excluded'), NotUsed(text='or run', \
reason='only the first alternative is used'))

    Generation and the search by symbols decode words in order; they support nothing else.
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
