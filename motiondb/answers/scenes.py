"""Answers about scenes. Values of rules are in metres, degrees or frames, as their unit says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from motiondb.answers.making import Source
from motiondb.answers.plain import fields_of
from motiondb.scene.report.report_records import (
    Collision,
    GuardReport,
    ImpossibleMotion,
    JumpReport,
    LimbReport,
    PaceReport,
)


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
class SceneAnswer(SceneRow):
    """The report of a scene."""

    settings: dict[str, Any]
    ball: bool
    actions: dict[str, tuple[str, ...]]
    by_rule: tuple[MeasuredRule, ...]
    collisions: tuple[Collision, ...]
    collisions_before: int
    feet: dict[str, tuple[float, float]]  # Slip of planted feet, there and in the sources, m/s
    paces: tuple[PaceReport, ...]
    impossible: tuple[ImpossibleMotion, ...]
    planted_feet: tuple[JumpReport, ...]
    near_limbs: tuple[LimbReport, ...]
    guards: tuple[GuardReport, ...]
    bone_error: float  # Metres
    ball_gap: float | None  # Metres; None without a ball
    too_fast: tuple[str, ...]
    settled: bool
    tries: int
    cut_short: bool
    cut_at: dict[str, int] | None = None
    sources: tuple[Source, ...]


def scene_row(scene: SceneAnswer) -> SceneRow:
    """Return a scene as a row of a list.

    Parameters
    ----------
    scene : SceneAnswer
        What :meth:`Scenes.facts` gives.
    """
    return SceneRow(**fields_of(scene, SceneRow))
