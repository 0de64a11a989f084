"""The report of a scene as text and as facts for JSON.

Values are metres for positions and lines, metres beyond the bounds for distances, degrees for
directions and frames for synchronisations. The threshold of a position, a line or a direction is
the weight of the rule, the deviation that costs 1; that of a synchronisation is two frames; a
distance must be kept. All values are measured on the finished motions
(:mod:`motiondb.scene.report.scene_report`), in the frames in which a rule is evaluated: one, or,
for throughout, those of its own actions and no others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from motiondb import store
from motiondb.answers.making import Source
from motiondb.answers.scenes import MeasuredRule, SceneAnswer
from motiondb.records import MOTION_FPS
from motiondb.scene.report.report_records import (
    Collision,
    GuardReport,
    ImpossibleMotion,
    JumpReport,
    LimbReport,
    PaceReport,
)

_Span = tuple[int, int]


def report_facts(record: store.StoredScene) -> SceneAnswer:
    """Return everything that is known of a scene, for JSON.

    Every rule has the frames [``start``, ``end``) in which it was evaluated and their number
    ``frames``.
    """
    rest: dict[str, Any] = dict(record.report)
    del rest["rule_frames"]
    for key, shape in _PARTS.items():
        rest[key] = tuple(shape(**row) for row in rest[key])
    return SceneAnswer(
        scene=record.name,
        characters=len(record.players),
        clips=sum(len(player.clips) for player in record.players),
        frames=record.n_frames,
        seconds=round(record.n_frames / MOTION_FPS, 3),
        error=record.error,
        rules=len(record.rules),
        broken=sum(not rule.kept for rule in record.rules),
        settings=dict(record.settings),
        ball=bool(len(record.ball)),
        actions={
            player.name: tuple(clip.terminal for clip in player.clips) for player in record.players
        },
        by_rule=tuple(_measured(rule, span) for rule, span in _spans(record)),
        **rest,
    )


_PARTS: dict[str, type] = {
    "collisions": Collision,
    "paces": PaceReport,
    "impossible": ImpossibleMotion,
    "planted_feet": JumpReport,
    "near_limbs": LimbReport,
    "guards": GuardReport,
    "sources": Source,
}  # What the lists of a stored report hold


def _spans(record: store.StoredScene) -> list[tuple[store.SceneRule, _Span]]:
    """Return the rules, each with its first evaluated frame and the one after the last."""
    frames = record.report["rule_frames"]
    return [(rule, (start, end)) for rule, (start, end) in zip(record.rules, frames, strict=True)]


def _measured(rule: store.SceneRule, span: _Span) -> MeasuredRule:
    start, end = span
    return MeasuredRule(
        rule.player,
        rule.action,
        rule.clip,
        rule.kind,
        rule.about,
        rule.unit,
        round(rule.before, 4),
        round(rule.after, 4),
        round(rule.threshold, 4),
        rule.frame,
        start,
        end,
        end - start,
        rule.kept,
    )


def report_text(record: store.StoredScene) -> str:
    """Return the report as lines of text."""
    facts = report_facts(record)
    lines = [
        f"{record.name}: {facts.characters} characters, {facts.clips} clips,"
        f" {record.n_frames} frames ({facts.seconds:.1f} s)",
        f"error -log P(Z) {record.error:.2f} as sampled; seed {record.settings.get('seed')}",
        *cut_short_lines(record),
        "",
    ]
    lines += [f"{name:6} {' '.join(actions)}" for name, actions in facts.actions.items()]
    lines += ["", f"rules kept: {facts.rules - facts.broken} of {facts.rules}", ""]
    lines += _table(
        ["player", "action", "rule", "about", "before", "after", "threshold", "frame", ""],
        [_rule_row(rule, span, record.n_frames) for rule, span in _spans(record)],
    )
    lines += ["", *_contact_lines(record), *impossible_lines(record.report)]
    lines += [*_limb_lines(record), *_guard_lines(record), *_feet_lines(record)]
    lines += ["", *_source_lines(record)]
    return "\n".join(lines)


def cut_short_lines(record: store.StoredScene) -> list[str]:
    """Return a line if a limit of time ended the sampling, else no line."""
    if not record.report.get("cut_short", False):
        return []
    minutes = float(record.settings.get("minutes") or 0.0)
    at = record.report.get("cut_at", {})
    ended = f"; it ended after {at['rounds']} of {at['of']} rounds of try {at['try']}" if at else ""
    return [
        f"sampling was cut short by --minutes {minutes:g}: the seed alone does not determine this "
        f"scene, and more minutes may improve it{ended}"
    ]


def _rule_row(rule: store.SceneRule, span: _Span, n_frames: int) -> list[str]:
    start, end = span
    frames, fault = str(rule.frame), "" if rule.kept else "BROKEN"
    if end - start > 1:
        frames = f"{start}-{end - 1}, {end - start} of {n_frames}"
        fault += f", most at {rule.frame}" * (not rule.kept)
    shown = [
        f"{value:.2f} {rule.unit}".rstrip() for value in (rule.before, rule.after, rule.threshold)
    ]
    action = f"{rule.action} ({rule.clip + 1})"
    return [
        rule.player,
        action,
        rule.kind,
        rule.about,
        *shown,
        frames,
        fault,
    ]


def _contact_lines(record: store.StoredScene) -> list[str]:
    collisions = record.report.get("collisions", [])
    if not collisions:
        return ["collisions: none"]
    return ["collisions:"] + [
        f"  {' and '.join(c['players'])}, frames {c['start']} to {c['end']},"
        f" {c['depth']:.2f} m deep"
        for c in collisions
    ]


_IMPOSSIBLE = {
    "airborne": "both feet in the air for {value:.0f} frames, at most {limit:.0f} are possible",
    "speed": "travels at {value:.1f} m/s, at most {limit:.1f} m/s is possible",
    "step": "feet {value:.2f} m apart, at most {limit:.2f} m is possible",
    "foot jump": "a planted foot jumps by {value:.2f} m, at most {limit:.2f} m is possible",
    "limbs": "limbs pass through each other",
}


def impossible_lines(report: Mapping[str, Any]) -> list[str]:
    """Return the impossible motion of a scene, one line each; none for scenes without this fact."""
    if "impossible" not in report:
        return []
    motions = report["impossible"]
    if not motions:
        return ["impossible motion: none"]
    return ["impossible motion:"] + [
        f"  {' and '.join(m['players'])}{' ' * bool(m['action'])}{m['action']}, {_frames(m)}: "
        + _IMPOSSIBLE[m["kind"]].format(**m)
        for m in motions
    ]


def _frames(facts: Mapping[str, Any]) -> str:
    start, last = facts["start"], facts["end"] - 1
    if start == last:
        return f"frame {start}"
    return f"frames {start} to {last}, most at {facts['frame']}"


def _limb_lines(record: store.StoredScene) -> list[str]:
    pairs = record.report.get("near_limbs", [])
    return ["limbs of two players within 5 cm:"] * bool(pairs) + [
        f"  {' and '.join(p['players'])}, {p['n_frames']} frames,"
        f" nearest {p['metres']:.2f} m at frame {p['frame']}"
        for p in pairs
    ]


def _guard_lines(record: store.StoredScene) -> list[str]:
    guards = record.report.get("guards", [])
    return ["distance of guards over all frames (rules use those of guarding):"] * bool(guards) + [
        f"  {g['player']} from {g['target']}: outside {g['near']:g} to {g['far']:g} m in"
        f" {100 * g['outside']:.0f} % of {record.n_frames} frames (rules use {g['n_frames']}), "
        f"farthest {g['farthest']:.1f} m at frame {g['frame']}"
        for g in guards
    ]


def _feet_lines(record: store.StoredScene) -> list[str]:
    feet = record.report.get("feet", {})
    lines = ["feet on the ground slide (in the captures), m/s:"]
    lines += [f"  {name:6} {slip:.3f} ({there:.3f})" for name, (slip, there) in feet.items()]
    jumps = record.report.get("planted_feet", [])
    lines += ["largest jump of a planted foot within 0.3 s (in the captures), m:"] * bool(jumps)
    lines += [
        f"  {j['player']:6} {j['metres']:.3f} ({j['source_metres']:.3f})"
        + f", {j['foot']} foot, frames {j['start']} to {j['end']}" * bool(j["foot"])
        for j in jumps
    ]
    paces = record.report.get("paces", [])
    lines += ["fastest on the ground, as sampled and after polish, m/s:"] * bool(paces)
    lines += [f"  {p['player']:6} {p['before']:.1f} {p['after']:.1f}" for p in paces]
    gap = record.report.get("ball_gap")
    return lines + ([] if gap is None else [f"ball to palm while held: {gap:.2f} m at most"])


def _source_lines(record: store.StoredScene) -> list[str]:
    lines = ["made from:"]
    for source in record.report.get("sources", []):
        lines.append(
            f"  {source['capture']}, licence {source['licence']}, {source['frames']} frames"
        )
    return lines


def source_list(provenances: Sequence[store.Provenance]) -> list[dict[str, Any]]:
    """Return the captures that a scene's frames come from, each once, with licence and frames."""
    frames: dict[store.SourceCapture, int] = {}
    for one in provenances:
        for number, source in enumerate(one.sources):
            count = int((np.asarray(one.source_numbers) == number).sum())
            frames[source] = frames.get(source, 0) + count
    return [
        {
            "capture": source.name,
            "licence": source.licence or "unknown",
            "sha256": source.sha256,
            "frames": count,
        }
        for source, count in sorted(frames.items(), key=lambda pair: pair[0].name)
        if count
    ]


def _table(columns: list[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a table, with columns as wide as necessary."""
    widths = [max(len(cell) for cell in column) for column in zip(columns, *rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [columns, *rows]
    ]
