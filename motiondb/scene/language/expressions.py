"""The requirements of a diagram for each player: an expression of actions, and rules.

The expression is that of the paper, such as ``(walk|run)*(catch)(dribble)*(shoot)``: one class of
actions for each act, with a star where the act may consist of several actions. A string X of
actions fits if members of the classes are a subsequence of it::

    g_user = number of classes - longest common subsequence(X, expression without stars)

The classes are those of the verbs (:mod:`.activity`). Somebody who has the object at first begins
with the rest of the grammar for that, if there is one. The other player of an element does what the
grammar's synchronisation asks for.

Auxiliary rules accompany the expression. Circles and the ends of moves are positions to reach, and
the points that a curve passes are positions on the way. Each act begins at the player's position in
the drawing at that time; otherwise the player could move to a place that is not drawn, and act
there. What is sent faces its target, unless the grammar says how.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4, equation (8).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise, permutations

import numpy as np

from motiondb.records import FloatArray
from motiondb.scene.language.activity import GIVE, SEND, STRIKE, TAKE
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
from motiondb.scene.language.tactics import DOES, Act, Diagram, paired

# Smooth curves through points, used to draw and to interpret the moves of a diagram.


def smooth_curve(points: FloatArray, per_part: int = 24) -> FloatArray:
    """Return the smooth curve through points.

    Consecutive points at the same place count once. A single point is returned unchanged.

    Shapes: `points` (points, 2), m; result ((points - 1) * per_part + 1, 2), m.

    `per_part`: Number of samples between two consecutive points. 24 leaves no visible corners in a
    picture; chosen by hand.

    >>> smooth_curve(np.array([[0.0, 0.0], [2.0, 0.0]]), 2).round(6).tolist()
    [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]

    A centripetal Catmull-Rom spline passes through its points without loops between them. The
    points at both ends are mirrored, so that the curve starts towards the second point and arrives
    from the last point but one.

    Source: P. J. Barry and R. N. Goldman, "A Recursive Evaluation Algorithm for a Class of
    Catmull-Rom Splines", SIGGRAPH 1988.
    """
    points = np.asarray(points, dtype=float)
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    points = points[np.concatenate([[True], apart])]
    if len(points) < 2:
        return points
    ends = [2.0 * points[:1] - points[1:2], points, 2.0 * points[-1:] - points[-2:-1]]
    extended = np.concatenate(ends)
    u = np.arange(per_part) / per_part
    parts = [_part(extended[i : i + 4], u) for i in range(len(points) - 1)]
    return np.concatenate([*parts, points[-1:]])


def _part(p: FloatArray, u: FloatArray) -> FloatArray:
    """Return the curve between the second and third of four points at fractions ``u``."""
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(p, axis=0), axis=1)))])
    t = (knots[1] + u * (knots[2] - knots[1]))[:, None]

    def between(a: FloatArray, b: FloatArray, i: int, j: int) -> FloatArray:
        return ((knots[j] - t) * a + (t - knots[i]) * b) / (knots[j] - knots[i])

    a1, a2, a3 = (between(p[i], p[i + 1], i, i + 1) for i in range(3))
    return between(between(a1, a2, 0, 2), between(a2, a3, 1, 3), 1, 2)


def path_fractions(points: FloatArray) -> FloatArray:
    """Return the position of each point along the curve, as a fraction of its length from 0 to 1.

    >>> path_fractions(np.array([[0.0, 0.0], [1.0, 0.0], [4.0, 0.0]])).round(3).tolist()
    [0.0, 0.25, 1.0]
    """
    points = np.asarray(points, dtype=float)
    moved = np.concatenate([[False], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9])
    per_part = 64  # samples for the length; chosen by hand
    steps = np.linalg.norm(np.diff(smooth_curve(points, per_part), axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps.reshape(-1, per_part).sum(axis=1))])
    return np.asarray(lengths[np.cumsum(moved)] / max(float(lengths[-1]), 1e-12))


MOST_ACTIONS = 40
"""Largest number of actions of a player. Chosen by hand: more than twice the longest string of the
measured scenes."""
_VIA_WEIGHT = 1.0  # Weight of a point on the way, m. It is loose because a curve is drawn by hand
_BESIDE = 1.5  # Metres between two who are drawn, up to which nobody goes to the other
_BESIDE_WEIGHT = 2.0  # Weight of the end of a way to somebody, m: the act says how near they are
_STAND_WEIGHT = 0.5  # Weight of the place where a drawn act begins, m: about half a step


@dataclass(frozen=True)
class Item:
    """One class of an expression."""

    actions: tuple[str, ...]  # Names of the terminals that match
    repeated: bool = False  # Whether several actions in a row may match
    element: int = -1  # Index of the diagram's element, or -1 for having the object at first
    other: str = ""  # The other player of the element, or ""
    target: str = ""  # The place that the element is aimed at, or ""
    # Index of the class in the other player's expression that belongs to this one, or -1
    other_item: int = -1
    # Points from the player's place to the end of the move; one point if the player stays
    way: tuple[Spot, ...] = ()
    beside: str = ""  # The player to whom the way leads, who is drawn at its end, or ""

    @property
    def metres(self) -> float:
        """The length of the way."""
        return sum(math.hypot(b.x - a.x, b.z - a.z) for a, b in pairwise(self.way))

    def __str__(self) -> str:
        """Return the class in the notation of the paper."""
        return f"({'|'.join(self.actions)}){'*' if self.repeated else ''}"


@dataclass(frozen=True)
class DiagramRule:
    """A semantic rule of one player's item."""

    player: str  # Name of the player
    item: int  # Index of the item, or -1 for the whole action string
    rule: SemanticRule
    # Index of the partner's item that a synchronisation rule refers to, or -1
    partner_item: int = -1


