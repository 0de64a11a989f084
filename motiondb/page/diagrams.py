"""Tactics diagrams as JSON, to and from the browser. Places are [x, z] in metres."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import AfterValidator

from motiondb.answers.plain import extended
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import KINDS, Court, Diagram, Element, Player

Point = tuple[float, float]
Team = Literal["attack", "defence", "player"]
_NAME = re.compile(r"[^\W\d]\w*")
_TITLE, _GRAMMAR = re.compile(r'[^"\n\r]*'), re.compile(r"[^\W\d]\w*(-\w+)*")
_MOST = 200  # Largest number of players, elements or places of a request
_FARTHEST = 1000.0  # Largest distance of a request, metres
_LATEST = 10_000  # Largest step of a request
_STRICT: dict[str, Any] = {"extra": "forbid"}  # Unknown keys of a request are refused


@dataclass(frozen=True)
class PlayerShape:
    """A player at the beginning of the play."""

    __pydantic_config__: ClassVar = _STRICT
    name: str
    team: Team
    at: Point
    guards: str = ""


@dataclass(frozen=True)
class ElementShape:
    """An action of a player; ``line`` is ignored in requests."""

    __pydantic_config__: ClassVar = _STRICT
    kind: Literal[KINDS]  # type: ignore[valid-type]  # a tuple of literals
    step: int
    player: str
    other: str = ""
    caught: int = 0
    via: list[Point] = field(default_factory=list)
    to: Point | None = None
    line: int | None = None


@dataclass(frozen=True)
class CourtShape:
    """The court; ``behind_rim`` follows from the other values and is ignored in requests."""

    __pydantic_config__: ClassVar = _STRICT
    width: float = 15.0
    length: float = 14.0
    behind_rim: float = 1.575
    lines: bool = True


@dataclass(frozen=True)
class PlaceShape:
    """A place that rules may refer to."""

    __pydantic_config__: ClassVar = _STRICT
    name: str
    at: Point


@dataclass(frozen=True)
class DiagramShape:
    """A tactics diagram."""

    __pydantic_config__: ClassVar = _STRICT
    title: str
    players: list[PlayerShape]
    grammar: str = "basketball"
    ball: str = ""
    court: CourtShape = CourtShape()
    places: list[PlaceShape] = field(default_factory=list)
    elements: list[ElementShape] = field(default_factory=list)


def _check_limits(shape: DiagramShape) -> DiagramShape:
    """Return the diagram of a request; one outside the limits is refused."""
    players, elements, places = shape.players, shape.elements, shape.places
    names = [p.name for p in players] + [p.name for p in places] + [e.player for e in elements]
    names += [name for name in (shape.ball, *(p.guards for p in players)) if name]
    names += [e.other for e in elements if e.other]
    points = [p.at for p in players] + [p.at for p in places]
    points += [at for e in elements for at in e.via]
    points += [e.to for e in elements if e.to is not None]
    size = (shape.court.width, shape.court.length)
    expected = {
        "a title of at most 200 characters without quotes and line breaks": (
            len(shape.title) <= 200 and _TITLE.fullmatch(shape.title)
        ),
        "a grammar's name of at most 60 characters": (
            len(shape.grammar) <= 60 and _GRAMMAR.fullmatch(shape.grammar)
        ),
        "names of letters and digits, at most 60 characters long": (
            all(len(name) <= 60 and _NAME.fullmatch(name) for name in names)
        ),
        f"at most {_MOST} players, elements and places": (
            max(len(players), len(elements), len(places), *(len(e.via) for e in elements)) <= _MOST
        ),
        f"places within {_FARTHEST:g} m": (
            all(abs(value) <= _FARTHEST for point in points for value in point)
        ),
        f"a court of at most {_FARTHEST:g} m": all(0.0 <= metres <= _FARTHEST for metres in size),
        f"steps from 1 to {_LATEST}": (
            all(1 <= e.step <= _LATEST and 0 <= e.caught <= _LATEST for e in elements)
        ),
    }
    for what, holds in expected.items():
        if not holds:
            raise ValueError(f"expected {what}, found another diagram")
    return shape


RequestedDiagram = Annotated[DiagramShape, AfterValidator(_check_limits)]
"""The diagram of a request. Diagrams of answers have no limits: a text may hold any."""


def diagram_of(shape: DiagramShape) -> Diagram:
    """Return the diagram of a request; the rim is added where it is not among the places."""
    rim = () if any(p.name == "rim" for p in shape.places) else (("rim", Spot(0.0, 0.0)),)
    court = Court()
    if not shape.court.lines:
        width, length = shape.court.width, shape.court.length
        court = Court(width, length, behind_rim=length / 2, lines=False)
    elements = tuple(
        Element(
            e.kind,
            e.step,
            e.player,
            e.other,
            tuple(Spot(*at) for at in e.via),
            Spot(*e.to) if e.to else None,
            e.caught,
        )
        for e in shape.elements
    )
    return Diagram(
        shape.title,
        tuple(Player(p.name, p.team, Spot(*p.at), p.guards) for p in shape.players),
        elements,
        shape.grammar,
        court,
        (*rim, *((p.name, Spot(*p.at)) for p in shape.places)),
        shape.ball,
    )


def diagram_shape(diagram: Diagram) -> DiagramShape:
    """Return a diagram for the browser."""
    elements = [
        ElementShape(
            e.kind,
            e.step,
            e.player,
            e.other,
            e.caught,
            [(spot.x, spot.z) for spot in e.via],
            (e.to.x, e.to.z) if e.to else None,
            e.line,
        )
        for e in diagram.elements
    ]
    return DiagramShape(
        diagram.name,
        [
            PlayerShape(p.name, cast("Team", p.team), (p.at.x, p.at.z), p.guards)
            for p in diagram.players
        ],
        diagram.grammar,
        diagram.ball,
        extended(CourtShape, diagram.court),
        [PlaceShape(name, (spot.x, spot.z)) for name, spot in diagram.places],
        elements,
    )
