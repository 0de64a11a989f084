"""The answer about a gait: events, cycles, measures and angles of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from motiondb.answers.plain import OPTIONAL
from motiondb.body.gait import FootEvent, FootPrint, GaitCycle, GaitMeasure, JointAngles
from motiondb.tabled import Tabled


@dataclass(frozen=True, repr=False)
class GaitReport(Tabled):
    """How somebody walks or runs; seconds from the start of the motion, metres."""

    name: str
    seconds: float
    fps: float  # Of the capture, at which the events were found
    events: tuple[FootEvent, ...]
    cycles: tuple[GaitCycle, ...]
    measures: tuple[GaitMeasure, ...]
    angles: tuple[JointAngles, ...]
    prints: tuple[FootPrint, ...]
    treadmill: float  # Its speed, metres a second; 0 without one
    notes: tuple[str, ...] = ()
    png: Path | None = field(default=None, metadata=OPTIONAL)

    def _rows(self) -> tuple[str, Sequence[Mapping[str, object]]]:
        title = f"{self.name}: {len(self.cycles)} cycles, {len(self.events)} events of the feet"
        return title, [vars(each) for each in self.measures]
