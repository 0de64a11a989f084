"""Tactics diagrams as JSON, to and from the browser. Places are [x, z] in metres."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator

from motiondb.answers.plain import extended
from motiondb.scene.language.activity import Activity, Ground, Place
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import DOES, Diagram, Element, Player
from motiondb.scene.language.tactics_file import format_diagram, other_statements

Point = tuple[float, float]
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
    team: str
    at: Point
    guards: str = ""


@dataclass(frozen=True)
class ElementShape:
    """An action of a player; ``line`` is ignored in requests."""

    __pydantic_config__: ClassVar = _STRICT
    kind: str
    step: int
    player: str
    other: str = ""
    caught: int = 0
    via: list[Point] = field(default_factory=list)
    to: Point | None = None
    line: int | None = None
    target: str = ""
    link: str = ""


@dataclass(frozen=True)
class GroundShape:
    """The ground; a request says only its size, and whether it is that of the grammar."""

    __pydantic_config__: ClassVar = _STRICT
    width: float = 20.0
    length: float = 20.0
    left: float = -10.0
    back: float = -10.0
    own: bool = False  # Whether the diagram has another ground than its grammar
    # Lines through points [x, height, z]
    marks: list[list[tuple[float, float, float]]] = field(default_factory=list)


@dataclass(frozen=True)
class PlaceShape:
    """A place that rules may refer to; what is no place of the diagram itself is ``given``."""

    __pydantic_config__: ClassVar = _STRICT
    name: str
    at: Point
    given: bool = False
    height: float = 0.0
    width: float = 0.0
    tall: float = 0.0


@dataclass(frozen=True)
class DiagramShape:
    """A tactics diagram."""

    __pydantic_config__: ClassVar = _STRICT
    title: str
    players: list[PlayerShape]
    grammar: str = "basketball"
    ball: str = ""
    ground: GroundShape = GroundShape()
    places: list[PlaceShape] = field(default_factory=list)
    elements: list[ElementShape] = field(default_factory=list)
    # Other statements of the text, such as what players keep up, as they are written
    more: list[str] = field(default_factory=list)


def _check_limits(shape: DiagramShape) -> DiagramShape:
    """Return the diagram of a request; one outside the limits is refused."""
    players, elements, places = shape.players, shape.elements, shape.places
    names = [p.name for p in players] + [p.name for p in places] + [e.player for e in elements]
    names += [name for name in (shape.ball, *(p.guards for p in players)) if name]
    names += [name for e in elements for name in (e.other, e.target, e.link) if name]
    names += [p.team for p in players] + [e.kind for e in elements]
    points = [p.at for p in players] + [p.at for p in places]
    points += [at for e in elements for at in e.via]
    points += [e.to for e in elements if e.to is not None]
    size = (shape.ground.width, shape.ground.length)
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
        f"a ground of at most {_FARTHEST:g} m": all(0.0 <= metres <= _FARTHEST for metres in size),
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


def text_of(shape: DiagramShape, activity: Activity | None) -> str:
    """Return the text of a request's diagram, by its grammar's ``activity`` (None: unknown)."""
    ground = Ground.field(shape.ground.width, shape.ground.length) if shape.ground.own else None
    elements = tuple(
        extended(
            Element,
            e,
            via=tuple(Spot(*at) for at in e.via),
            to=Spot(*e.to) if e.to else None,
            line=0,
        )
        for e in shape.elements
        if e.kind != DOES
    )
    diagram = Diagram(
        shape.title,
        tuple(Player(p.name, p.team, Spot(*p.at), p.guards) for p in shape.players),
        elements,
        shape.grammar,
        ground,
        tuple((p.name, Spot(*p.at)) for p in shape.places if not p.given),
        shape.ball,
        activity=activity or Activity(),
    )
    more = [line for line in shape.more if "\n" not in line]
    return format_diagram(diagram) + "".join(f"{line}\n" for line in more)


def diagram_shape(diagram: Diagram) -> DiagramShape:
    """Return a diagram for the browser."""
    own = dict(diagram.own_places)
    elements = [
        extended(
            ElementShape,
            e,
            via=[(spot.x, spot.z) for spot in e.via],
            to=(e.to.x, e.to.z) if e.to else None,
        )
        for e in diagram.elements
        if e.kind != DOES
    ]
    return DiagramShape(
        diagram.name,
        [PlayerShape(p.name, p.team, (p.at.x, p.at.z), p.guards) for p in diagram.players],
        diagram.grammar,
        diagram.ball,
        ground_shape(diagram.court, diagram.ground is not None),
        [_place(name, spot, name not in own, diagram) for name, spot in diagram.places],
        elements,
        other_statements(diagram),
    )


def ground_shape(ground: Ground, own: bool = False) -> GroundShape:
    """Return a ground for the browser; ``own``: a diagram's."""
    return extended(GroundShape, ground, own=own, marks=[list(mark) for mark in ground.marks])


def _place(name: str, spot: Spot, given: bool, diagram: Diagram) -> PlaceShape:
    known = diagram.activity.place.get(name, Place(name))
    return extended(PlaceShape, known, at=(spot.x, spot.z), given=given)
