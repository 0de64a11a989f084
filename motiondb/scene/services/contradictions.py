"""Distances that nobody can keep at once, or nowhere on the ground: refused before sampling.

A distance is asked for by a rule of the grammar at an act that is drawn, by one of the start symbol
for all acts, or by the diagram from one step to another. Two of them about the same pair contradict
each other if they look at the same time and no distance is within the bounds of both. One alone is
impossible if no point of the ground is as near or as far, or if the act is drawn to end elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

from motiondb.errors import Fault, SceneError
from motiondb.grammar.cfg.context_free import Tree
from motiondb.scene.energy.binding import DISTANCE, POINT, Binder, RuleTable
from motiondb.scene.language.expressions import Item, step_of
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import END, START, THROUGHOUT, DistanceRule, Spot
from motiondb.scene.language.tactics import Diagram, Element, Stretch

NEAR = 1.0  # How far from the drawing people may be, m


@dataclass(frozen=True)
class _Asked:
    """A distance that a player is asked to keep to somebody, or to a point."""

    player: str
    target: str | Spot
    about: str  # What the target is called
    rule: DistanceRule
    item: Item | None = None  # The act at which the rule looks; None for what is kept up
    element: Element | None = None
    kept: Stretch | None = None  # Whose steps it holds for; None for all
    step: int = 0  # The step of the act

    @property
    def line(self) -> int:
        """The line of the diagram."""
        return self.kept.line if self.kept else self.element.line if self.element else 0

    def __str__(self) -> str:
        """Return it in words."""
        if self.kept:
            return f"'{self.kept}'"
        bounds = [f"at least {self.rule.near:g} m"] * (self.rule.near > 0.0)
        bounds += [f"at most {self.rule.far:g} m"] * math.isfinite(self.rule.far)
        said = f"{' and '.join(bounds)} from {self.player} to {self.about}"
        return f"{said} in '{self.element}' (line {self.line})" if self.element else said


def check_distances(
    diagram: Diagram, grammar: MotionGrammar, trees: Mapping[str, Tree], where: str
) -> None:
    """Refuse a diagram whose distances contradict one another, or the ground."""
    binder = Binder(diagram, grammar)
    table = binder.bind([binder.string(n, trees[name]) for n, name in enumerate(binder.names)])
    asked = list(_asked(diagram, grammar, binder, table))
    faults = [*(fault for one in asked for fault in _alone(diagram, one)), *_pairs(asked)]
    if faults:
        raise SceneError(*faults, where=where)


def _asked(
    diagram: Diagram, grammar: MotionGrammar, binder: Binder, table: RuleTable
) -> Iterator[_Asked]:
    """Yield all distances of a diagram that do not depend on which of several actions is done."""
    kept = [one for one in diagram.stretches if one.other]
    stretches = []
    for one in kept:
        bounds = DistanceRule(one.other, one.near, one.far)
        stretches += [bounds, DistanceRule(one.player, one.near, one.far)]
        yield _Asked(one.player, one.other, one.other, bounds, kept=one)
    for number in range(len(table.rows)):
        row, rule, n = table.rows[number], table.rules[number], int(table.items[number])
        if not isinstance(rule, DistanceRule) or row["kind"] != DISTANCE or rule in stretches:
            continue
        player = int(row["player"])
        item = binder.items[player][n] if n >= 0 else None
        whole = int(row["first"]) == 0 and int(row["last"]) == len(table.actions[player])
        always = whole and rule.moment.name == THROUGHOUT and _of_start(grammar, rule)
        if not (item and item.element >= 0 and _always(grammar, item, rule)) and not always:
            continue
        element = diagram.elements[item.element] if item else None
        at = Spot(float(row["x"]), float(row["z"]))
        target = at if row["target"] == POINT else table.players[row["target"]]
        about = target if isinstance(target, str) else str(rule.target)
        step = step_of(diagram, table.players[player], item) if item else 0
        yield _Asked(table.players[player], target, about, rule, item, element, step=step)


def _of_start(grammar: MotionGrammar, rule: DistanceRule) -> bool:
    starts = {start.symbol for start in grammar.starts}
    return any(a.rule == rule and a.symbol in starts for a in grammar.annotations)


def _always(grammar: MotionGrammar, item: Item, rule: DistanceRule) -> bool:
    """Return whether every action that an item allows has the rule, below whatever it stands."""
    return all(rule in grammar.rules_of(action, ()) for action in item.actions)


def _alone(diagram: Diagram, one: _Asked) -> Iterator[Fault]:
    """Yield why nobody can keep one distance, for itself."""
    left, right, back, front = diagram.court.corners
    near, far, nearest, farthest = (
        one.rule.near,
        one.rule.far,
        0.0,
        math.hypot(right - left, front - back),
    )
    if isinstance(one.target, Spot):
        x, z = one.target.x, one.target.z
        beside = max(left - x, 0.0, x - right), max(back - z, 0.0, z - front)
        across = max(abs(left - x), abs(right - x)), max(abs(back - z), abs(front - z))
        nearest, farthest = math.hypot(*beside), math.hypot(*across)
    if near > farthest + NEAR or far < nearest - NEAR:
        size = f"{right - left:g} x {front - back:g} m"
        found = f"{one}, on a ground of {size}"
        yield _fault(one, "a distance that somebody on the ground can keep", found, "the ground")
    elif one.item and one.element and one.element.to and isinstance(one.target, Spot):
        way = {START: one.item.way[:1], END: one.item.way[-1:]}.get(
            one.rule.moment.name, one.item.way
        )
        least, most = _apart(way, one.target)
        if least > far + NEAR or most < near - NEAR:
            found = f"{one}, {least if least > far else most:.1f} m from where it is drawn"
            yield _fault(one, "a place that its rule allows", found, "the drawing")


def _apart(way: Sequence[Spot], target: Spot) -> tuple[float, float]:
    """Return the least and the largest distance of a drawn way from a point, m."""
    here = complex(target.x, target.z)
    points = [complex(spot.x, spot.z) - here for spot in way]
    least = min(map(abs, points))
    for a, b in pairwise(points):
        share = -(a * (b - a).conjugate()).real / max(abs(b - a) ** 2, 1e-12)
        least = min(least, abs(a + min(max(share, 0.0), 1.0) * (b - a)))
    return least, max(map(abs, points))


def _pairs(asked: list[_Asked]) -> Iterator[Fault]:
    """Yield which two distances nobody can keep at once."""
    for one, other in combinations(asked, 2):
        if one.rule.near <= other.rule.far and other.rule.near <= one.rule.far:
            continue
        pair, same = {one.player, one.target}, {other.player, other.target}
        if pair == same and _at_once(one, other):
            what = "distances that can be kept at once"
            yield _fault(one, what, f"{one}, and {other}", "one of them")


def _at_once(one: _Asked, other: _Asked) -> bool:
    """Return whether two distances are looked at at the same time."""
    if one.item and other.item:
        same = one.element is other.element and one.player == other.player
        return same and one.rule.moment == other.rule.moment
    first, last = _steps(one)
    since, until = _steps(other)
    return first <= until and since <= last


def _steps(one: _Asked) -> tuple[float, float]:
    """Return the first and the last step of the diagram at which a distance is looked at."""
    if one.element:
        return one.step, one.step
    return (one.kept.first, one.kept.last) if one.kept and one.kept.last else (0.0, math.inf)


def _fault(one: _Asked, what: str, found: str, other: str) -> Fault:
    subject = str(one.kept or one.element or one.player)
    return Fault(what, found, f"Change the distance or {other}.", one.line, 0, subject)