def expressions(diagram: Diagram) -> dict[str, tuple[Item, ...]]:
    """Return the expression of every player.

    The diagram must have passed :func:`.possession.check_diagram`.
    """
    items_of: dict[str, list[Item]] = {}
    at: dict[tuple[int, str], int] = {}
    rest, holder = diagram.activity.first_rest(), first_holder(diagram)
    for name, acts in diagram.acts.items():
        place = diagram.player[name].at
        items = [Item((rest,), way=(place,))] if rest and name == holder else []
        for act, holds in zip(acts, has_ball(diagram, name), strict=True):
            made = _items(diagram, act, holds, place)
            if made[-1].other:
                at[act.element, name] = len(items) + len(made) - 1
            items += made
            place = made[-1].way[-1]
        items_of[name] = items
    return {
        name: tuple(replace(i, other_item=at.get((i.element, i.other), -1)) for i in items)
        for name, items in items_of.items()
    }


def _items(diagram: Diagram, act: Act, holds: bool, place: Spot) -> list[Item]:
    """Return the classes of one act of a player who is at ``place``."""
    element = diagram.elements[act.element]
    if act.part:
        return [Item(act.part, False, act.element, element.player, way=(place,))]
    steps, places = diagram.verb(element, holds).steps, dict(diagram.places)
    end, beside = element.to, ""
    if end is None and len(steps) > 1 and element.kind != DOES:
        end = places.get(element.target)
        if element.other and not end:
            there = diagram.place_at(element.other, element.step)
            if math.hypot(there.x - place.x, there.z - place.z) > _BESIDE:
                end, beside = there, element.other
    way = (place, *element.via, end) if end else (place,)
    if end is None and element.kind != DOES:
        steps = steps[-1:]  # nothing to go for
    items = []
    for number, step in enumerate(steps):
        repeated = len(way) > 1 if step.repeated is None else step.repeated
        if number == 0 and len(steps) > 1 and len(way) > 1:
            repeated = True
        last = number == len(steps) - 1
        other, target = (element.other, element.target) if last else ("", "")
        items.append(Item(step.actions, repeated, act.element, other, target, -1, way, beside))
        way, beside = way[-1:], ""
    return items


def g_user(string: Sequence[str], expression: Sequence[Collection[str]]) -> int:
    """Return the number of classes of an expression that a string of actions misses (equation 8).

    >>> wanted = [{"walk", "run"}, {"catch"}, {"dribble"}, {"shoot"}]
    >>> g_user("walk run catch dribble dribble shoot".split(), wanted)
    0
    >>> g_user("walk catch shoot".split(), wanted)
    1
    """
    worth = [[1.0 if action in members else -1.0 for members in expression] for action in string]
    missed = {member for action, member in paired(worth, len(expression)) if action < 0}
    return len(missed)


Spans = tuple[tuple[int, int], ...]
"""For every item of an expression its first action, and the one after its last."""

MOST_ASSIGNMENTS = 48
"""Most assignments of a string that are compared. Chosen by hand: strings of the measured scenes
have up to a few dozen; evaluating one takes a fraction of a millisecond."""
_MOST_LISTED = 2000  # Most assignments that are listed before they are thinned out


