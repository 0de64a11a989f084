"""Tactics diagrams as JSON, and what can be checked before a scene is made."""

from __future__ import annotations

from typing import Any

from motiondb.database import MotionDB
from motiondb.database.scenes.scene_texts import Board, count_clips, element_faults
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import Diagram


def diagram_facts(diagram: Diagram) -> dict[str, Any]:
    """Return a diagram; places are [x, z] in metres."""
    court = diagram.court
    return {
        "title": diagram.name,
        "grammar": diagram.grammar,
        "ball": diagram.ball,
        "court": {
            "width": court.width,
            "length": court.length,
            "behind_rim": court.behind_rim,
            "lines": court.lines,
        },
        "places": [{"name": name, "at": _at(spot)} for name, spot in diagram.places],
        "players": [
            {"name": p.name, "team": p.team, "at": _at(p.at), "guards": p.guards}
            for p in diagram.players
        ],
        "elements": [
            {
                "kind": e.kind,
                "step": e.step,
                "caught": e.caught,
                "player": e.player,
                "other": e.other,
                "via": [_at(spot) for spot in e.via],
                "to": _at(e.to) if e.to else None,
                "line": e.line,
            }
            for e in diagram.elements
        ],
    }


def _at(spot: Spot) -> list[float]:
    return [spot.x, spot.z]


def board_facts(db: MotionDB, board: Board, name: str, shipped: bool) -> dict[str, Any]:
    """Return a diagram with its faults, shortest strings of actions, and number of clips."""
    clips = {}
    if board.grammar is not None and board.actions:
        clips = count_clips(db.scenes.find_actions(board.grammar), board.actions)
    reasons = element_faults(board)
    about = {fault.player: fault.message for fault in board.faults if fault.player}
    players = board.diagram.players if board.diagram else ()
    by_line = {fault.line: fault.message for fault in board.faults}
    return {
        "name": name,
        "shipped": shipped,
        "text": board.text,
        "diagram": diagram_facts(board.diagram) if board.diagram else None,
        "feasible": not board.faults,
        "fault": "\n".join(fault.message for fault in board.faults) or None,
        "line": next((fault.line for fault in board.faults if fault.line), None),
        "faults": [
            {"line": f.line or None, "message": f.message, "player": f.player or None}
            for f in board.faults
        ],
        "holder": board.holder,
        "elements": [
            {"element": number, "feasible": not reason, "reason": reason or None}
            for number, reason in enumerate(reasons)
        ],
        "players": [
            {
                "name": player.name,
                "shortest": list(board.strings.get(player.name, ())),
                "expression": board.expressions.get(player.name, ""),
                "reason": about.get(player.name) or by_line.get(player.line),
            }
            for player in players
        ],
        "clips": clips,
        "without_clips": [action for action, count in clips.items() if not count],
    }
