"""Reading tactics diagrams from text: one statement a line, in metres; ``#`` begins a comment.

::

    diagram "Give and Go"                     # its title
    grammar basketball                        # the grammar that it is played by
    court half                                # or: court 8 x 6, metres, without lines
    place bench at 6 2                        # a place that rules may name; the rim is at 0 0
    ball A1                                   # only needed if no pass or shot implies it

    attack A1 at 0 8                          # a circle: team, name, x and z
    defence D1 at 0 6.5 guards A1

    1 pass A1 to A2                           # the number is the step; a later pass: caught 2
    1 feint D1 to 1 6
    2 cut A1 via 1.5 5 to 0.6 1.4             # via may name several points, divided by commas
    3 screen A2 on D1 via -1 5 to 0 6
    4 layup A1

Moves are ``move`` (a dribble for the player with the ball, else walk or run), ``walk``, ``run``,
``cut`` and ``dribble``. Shots are ``shoot`` and ``layup``. Zigzags are ``feint``, ``fake``,
``pivot_left`` and ``pivot_right``. Defenders ``guard`` and ``block`` (``2 guard D1 on A1``). A move
may name the player that it is directed at (``1 run D2 on A1 to 4.5 4.4``) if that is not the
guarded player. The axes are those of :mod:`.tactics`.
"""

from __future__ import annotations

from dataclasses import replace

from motiondb.errors import suggestion
from motiondb.scene.language.possession import check_diagram
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import (
    FEINTS,
    KINDS,
    MOVES,
    TEAMS,
    Court,
    Diagram,
    Element,
    Player,
)
from motiondb.scene.language.tokens import Cursor, refuse, statements

# Writing tactics diagrams as text, which :func:`read_diagram` reads again.


_RIM = ("rim", Spot(0.0, 0.0))  # The place that every diagram has: the origin, below the rim


def format_diagram(diagram: Diagram) -> str:
    r"""Return the text of a diagram.

    >>> from motiondb.scene.language.tactics import Player
    >>> shooter = Player("A1", "attack", Spot(0.0, 8.0))
    >>> play = Diagram("Drill", (shooter,), (Element("layup", 1, "A1"),))
    >>> print(format_diagram(play))
    diagram "Drill"
    grammar basketball
    court half
    <BLANKLINE>
    attack A1 at 0 8
    <BLANKLINE>
    1 layup A1
    <BLANKLINE>

    Places are written to the centimetre: nobody draws more exactly.
    """
    head = [f'diagram "{diagram.name}"', f"grammar {diagram.grammar}", _court(diagram.court)]
    head += [f"place {name} at {_spot(at)}" for name, at in diagram.places if (name, at) != _RIM]
    if diagram.ball:
        head.append(f"ball {diagram.ball}")
    players = [
        f"{player.team} {player.name} at {_spot(player.at)}"
        + (f" guards {player.guards}" if player.guards else "")
        for player in diagram.players
    ]
    elements = [_element(element) for element in diagram.elements]
    return "\n\n".join("\n".join(lines) for lines in (head, players, elements) if lines) + "\n"


def _court(court: Court) -> str:
    if court == Court():
        return "court half"
    return f"court {_number(court.width)} x {_number(court.length)}"