def assignments(string: Sequence[str], items: Sequence[Item]) -> tuple[Spans, ...]:
    """Return the ways to assign the actions of a string to items; () where g_user is not 0.

    An item takes an action that matches, a repeated one also matching actions that follow directly.
    No matching action directly before or after those of a repeated item is left over, unless it
    belongs to another item. The first assignment is that of :func:`spans`. If there are more than
    :data:`MOST_ASSIGNMENTS`, they are thinned out evenly.

    >>> walk = Item(("walk",), True)
    >>> assignments("walk bow walk walk".split(), [walk, walk])
    (((0, 1), (2, 4)), ((2, 3), (3, 4)))
    """
    first = spans(string, items)
    if first is None:
        return ()
    listed = list(islice(_assigned(tuple(string), tuple(items), 0, False), _MOST_LISTED))
    others = [one for one in listed if one != first]
    if len(others) >= MOST_ASSIGNMENTS:
        chosen = np.linspace(0, len(others) - 1, MOST_ASSIGNMENTS - 1).round().astype(int)
        others = [others[k] for k in chosen]
    return first, *others


def _assigned(
    string: tuple[str, ...], items: tuple[Item, ...], since: int, at_once: bool
) -> Iterator[Spans]:
    """Yield the assignments of items to actions from ``since`` on, or ``at_once`` from there."""
    if not items:
        if not at_once:
            yield ()
        return
    item = items[0]
    for start in range(since, since + 1 if at_once else len(string)):
        left_over = start > since and item.repeated and string[start - 1] in item.actions
        if start >= len(string) or string[start] not in item.actions or left_over:
            continue
        end = start + 1
        while item.repeated and end < len(string) and string[end] in item.actions:
            end += 1
        for cut in range(start + 1, end + 1):
            for rest in _assigned(string, items[1:], cut, cut < end):
                yield ((start, cut), *rest)


def spans(string: Sequence[str], items: Sequence[Item]) -> Spans | None:
    """Return which actions of a string belong to each item, or None if g_user is not 0.

    Each item takes the first action that matches. A repeated item also takes the matching actions
    that follow directly, up to the next item. Consecutive repeated items with the same actions (a
    run and then a cut) divide their common actions in proportion to the lengths of their ways.

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
    intervals = []
    for number, item in enumerate(items):
        end = firsts[number] + 1
        limit = firsts[number + 1] if number + 1 < len(items) else len(string)
        while item.repeated and end < limit and string[end] in item.actions:
            end += 1
        intervals.append((firsts[number], end))
    return tuple(_shared_out(intervals, items))


def _shared_out(intervals: list[tuple[int, int]], items: Sequence[Item]) -> list[tuple[int, int]]:
    """Divide actions between repeated items with the same actions, by the lengths of their ways."""
    number = 0
    while number < len(items):
        last = number + 1
        while (
            last < len(items)
            and items[number].repeated
            and items[last].repeated
            and items[last].actions == items[number].actions
            and intervals[last][0] == intervals[last - 1][1]
        ):
            last += 1
        if last > number + 1:
            first, end = intervals[number][0], intervals[last - 1][1]
            ways = np.cumsum([max(item.metres, 1e-9) for item in items[number:last]])
            shares = np.round((end - first) * ways / ways[-1]).astype(int)
            cuts = [first, *(first + shares).tolist()]
            n = last - number
            for k in range(1, n):  # at least one action each
                cuts[k] = min(max(cuts[k], cuts[k - 1] + 1), end - (n - k))
            intervals[number:last] = list(pairwise(cuts))
        number = last
    return intervals


def auxiliary_rules(diagram: Diagram, grammar: MotionGrammar) -> tuple[DiagramRule, ...]:
    """Return the rules that follow from a diagram, beside those of its grammar."""
    auxiliary: list[DiagramRule] = []
    for name, items in expressions(diagram).items():
        start = PositionRule(diagram.player[name].at, Moment(START))
        auxiliary.append(DiagramRule(name, -1, start))
        spelt = _spelt(diagram, name)
        for number, item in enumerate(items):
            for rule in [] if spelt else _place_rules(item):
                auxiliary.append(DiagramRule(name, number, rule))
            for rule in _link_rules(item, grammar):
                partner = item.other_item if isinstance(rule, SynchronisationRule) else -1
                auxiliary.append(DiagramRule(name, number, rule, partner))
    return tuple(auxiliary)


def _spelt(diagram: Diagram, name: str) -> bool:
    """Return whether a player's actions are spelt out, so that no place is drawn for them."""
    acts = [act for act in diagram.acts[name] if not act.part]
    return bool(acts) and all(diagram.elements[act.element].kind == DOES for act in acts)


