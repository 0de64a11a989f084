"""Casting: the shortest string of actions for each player of a diagram, or why there is none.

Before, the times of the diagram are checked, by a network of earliest and latest times. Every act
of a player begins and ends; a way takes as long as a fast run; acts of one player follow one
another; what is given is caught later, what is linked happens at one time; and a diagram may say
how long after a step another one comes. Each of these asks that one time is at least so many
seconds after another. The times are possible if and only if no circle of such demands asks that a
time is later than itself. The circle is found by the algorithm of Bellman and Ford, and told.

Sources: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4; R. Dechter, I. Meiri and J. Pearl, "Temporal constraint networks",
Artificial Intelligence 49 (1991).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.errors import Fault, SceneError
from motiondb.grammar.cfg.context_free import Tree, reachable_symbols
from motiondb.records import FloatArray
from motiondb.scene.energy.binding import Binder
from motiondb.scene.language.activity import GIVE, OPPONENT, PARTNER, RECEIVER, ROLES, TARGET
from motiondb.scene.language.expressions import (
    MOST_ACTIONS,
    Item,
    exact_actions,
    expressions,
    step_of,
)
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import (
    PASS_SPEED,
    RULE_NAMES,
    SemanticRule,
    Spot,
    line_error,
)
from motiondb.scene.language.tactics import Diagram, Element, Stretch
from motiondb.scene.sampling.random_subtrees import Derivations
from motiondb.scene.services.contradictions import NEAR, check_distances
from motiondb.scene.services.services import plan


def cast(diagram: Diagram, grammar: MotionGrammar, where: str = "") -> dict[str, Tree]:
    """Return for each player the shortest string of the grammar that fits the diagram (g_user = 0).

    `where`: Name of the diagram's file, for messages; by default the name of the diagram.
    """
    trees, faults = try_cast(diagram, grammar, where)
    for fault in faults.values():
        raise SceneError(fault, where=where or diagram.name)
    return trees


def try_cast(
    diagram: Diagram, grammar: MotionGrammar, where: str = ""
) -> tuple[dict[str, Tree], dict[str, Fault]]:
    """Cast every player by itself.

    `where`: Name of the diagram's file, for messages; by default the name of the diagram.
    """
    where = where or diagram.name
    _check_places(diagram, grammar, where)
    check_times(diagram, where)
    trees, faults = {}, {}
    for name, items in expressions(diagram).items():
        made = _cast_player(diagram, grammar, name, items)
        if isinstance(made, Fault):
            faults[name] = made
        else:
            trees[name] = made
    if not faults:
        check_distances(diagram, grammar, trees, where)
    return trees, faults


def _cast_player(
    diagram: Diagram, grammar: MotionGrammar, name: str, items: Sequence[Item]
) -> Tree | Fault:
    """Return a player's shortest string, or why there is none."""
    player = diagram.player[name]
    try:
        start = grammar.start_of(player.team)
    except SceneError as error:
        return replace(error.faults[0], line=player.line, subject=f"{player.team} {name}")
    if len(items) > MOST_ACTIONS:
        what, advice = (
            f"at most {MOST_ACTIONS} things to do",
            "Make a scene of each part of the play.",
        )
        return Fault(what, str(len(items)), advice, player.line, 0, name)
    missing = _missing_role(diagram, grammar, name, start, items)
    tree = missing or _planned(diagram, grammar, name, start, items)
    return _unasked(diagram, grammar, name, start, items, tree) if isinstance(tree, Tree) else tree


def _unasked(
    diagram: Diagram,
    grammar: MotionGrammar,
    name: str,
    start: str,
    items: Sequence[Item],
    tree: Tree,
) -> Tree | Fault:
    """The string, or that the grammar forces an action that is done only when asked."""
    closed = exact_actions(diagram, grammar, name)
    try:
        Derivations(grammar.started(start), items, closed)
    except SceneError:
        asked = {action for item in items for action in item.actions}
        unasked = [a for a in dict.fromkeys(tree.leaves()) if a in closed and a not in asked]
        without = " and ".join(unasked) or "more of it"
        return Fault(
            f"a string of the grammar {grammar.name} with what is drawn",
            f"none without {without}, which is done only when asked: '{' '.join(tree.leaves())}'",
            "Draw it, take 'when asked' from it, or add a rule that does without.",
            diagram.player[name].line,
            0,
            name,
        )
    return tree


