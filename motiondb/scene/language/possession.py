"""Who has the object, and whether a diagram can be played at all.

The first holder is found by tracing the diagram backwards from the acts that keep, give or send the
object to the one before them that takes it: a player who needs it without having taken it had it
from the start. A diagram is infeasible if two players had it, if a player needs what they have
given away, if something is caught before it is thrown, or if an element names somebody who does not
exist.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.scene.language.activity import (
    KEEPING,
    LOSING,
    OPPONENT,
    PLAYER,
    PUT,
    RECEIVER,
    ROLES,
    SEND,
    STRIKE,
    TAKE,
)
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import BODY_WIDTH, Act, Diagram, Element, Player


def check_diagram(diagram: Diagram, where: str = "") -> None:
    """Refuse a diagram that cannot be played, and name all its faults."""
    faults = list(_name_faults(diagram)) or [*_place_faults(diagram), *_ball_faults(diagram)]
    if faults:
        raise SceneError(*faults, where=where or diagram.name)


def first_holder(diagram: Diagram) -> str:
    """Return the player who has the object when the play begins, or "" if nobody needs one."""
    if diagram.ball:
        return diagram.ball
    return next((holder for holder, _ in _holders(diagram)), "")


def has_ball(diagram: Diagram, name: str) -> tuple[bool, ...]:
    """Return for each act of a player whether the player has the object when the act begins."""
    held = first_holder(diagram) == name
    holds = []
    for act in diagram.acts[name]:
        holds.append(held)
        held = _after(diagram, act, held)
    return tuple(holds)


def lies_at(diagram: Diagram, element: Element | None) -> str:
    """Return the place where the object lies before an element of the diagram, or ""."""
    activity, place = diagram.activity, diagram.activity.thing.at if diagram.activity.thing else ""
    for one in sorted(diagram.elements, key=lambda each: each.step):
        if element is not None and one.step >= element.step:
            break
        action = diagram.verb(one, True).last[0]
        if activity.deed(action) == PUT:
            place = one.target or activity.aim(action) or place
    return place


def _after(diagram: Diagram, act: Act, held: bool) -> bool:
    """Return whether who ``held`` the object, or not, has it after an act."""
    activity = diagram.activity
    steps = diagram.verb(diagram.elements[act.element], held).steps
    for actions in (act.part,) if act.part else [step.actions for step in steps]:
        deeds = {activity.deed(action) for action in actions}
        held = (held or deeds == {TAKE}) and not deeds <= set(LOSING)
    return held


def _needs(diagram: Diagram, element: Element) -> bool:
    """Return whether an element can only be done by who has the object."""
    return _begins(diagram, element, *KEEPING, *LOSING)


def _who_has(diagram: Diagram, element: Element) -> str:
    """Return the player who has the object when an element begins, or ""."""
    for name, acts in diagram.acts.items():
        before = [a for a in acts if diagram.elements[a.element].step < element.step]
        held = first_holder(diagram) == name
        for act in before:
            held = _after(diagram, act, held)
        if held:
            return name
    return ""


def _begins(diagram: Diagram, element: Element, *deeds: str) -> bool:
    """Return whether an element does one of these with the object before anything else."""
    return all(diagram.activity.begins(form, *deeds) for form in diagram.forms(element))


def _lies_or_flies(diagram: Diagram, taken: Element) -> bool:
    """Return whether the object lies somewhere, or somebody else sends it before or in the step."""
    thing, away = diagram.activity.thing, set(diagram.activity.doing(SEND, STRIKE))
    return bool(thing and thing.at) or any(
        one.step <= taken.step and one.player != taken.player and away >= set(form.last)
        for one in diagram.elements
        for form in diagram.forms(one)
    )


def _holders(diagram: Diagram) -> Iterator[tuple[str, Element | None]]:
    """Yield every player who needs the object without having taken it, and the element."""
    if diagram.ball:
        yield diagram.ball, None
    if diagram.activity.thing and diagram.activity.thing.at:
        return
    for name, acts in diagram.acts.items():
        for act in acts:
            element = diagram.elements[act.element]
            if _after(diagram, act, False):
                break
            if not act.part and _needs(diagram, element):
                if name != diagram.ball:
                    yield name, element
                break


def _fault(
    element: Element, expected: str, found: str, advice: str, code: str = "", **fields: str
) -> Fault:
    return Fault(expected, found, advice, element.line, 0, str(element), code, fields)


def _name_faults(diagram: Diagram) -> Iterator[Fault]:
    """Yield the faults of players who do not exist or are of the wrong team."""
    names = list(diagram.player)
    everybody = f"one of the players {', '.join(names)}"
    taken = {*ROLES, *(place for place, _ in diagram.places)}
    for player in diagram.players:
        if player.name in taken:
            found = "the name of a place or a role in rules"
            yield _of_player(player, "a player's name", found, "Choose another name.")
        if player.guards in names:
            yield from _guard_faults(diagram, player)
        if player.guards and player.guards not in names:
            advice = (suggestion(player.guards, names) or " Add the player.").strip()
            subject = f"{player.name} guards {player.guards}"
            yield Fault(everybody, repr(player.guards), advice, player.line, 0, subject)
    if diagram.ball and diagram.ball not in names:
        near = (suggestion(diagram.ball, names) or " Add the player.").strip()
        yield Fault(everybody, repr(diagram.ball), near, subject=f"ball {diagram.ball}")
    yield from _stretch_faults(diagram, everybody)
    for element in diagram.elements:
        unknown = [n for n in (element.player, element.other) if n and n not in names]
        if not unknown:
            yield from _team_faults(diagram, element)
            continue
        what, advice = everybody, "Add the player, or name another."
        role = diagram.verb(element).role
        if unknown[0] == element.other and role not in (RECEIVER, OPPONENT):
            named = ", ".join(place for place, _ in diagram.places)
            what += f", or of the places {named}" if named else ", or a place"
            advice = f"Add 'place {unknown[0]} at X Z', or the player."
        near = suggestion(unknown[0], names).strip() or advice
        yield _fault(element, what, repr(unknown[0]), near)


def _stretch_faults(diagram: Diagram, everybody: str) -> Iterator[Fault]:
    names = list(diagram.player)
    steps = {element.step for element in diagram.elements}
    kept = [(str(one), (one.first, one.last)) for one in diagram.stretches]
    timed = [(f"step {step} comes {lag:g} s after {since}", (step, since))
             for step, lag, since in diagram.times]  # fmt: skip
    named = [(number, what) for what, of in (*kept, *timed) for number in of]
    for number, what in named:
        if number and number not in steps:
            one_of = f"a step of the diagram ({', '.join(map(str, sorted(steps)))})"
            yield Fault(one_of, str(number), "Draw it, or name another.", subject=what)
    for stretch in diagram.stretches:
        for name in (stretch.player, stretch.other):
            if name and name not in names:
                near = suggestion(name, names).strip() or "Add the player, or name another."
                yield Fault(everybody, repr(name), near, stretch.line, 0, str(stretch))


def _guard_faults(diagram: Diagram, player: Player) -> Iterator[Fault]:
    guarded = diagram.player[player.guards]
    leader = diagram.activity.leader_of(player.team)
    actual = "a team-mate" if guarded.team == player.team != PLAYER and not leader else ""
    actual = "the player themselves" if guarded == player else actual
    if actual:
        advice = "Name a player of the other team."
        subject = f"{player.name} guards {guarded.name}"
        yield Fault(f"an opponent of {player.name}", actual, advice, player.line, 0, subject)


def _team_faults(diagram: Diagram, element: Element) -> Iterator[Fault]:
    if not element.other:
        return
    role = diagram.verb(element).role
    one, other = diagram.player[element.player], diagram.player[element.other]
    if one.name == other.name:
        what, advice = "two players", f"{one.name} cannot do this to themselves."
        yield _fault(element, what, f"{one.name} twice", advice)
    elif role == OPPONENT and one.team == other.team != PLAYER:
        what, actual = f"an opponent of {one.name}", f"{other.name}, a team-mate"
        yield _fault(element, what, actual, "Name a player of the other team.")


def _place_faults(diagram: Diagram) -> Iterator[Fault]:
    """Yield the faults of points off the ground and of players at one point."""
    court = diagram.court
    left, right, back, front = court.corners
    what = f"a point on the ground (x {left:g} to {right:g} m, z {back:g} to {front:g} m)"
    advice = "x grows to the right and z down the page. Move it, or make the ground larger."
    for player in diagram.players:
        if not court.holds(player.at):
            yield _of_player(player, what, _point(player.at), advice)
    for one, other in combinations(diagram.players, 2):
        apart = math.hypot(one.at.x - other.at.x, one.at.z - other.at.z)
        if apart < BODY_WIDTH:
            least, found = f"{BODY_WIDTH:g} m", f"{apart:.2g} m"
            what = f"a place at least {least} from {one.name} (line {one.line})"
            touch = "Players this close touch each other: move one of them."
            fields = {"least": least, "other": one.name, "apart": found}
            yield _of_player(other, what, found, touch, "too_near", **fields)
    for element in diagram.elements:
        for spot in (*element.via, *([element.to] if element.to else [])):
            if not court.holds(spot):
                yield _fault(element, what, _point(spot), advice)


def _of_player(
    player: Player, expected: str, found: str, advice: str, code: str = "", **fields: str
) -> Fault:
    return Fault(expected, found, advice, player.line, 0, player.name, code, fields)


def _point(spot: Spot) -> str:
    return f"{spot.x:g} {spot.z:g}"


def _ball_faults(diagram: Diagram) -> Iterator[Fault]:
    """Yield the faults of passes back in time, and of balls that players do not have."""
    for element in diagram.elements:
        if element.caught and element.caught < element.step:
            what = f"a step from {element.step} on for the catch"
            actual = f"step {element.caught}, back in time"
            yield _fault(element, what, actual, "A pass is caught after it is thrown.")
    holders = list(_holders(diagram))
    if len(holders) > 1:
        yield _two_holders(holders, thing_of(diagram))
        return
    for name, acts in diagram.acts.items():
        held = has_ball(diagram, name)
        given: Element | None = None
        for act, ball in zip(acts, held, strict=True):
            yield from _act_faults(diagram, act, (name, ball, given))
            if not act.part and not _after(diagram, act, True):
                given = diagram.elements[act.element]


def _two_holders(holders: list[tuple[str, Element | None]], thing: str) -> Fault:
    told = [(name, str(element or f"{thing} {name}"), element) for name, element in holders]
    because = [
        f"{name} ('{done}'{f', line {element.line}' if element else ''})"
        for name, done, element in told
    ]
    last = holders[-1][1]
    return Fault(
        f"one player with the {thing} at the beginning",
        f"{len(holders)}: {' and '.join(because)}",
        f"Let it be given to {holders[-1][0]} before.",
        last.line if last else 0,
        subject=str(last),
        code="two_holders",
        fields={
            "thing": thing,
            "count": str(len(holders)),
            "who": " and ".join(f"{name} ('{done}')" for name, done, _ in told),
        },
    )


def _act_faults(
    diagram: Diagram, act: Act, who: tuple[str, bool, Element | None]
) -> Iterator[Fault]:
    """Yield the faults of one act: with the object, or without it, where it must not be."""
    name, ball, given = who
    element, thing = diagram.elements[act.element], thing_of(diagram)
    what = f"{name} to have the {thing}"
    takes = not act.part and _begins(diagram, element, TAKE)
    free = not act.part and all(diagram.activity.free(form) for form in diagram.forms(element))
    if ((act.part and _after(diagram, act, False)) or takes) and ball:
        actual = f"{name} with the {thing} already"
        what = f"a receiver without the {thing}"
        yield _fault(element, what, actual, "Let it be given away before.")
    elif not act.part and _needs(diagram, element) and not ball:
        gone, advice = f"{name} without the {thing}", f"Let {name} take it, or be given it, before."
        if diagram.activity.thing and diagram.activity.thing.at:
            advice += (
                f" What is struck where it lies, such as by a kick, needs 'strike({thing}, PLACE)'."
            )
        if given is not None:
            gone += f" since '{given}' (line {given.line})"
            advice = "Let it be given back."
        fields = {"player": name, "thing": thing, "since": str(given or "")}
        yield _fault(element, what, gone, advice, "empty_handed", **fields)
    elif takes and not _lies_or_flies(diagram, element):
        advice = f"Give it to {name} instead, or say where it lies: 'object {thing} at PLACE'."
        yield _fault(element, f"a {thing} to take", "none that lies anywhere", advice)
    elif not act.part and _begins(diagram, element, STRIKE) and _who_has(diagram, element):
        actual = f"{_who_has(diagram, element)} with it"
        advice = f"Let it be put down before, or be sent to them: 'serve: send({thing}, receiver)'."
        yield _fault(element, f"the {thing} to lie", actual, advice)
    elif free and ball:
        advice = f"Choose an action that keeps the {thing}, or let it be given away before."
        actual = f"{name} with it"
        fields = {"player": name, "thing": thing}
        what = f"{name} without the {thing}"
        yield _fault(element, what, actual, advice, "hands_full", **fields)


def thing_of(diagram: Diagram) -> str:
    """Return the name of the object."""
    return diagram.activity.thing.name if diagram.activity.thing else "object"
