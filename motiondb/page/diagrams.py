"""Tactics diagrams as JSON, to and from the browser. Places are [x, z] in metres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import Field

from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import KINDS, Court, Diagram, Element, Player

Metres = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]
Size = Annotated[float, Field(ge=0.0, le=1000.0, allow_inf_nan=False)]
Point = tuple[Metres, Metres]
PlayerName = Annotated[str, Field(pattern=r"^[^\W\d]\w*$", max_length=60)]
OtherName = Annotated[str, Field(pattern=r"^([^\W\d]\w*)?$", max_length=60)]
Team = Literal["attack", "defence", "player"]
MOST = 200  # Largest number of players, elements or places
_STRICT: dict[str, Any] = {"extra": "forbid"}  # Unknown keys of a request are refused


@dataclass(frozen=True)
class PlayerShape:
    """A player at the beginning of the play."""

    __pydantic_config__: ClassVar = _STRICT
    name: PlayerName
    team: Team
    at: Point
    guards: OtherName = ""


@dataclass(frozen=True)
class ElementShape:
    """An action of a player; ``line`` is ignored in requests."""

    __pydantic_config__: ClassVar = _STRICT
    kind: Literal[KINDS]  # type: ignore[valid-type]  # a tuple of literals
    step: Annotated[int, Field(ge=1, le=10_000)]
    player: PlayerName
    other: OtherName = ""
    caught: Annotated[int, Field(ge=0, le=10_000)] = 0
    via: Annotated[list[Point], Field(max_length=MOST)] = field(default_factory=list)
    to: Point | None = None
    line: int | None = None


@dataclass(frozen=True)
class CourtShape:
    """The court; ``behind_rim`` follows from the other values and is ignored in requests."""

    __pydantic_config__: ClassVar = _STRICT
    width: Size = 15.0
    length: Size = 14.0
    behind_rim: float = 1.575
    lines: bool = True


@dataclass(frozen=True)
class PlaceShape:
    """A place that rules may refer to."""

    __pydantic_config__: ClassVar = _STRICT
    name: PlayerName
    at: Point


@dataclass(frozen=True)
class DiagramShape:
    """A tactics diagram."""

    __pydantic_config__: ClassVar = _STRICT
    title: Annotated[str, Field(pattern=r'^[^"\n\r]*$', max_length=200)]
    players: Annotated[list[PlayerShape], Field(max_length=MOST)]
    grammar: Annotated[str, Field(pattern=r"^[^\W\d]\w*(-\w+)*$", max_length=60)] = "basketball"
    ball: OtherName = ""
    court: CourtShape = CourtShape()
    places: Annotated[list[PlaceShape], Field(max_length=MOST)] = field(default_factory=list)
    elements: Annotated[list[ElementShape], Field(max_length=MOST)] = field(default_factory=list)


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
        CourtShape(**vars(diagram.court)),
        [PlaceShape(name, (spot.x, spot.z)) for name, spot in diagram.places],
        elements,
    )
