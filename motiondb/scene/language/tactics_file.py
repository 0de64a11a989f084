"""Reading diagrams from text: one statement a line, in metres; ``#`` begins a comment.

::

    diagram "Give and Go"                     # its title
    grammar basketball                        # the grammar that it is played by
    court half                                # the grammar's ground; or: ground 8 x 6
    place bench at 6 2                        # where a place is that rules may name
    ball A1                                   # who has the object, if no element implies it

    attack A1 at 0 8                          # a circle: role, name, x and z
    defence D1 at 0 6.5 guards A1             # or: follower F1 at 0 6 follows L1

    1 pass A1 to A2                           # the number is the step; a later catch: caught 2
    1 feint D1 to 1 6
    2 cut A1 via 1.5 5 to 0.6 1.4             # via may name several points, divided by commas
    3 layup A1 at rim                         # at, on, with, to: a player or a place
    1 does D1 guard* then run | walk          # exactly these actions, in this order

    D1 keeps 0.5 m .. 2 m to A1 from 1 to 4   # a distance, from one step to another
    D1 keeps moving
    step 3 comes 0.6 s after 2

Verbs are the actions of the grammar, and those that it declares (:mod:`.activity_text`).
"""

from __future__ import annotations

from dataclasses import replace

from motiondb.errors import suggestion
from motiondb.scene.language.activity import Activity, Ground, Step, Verb
from motiondb.scene.language.activity_text import LARGEST, read_extent, read_spot
from motiondb.scene.language.possession import check_diagram
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import DOES, Diagram, Element, Player, Stretch
from motiondb.scene.language.tokens import Cursor, refuse, statements

# Writing tactics diagrams as text, which :func:`read_diagram` reads again.


def format_diagram(diagram: Diagram) -> str:
    r"""Return the text of a diagram.

    >>> from motiondb.scene.language.tactics import Player
    >>> shooter = Player("A1", "attack", Spot(0.0, 8.0))
    >>> play = Diagram("Drill", (shooter,), (Element("layup", 1, "A1"),))
    >>> print(format_diagram(play))
    diagram "Drill"
    grammar basketball
    <BLANKLINE>
    attack A1 at 0 8
    <BLANKLINE>
    1 layup A1
    <BLANKLINE>

    Places are written to the centimetre: nobody draws more exactly.
    """
    head = [f'diagram "{diagram.name}"', f"grammar {diagram.grammar}"]
    if diagram.ground is not None:
        head.append(f"ground {_number(diagram.ground.width)} x {_number(diagram.ground.length)}")
    head += [f"place {name} at {_spot(at)}" for name, at in diagram.own_places]
    if diagram.ball:
        head.append(f"{_thing(diagram.activity)} {diagram.ball}")
    players = [
        f"{player.team} {player.name} at {_spot(player.at)}"
        + (f" guards {player.guards}" if player.guards else "")
        for player in diagram.players
    ]
    drawn = [_element(one, diagram) for one in diagram.elements if one.kind != DOES]
    parts = (head, players, drawn, other_statements(diagram))
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def other_statements(diagram: Diagram) -> list[str]:
    """Return the lines of a diagram that nothing is drawn for."""
    lines = [_element(one, diagram) for one in diagram.elements if one.kind == DOES]
    lines += [str(one) for one in diagram.stretches]
    within = diagram.times
    return lines + [f"step {step} comes {lag:g} s after {since}" for step, lag, since in within]


def _thing(activity: Activity) -> str:
    """Return how diagrams call the object; "ball" where the grammar is not known."""
    if activity.thing:
        return activity.thing.name
    return "" if activity.actions else "ball"


