"""Schemas of tactics diagrams and scenes. Places are [x, z] in metres."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from motiondb.page.schemas.shared_schemas import Facts, SourceFacts

Spot = tuple[float, float]


class CourtFacts(Facts):
    """The court."""

    width: float
    length: float
    behind_rim: float
    lines: bool


class PlaceFacts(Facts):
    """A named place."""

    name: str
    at: Spot


class PlayerFacts(Facts):
    """A player at the beginning."""

    name: str
    team: str
    at: Spot
    guards: str


class ElementFacts(Facts):
    """An action that is drawn."""

    kind: str
    step: int
    caught: int
    player: str
    other: str
    via: list[Spot]
    to: Spot | None
    line: int


class DiagramFacts(Facts):
    """A tactics diagram."""

    title: str
    grammar: str
    ball: str
    court: CourtFacts
    places: list[PlaceFacts]
    players: list[PlayerFacts]
    elements: list[ElementFacts]


class FaultFacts(Facts):
    """Why a diagram cannot be played."""

    line: int | None
    message: str
    player: str | None


class ElementVerdict(Facts):
    """Whether an element can be played."""

    element: int
    feasible: bool
    reason: str | None


class PlayerVerdict(Facts):
    """What the diagram requires of a player."""

    name: str
    shortest: list[str]
    expression: str
    reason: str | None


class BoardFacts(Facts):
    """A diagram, with its faults and clips."""

    name: str
    shipped: bool
    text: str
    diagram: DiagramFacts | None = Field(description="null: the text is not a diagram.")
    feasible: bool
    fault: str | None
    line: int | None
    faults: list[FaultFacts]
    holder: str | None
    elements: list[ElementVerdict]
    players: list[PlayerVerdict]
    clips: dict[str, int]
    without_clips: list[str]


class BoardRow(Facts):
    """A diagram that can be opened."""

    name: str
    title: str
    shipped: bool


class BoardRows(Facts):
    """The shipped diagrams and the user's."""

    boards: list[BoardRow]


class BoardKinds(Facts):
    """The kinds of elements, the teams, and the grammars of diagrams."""

    kinds: list[str]
    teams: list[str]
    grammars: list[str]


class BoardRemoved(Facts):
    """A diagram that was deleted."""

    removed: str


class SceneRow(Facts):
    """A scene in a list."""

    ref: str
    name: str
    characters: int
    clips: int
    frames: int
    seconds: float
    error: float
    rules: int
    broken: int


class SceneRows(Facts):
    """The scenes of this server and of the database."""

    scenes: list[SceneRow]


class RuleFacts(Facts):
    """A rule of a scene, measured before and after polishing."""

    player: str
    action: str
    clip: int
    rule: str
    about: str
    unit: str
    before: float | None
    after: float | None
    threshold: float | None
    frame: int = Field(description="The frame to look at, 30 a second.")
    start: int | None
    end: int | None
    frames: int | None
    kept: bool


class CollisionFacts(Facts):
    """Players who collide."""

    players: list[str]
    start: int
    end: int
    depth: float


class PaceFacts(Facts):
    """The highest speed of a player, m/s."""

    player: str
    before: float
    after: float


class ImpossibleFacts(Facts):
    """Motion that no person can do."""

    kind: str
    players: list[str]
    action: str
    start: int
    end: int
    frame: int
    value: float
    limit: float
    unit: str


class JumpFacts(Facts):
    """The largest displacement of a planted foot of a player, in metres."""

    player: str
    foot: str = Field(description="left or right; empty if no foot was ever planted.")
    metres: float
    start: int
    end: int
    source_metres: float


class LimbFacts(Facts):
    """The smallest distance between the limbs of two players, in metres."""

    players: list[str]
    metres: float
    frame: int
    n_frames: int


class GuardFacts(Facts):
    """The distance of a guard to the guarded player, in metres."""

    player: str
    target: str
    near: float
    far: float
    n_frames: int
    outside: float
    farthest: float
    frame: int


class TimedAction(Facts):
    """An action of a player in time."""

    terminal: str
    start: float | None
    end: float | None


class ReportFacts(Facts):
    """The report of a scene; scenes of earlier versions lack some of it."""

    scene: str
    settings: dict[str, Any]
    error: float
    characters: int
    clips: int
    frames: int
    seconds: float
    ball: bool
    rules: int
    broken: int
    actions: dict[str, list[str]]
    by_rule: list[RuleFacts]
    collisions: list[CollisionFacts] | None = None
    collisions_before: int | None = None
    feet: dict[str, tuple[float, float]] | None = Field(
        default=None, description="Slip of planted feet, of each player and of the sources, m/s."
    )
    paces: list[PaceFacts] | None = None
    impossible: list[ImpossibleFacts] | None = None
    planted_feet: list[JumpFacts] | None = None
    near_limbs: list[LimbFacts] | None = None
    guards: list[GuardFacts] | None = None
    bone_error: float | None = Field(default=None, description="Metres.")
    ball_gap: float | None = Field(default=None, description="Metres; null without a ball.")
    too_fast: list[str] | None = None
    settled: bool | None = None
    tries: int | None = None
    cut_short: bool | None = None
    cut_at: dict[str, int] | None = None
    sources: list[SourceFacts] | None = None


class SceneFacts(Facts):
    """A scene."""

    ref: str
    name: str
    text: str
    board: DiagramFacts
    report: ReportFacts
    actions: dict[str, list[TimedAction]]
    curve: list[tuple[float, float]]
    took: dict[str, float] = Field(description="Duration of each part of the work, seconds.")


class SceneKept(Facts):
    """The ref of a scene that is kept."""

    ref: str


class SceneRemoved(Facts):
    """A kept scene that was removed, with its captures."""

    removed: str
    captures: list[str]
