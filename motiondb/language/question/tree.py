"""The tree of a question: frozen nodes, and constructors that keep it in one normal form.

    node      meaning                                      written as
    Action    one action: words, sides of limbs, manner    walk slow
    Anything  any action                                   ?
    InOrder   its parts one after the other                walk, then sit
    AtOnce    its parts in the same interval               walk while wave
    Both      all parts, simultaneously or in order        walk and wave
    AnyOf     at least one part                            walk or run
    Without   a part that does not show what is excluded   walk, not run
    Repeated  a part several times                         jump 3 times
    Lasting   a part for some seconds                      walk for 10 s
    Measured  a part as far, or as fast                    turn left by 90 degrees

Normal form: InOrder, AtOnce, Both and AnyOf hold two parts or more and no part of their own kind;
an excluded AnyOf is a list of exclusions (not (a or b) is not a and not b).

A piece is *bare* when it names no action by itself and belongs to one before: its words are
directions, limbs or sizes alone (``vocabulary.MODIFIERS``), or it holds nothing but a manner or an
amount: "forward", "left hand", "slowly", "three times".
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from motiondb.language.question.amounts import Measure
from motiondb.language.vocabulary import IN_A_CIRCLE, IN_PLACE, MODIFIERS, SINGLE, TRAVELS

SIDES = frozenset(("left", "right", "both"))
_LIMBS_TEXT = """
arm hand fist wrist elbow shoulder finger thumb palm leg foot knee hip ankle toe heel thigh
"""
LIMBS = frozenset(_LIMBS_TEXT.split())
"""Parts of the body of which there are a left and a right one."""
_HANDS = frozenset(("hand", "fist", "palm", "arm", "wrist"))
_PARTS = frozenset(
    ("head", "hip", "shoulder", "elbow", "chin", "chest", "knee", "foot", "toe", "waist")
)
"""Where a hand is held, if both are said: "left hand on hip"."""
_BORNE = frozenset(("stand", "balance", "hop"))  # Actions that one leg may bear
SHARED_WAYS = frozenset(("forward", "backward", "back", "sideways", IN_PLACE, IN_A_CIRCLE))
"""Directions that ways of travelling share: "walk or run backward"."""


@dataclass(frozen=True)
class Action:
    """One action."""

    words: tuple[str, ...]  # Lemmas in the order of the question, sides and limbs among them
    manner: tuple[str, ...] = ()  # How it is done, as adjectives: ``slow`` for "slowly"

    @property
    def all_words(self) -> tuple[str, ...]:
        """Words and manners, which are compared with captions."""
        return (*self.words, *self.manner)

    @property
    def sides(self) -> tuple[tuple[str, str], ...]:
        """Every side with the limb that it belongs to.

        >>> Action(("wave", "left", "hand")).sides
        (('left', 'hand'),)
        >>> Action(("turn", "left")).sides
        ()
        """
        pairs, waiting = [], []
        for word in self.words:
            if word in SIDES:
                waiting.append(word)
            else:
                pairs += [(side, word) for side in waiting if word in LIMBS]
                waiting = []
        return tuple(pairs)


@dataclass(frozen=True)
class Anything:
    """Any action: ``?`` in a question."""


@dataclass(frozen=True)
class InOrder:
    """Parts one after the other."""

    parts: tuple[Node, ...]


@dataclass(frozen=True)
class AtOnce:
    """Parts in the same interval."""

    parts: tuple[Node, ...]


@dataclass(frozen=True)
class Both:
    """All of the parts, simultaneously or in order: the question leaves this open."""

    parts: tuple[Node, ...]


@dataclass(frozen=True)
class AnyOf:
    """At least one of the parts."""

    parts: tuple[Node, ...]


@dataclass(frozen=True)
class Without:
    """A part that shows none of the exclusions."""

    part: Node
    excluded: tuple[Node, ...]
    later: bool = False  # Whether nothing of it comes afterwards, either


@dataclass(frozen=True)
class Repeated:
    """A part several times: at least ``least``, at most ``most`` (None: no upper limit)."""

    part: Node
    least: int
    most: int | None


@dataclass(frozen=True)
class Lasting:
    """A part for ``least`` to ``most`` seconds (None: no upper limit)."""

    part: Node
    least: float
    most: float | None


@dataclass(frozen=True)
class Measured:
    """A part that turns by an angle, or goes as far, as fast or as many steps, as measured."""

    part: Node
    measure: Measure


AmountNode: TypeAlias = Repeated | Lasting | Measured
Node: TypeAlias = Action | Anything | InOrder | AtOnce | Both | AnyOf | Without | AmountNode
Joined: TypeAlias = type[InOrder] | type[AtOnce] | type[Both] | type[AnyOf]


@dataclass(frozen=True)
class NotUsed:
    """A part of a question that is not in the tree: its text and the reason."""

    text: str
    reason: str


@dataclass(frozen=True)
class Question:
    """A parsed question."""

    text: str  # As it was written
    tree: Node  # The tree of the question
    # What the tree leaves out, in the order of the question. Articles, pronouns and other words
    # that do not describe motion are not listed
    not_used: tuple[NotUsed, ...] = ()


def join(kind: Joined, parts: Sequence[Node]) -> Node:
    """Parts joined by one kind of node; a single part is itself, parts of that kind are opened.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> join(AnyOf, [join(AnyOf, [walk, run]), sit]) == AnyOf((walk, run, sit))
    True
    """
    opened: list[Node] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))


def at_once(parts: Sequence[Node]) -> Node:
    """Parts in one interval; the parts of a ``Both`` among them become simultaneous too.

    >>> walk, wave, turn = (Action((word,)) for word in ("walk", "wave", "turn"))
    >>> at_once([Both((walk, wave)), turn]) == AtOnce((walk, wave, turn))
    True
    """
    opened: list[Node] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, Both) else (part,))
    return join(AtOnce, opened)


def without(part: Node, excluded: Sequence[Node], later: bool = False) -> Node:
    """A part without its exclusions; exclusions of the same part become one list.

    `later`: Whether nothing of it comes afterwards, either.

    >>> without(Action(("stand", "still")), [Action(("left", "leg"))]).excluded
    (Action(words=('stand', 'left', 'leg'), manner=()),)
    """
    listed: list[Node] = []
    for node in excluded:
        listed.extend(node.parts if isinstance(node, AnyOf) else (node,))
    listed = [_held_on(part, node) for node in listed]
    if isinstance(part, Without):
        later = later or part.later
        return replace(part, excluded=(*part.excluded, *listed), later=later)
    return Without(part, tuple(listed), later) if listed else part


def _held_on(part: Node, excluded: Node) -> Node:
    """An excluded leg with the action that it would bear: "stand, but not on one leg"."""
    bears = [word for each in actions_of(part) for word in each.words if word in _BORNE]
    if not bears or not isinstance(excluded, Action) or not is_bare(excluded):
        return excluded
    of_one = not {SINGLE, "left", "right"}.isdisjoint(excluded.words)
    if not of_one or {"leg", "foot"}.isdisjoint(excluded.words):
        return excluded
    return replace(excluded, words=(bears[-1], *excluded.words))


def parts_of(node: Node) -> tuple[Node, ...]:
    """The nodes directly below a node, exclusions last."""
    match node:
        case Action() | Anything():
            return ()
        case Without():
            return (node.part, *node.excluded)
        case Repeated() | Lasting() | Measured():
            return (node.part,)
        case _:
            return node.parts


def walk(node: Node) -> Iterator[Node]:
    """A node and all nodes below it, from the left."""
    yield node
    for part in parts_of(node):
        yield from walk(part)


def actions_of(node: Node) -> tuple[Action, ...]:
    """The requested actions, from the left, without the excluded ones."""
    if isinstance(node, Action):
        return (node,)
    below = (node.part,) if isinstance(node, Without) else parts_of(node)
    return tuple(action for part in below for action in actions_of(part))


def map_actions(node: Node, change: Callable[[Action], Action]) -> Node:
    """The same tree with every requested action changed; exclusions do not change."""
    if isinstance(node, Action):
        return change(node)
    if isinstance(node, (Without, Repeated, Lasting, Measured)):
        return replace(node, part=map_actions(node.part, change))
    if isinstance(node, Anything):
        return node
    return replace(node, parts=tuple(map_actions(part, change) for part in node.parts))


def is_bare(node: Node) -> bool:
    """Whether a node names no action by itself.

    >>> is_bare(Action(("left", "hand"))), is_bare(Repeated(Action(()), 2, 2))
    (True, True)
    >>> is_bare(Action(("walk", "left")))
    False
    """
    action = core(node)
    return action is not None and MODIFIERS.issuperset(action.words)


def holds_at(node: Node) -> bool:
    """Whether a node names nothing but a hand at a part of the body.

    >>> holds_at(Action(("both", "hand", "hip"))), holds_at(Action(("both", "hand")))
    (True, False)
    """
    action = core(node)
    words = set() if action is None or not is_bare(node) else {*action.words}
    return not words.isdisjoint(_HANDS) and not words.isdisjoint(_PARTS)


def names_words(node: Node) -> bool:
    """Whether a bare node holds words or manners, not amounts alone."""
    action = core(node)
    return action is not None and bool(action.words or action.manner)


def attach(node: Node, bare: Node) -> Node:
    """A node with the words, manner and amounts of a bare one; ``AtOnce`` if it has no action.

    >>> attach(Action(("walk",)), Action(("forward",), ("slow",)))
    Action(words=('walk', 'forward'), manner=('slow',))
    """
    added = core(bare)
    assert added is not None

    if not actions_of(node):
        return at_once([node, bare]) if names_words(bare) else _with_amounts(node, bare)

    def extended(action: Action) -> Action:
        return Action((*action.words, *added.words), (*action.manner, *added.manner))

    return _with_amounts(map_actions(node, extended), bare)


def say_again(before: Node, bare: Node, keeps: bool = False) -> Node:
    """The action before with the directions, limbs, manner and amounts of a bare node.

    `keeps`: Whether it keeps the amounts of the action before, unless the bare node has some.

    >>> say_again(Action(("turn", "left")), Action(("right",)))
    Action(words=('turn', 'right'), manner=())
    """
    added = core(bare)
    said = actions_of(before)
    if added is None or not said:
        return bare
    verbs = tuple(word for word in said[-1].words if word not in MODIFIERS)
    is_plain = keeps and isinstance(bare, Action) and core(before) is not None
    amounts = before if is_plain else bare
    return _with_amounts(Action((*verbs, *added.words), added.manner), amounts)


def share_limb(before: Node, bare: Node) -> Node:
    """The action before, with the limb that both sides share: "wave left or right hand".

    >>> share_limb(Action(("wave", "left")), Action(("right", "hand")))
    Action(words=('wave', 'left', 'hand'), manner=())
    """
    added = core(bare)
    if not isinstance(before, Action) or added is None or len(added.words) < 2:
        return before
    shared = before.words[-1:] and before.words[-1] in SIDES and added.words[0] in SIDES
    if shared and added.words[1] in LIMBS:
        return replace(before, words=(*before.words, added.words[1]))
    return before


def any_of(nodes: Sequence[Node]) -> Node:
    """Alternatives; ways of travelling share what stands behind the last of them.

    >>> walk, run, turn = Action(("walk",)), Action(("run", "backward")), Action(("turn", "left"))
    >>> [node.words for node in any_of([walk, run]).parts]
    [('walk', 'backward'), ('run', 'backward')]
    >>> any_of([walk, turn]) == AnyOf((walk, turn))
    True
    """
    joined = join(AnyOf, nodes)
    behind = joined.parts[-1] if isinstance(joined, AnyOf) else joined
    last = core(behind)
    if not isinstance(joined, AnyOf) or last is None or not last.words:
        return joined
    verb, *way = last.words
    if verb not in TRAVELS or not SHARED_WAYS.issuperset(way):
        return joined

    def shared(node: Node) -> Node:
        if not isinstance(node, Action) or node.manner or len(node.words) != 1:
            return node
        if node.words[0] not in TRAVELS:
            return node
        return _with_amounts(Action((*node.words, *way), last.manner), behind)

    return AnyOf(tuple(map(shared, joined.parts)))


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
            rest = part[0] if part else Anything()
            return without(rest, kept(node.excluded), node.later), dropped
        case Repeated() | Lasting() | Measured():
            part = kept([node.part])
            return (replace(node, part=part[0]) if part else None), dropped
    return node, []


def core(node: Node) -> Action | None:
    """The action within counts and durations; None if there is anything else.

    >>> core(Lasting(Action(("walk",)), 5.0, None)), core(Anything())
    (Action(words=('walk',), manner=()), None)
    """
    while isinstance(node, (Repeated, Lasting, Measured)):
        node = node.part
    return node if isinstance(node, Action) else None


def _with_amounts(node: Node, bare: Node) -> Node:
    """A node within the amounts of a bare one."""
    if isinstance(bare, (Repeated, Lasting, Measured)):
        return replace(bare, part=_with_amounts(node, bare.part))
    return node