def _planned(
    diagram: Diagram,
    grammar: MotionGrammar,
    name: str,
    start: str,
    items: Sequence[Item],
) -> Tree | Fault:
    """Return a player's shortest string, or the first impossible act."""
    goals = [item.actions for item in items]
    try:
        return plan(grammar, (), goals, start)
    except SceneError as error:
        reason, fields = str(error), dict(error.faults[0].fields) if error.faults else {}
    last = 1
    while last < len(items):
        try:
            plan(grammar, (), goals[:last], start)
        except SceneError:
            break
        last += 1
    element = items[last - 1].element
    drawn = diagram.elements[element] if element >= 0 else None
    line = drawn.line if drawn else diagram.player[name].line
    wanted = "".join(str(item) for item in items)
    if drawn and drawn.player != name:
        wanted += f", of which {items[last - 1]} is for '{drawn}'"
    fields |= {"player": name, "grammar": grammar.name}
    what = f"of {name} what the grammar {grammar.name} allows"
    return Fault(what, wanted, reason, line, 0, "", "not_allowed", fields)


def _check_places(diagram: Diagram, grammar: MotionGrammar, where: str) -> None:
    """Refuse a diagram without a place that the grammar's rules need."""
    known = dict(diagram.places)
    for place in grammar.places:
        if place not in known and place not in diagram.player:
            what = f"the place {place!r}, which rules of the grammar {grammar.name} are about"
            fault = Fault(what, ", ".join(known), f"Add 'place {place} at 0 0'.")
            raise SceneError(fault, where=where)


def _missing_role(
    diagram: Diagram, grammar: MotionGrammar, name: str, start: str, items: Sequence[Item]
) -> Fault | None:
    """Return the fault of an action that a player may do, if nobody fills a role of its rules."""
    above, binder = reachable_symbols(grammar.started(start)), Binder(diagram, grammar)
    asked: dict[str, list[Item | None]] = {}
    for item in items:
        for action in item.actions if item.element >= 0 else ():
            asked.setdefault(action, []).append(item)
    closed = set(exact_actions(diagram, grammar, name)) - set(asked)
    roles = {*ROLES, *(role for role, _ in grammar.activity.roles)}
    acts = [(a, i) for a in grammar.terminal for i in asked.get(a, [None])]
    for action, one in acts:
        if action not in above or action in closed:
            continue
        element = diagram.elements[one.element] if one else None
        for rule in grammar.rules_of(action, above):
            about = [getattr(rule, part, "") for part in ("target", "partner", "first", "second")]
            for role in dict.fromkeys(each for each in about if isinstance(each, str)):
                if role in roles and not binder.role(role, one or Item((action,)), name):
                    return _without_role(diagram, name, (action, element), (role, rule))
    return None


def _without_role(
    diagram: Diagram,
    name: str,
    done: tuple[str, Element | None],
    asked: tuple[str, SemanticRule],
) -> Fault:
    action, element = done
    role, rule = asked
    line = element.line if element else diagram.player[name].line
    who = {OPPONENT: "an opponent", PARTNER: "a partner", TARGET: "a target"}.get(role, f"a {role}")
    advice = f"Add a player who is the {role}"
    if role == diagram.player[name].team:
        advice = f"Write of whom the rule is: '{action} in SYMBOL: ...'"
    advice = {
        OPPONENT: "Add a player of the other team",
        RECEIVER: f"Write 'when asked' behind the words of {action}",
        TARGET: f"Write 'at' and a place behind {element or action}",
    }.get(role, advice)
    rest = f", or take the {'element out' if element else 'rule out of the grammar'}."
    what = f"{who} of {name}, whom the rule {RULE_NAMES[type(rule)]} of {action} is about"
    return Fault(what, "none", f"{advice}{rest}", line, 0, str(element or name))


FASTEST = 8.0  # Speed of a pelvis, m/s, that nobody exceeds
SHORTEST = 0.2  # Seconds that any act takes at least: the shortest clip
_SLACK = 0.1  # By how much a time that a diagram states may be missed, s: about two frames

