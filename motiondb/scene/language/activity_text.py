"""Reading what an activity is made of from the statements of a grammar; see :mod:`.grammar_file`.

::

    verb move = walk | run to X Z          # a class of actions, and whether it leads somewhere
    verb move = dribble to X Z with ball   # the same word for who has the ball
    verb screen = walk | run then push_off on opponent to X Z
    verb fake = fake_shot*                 # * repeats, "once" does not
    role leader, follower of leader
    object cup size 8 cm at table          # where it lies at first; without, somebody has it
    place rim at 0 0 height 3.05 m size 45 cm
    place goal height 1 m size 3 x 2 m     # upright, which a diagram puts somewhere
    ground half 15 x 14 from -7.5 -1.575   # a name, width and length, least x and z in metres
    mark 0 0, 1 0, arc 0 0 1 0 90          # a line on it: points, arcs x z radius from to (degrees)
    rest idle                              # also: with ball, for ACTION, after ACTION
    parry, duck answers punch | kick after 0.1 s
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from motiondb.scene.language.activity import (
    DEEDS,
    GIVE,
    ROLES,
    TAKE,
    Activity,
    Answers,
    Ground,
    Place,
    Rest,
    Step,
    Thing,
    Verb,
)
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tokens import Cursor, Token

SMALLEST, LARGEST = 2.0, 100.0
"""Limits of the size of the ground, m. Outside, the file is likely to use another unit."""
_THINNEST, _WIDEST = 0.01, 20.0  # Limits of sizes and heights of objects and places, m
_ARC = 73  # Points of an arc
_NOT_LINKS = ("then", "once", "for", "after")
_VERB = "Write 'verb move = walk | run to X Z', or 'verb pass = throw to receiver'."


@dataclass
class ActivityDraft:
    """The statements read so far; ``named`` are names that must be known in the end."""

    verbs: list[Verb] = field(default_factory=list)
    roles: dict[str, str] = field(default_factory=dict)
    thing: Thing | None = None
    deeds: list[tuple[str, str, str]] = field(default_factory=list)
    rests: list[Rest] = field(default_factory=list)
    answers: list[Answers] = field(default_factory=list)
    places: dict[str, Place] = field(default_factory=dict)
    ground: Ground = field(default_factory=Ground)
    marks: list[tuple[tuple[float, float, float], ...]] = field(default_factory=list)
    # Each with what it must be: "action", "role", "place", "object" or "aim"
    named: list[tuple[Token, str]] = field(default_factory=list)

    def name(self, cursor: Cursor, kind: str, advice: str) -> str:
        """Take a name that must be known as a ``kind`` in the end."""
        token = cursor.here
        what = {"action": "an action", "role": "a role", "place": "a place"}.get(kind, "a name")
        name = cursor.name(what, advice)
        self.named.append((token, kind))
        return name

    def actions(self, cursor: Cursor, advice: str) -> tuple[str, ...]:
        """Take one action, or several divided by ``|``."""
        names = [self.name(cursor, "action", advice)]
        while cursor.meets("|"):
            names.append(self.name(cursor, "action", advice))
        return tuple(names)


def _read_verb(cursor: Cursor, draft: ActivityDraft) -> None:
    name = cursor.name("the verb's name", _VERB)
    cursor.expect("=", _VERB)
    steps = [_read_step(cursor, draft)]
    while cursor.meets("then"):
        steps.append(_read_step(cursor, draft))
    link, role, goes, with_object = "", "", False, False
    while cursor.here.kind == "name":
        token, word = cursor.here, cursor.take().text
        if word == "with" and link:
            draft.name(cursor, "object", "Write 'object ball' in a line of its own.")
            with_object = True
        elif cursor.here.text == "X" and cursor.after.text == "Z":
            cursor.take(), cursor.take()
            goes = True
        elif link or word in _NOT_LINKS:
            cursor.fail("one word and role, 'to X Z', or 'with' and the object", _VERB, token)
        else:
            link, role = word, draft.name(cursor, "aim", _VERB)
    draft.verbs.append(Verb(name, tuple(steps), link, role, goes, with_object))


def _read_step(cursor: Cursor, draft: ActivityDraft) -> Step:
    actions = draft.actions(cursor, _VERB)
    repeated = True if cursor.meets("*") else False if cursor.meets("once") else None
    return Step(actions, repeated)


def _read_role(cursor: Cursor, draft: ActivityDraft) -> None:
    advice = "Write 'role leader, follower of leader'."
    while True:
        token = cursor.here
        name = cursor.name("a role", advice)
        if name in ROLES:
            cursor.fail("another name", f"{name!r} has its own meaning in rules.", token)
        draft.roles[name] = draft.name(cursor, "role", advice) if cursor.meets("of") else ""
        if not cursor.meets(","):
            return


def _read_thing(cursor: Cursor, draft: ActivityDraft) -> None:
    token = cursor.here
    name = cursor.name("the object's name", "Write 'object ball size 24 cm'.")
    if draft.thing is not None:
        cursor.fail("one object", f"The grammar has {draft.thing.name!r} already.", token)
    size = _size(cursor) if cursor.meets("size") else Thing.size
    at = draft.name(cursor, "place", "Write 'at table'.") if cursor.meets("at") else ""
    draft.thing = Thing(name, size, at)


def _size(cursor: Cursor) -> float:
    token = cursor.here
    value = cursor.quantity("length", "a size")
    if not _THINNEST <= value <= _WIDEST:
        cursor.fail(f"{_THINNEST:g} to {_WIDEST:g} m", "Correct the size.", token)
    return value


def read_place(cursor: Cursor, draft: ActivityDraft) -> None:
    """Read one place of a ``place`` line."""
    token = cursor.here
    name = cursor.name("a name of a place", "Write 'place object, goal'.")
    if name in ROLES:
        advice = f"{name} means a player: name the place otherwise."
        cursor.fail("a name of a place", advice, token)
    if name in draft.places:
        cursor.fail("every place once", "Leave one of them out.", token)
    at, height, width, tall = None, 0.0, 0.0, 0.0
    if cursor.meets("at"):
        at = read_spot(cursor)
    if cursor.meets("height"):
        height = _size(cursor)
    if cursor.meets("size"):
        if cursor.after.text == "x":
            width = cursor.number("the width", "Write 'size 3 x 2 m'.")
            cursor.expect("x", "Write 'size 3 x 2 m'.")
            tall = _size(cursor)
        else:
            width = _size(cursor)
    draft.places[name] = Place(name, at, height, width, tall)


def read_spot(cursor: Cursor) -> Spot:
    """Read a point of the ground."""
    advice = "Write x and z in metres: 0 8."
    x = cursor.number("x, metres", advice)
    return Spot(x, cursor.number("z, metres", advice))


def read_extent(cursor: Cursor, advice: str) -> tuple[float, float]:
    """Read the width and length of a ground, ``8 x 6``, m."""
    sizes = []
    for what in ("the width in metres", "the length in metres"):
        token = cursor.here
        sizes.append(cursor.number(what, advice))
        if not SMALLEST <= sizes[-1] <= LARGEST:
            cursor.fail(f"{SMALLEST:g} to {LARGEST:g} metres", "Lengths are metres.", token)
        if len(sizes) == 1:
            cursor.expect("x", advice)
    return sizes[0], sizes[1]


def _read_ground(cursor: Cursor, draft: ActivityDraft) -> None:
    advice = "Write 'ground 8 x 6', or 'ground half 15 x 14 from -7.5 -1.575'."
    name = cursor.take().text if cursor.here.kind == "name" else ""
    width, length = read_extent(cursor, advice)
    corner = Spot(-width / 2, -length / 2)
    if cursor.meets("from"):
        corner = read_spot(cursor)
    draft.ground = Ground(name, width, length, corner.x, corner.z)


def _read_mark(cursor: Cursor, draft: ActivityDraft) -> None:
    points: list[tuple[float, float, float]] = []
    while True:
        if cursor.meets("arc"):
            names = ("x", "z", "the radius", "the first angle", "the last angle")
            advice = "Write 'arc x z radius from to'."
            x, z, r, a, b = (cursor.number(what, advice) for what in names)
            turns = [math.radians(a + (b - a) * k / (_ARC - 1)) for k in range(_ARC)]
            points += [(x + r * math.cos(t), 0.0, z + r * math.sin(t)) for t in turns]
        else:
            spot = read_spot(cursor)
            more = cursor.number("z", "") if cursor.here.kind == "number" else None
            points.append((spot.x, 0.0, spot.z) if more is None else (spot.x, spot.z, more))
        if not cursor.meets(","):
            break
    draft.marks.append(tuple(points))


def _read_rest(cursor: Cursor, draft: ActivityDraft) -> None:
    advice = "Write 'rest idle', 'rest hold with ball', 'rest guard for guard' or 'after sit_down'."
    action = draft.name(cursor, "action", advice)
    with_object = False
    doing: tuple[str, ...] = ()
    after: tuple[str, ...] = ()
    if cursor.meets("with"):
        draft.name(cursor, "object", advice)
        with_object = True
    elif cursor.meets("for"):
        doing = draft.actions(cursor, advice)
    elif cursor.meets("after"):
        after = draft.actions(cursor, advice)
    draft.rests.append(Rest(action, with_object, doing, after))


STATEMENTS: dict[str, Callable[[Cursor, ActivityDraft], None]] = {
    "verb": _read_verb,
    "role": _read_role,
    "object": _read_thing,
    "ground": _read_ground,
    "mark": _read_mark,
    "rest": _read_rest,
}
"""Statements by their first word."""


def read_answers(cursor: Cursor, answers: tuple[Token, ...], draft: ActivityDraft) -> None:
    """Read what follows ``parry, duck answers``."""
    draft.named += [(token, "action") for token in answers]
    acts = draft.actions(cursor, "Write 'parry answers punch | kick'.")
    lag = cursor.quantity("time", "a time") if cursor.meets("after") else 0.0
    draft.answers.append(Answers(tuple(token.text for token in answers), acts, lag))


def read_deed(cursor: Cursor, symbols: tuple[Token, ...], draft: ActivityDraft) -> None:
    """Read what actions do with the object, such as ``send(ball, rim)``."""
    deed = cursor.name("a deed", "", DEEDS)
    cursor.expect("(", f"Write what is meant: {deed}(ball).")
    draft.name(cursor, "object", "Write 'object ball' in a line of its own.")
    to = draft.name(cursor, "aim", "Write a place.") if cursor.meets(",") else ""
    cursor.expect(")", "Close the bracket.")
    draft.named += [(token, "action") for token in symbols]
    draft.deeds += [(token.text, deed, "" if to in ROLES else to) for token in symbols]


def finished(
    draft: ActivityDraft,
    actions: tuple[str, ...],
    replies: list[tuple[str, str, tuple[str, ...]]],
    flights: list[tuple[str, tuple[str, ...]]],
) -> Activity:
    """Return the activity; a flight without an object is that of a ball.

    `flights`: Actions that are synchronised by a ball's flight, with the actions that catch it.
    """
    thing, deeds = draft.thing, list(draft.deeds)
    said = {action for action, _, _ in deeds}
    if flights:
        thing = thing or Thing("ball")
        thrown = [(action, GIVE, "") for action, _ in flights]
        thrown += [(one, TAKE, "") for _, caught in flights for one in caught]
        deeds += [deed for deed in dict.fromkeys(thrown) if deed[0] not in said]
    name, verbs = thing.name if thing else "", []
    for verb in draft.verbs:
        if verb.link == "with" and verb.role == name:  # not with somebody, but with the object
            verb = replace(verb, link="", role="", with_object=True)
        verbs.append(verb)
    ground = replace(draft.ground, marks=tuple(draft.marks))
    return Activity(
        actions,
        tuple(verbs),
        tuple(draft.roles.items()),
        thing,
        tuple(dict.fromkeys(deeds)),
        tuple(draft.rests),
        tuple(draft.answers),
        tuple(replies),
        tuple(draft.places.values()),
        ground,
    )