def exact_actions(diagram: Diagram, grammar: MotionGrammar, name: str) -> tuple[str, ...]:
    """Return the actions that a player does only where the diagram asks for them."""
    if _spelt(diagram, name):
        return grammar.activity.actions
    moving = any(one.player == name and not one.other for one in diagram.stretches)
    rests = [rest.action for rest in grammar.activity.rests] if moving else []
    return (*grammar.only_asked, *rests)


def _place_rules(item: Item) -> Iterator[SemanticRule]:
    """Yield the positions that an item asks for: its start, the points of its curve, its end."""
    yield PositionRule(item.way[0], Moment(START), _STAND_WEIGHT)
    if len(item.way) < 2:
        return
    shares = path_fractions(np.array([(spot.x, spot.z) for spot in item.way]))
    for spot, share in list(zip(item.way, shares, strict=True))[1:-1]:
        yield PositionRule(spot, Moment(PATH, float(share)), _VIA_WEIGHT)
    if item.beside:
        yield PositionRule(item.beside, Moment(END), _BESIDE_WEIGHT)
    else:
        yield PositionRule(item.way[-1], Moment(END))


def _link_rules(item: Item, grammar: MotionGrammar) -> Iterator[SemanticRule]:
    """Yield the rules for who gives or sends the object, unless the grammar has them.

    They face the receiver or the target, and what is given is caught when it arrives.
    """
    activity, action = grammar.activity, item.actions[0]
    deed = activity.deed(action)
    target = item.other or item.target or activity.aim(action)
    if deed not in (GIVE, SEND, STRIKE) or not target:
        return
    moment, of = Moment(grammar.terminal[action].event or END), item.actions
    stated = {type(a.rule) for a in grammar.annotations if a.symbol in of and not a.within}
    if DirectionRule not in stated:
        yield DirectionRule(target, moment)
    if deed == GIVE and SynchronisationRule not in stated:
        yield SynchronisationRule(target, activity.doing(TAKE), None, moment)


# Steps of different players whose order nothing ensures but the drawing. Nobody begins a step when
# another player has ended a later one. Mostly that follows: a player's acts come one after another,
# what is caught was given before, and what is linked happens at one time.

Items = Sequence[Sequence[Item]]
"""The expression of every player, in the order of the diagram."""


def step_of(diagram: Diagram, player: str, item: Item) -> int:
    """Return the step of an item of a player, 0 if it is not drawn."""
    if item.element < 0:
        return 0
    element = diagram.elements[item.element]
    caught = element.caught if element.player != player else 0
    return caught or element.step


def unlinked_orders(diagram: Diagram, items: Items) -> Iterator[tuple[int, int, int, int]]:
    """Yield player, item, other player, item of a later step, if no links ensure their order.

    Of several that say the same the narrowest is enough.
    """
    names = [player.name for player in diagram.players]
    for one, other in permutations(range(len(items)), 2):
        before: dict[int, int] = {}
        for m, later in enumerate(items[other]):
            until = step_of(diagram, names[other], later)
            steps = (step_of(diagram, names[one], item) for item in items[one])
            begins = [k for k, step in enumerate(steps) if 0 < step < until]
            if begins:
                before.setdefault(begins[-1], m)
        for k, m in before.items():
            if (other, m) not in _linked_after(diagram, items, (one, k)):
                yield one, k, other, m


def _linked_after(diagram: Diagram, items: Items, here: tuple[int, int]) -> set[tuple[int, int]]:
    """Return the items (player, number) that come after one, or with it, by links of players."""
    number = {player.name: n for n, player in enumerate(diagram.players)}
    done, waiting = set[tuple[int, int]](), [here]
    while waiting:
        player, k = waiting.pop()
        if (player, k) in done or k >= len(items[player]):
            continue
        done.add((player, k))
        waiting.append((player, k + 1))
        item = items[player][k]
        taken = any(diagram.activity.deed(action) == TAKE for action in item.actions)
        if item.other_item >= 0 and not taken:  # what is taken was given before
            waiting.append((number[item.other], item.other_item))
    return done
