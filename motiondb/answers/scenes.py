"""Answers about scenes. Values of rules are in metres, degrees or frames, as their unit says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from motiondb.answers.making import Source
from motiondb.answers.plain import OPTIONAL, extended
from motiondb.scene.report import report_records


@dataclass(frozen=True)
class MeasuredRule:
    """A rule of a scene, measured before and after polishing in frames [start, end)."""

    player: str
    action: str
    clip: int
    rule: str
    about: str
    unit: str
    before: float | None
    after: float | None
    threshold: float | None
    frame: int  # The frame where it fails most, 30 a second
    start: int
    end: int
    frames: int
    kept: bool


@dataclass(frozen=True, kw_only=True)
class SceneMade:
    """A scene that was made or updated."""

    kind: Literal["scene"] = "scene"
    scene: str
    ref: str


@dataclass(frozen=True)
class SceneRow:
    """A scene in a list."""

    scene: str
    characters: int
    clips: int
    frames: int
    seconds: float
    error: float  # -log P of the sampled scene
    rules: int
    broken: int


@dataclass(frozen=True, kw_only=True)
class SceneDetails:
    """What was measured on a scene beside its rules, and how it was made."""

    collisions: tuple[report_records.Collision, ...]
    collisions_before: int
    feet: dict[str, tuple[float, float]]  # Slip of planted feet, there and in the sources, m/s
    paces: tuple[report_records.PaceReport, ...]
    impossible: tuple[report_records.ImpossibleMotion, ...]
    planted_feet: tuple[report_records.JumpReport, ...]
    near_limbs: tuple[report_records.LimbReport, ...]
    guards: tuple[report_records.GuardReport, ...]
    seen: tuple[
        report_records.SeenFault, ...
    ] = ()  # What a viewer sees at once although no rule is about it
    bone_error: float  # Metres
    ball_gap: float | None  # Metres; None without a ball
    too_fast: tuple[str, ...]
    settled: bool
    tries: int
    cut_short: bool
    cut_at: dict[str, int] | None = None
    sources: tuple[Source, ...]


@dataclass(frozen=True, kw_only=True)
class SceneAnswer(SceneDetails, SceneRow):
    """The report of a scene."""

    settings: dict[str, Any]
    ball: bool
    actions: dict[str, tuple[str, ...]]
    by_rule: tuple[MeasuredRule, ...]


def scene_row(scene: SceneAnswer) -> SceneRow:
    """Return a scene as a row of a list.

    Parameters
    ----------
    scene : SceneAnswer
        What :meth:`Scenes.facts` gives.
    """
    return extended(SceneRow, scene)


@dataclass(frozen=True)
class StartSymbol:
    """Properties of the strings of one start symbol of a motion grammar."""

    symbol: str
    team: str
    can_be_empty: bool
    strings: int  # Number of its most probable strings whose trees were counted
    ambiguous: str  # The first of these with several trees, "" if each has one
    trees: int | None  # Number of its trees; None if there are endlessly many


@dataclass(frozen=True)
class CheckedGrammar:
    """Properties of a motion grammar; with the number of clips of each action of a database."""

    name: str
    nonterminals: tuple[str, ...]
    terminals: tuple[str, ...]
    rules: tuple[str, ...]
    semantic_rules: int
    useless: tuple[str, ...]
    nullable: tuple[str, ...]
    starts: list[StartSymbol]
    verbs: tuple[str, ...]  # What a diagram of it may draw
    clips: dict[str, int] | None = field(default=None, metadata=OPTIONAL)
    # Words of captions that are nearest to those of each terminal without clips
    nearest: dict[str, tuple[str, ...]] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class ValidatedActions:
    """Whether a motion grammar allows some actions: their tree, or where they fail."""

    allowed: bool
    start: str
    tree: str | list[Any] | None
    trees: int | None  # Their number; None for endlessly many
    position: int | None
    expected: tuple[str, ...]
    message: str
    clips: dict[str, int] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class NextAction:
    """An action that may come next."""

    action: str
    probability: float


@dataclass(frozen=True)
class NextActions:
    """The actions that may come next, and the probability of the end."""

    next: list[NextAction]
    end: float
    clips: dict[str, int] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class ActionString:
    """A string of actions that reaches some goals."""

    string: tuple[str, ...]
    clips: dict[str, int] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class DiagramPlayer:
    """What a diagram requires of a player."""

    name: str
    team: str
    expression: str
    shortest: tuple[str, ...]
    opponent: str | None


@dataclass(frozen=True)
class DrawnDiagram:
    """A tactics diagram that was drawn."""

    diagram: str
    grammar: str
    file: str
    ball: str  # The player who has the ball at first
    players: list[DiagramPlayer]
    clips: dict[str, int] | None = field(default=None, metadata=OPTIONAL)
