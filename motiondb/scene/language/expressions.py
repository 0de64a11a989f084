"""What a diagram asks of each player: an expression of actions, and rules of space and time.

The expression is the paper's, such as ``(walk|run)*(catch)(dribble)*(shoot)``: a class of actions
for each act, starred where it may go on. A string X of actions fits as far as members of the
classes are a subsequence of it::

    g_user = length - longest common subsequence(X, expression, stars dropped)

The classes: a move is walk or run, and dribble with the ball; a cut is run; who has the ball at
first holds it; who is passed to catches; who is screened pushes; a pivot or fake is its own action.

Beside the expression stand auxiliary rules: circles and the ends of moves are places to be at,
points that a curve passes are places on the way, and everything begins where the drawing says that
its player is then (or else they could go somewhere that nobody drew, and catch there). A shot faces
the rim, a pass faces its receiver and is synchronised with the catch, a screen faces the screened
and is synchronised with the push.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4, equation (8).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.scene.language.curves import path_fractions
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.possession import first_holder, has_ball
from motiondb.scene.language.semantic_rules import (
    END,
    PATH,
    START,
    DirectionRule,
    Moment,
    PositionRule,
    SemanticRule,
    Spot,
    SynchronisationRule,
)
from motiondb.scene.language.tactics import FEINTS, MOVES, SHOTS, Diagram

ONLY_ASKED = (
    *("hold", "catch", "pass", "shoot", "layup"),
    *("screen", "push", "block", "feint", "fake_shot"),
)
"""Actions that somebody else takes part in, or that the ball's course depends on: nobody does them
unless the diagram asks, or else there were balls from nowhere and passes to nobody. (A choice; the
paper's strings may do what the grammar allows beside what is asked.)"""

MOST_ACTIONS = 40
"""Actions of a player at most."""
_VIA_WEIGHT = 1.0
"""Metres: a curve is drawn by hand, so what it passes is a wish, not a place to be at."""
_STAND_WEIGHT = 0.5
"""Metres: where something begins that was drawn; half a step is near."""


@dataclass(frozen=True)
class Item:
    """One class of an expression.

    Attributes
    ----------
    actions : the terminals that match; ``repeated`` where more than one may follow.
    element : number of the diagram's element, -1 for holding the ball at first.
    other, other_item : the player at the other end of a pass, screen, guard or block, and the
        class of their expression that belongs to it (-1 where there is none).
    way : points from where the player stands to where the item leads; one where it leads nowhere.
    """

    actions: tuple[str, ...]
    repeated: bool = False
    element: int = -1
    other: str = ""
    other_item: int = -1
    way: tuple[Spot, ...] = ()

    def __str__(self) -> str:
        return f"({'|'.join(self.actions)}){'*' if self.repeated else ''}"


@dataclass(frozen=True)
class DiagramRule:
    """A semantic rule of one player's item; item -1 is the whole action string.

    ``partner_item`` is the partner's item that a synchronisation rule means, else -1.
    """

    player: str
    item: int
    rule: SemanticRule
    partner_item: int = -1


def expressions(diagram: Diagram) -> dict[str, tuple[Item, ...]]:
    """Every player's expression; the diagram must have passed :func:`.possession.check_diagram`."""
    found: dict[str, list[Item]] = {}
    at: dict[tuple[int, str], int] = {}
    for name, acts in diagram.acts.items():
        place = diagram.player[name].at
        items = [Item(("hold",), way=(place,))] if name == first_holder(diagram) else []
        for act, ball in zip(acts, has_ball(diagram, name), strict=True):
            element = diagram.elements[act.element]
            own = act.part == "own"
            way = (place, *element.via, element.to) if own and element.to else (place,)
            other = element.other if own else element.player
            classes = _classes(element.kind, ball) if own else [((act.part,), False)]
            if own and element.kind == "screen" and len(way) > 1:
                items.append(Item(("walk", "run"), True, act.element, way=way))
                way = way[-1:]
            for actions, repeated in classes:
                if other:
                    at[act.element, name] = len(items)
                items.append(Item(actions, repeated, act.element, other, way=way))
            place = way[-1]
        found[name] = items
    return {
        name: tuple(replace(i, other_item=at.get((i.element, i.other), -1)) for i in items)
        for name, items in found.items()
    }


def _classes(kind: str, ball: bool) -> list[tuple[tuple[str, ...], bool]]:
    """The classes of a player's own element, with whether they repeat."""
    if kind in MOVES:
        if kind == "dribble" or (kind == "move" and ball):
            return [(("dribble",), True)]
        return [({"walk": ("walk",), "move": ("walk", "run")}.get(kind, ("run",)), True)]
    if kind in FEINTS:
        return [(("fake_shot" if kind == "fake" else kind,), kind != "feint")]
    return [((kind,), kind == "guard")]


def g_user(string: Sequence[str], expression: Sequence[Collection[str]]) -> int:
    """How many classes of an expression a string of actions misses (equation 8).

    >>> wanted = [{"walk", "run"}, {"catch"}, {"dribble"}, {"shoot"}]
    >>> g_user("walk run catch dribble dribble shoot".split(), wanted)
    0
    >>> g_user("walk catch shoot".split(), wanted)
    1
    """
    row = [0] * (len(expression) + 1)
    for action in string:
        above = row
        row = [0]
        for number, members in enumerate(expression, start=1):
            both = above[number - 1] + 1 if action in members else 0
            row.append(max(above[number], row[-1], both))
    return len(expression) - row[-1]


def spans(string: Sequence[str], items: Sequence[Item]) -> tuple[tuple[int, int], ...] | None:
    """Which actions of a string belong to which item, as intervals; None where g_user is not 0.

    Each item takes the first action that it can; a repeated one also those behind it that it
    matches, as far as the next item. Where repeated items of the same actions follow one another
    (a run and then a cut), actions in a row are shared out by the metres of their ways.

    >>> items = [Item(("walk", "run"), True), Item(("catch",))]
    >>> spans("idle walk run catch".split(), items)
    ((1, 3), (3, 4))
    """
    firsts = []
    at = 0
    for item in items:
        while at < len(string) and string[at] not in item.actions:
            at += 1
        if at == len(string):
            return None
        firsts.append(at)
        at += 1
    found = []
    for number, item in enumerate(items):
        end = firsts[number] + 1
        limit = firsts[number + 1] if number + 1 < len(items) else len(string)
        while item.repeated and end < limit and string[end] in item.actions:
            end += 1
        found.append((firsts[number], end))
    return tuple(_shared_out(found, items))


def _shared_out(found: list[tuple[int, int]], items: Sequence[Item]) -> list[tuple[int, int]]:
    """Stretches of repeated items of the same actions in a row, divided by their ways."""
    number = 0
    while number < len(items):
        last = number + 1
        while (
            last < len(items)
            and items[number].repeated
            and items[last].repeated
            and items[last].actions == items[number].actions
            and found[last][0] == found[last - 1][1]
        ):
            last += 1
        if last > number + 1:
            first, end = found[number][0], found[last - 1][1]
            ways = np.cumsum([max(_metres(item), 1e-9) for item in items[number:last]])
            shares = np.round((end - first) * ways / ways[-1]).astype(int)
            cuts = [first, *(first + shares).tolist()]
            n = last - number
            for k in range(1, n):  # at least one action each
                cuts[k] = min(max(cuts[k], cuts[k - 1] + 1), end - (n - k))
            found[number:last] = list(pairwise(cuts))
        number = last
    return found


def _metres(item: Item) -> float:
    """The length of an item's way."""
    return sum(float(np.hypot(b.x - a.x, b.z - a.z)) for a, b in pairwise(item.way))


def auxiliary_rules(
    diagram: Diagram, grammar: MotionGrammar | None = None
) -> tuple[DiagramRule, ...]:
    """The rules that follow from a diagram.

    Parameters
    ----------
    grammar : where given, rules of a kind that it has for the same action are left out: it says
        them of every pass, shot and screen, and the items say who is meant.
    """
    found: list[DiagramRule] = []
    for name, items in expressions(diagram).items():
        start = PositionRule(diagram.player[name].at, Moment(START))
        found.append(DiagramRule(name, -1, start))
        for number, item in enumerate(items):
            kind = diagram.elements[item.element].kind if item.element >= 0 else ""
            rules = [*_place_rules(item), *_link_rules(item, kind)]
            stated = _stated(grammar, item.actions)
            for rule in rules:
                if type(rule) not in stated or isinstance(rule, PositionRule):
                    partner = item.other_item if isinstance(rule, SynchronisationRule) else -1
                    found.append(DiagramRule(name, number, rule, partner))
    return tuple(found)


def _place_rules(item: Item) -> Iterator[SemanticRule]:
    yield PositionRule(item.way[0], Moment(START), _STAND_WEIGHT)
    if len(item.way) < 2:
        return
    shares = path_fractions(np.array([(spot.x, spot.z) for spot in item.way]))
    for spot, share in list(zip(item.way, shares, strict=True))[1:-1]:
        yield PositionRule(spot, Moment(PATH, float(share)), _VIA_WEIGHT)
    yield PositionRule(item.way[-1], Moment(END))


def _link_rules(item: Item, kind: str) -> Iterator[SemanticRule]:
    if item.actions == ("pass",):
        yield DirectionRule(item.other, Moment("release"))
        yield SynchronisationRule(item.other, ("catch",), None, Moment("release"))
    elif kind in SHOTS:
        yield DirectionRule("rim", Moment("release"))
    elif item.actions == ("screen",):
        yield DirectionRule(item.other, Moment("contact"))
        yield SynchronisationRule(item.other, ("push",), 0.0, Moment("contact"))


def _stated(grammar: MotionGrammar | None, actions: Sequence[str]) -> set[type]:
    if grammar is None:
        return set()
    return {type(a.rule) for a in grammar.annotations if a.symbol in actions and not a.within}
