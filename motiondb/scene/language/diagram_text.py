"""Writing tactics diagrams as text, which :func:`.tactics_file.read_diagram` reads again.

Places are written to the centimetre: nobody draws more exactly.
"""

from __future__ import annotations

from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import Court, Diagram, Element

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
