"""Possession of the ball, and whether a diagram can be played at all.

The first holder of the ball is found by tracing the diagram backwards from the acts that need the
ball (a pass, a shot, a dribble, a fake, a pivot) to the catch before them: a player who needs the
ball without having caught it had it from the start. A diagram is infeasible if two players had it,
if a player needs a ball that they have given away, if a pass is caught before it is thrown, or if
an element names a player who does not exist.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from motiondb.errors import SceneError, suggestion
from motiondb.scene.language.motion_grammar import ROLES
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import (
    BODY_WIDTH,
    PLAYER,
    SHOTS,
    WITH_BALL,
    WITHOUT_BALL,
    Act,
    Diagram,
    Element,
    Player,
)


def check_diagram(diagram: Diagram, where: str = "") -> None:
    """Refuse a diagram that cannot be played, and name all its faults."""
    where = where or diagram.name
    faults = list(_name_faults(diagram, where)) or [
        *_place_faults(diagram, where),
        *_ball_faults(diagram, where),
    ]
    if faults:
        raise SceneError("\n".join(faults))


def first_holder(diagram: Diagram) -> str:
    """Return the player who has the ball when the play begins, or "" if no element needs a ball."""
    if diagram.ball:
        return diagram.ball
    return next((holder for holder, _ in _holders(diagram)), "")


def has_ball(diagram: Diagram, name: str) -> tuple[bool, ...]:
    """Return for each act of a player whether the player has the ball when the act begins."""
    held = first_holder(diagram) == name
    holds = []
    for act in diagram.acts[name]:
        holds.append(held)
        kind = diagram.elements[act.element].kind
        if act.part == "catch":
            held = True
        elif act.part == "own" and kind in ("pass", *SHOTS):
            held = False
    return tuple(holds)


def _holders(diagram: Diagram) -> Iterator[tuple[str, Element | None]]:
    """Yield every player who needs the ball without having caught it, and the element."""
    if diagram.ball:
        yield diagram.ball, None
    for name, acts in diagram.acts.items():
        for act in acts:
            element = diagram.elements[act.element]
            if act.part == "catch":
                break
            if act.part == "own" and element.kind in WITH_BALL:
                if name != diagram.ball:
                    yield name, element
                break


def _fault(where: str, element: Element, expected: str, actual: str, advice: str) -> str:
    return f"{where}:{element.line}: '{element}': expected {expected}, found {actual}. {advice}"


def _name_faults(diagram: Diagram, where: str) -> Iterator[str]:
    """Yield the faults of players who do not exist or are of the wrong team."""
    names = list(diagram.player)
    everybody = f"one of the players {', '.join(names)}"
    taken = {*ROLES, *(place for place, _ in diagram.places)}
    for player in diagram.players:
        if player.name in taken:
            yield (
                f"{where}:{player.line}: '{player.name}': expected a player's name, found the "
                f"name of a place or a role in rules. Choose another name."
            )
        if player.guards in names:
            yield from _guard_faults(diagram, player, where)
        if player.guards and player.guards not in names:
            yield (
                f"{where}:{player.line}: '{player.name} guards {player.guards}': expected"
                f" {everybody}, found {player.guards!r}."
                f"{suggestion(player.guards, names) or ' Add the player.'}"
            )
    if diagram.ball and diagram.ball not in names:
        near = suggestion(diagram.ball, names) or " Add the player."
        yield f"{where}: 'ball {diagram.ball}': expected {everybody}, found {diagram.ball!r}.{near}"
    for element in diagram.elements:
        for name in (element.player, element.other):
            if name and name not in names:
                near = suggestion(name, names).strip() or "Add the player, or name another."
                yield _fault(where, element, everybody, repr(name), near)
                break
        else:
            yield from _team_faults(diagram, element, where)


def _guard_faults(diagram: Diagram, player: Player, where: str) -> Iterator[str]:
    guarded = diagram.player[player.guards]
    actual = "a team-mate" if guarded.team == player.team != PLAYER else ""
    actual = "the player themselves" if guarded == player else actual
    if actual:
        yield (
            f"{where}:{player.line}: '{player.name} guards {guarded.name}': expected an opponent"
            f" of {player.name}, found {actual}. Name a player of the other team."
        )


def _team_faults(diagram: Diagram, element: Element, where: str) -> Iterator[str]:
    if not element.other:
        return
    one, other = diagram.player[element.player], diagram.player[element.other]
    if one.name == other.name:
        what, advice = "two players", f"{one.name} cannot do this to themselves."
        yield _fault(where, element, what, f"{one.name} twice", advice)
    elif element.kind == "pass" and one.team != other.team:
        what = f"a receiver of the team of {one.name}"
        actual = f"{other.name}, who plays against {one.name}"
        yield _fault(where, element, what, actual, "Pass to a team-mate.")
    elif element.kind != "pass" and one.team == other.team:
        what, actual = f"an opponent of {one.name}", f"{other.name}, a team-mate"
        yield _fault(where, element, what, actual, "Name a player of the other team.")


def _place_faults(diagram: Diagram, where: str) -> Iterator[str]:
    """Yield the faults of points off the court and of players at one point."""
    court = diagram.court
    what = (
        f"a point on the court (x {-court.width / 2:g} to {court.width / 2:g} m,"
        f" z {-court.behind_rim:g} to {court.length - court.behind_rim:g} m)"
    )
    origin = "below the rim" if court.lines else "the middle of the court"
    advice = f"The origin is {origin}, z grows away from the baseline."
    for player in diagram.players:
        if not court.holds(player.at):
            yield (
                f"{where}:{player.line}: '{player.name}': expected {what},"
                f" found {_point(player.at)}. {advice}"
            )
    for one, other in combinations(diagram.players, 2):
        apart = math.hypot(one.at.x - other.at.x, one.at.z - other.at.z)
        if apart < BODY_WIDTH:
            yield (
                f"{where}:{other.line}: '{other.name}': expected a place at least {BODY_WIDTH:g} m"
                f" from {one.name} (line {one.line}), found {apart:.2g} m. Players this close "
                f"touch each other: move one of them."
            )
    for element in diagram.elements:
        for spot in (*element.via, *([element.to] if element.to else [])):
            if not court.holds(spot):
                yield _fault(where, element, what, _point(spot), advice)


def _point(spot: Spot) -> str:
    return f"{spot.x:g} {spot.z:g}"


def _ball_faults(diagram: Diagram, where: str) -> Iterator[str]:
    """Yield the faults of passes back in time, and of balls that players do not have."""
    for element in diagram.elements:
        if element.kind == "pass" and element.caught and element.caught < element.step:
            what = f"a step from {element.step} on for the catch"
            actual = f"step {element.caught}, back in time"
            yield _fault(where, element, what, actual, "A pass is caught after it is thrown.")
    holders = list(_holders(diagram))
    if len(holders) > 1:
        yield _two_holders(holders, where)
        return
    for name, acts in diagram.acts.items():
        held = has_ball(diagram, name)
        given: Element | None = None
        for act, ball in zip(acts, held, strict=True):
            element = diagram.elements[act.element]
            yield from _act_faults(act, element, name, ball, given, where)
            if act.part == "own" and element.kind in ("pass", *SHOTS):
                given = element


def _two_holders(holders: list[tuple[str, Element | None]], where: str) -> str:
    because = [
        f"{name} ('{element}', line {element.line})" if element else f"{name} ('ball {name}')"
        for name, element in holders
    ]
    element = holders[-1][1]
    line = f":{element.line}" if element else ""
    return (
        f"{where}{line}: '{element}': expected one player with the ball at the beginning, found"
        f" {len(holders)}: {' and '.join(because)}. Add a pass to {holders[-1][0]} before."
    )


def _act_faults(
    act: Act, element: Element, name: str, ball: bool, given: Element | None, where: str
) -> Iterator[str]:
    """Yield the faults of one act: with the ball, or without it, where it must not be."""
    if act.part == "catch" and ball:
        actual = f"{name} with the ball already"
        yield _fault(where, element, "a receiver without the ball", actual, "Pass it on before.")
    elif act.part == "own" and element.kind in WITH_BALL and not ball:
        gone = f"{name} without the ball"
        if given is not None:
            gone += f" since '{given}' (line {given.line})"
        yield _fault(where, element, f"{name} to have the ball", gone, "Let it be passed back.")
    elif act.part == "own" and element.kind in WITHOUT_BALL and ball:
        advice = "Who has the ball dribbles, pivots or fakes; or pass it on before."
        yield _fault(where, element, f"{name} without the ball", f"{name} with it", advice)
