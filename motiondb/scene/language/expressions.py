"""The requirements of a diagram for each player: an expression of actions, and rules.

The expression is that of the paper, such as ``(walk|run)*(catch)(dribble)*(shoot)``: one class of
actions for each act, with a star where the act may consist of several actions. A string X of
actions fits if members of the classes are a subsequence of it::

    g_user = number of classes - longest common subsequence(X, expression without stars)

A move is the class walk or run, or dribble for the player with the ball. A cut is a run. The first
holder of the ball has the class hold. The receiver of a pass has the class catch. A screened player
has the class push. A pivot or a fake is its own action.

Auxiliary rules accompany the expression. Circles and the ends of moves are positions to reach, and
the points that a curve passes are positions on the way. Each act begins at the player's position in
the drawing at that time; otherwise the player could move to a place that is not drawn, and catch
the ball there. A shot faces the rim. A pass faces its receiver and is synchronised with the catch.
A screen faces the screened player and is synchronised with the push.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4, equation (8).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise

import numpy as np

from motiondb.records import FloatArray
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
from motiondb.scene.language.tactics import FEINTS, KINDS, MOVES, SHOTS, Diagram

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


ONLY_ASKED = (
    *("hold", "catch", "pass", "shoot", "layup"),
    *("screen", "push", "block", "feint", "fake_shot"),
)
"""Actions that are drawn only where the diagram asks for them.

Each involves another player or decides the course of the ball; without a request there would be
balls from nowhere and passes to nobody. This is a choice of this program: the paper's strings may
contain whatever the grammar allows."""

MOST_ACTIONS = 40
"""Largest number of actions of a player. Chosen by hand: more than twice the longest string of the
measured scenes."""
_VIA_WEIGHT = 1.0  # Weight of a point on the way, m. It is loose because a curve is drawn by hand
_STAND_WEIGHT = 0.5  # Weight of the place where a drawn act begins, m: about half a step


@dataclass(frozen=True)
class Item:
    """One class of an expression."""

    actions: tuple[str, ...]  # Names of the terminals that match
    repeated: bool = False  # Whether several actions in a row may match
    element: int = -1  # Index of the diagram's element, or -1 for holding the ball at first
    other: str = ""  # The other player of a pass, screen, guard or block, or ""
    # Index of the class in the other player's expression that belongs to this one, or -1
    other_item: int = -1
    # Points from the player's place to the end of the move; one point if the player stays
    way: tuple[Spot, ...] = ()

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
    for name, acts in diagram.acts.items():
        place = diagram.player[name].at
        items = [Item(("hold",), way=(place,))] if name == first_holder(diagram) else []
        for act, ball in zip(acts, has_ball(diagram, name), strict=True):
            element = diagram.elements[act.element]
            holds_ball = act.part == "own"
            way = (place, *element.via, element.to) if holds_ball and element.to else (place,)
            other = element.other if holds_ball else element.player
            classes = _classes(element.kind, ball) if holds_ball else [((act.part,), False)]
            if holds_ball and element.kind == "screen" and len(way) > 1:
                items.append(Item(("walk", "run"), True, act.element, way=way))
                way = way[-1:]
            for actions, repeated in classes:
                if other:
                    at[act.element, name] = len(items)
                items.append(Item(actions, repeated, act.element, other, way=way))
            place = way[-1]
        items_of[name] = items
    return {
        name: tuple(replace(i, other_item=at.get((i.element, i.other), -1)) for i in items)
        for name, items in items_of.items()
    }


def _classes(kind: str, ball: bool) -> list[tuple[tuple[str, ...], bool]]:
    """Return the classes of a player's own element, each with whether it repeats."""
    if kind in MOVES:
        if kind == "dribble" or (kind == "move" and ball):
            return [(("dribble",), True)]
        return [({"walk": ("walk",), "move": ("walk", "run")}.get(kind, ("run",)), True)]
    if kind in FEINTS:
        return [(("fake_shot" if kind == "fake" else kind,), kind != "feint")]
    return [((kind,), kind == "guard")]