_Time = tuple[str, int, str]  # Player, act, and "begin", "event" or "end"


@dataclass(frozen=True)
class _Demand:
    """One time is at least ``seconds`` after another."""

    before: _Time
    after: _Time
    seconds: float
    why: str


def check_times(diagram: Diagram, where: str = "") -> None:
    """Refuse a diagram whose times or distances are impossible, and tell the circle."""
    items = expressions(diagram)
    circle = _circle(_demands(diagram, items))
    if circle:
        raise SceneError(_told(circle), where=where or diagram.name)
    for kept in diagram.stretches:
        if kept.other:
            _check_stretch(diagram, items, kept, where or diagram.name)


def _demands(diagram: Diagram, items: dict[str, tuple[Item, ...]]) -> list[_Demand]:
    demands = []
    for name, row in items.items():
        for k, item in enumerate(row):
            begin, event, end = (name, k, "begin"), (name, k, "event"), (name, k, "end")
            demands += [_Demand(begin, event, 0.0, ""), _Demand(event, end, 0.0, "")]
            metres = item.metres
            seconds = max(metres / FASTEST, SHORTEST)
            run = f"{name} would have to run {metres:.1f} m" if metres > FASTEST * SHORTEST else ""
            demands.append(_Demand(begin, end, seconds, run or f"{name} does {item}"))
            if k + 1 < len(row):
                demands.append(_Demand(end, (name, k + 1, "begin"), 0.0, ""))
            if item.other and item.other_item >= 0 and item.element >= 0:
                demands += _links(diagram, items, name, k)
    return demands + _stated(diagram, items)


def _links(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], name: str, k: int
) -> list[_Demand]:
    """Return the demands of an act that is linked with another player's, from its own side."""
    item = items[name][k]
    if diagram.elements[item.element].player != name:
        return []
    theirs = items[item.other][item.other_item]
    one, other = (name, k, "event"), (item.other, item.other_item, "event")
    gives = any(diagram.activity.deed(action) == GIVE for action in item.actions)
    apart = math.hypot(item.way[-1].x - theirs.way[0].x, item.way[-1].z - theirs.way[0].z)
    lag = max(apart - 2.0 * NEAR, 0.0) / PASS_SPEED if gives else 0.0
    why = f"{item.other} does {theirs} when {name} does {item}"
    answers = {action for said in diagram.activity.answers for action in said.answers}
    later = gives or answers.issuperset(theirs.actions)
    back = [] if later else [_Demand(other, one, 0.0, why)]
    return [_Demand(one, other, lag, why), *back]


def _stated(diagram: Diagram, items: dict[str, tuple[Item, ...]]) -> list[_Demand]:
    """Return the demands of ``step 3 comes 0.6 s after 2``, as their first acts are measured.

    A way is measured from its end, and to its beginning.
    """
    of: dict[int, tuple[_Time, _Time]] = {}
    for name, row in items.items():
        for k, item in enumerate(row):
            if item.element >= 0:
                begin, end = ("begin", "end") if item.repeated else ("event", "event")
                step = diagram.elements[item.element].step
                of.setdefault(step, ((name, k, begin), (name, k, end)))
    demands = []
    for step, seconds, since in diagram.times:
        if step in of and since in of:
            why = f"in {seconds:g} s between steps {since} and {step}"
            (_, before), (after, _) = of[since], of[step]
            demands.append(_Demand(before, after, seconds - _SLACK, why))
            demands.append(_Demand(after, before, -seconds - _SLACK, why))
    return demands


def _circle(demands: list[_Demand]) -> list[_Demand]:
    """Return demands whose sum asks that a time is later than itself; [] if there are none."""
    latest: dict[_Time, float] = {}
    because: dict[_Time, _Demand] = {}
    for demand in demands:
        latest.setdefault(demand.before, 0.0)
        latest.setdefault(demand.after, 0.0)
    for _ in range(len(latest) + 1):
        changed = None
        for demand in demands:
            asked = latest[demand.before] + demand.seconds
            if asked > latest[demand.after] + 1e-9:
                latest[demand.after], because[demand.after] = asked, demand
                changed = demand.after
        if changed is None:
            return []
    at = changed
    assert at is not None
    for _ in range(len(latest)):  # into the circle
        at = because[at].before
    circle, here = [], at
    while True:
        circle.append(because[here])
        here = because[here].before
        if here == at:
            return circle[::-1]


