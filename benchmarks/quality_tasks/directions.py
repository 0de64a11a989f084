"""Directions and sides of limbs, as captions say them and as measured.

Neither took part in making the other: of every action of a caption that names a direction
(``motiondb.meaning.travelled``) or a limb of a side (``motiondb.meaning.limb_sides``), the capture
is measured for that and for the opposite.
"""

from __future__ import annotations

from pathlib import Path

from motiondb.language.vocabulary import split_actions
from motiondb.meaning.limb_sides import (
    limb_speeds,
    limbs_to_measure,
    moves_otherwise,
    speeds_of_limbs,
)
from motiondb.meaning.travelled import directions_to_measure, furthest, speeds_of, turning
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
            for words in _actions(capture):
                turn = turning(words)
                for direction in directions_to_measure(words):
                    said.setdefault(direction, []).append(_goes(capture, direction, turn))
                    if direction in OPPOSITE:
                        away = _goes(capture, OPPOSITE[direction], turn)
                        reverse.setdefault(direction, []).append(away)
                for side, limb in limbs_to_measure(words):
                    said.setdefault(f"{side} {limb}", []).append(_moves(capture, side, limb, words))
                    if side in OPPOSITE:
                        other = _moves(capture, OPPOSITE[side], limb, words)
                        reverse.setdefault(f"{side} {limb}", []).append(other)
        for asked, values in sorted(said.items()):
            against = mean_of(reverse[asked], seed) if asked in reverse else "-"
            rows.append((name, asked, len(values), mean_of(values, seed), against))
    return TaskReport(
        "Directions and sides",
        "Captions that name the direction of an action that travels or turns, or the limb that "
        "moves, against the motion. Captures of several actions may go in both directions.",
        ("captures", "the caption says", "captures", "measured so", "measured the opposite way"),
        tuple(rows),
    )


def _actions(capture: Capture) -> list[tuple[str, ...]]:
    """The different actions of the captions of a capture."""
    actions = [tuple(action) for text in capture.captions for action in split_actions(text)]
    return sorted(set(actions))


def _goes(capture: Capture, direction: str, turn: str) -> float:
    return float(furthest(speeds_of(capture.features), direction, turn)[0] >= 1.0)


def _moves(capture: Capture, side: str, limb: str, words: tuple[str, ...]) -> float:
    return float(
        not moves_otherwise(limb_speeds(speeds_of_limbs(capture.features), limb, words), side)
    )