def playable_kinds(actions: Collection[str]) -> tuple[str, ...]:
    """Return the kinds of elements that somebody with some actions can play.

    >>> playable_kinds({"walk", "carry"})
    ('move', 'walk')
    """
    pushed = {"pass": ["catch"], "screen": ["push"]}  # what the other player does
    return tuple(
        kind
        for kind in KINDS
        if all(set(of) & set(actions) for of, _ in _classes(kind, ball=False))
        and set(pushed.get(kind, ())) <= set(actions)
    )


def g_user(string: Sequence[str], expression: Sequence[Collection[str]]) -> int:
    """Return the number of classes of an expression that a string of actions misses (equation 8).

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
            ways = np.cumsum([max(_metres(item), 1e-9) for item in items[number:last]])
            shares = np.round((end - first) * ways / ways[-1]).astype(int)
            cuts = [first, *(first + shares).tolist()]
            n = last - number
            for k in range(1, n):  # at least one action each
                cuts[k] = min(max(cuts[k], cuts[k - 1] + 1), end - (n - k))
            intervals[number:last] = list(pairwise(cuts))
        number = last
    return intervals


def _metres(item: Item) -> float:
    """Return the length of an item's way, m."""
    return sum(float(np.hypot(b.x - a.x, b.z - a.z)) for a, b in pairwise(item.way))


def auxiliary_rules(
    diagram: Diagram, grammar: MotionGrammar | None = None
) -> tuple[DiagramRule, ...]:
    """Return the rules that follow from a diagram.

    `grammar`: The grammar. If given, a rule of the diagram is left out if the grammar has a rule of
    the same kind for the same action: the grammar then states it for every pass, shot and screen,
    and the items say who is meant.
    """
    auxiliary: list[DiagramRule] = []
    for name, items in expressions(diagram).items():
        start = PositionRule(diagram.player[name].at, Moment(START))
        auxiliary.append(DiagramRule(name, -1, start))
        for number, item in enumerate(items):
            kind = diagram.elements[item.element].kind if item.element >= 0 else ""
            rules = [*_place_rules(item), *_link_rules(item, kind)]
            stated = _stated(grammar, item.actions)
            for rule in rules:
                if type(rule) not in stated or isinstance(rule, PositionRule):
                    partner = item.other_item if isinstance(rule, SynchronisationRule) else -1
                    auxiliary.append(DiagramRule(name, number, rule, partner))
    return tuple(auxiliary)


def _place_rules(item: Item) -> Iterator[SemanticRule]:
    """Yield the positions that an item asks for: its start, the points of its curve, its end."""
    yield PositionRule(item.way[0], Moment(START), _STAND_WEIGHT)
    if len(item.way) < 2:
        return
    shares = path_fractions(np.array([(spot.x, spot.z) for spot in item.way]))
    for spot, share in list(zip(item.way, shares, strict=True))[1:-1]:
        yield PositionRule(spot, Moment(PATH, float(share)), _VIA_WEIGHT)
    yield PositionRule(item.way[-1], Moment(END))


def _link_rules(item: Item, kind: str) -> Iterator[SemanticRule]:
    """Yield the rules that link an item with the rim or with another player."""
    if item.actions == ("pass",):
        yield DirectionRule(item.other, Moment("release"))
        yield SynchronisationRule(item.other, ("catch",), None, Moment("release"))
    elif kind in SHOTS:
        yield DirectionRule("rim", Moment("release"))
    elif item.actions == ("screen",):
        yield DirectionRule(item.other, Moment("contact"))
        yield SynchronisationRule(item.other, ("push",), 0.0, Moment("contact"))


def _stated(grammar: MotionGrammar | None, actions: Sequence[str]) -> set[type]:
    """Return the kinds of rule that the grammar states for actions in every context."""
    if grammar is None:
        return set()
    return {type(a.rule) for a in grammar.annotations if a.symbol in actions and not a.within}
