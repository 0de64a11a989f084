"""Directions of travel and of turning, as captions say them and as measured.

Neither took part in making the other: of every action of a caption that names a direction
(``motiondb.meaning.travelled``), the capture is measured in that direction and in the opposite one.
"""

from __future__ import annotations

from pathlib import Path

from motiondb.language.vocabulary import split_actions
from motiondb.meaning.travelled import TURNS, directions_to_measure, furthest, speeds_of
from quality_protocol.captures import Capture, load_bandai, load_cmu, without_copies
from quality_protocol.confidence import mean_of
from quality_protocol.report import Measure, TaskReport

OPPOSITE = {"forward": "backward", "backward": "forward", "left": "right", "right": "left"}


def run(data: Path, seed: int) -> TaskReport:
    """Share of captures that go where their captions say, and where these say the opposite."""
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, captures in (("CMU", load_cmu(data)), ("Bandai-Namco", load_bandai(data))):
        said: dict[str, list[float]] = {}
        reverse: dict[str, list[float]] = {}
        for capture in without_copies(captures):
            for direction, turns in sorted(_said(capture)):
                said.setdefault(direction, []).append(_goes(capture, direction, turns))
                if direction in OPPOSITE:
                    away = _goes(capture, OPPOSITE[direction], turns)
                    reverse.setdefault(direction, []).append(away)
        for direction, values in sorted(said.items()):
            against = mean_of(reverse[direction], seed) if direction in reverse else "-"
            rows.append((name, direction, len(values), mean_of(values, seed), against))
    return TaskReport(
        "Directions",
        "Captions that name the direction of an action that travels or turns, against that of the "
        "motion. Captures of several actions may go in both directions.",
        ("captures", "the caption says", "captures", "measured so", "measured the opposite way"),
        tuple(rows),
    )


def _said(capture: Capture) -> set[tuple[str, bool]]:
    """The directions that the captions of a capture name, and whether the action is a turn."""
    actions = [action for text in capture.captions for action in split_actions(text)]
    return {
        (direction, not TURNS.isdisjoint(action))
        for action in actions
        for direction in directions_to_measure(action)
    }


def _goes(capture: Capture, direction: str, turns: bool) -> float:
    return float(furthest(speeds_of(capture.features), direction, turns)[0] >= 1.0)