def _number(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"


def _spot(spot: Spot) -> str:
    return f"{_number(spot.x)} {_number(spot.z)}"


def _element(element: Element) -> str:
    text = f"{element.step} {element.kind} {element.player}"
    if element.kind == "pass":
        caught = f" caught {element.caught}" if element.caught else ""
        return f"{text} to {element.other}{caught}"
    if element.other:
        text += f" on {element.other}"
    if element.via:
        text += f" via {', '.join(map(_spot, element.via))}"
    return text + (f" to {_spot(element.to)}" if element.to else "")


_KEYWORDS = ("diagram", "grammar", "court", "place", "ball", *TEAMS)
_ONCE = ("diagram", "grammar", "court", "place", "ball")
_LONGEST_NAME = 60  # Most characters of a player's name, which becomes part of the names of files
_LAST_STEP = 10_000  # Largest step. A larger number is a slip;
_SMALLEST, _LARGEST = 2.0, 100.0
"""Limits of the size of the ground, m. Outside, the file is likely to use another unit."""


def read_diagram(text: str, where: str = "diagram") -> Diagram:
    """Read a diagram from its text, and check that it can be played."""
    diagram = parse_diagram(text, where)
    check_diagram(diagram, where)
    return diagram


def parse_diagram(text: str, where: str = "diagram") -> Diagram:
    """Read a diagram from its text, whether or not it can be played."""
    diagram = Diagram("", (), ())
    said: dict[str, int] = {}
    for cursor in statements(text, where):
        if cursor.here.kind == "number":
            diagram = replace(diagram, elements=(*diagram.elements, _read_element(cursor)))
        else:
            _refuse_repetition(cursor, said)
            diagram = _read_keyword(cursor, diagram)
        cursor.done("Write one statement a line.")
    if not diagram.players:
        refuse(where, "at least one player", "none", "Write 'attack A1 at 0 8'.")
    return replace(diagram, name=diagram.name or where)


def _refuse_repetition(cursor: Cursor, said: dict[str, int]) -> None:
    """Refuse a second statement of a kind that is allowed only once."""
    key = cursor.here.text
    if key in _ONCE:
        key = f"place {cursor.after.text}" if key == "place" else key
        cursor.once(said, key, f"{key!r} once")


def _read_keyword(cursor: Cursor, diagram: Diagram) -> Diagram:
    token = cursor.take()
    if token.kind != "name" or token.text not in _KEYWORDS:
        near = suggestion(token.text, _KEYWORDS).strip()
        if token.text in KINDS:
            near = f"Write the step before it: '1 {token.text} ...'."
        what = f"a step's number, or one of {', '.join(_KEYWORDS)}"
        cursor.fail(what, near or "See the format of diagrams.", token)
    if token.text == "diagram":
        if cursor.here.kind != "text":
            cursor.fail("the diagram's title in quotes", 'Write diagram "Give and Go".')
        return replace(diagram, name=cursor.take().text)
    if token.text == "grammar":
        name = cursor.name("a grammar's name", "Write 'grammar basketball'.")
        return replace(diagram, grammar=name)
    if token.text == "court":
        return replace(diagram, court=_read_court(cursor))
    if token.text == "ball":
        return replace(diagram, ball=cursor.name("a player's name", "Write 'ball A1'."))
    if token.text == "place":
        name = cursor.name("a place's name", "Write 'place bench at 6 2'.")
        cursor.expect("at", "Write 'place bench at 6 2'.")
        others = tuple(pair for pair in diagram.places if pair[0] != name)
        token = cursor.here
        spot = _read_spot(cursor)
        if max(abs(spot.x), abs(spot.z)) > _LARGEST:
            cursor.fail(f"a place within {_LARGEST:g} metres", "Lengths are metres.", token)
        return replace(diagram, places=(*others, (name, spot)))
    return replace(diagram, players=(*diagram.players, _read_player(cursor, diagram, token.text)))


def _read_court(cursor: Cursor) -> Court:
    advice = "Write 'court half', or width and length in metres: 'court 8 x 6'."
    if cursor.meets("half"):
        return Court()
    sizes = []
    for what in ("half, or the court's width in metres", "the court's length in metres"):
        token = cursor.here
        sizes.append(cursor.number(what, advice))
        if not _SMALLEST <= sizes[-1] <= _LARGEST:
            size = f"{_SMALLEST:g} to {_LARGEST:g} metres"
            cursor.fail(size, "Lengths are metres.", token)
        if len(sizes) == 1:
            cursor.expect("x", advice)
    return Court(sizes[0], sizes[1], behind_rim=sizes[1] / 2, lines=False)


def _read_spot(cursor: Cursor) -> Spot:
    advice = "Write x and z in metres: 0 8."
    x = cursor.number("x, metres", advice)
    return Spot(x, cursor.number("z, metres", advice))


def _read_player(cursor: Cursor, diagram: Diagram, team: str) -> Player:
    token = cursor.here
    name = cursor.name("a player's name", f"Write '{team} A1 at 0 8'.")
    for other in diagram.players:  # some file systems do not distinguish upper and lower case
        if other.name.casefold() == name.casefold():
            cursor.fail("a name of their own", f"Line {other.line} has the same.", token)
    if len(name) > _LONGEST_NAME:
        cursor.fail(f"a name of at most {_LONGEST_NAME} characters", "Shorten it.", token)
    cursor.expect("at", f"Write '{team} {name} at 0 8'.")
    at = _read_spot(cursor)
    guards = ""
    if cursor.meets("guards"):
        guards = cursor.name("whom they guard", f"Write 'guards A1' behind {name}.")
    return Player(name, team, at, guards, token.line)


def _read_element(cursor: Cursor) -> Element:
    step = _read_step(cursor)
    token = cursor.here
    kind = cursor.name("what is done", "See the format of diagrams.", KINDS)
    player = cursor.name("a player's name", f"Write '{step} {kind} A1'.")
    element = Element(kind, step, player, line=token.line)
    if kind == "pass":
        cursor.expect("to", f"Write '{step} pass {player} to A2'.")
        other = cursor.name("the receiver's name", "Write whom the pass is for.")
        caught = _read_step(cursor) if cursor.meets("caught") else 0
        return replace(element, other=other, caught=caught)
    if kind in ("screen", "guard", "block") or (kind in MOVES and cursor.here.text == "on"):
        cursor.expect("on", f"Write '{step} {kind} {player} on D1'.")
        element = replace(element, other=cursor.name("an opponent's name", "Write who it is."))
    if kind in MOVES or kind in (*FEINTS, "screen"):
        element = _read_way(cursor, element)
    return element


def _read_step(cursor: Cursor) -> int:
    token = cursor.here
    value = cursor.number("a step", "Write a whole number from 1 on.")
    if value != int(value) or not 1 <= value <= _LAST_STEP:
        end = f"to {_LAST_STEP}" if value > _LAST_STEP else "on"
        what = f"a whole number from 1 {end}"
        cursor.fail(what, "Steps are counted 1, 2, 3.", token)
    return int(value)


def _read_way(cursor: Cursor, element: Element) -> Element:
    via: list[Spot] = []
    if cursor.meets("via"):
        via.append(_read_spot(cursor))
        while cursor.meets(","):
            via.append(_read_spot(cursor))
    if element.kind in MOVES or via:
        cursor.expect("to", f"Write where {element.player} goes: 'to 0.5 2'.")
        return replace(element, via=tuple(via), to=_read_spot(cursor))
    return replace(element, to=_read_spot(cursor) if cursor.meets("to") else None)
