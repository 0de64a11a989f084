"""What a run on the real captures found, handed to the report."""

from __future__ import annotations

from dataclasses import dataclass

from measured_run import MeasuredRun

from motiondb.records import Match
from real_tasks.answers import ExampleResult, MadeResult, WordResult
from real_tasks.measures import Part, Smoothness, WordPrecision
from real_tasks.notes import Notes


@dataclass(frozen=True)
class Stages:
    """What ``add`` and ``learn`` did; None if an existing database was used."""

    add: MeasuredRun | None
    learn: MeasuredRun | None


@dataclass(frozen=True)
class Findings:
    """Everything the report says."""

    stages: Stages
    counts: dict[str, float]
    problems: list[str]
    known: list[str]
    relations: list[str]
    words: list[WordResult]
    precision: dict[str, WordPrecision]
    parts: list[tuple[str, Match, float, Part | None]]
    examples: list[ExampleResult]
    made: list[MadeResult]
    captured: list[Smoothness]
    notes: dict[str, Notes]
    seconds: float