def _number(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"


def _spot(spot: Spot) -> str:
    return f"{_number(spot.x)} {_number(spot.z)}"


def _element(element: Element, diagram: Diagram) -> str:
    text = f"{element.step} {element.kind} {element.player}"
    if element.kind == DOES:
        return f"{text} {' then '.join(map(_step, element.steps))}"
    about, verb = element.other or element.target, diagram.verb(element)
    if about:
        text += f" {element.link or verb.link or 'on'} {about}"
    if element.caught:
        text += f" caught {element.caught}"
    if element.via:
        text += f" via {', '.join(map(_spot, element.via))}"
    return text + (f" to {_spot(element.to)}" if element.to else "")


def _step(step: Step) -> str:
    return " | ".join(step.actions) + "*" * bool(step.repeated)


_KEYWORDS = ("diagram", "grammar", "court", "ground", "place", "step")
_ONCE = ("diagram", "grammar", "court", "ground", "place")
_LONGEST_NAME = 60  # Most characters of a player's name, which becomes part of the names of files
_LAST_STEP = 10_000  # Largest step. A larger number is a slip;
_LONGEST_TIME = 60.0  # Longest time between two steps, s
_FOLLOWING = ("guards", "follows")


def grammar_name(text: str, where: str = "diagram") -> str:
    """Return the name of the grammar that a diagram's text is played by."""
    for cursor in statements(text, where):
        if cursor.here.text == "grammar" and cursor.after.kind == "name":
            return cursor.after.text
    return Diagram.grammar


def read_diagram(text: str, where: str = "diagram", activity: Activity | None = None) -> Diagram:
    """Read a diagram from its text, and check that it can be played.

    `activity`: That of its grammar (:attr:`.motion_grammar.MotionGrammar.activity`); without, any
    word is a verb.
    """
    diagram = parse_diagram(text, where, activity)
    check_diagram(diagram, where)
    return diagram


def parse_diagram(text: str, where: str = "diagram", activity: Activity | None = None) -> Diagram:
    """Read a diagram from its text, whether or not it can be played."""
    diagram = Diagram("", (), (), activity=activity or Activity())
    said: dict[str, int] = {}
    for cursor in statements(text, where):
        if cursor.here.kind == "number":
            diagram = replace(diagram, elements=(*diagram.elements, _read_element(cursor, diagram)))
        else:
            _refuse_repetition(cursor, said)
            diagram = _read_keyword(cursor, diagram)
        cursor.done("Write one statement a line.")
    if not diagram.players:
        refuse(where, "at least one player", "none", f"Write '{_some_team(diagram)} A1 at 0 8'.")
    return replace(diagram, name=diagram.name or where)


def _refuse_repetition(cursor: Cursor, said: dict[str, int]) -> None:
    """Refuse a second statement of a kind that is allowed only once."""
    key = cursor.here.text
    if key in _ONCE:
        key = f"place {cursor.after.text}" if key == "place" else key
        cursor.once(said, {"court": "ground"}.get(key, key), f"{key!r} once")


def _some_team(diagram: Diagram) -> str:
    return diagram.activity.teams[0]


def _read_keyword(cursor: Cursor, diagram: Diagram) -> Diagram:
    token, activity = cursor.take(), diagram.activity
    thing = _thing(activity)
    # without roles in the grammar any word is one
    is_open = not activity.roles and cursor.here.kind == "name" and cursor.after.text == "at"
    if token.text in _KEYWORDS:
        pass
    elif token.text == thing and token.kind == "name" and cursor.here.kind == "name":
        if diagram.ball:
            cursor.fail(f"'{thing}' once", "Leave one of the lines out.", token)
        return replace(diagram, ball=cursor.name("a player's name", f"Write '{thing} A1'."))
    elif token.kind == "name" and cursor.meets("keeps"):
        stretch = _read_stretch(cursor, token.text, token.line)
        return replace(diagram, stretches=(*diagram.stretches, stretch))
    elif token.kind == "name" and (token.text in activity.teams or is_open):
        player = _read_player(cursor, diagram, token.text)
        return replace(diagram, players=(*diagram.players, player))
    else:
        words = (*_KEYWORDS, *([thing] if thing else []), *activity.teams)
        near = suggestion(token.text, words).strip()
        if token.text in activity.verbs:
            near = f"Write the step before it: '1 {token.text} ...'."
        what = f"a step's number, or one of {', '.join(words)}"
        cursor.fail(what, near or "See the format of diagrams.", token)
    return _read_head(cursor, diagram, token.text)


def _read_head(cursor: Cursor, diagram: Diagram, word: str) -> Diagram:
    """Read what follows one of the keywords."""
    if word == "diagram":
        if cursor.here.kind != "text":
            cursor.fail("the diagram's title in quotes", 'Write diagram "Give and Go".')
        return replace(diagram, name=cursor.take().text)
    if word == "grammar":
        name = cursor.name("a grammar's name", "Write 'grammar basketball'.")
        return replace(diagram, grammar=name)
    if word in ("court", "ground"):
        return replace(diagram, ground=_read_ground(cursor, diagram.activity, word))
    if word == "step":
        return replace(diagram, times=(*diagram.times, _read_time(cursor)))
    name = cursor.name("a place's name", "Write 'place bench at 6 2'.")
    cursor.expect("at", "Write 'place bench at 6 2'.")
    others = tuple(pair for pair in diagram.own_places if pair[0] != name)
    token = cursor.here
    spot = read_spot(cursor)
    if max(abs(spot.x), abs(spot.z)) > LARGEST:
        cursor.fail(f"a place within {LARGEST:g} metres", "Lengths are metres.", token)
    return replace(diagram, own_places=(*others, (name, spot)))


def _read_ground(cursor: Cursor, activity: Activity, word: str) -> Ground | None:
    """Read a size, or the name of the grammar's ground: then the result is None."""
    named = activity.ground.name
    advice = f"Write width and length in metres: '{word} 8 x 6'"
    advice += f", or '{word} {named}'." if named else "."
    if cursor.here.kind == "name":
        known = (named,) if named else ()
        if named or cursor.here.text != "half":  # as older diagrams say of any ground
            cursor.name("the ground of the grammar", advice, known or ("a size",))
        else:
            cursor.take()
        return None
    return Ground.field(*read_extent(cursor, advice))


def _read_time(cursor: Cursor) -> tuple[int, float, int]:
    advice = "Write 'step 3 comes 0.6 s after 2'."
    step = _read_step(cursor)
    cursor.expect("comes", advice)
    most = cursor.quantity("time", "a time")
    cursor.expect("after", advice)
    token, since = cursor.here, _read_step(cursor)
    if since >= step or not 0.0 <= most <= _LONGEST_TIME:
        cursor.fail(
            f"a step before {step}, and a time from 0 to {_LONGEST_TIME:g} s", advice, token
        )
    return step, most, since


def _read_stretch(cursor: Cursor, name: str, line: int) -> Stretch:
    advice = f"Write '{name} keeps 0.5 m .. 2 m to A1 from 1 to 4', or '{name} keeps moving'."
    stretch = Stretch(name, line=line)
    if not cursor.meets("moving"):
        token = cursor.here
        near = cursor.quantity("length", "a distance, or 'moving'")
        cursor.expect("..", advice)
        far = cursor.quantity("length", "a distance")
        if not 0.0 <= near <= far:
            cursor.fail("distances of 0 or more, the nearer first", advice, token)
        cursor.expect("to", advice)
        stretch = replace(stretch, near=near, far=far, other=cursor.name("a player", advice))
    if cursor.meets("from"):
        token, first = cursor.here, _read_step(cursor)
        cursor.expect("to", advice)
        last = _read_step(cursor)
        if last < first:
            cursor.fail("an earlier step first", advice, token)
        stretch = replace(stretch, first=first, last=last)
    return stretch


def _read_player(cursor: Cursor, diagram: Diagram, team: str) -> Player:
    token = cursor.here
    name = cursor.name("a player's name", f"Write '{team} A1 at 0 8'.")
    for other in diagram.players:  # some file systems do not distinguish upper and lower case
        if other.name.casefold() == name.casefold():
            cursor.fail("a name of their own", f"Line {other.line} has the same.", token)
    if len(name) > _LONGEST_NAME:
        cursor.fail(f"a name of at most {_LONGEST_NAME} characters", "Shorten it.", token)
    cursor.expect("at", f"Write '{team} {name} at 0 8'.")
    at = read_spot(cursor)
    guards = ""
    if cursor.meets(*_FOLLOWING):
        guards = cursor.name("whom they guard", f"Write 'guards A1' behind {name}.")
    return Player(name, team, at, guards, token.line)


def _read_element(cursor: Cursor, diagram: Diagram) -> Element:
    step = _read_step(cursor)
    token, activity = cursor.here, diagram.activity
    if cursor.meets(DOES):
        name = cursor.name("a player's name", f"Write '{step} does A1 walk* then bow'.")
        return Element(DOES, step, name, line=token.line, steps=_read_string(cursor, activity))
    known = (*activity.verbs, DOES) if activity.actions else ()
    kind = cursor.name("what is done", "See the format of diagrams.", known)
    player = cursor.name("a player's name", f"Write '{step} {kind} A1'.")
    element = Element(kind, step, player, line=token.line)
    verb = activity.verb(kind)
    via: list[Spot] = []
    while cursor.here.kind == "name":
        word = cursor.here.text
        if cursor.meets("via"):
            via.append(read_spot(cursor))
            while cursor.meets(","):
                via.append(read_spot(cursor))
        elif word == "to" and cursor.after.kind == "number":
            cursor.take()
            return _whole(cursor, replace(element, via=tuple(via), to=read_spot(cursor)), verb)
        elif word == "caught" and element.other:
            cursor.take()
            element = replace(element, caught=_read_step(cursor))
        elif element.other or element.target:
            break
        else:
            element = _read_link(cursor, element, verb, diagram)
    return _whole(cursor, replace(element, via=tuple(via)), verb)


def _read_link(cursor: Cursor, element: Element, verb: Verb, diagram: Diagram) -> Element:
    """Read the other player or the place of an element, such as ``to A2`` or ``at goal``."""
    written = f"{element.step} {element.kind} {element.player}"
    if verb.link:
        cursor.expect(verb.link, f"Write '{written} {verb.link} D1'.")
    link = verb.link or cursor.take().text
    name = cursor.name("a player's or a place's name", f"Write '{written} {link} D1'.")
    places = {*diagram.activity.place, *(place for place, _ in diagram.own_places)}
    is_place = name in places and name not in diagram.player
    if is_place:
        return replace(element, target=name, link=link)
    return replace(element, other=name, link=link)


def _whole(cursor: Cursor, element: Element, verb: Verb) -> Element:
    """Return an element that has all that its verb needs, or refuse it."""
    if verb.link and not (element.other or element.target) and verb.role != "target":
        cursor.expect(
            verb.link, f"Write '{element.step} {element.kind} {element.player} {verb.link} D1'."
        )
    if element.to is None and (verb.must_go or element.via):
        cursor.expect("to", f"Write where {element.player} goes: 'to 0.5 2'.")
    return element


def _read_string(cursor: Cursor, activity: Activity) -> tuple[Step, ...]:
    """Read what somebody does: classes of actions, divided by ``then``."""
    steps: list[Step] = []
    while not steps or cursor.meets("then"):
        actions = [cursor.name("an action", "Write 'walk* then bow'.", activity.actions)]
        while cursor.meets("|"):
            actions.append(cursor.name("an action", "Write 'bow | wave'.", activity.actions))
        steps.append(Step(tuple(actions), bool(cursor.meets("*"))))
    return tuple(steps)


def _read_step(cursor: Cursor) -> int:
    token = cursor.here
    value = cursor.number("a step", "Write a whole number from 1 on.")
    if value != int(value) or not 1 <= value <= _LAST_STEP:
        end = f"to {_LAST_STEP}" if value > _LAST_STEP else "on"
        what = f"a whole number from 1 {end}"
        cursor.fail(what, "Steps are counted 1, 2, 3.", token)
    return int(value)