def _told(circle: list[_Demand]) -> str:
    """Return a circle of demands as a sentence."""
    runs = [demand.why for demand in circle if "have to run" in demand.why]
    stated = [demand.why for demand in circle if demand.why.startswith("in ")]
    if stated:
        acts = [d.why for d in circle if d.why and d.seconds > 0.0 and d.why not in stated]
        done = " and ".join(runs) or "; ".join(acts)
        told = f"that {done} {stated[0]}" if done else "that one follows " + ", one ".join(stated)
        return (
            f"expected times that people can keep, found {told}."
            " Give them longer, or draw a shorter way."
        )
    acts = [demand.why for demand in circle if demand.why]
    return (
        "expected acts that can come one after another, found a circle:"
        f" {'; '.join(dict.fromkeys(acts))}. Change the steps so that one of them comes first."
    )


def _check_stretch(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], kept: Stretch, where: str
) -> None:
    """Refuse a place that is drawn for somebody too far from whom they keep a distance to."""
    theirs = _places(diagram, items, kept.other, kept)
    ways = list(pairwise([*theirs, theirs[-1]]))
    for item in items[kept.player]:
        if item.element < 0 or not _inside(diagram, kept.player, item, kept):
            continue
        for spot in (item.way[0], item.way[-1]):
            ends = [line_error(_point(spot), _point(a), _point(b)) for a, b in ways]
            apart = float(min(ends))
            farthest = max(math.hypot(spot.x - a.x, spot.z - a.z) for a in theirs)
            if apart > kept.far + NEAR or farthest < kept.near - NEAR:
                element = diagram.elements[item.element]
                found = (
                    f"{kept.player} at {spot.x:g} {spot.z:g} in '{element}' (line {element.line}),"
                    f" {apart:.1f} m from wherever {kept.other} is drawn then"
                )
                too_far = apart > kept.far
                advice = (
                    f"Draw it {'nearer' if too_far else 'farther'}, or let the stretch end before."
                )
                fields = {"found": found.replace(f" (line {element.line})", "")}
                what, about = f"places that are as {'near' if too_far else 'far'}", str(kept)
                fault = Fault(what, found, advice, kept.line, 0, about, "apart", fields)
                raise SceneError(fault, where=where)
    for when, (one, other) in _both(diagram, items, kept):
        apart = math.hypot(one.x - other.x, one.z - other.z)
        if not kept.near - NEAR <= apart <= kept.far + NEAR:
            what, found = f"places {when} that keep it", f"{apart:.1f} m between them"
            advice = "Move them, or say from which step to which."
            fault = Fault(what, found, advice, kept.line, 0, str(kept))
            raise SceneError(fault, where=where)


def _both(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], kept: Stretch
) -> Iterator[tuple[str, tuple[Spot, ...]]]:
    """Yield where both players of a stretch are drawn at its beginning and at its end."""
    names = kept.player, kept.other
    if not kept.last:
        yield "to begin", tuple(diagram.player[name].at for name in names)
    within = [
        [i for i in items[n] if i.element >= 0 and _inside(diagram, n, i, kept)] for n in names
    ]
    if kept.last and all(len(row[-1].way) > 1 for row in within if row) and all(within):
        yield "to end", tuple(row[-1].way[-1] for row in within)


def _inside(diagram: Diagram, name: str, item: Item, kept: Stretch) -> bool:
    step = step_of(diagram, name, item)
    return kept.first <= step <= (kept.last or step)


def _places(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], name: str, kept: Stretch
) -> list[Spot]:
    """Return the points of a player's ways in a stretch, and where they are before."""
    places = [diagram.player[name].at]
    for item in items[name]:
        if item.element >= 0 and diagram.elements[item.element].step < kept.first:
            places = [item.way[-1]]
        elif item.element < 0 or _inside(diagram, name, item, kept):
            places += item.way
    return places


def _point(spot: Spot) -> FloatArray:
    return np.array([spot.x, spot.z])
