"""The page of measurements of scenes, from the result files of :mod:`scenes`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import mean
from typing import Any

TITLES = {
    "pass-and-shoot": "Pass and Shoot",
    "screen": "Screen",
    "backdoor": "Backdoor",
    "give-and-go": "Give and Go",
    "double-team": "Double Team",
    "passing-drills": "Passing Drills",
    "weave-pass": "Weave Pass",
    "figure-3": "Figure 3",
}
PAPER = {
    "pass-and-shoot": (4, 33, 179, 242),
    "screen": (5, 18, 132, 243),
    "backdoor": (4, 20, 136, 177),
    "give-and-go": (6, 36, 158, 354),
    "double-team": (4, 22, 170, 269),
    "passing-drills": (3, 34, 235, 588),
    "weave-pass": (3, 26, 245, 522),
}
"""Table 2: characters, instances, frames, seconds of both loops."""

Rows = list[dict[str, Any]]


def load(out: Path, part: str) -> Rows:
    """All results of a part."""
    return [json.loads(path.read_text()) for path in sorted(out.glob(f"{part}-*.json"))]


def page(out: Path) -> str:
    """The whole page."""
    parts: list[tuple[str, Callable[[Rows], list[str]]]] = [
        ("table", table_part),
        ("baseline", lambda rows: baseline_part(rows, load(out, "table"))),
        ("update", update_part),
    ]
    lines = ["# Scenes, measured", "", *_head()]
    for part, told in parts:
        rows = load(out, part)
        if rows:
            lines += ["", *told(rows)]
    return "\n".join(lines)


def _head() -> list[str]:
    return [
        "Are the rules of the shipped diagrams kept, and how long does a scene take? Measured "
        "by `benchmarks/scenes.py` on the sample data; its docstring has the commands. Terms "
        "are explained in the [guide](../guide/scenes.md). Times are those of the clock on two "
        "processors; other work makes them longer. The processor seconds of both threads beside "
        "them are hardly affected by it."
    ]


def grouped(rows: Rows) -> Iterable[tuple[str, Rows]]:
    """The rows of each diagram, in the order of the paper."""
    for diagram in TITLES:
        chosen = [row for row in rows if row["diagram"] == diagram]
        if chosen:
            yield diagram, chosen


def _listed(title: str, name: str, rows: Rows) -> list[str]:
    """What is wrong in each scene, under a title; nothing where nothing is."""
    told = [
        f"- {TITLES[row['diagram']]}, seed {row['seed']}: {'; '.join(row[name])}"
        for row in rows
        if row[name]
    ]
    return ["", title, "", *told, ""] if told else []


def _span(values: list[float], digits: int = 0) -> str:
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def table_part(rows: Rows) -> list[str]:
    """Table 2 compared with our results, and the deviations from the rules."""
    lines = [
        "## Every diagram from scratch",
        "",
        "Compared with Table 2 of the paper, where it has the diagram (its seconds are those of the"
        " outer and the inner loop on 8 cores). Ranges are over our seeds.",
        "",
        "| diagram | characters | clips, paper | clips | frames, paper | frames | seconds, paper |"
        " seconds | processor s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for diagram, group in grouped(rows):
        paper = PAPER.get(diagram, ("", "", "", ""))
        lines.append(
            f"| {TITLES[diagram]} | {group[0]['characters']} | {paper[1]} |"
            f" {_span([r['clips'] for r in group])} | {paper[2]} |"
            f" {_span([r['frames'] for r in group])} | {paper[3]} |"
            f" {_span([r['seconds'] for r in group], 1)} |"
            f" {_span([r['processor'] for r in group], 1)} |"
        )
    lines += [
        "",
        "There are 30 frames a second. The next table counts broken rules over all seeds. A rule"
        " is broken if it is off by more than its weight (direction 20 degrees, position and line"
        " 0.3 m; points on the path 1 m), a synchronisation if it is off by more than two frames, a"
        " distance if it is outside its bounds in any frame. Impossible motion is what the report"
        " of a scene says a viewer sees: both feet in the air, steps, speed or jumps of planted"
        " feet beyond those of the captures, limbs that cross.",
        "",
        "| diagram | seeds | rules a scene | broken before polish | broken | worst synchronisation,"
        " frames | collisions before | collisions | impossible motion | fastest, m/s | error |"
        " begun again |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for diagram, group in grouped(rows):
        lines.append(
            f"| {TITLES[diagram]} | {len(group)} | {_span([r['rules'] for r in group])} |"
            f" {sum(r['broken before'] for r in group)} | {sum(len(r['broken']) for r in group)} |"
            f" {max(r['synchronisation'] for r in group):.2f} |"
            f" {sum(r['collisions before'] for r in group)} |"
            f" {sum(r['collisions'] for r in group)} |"
            f" {sum(len(r['impossible']) for r in group)} | {max(r['pace'] for r in group):.1f} |"
            f" {_span([r['error'] for r in group], 1)} |"
            f" {sum(r['tries'] - 1 for r in group)} |"
        )
    lines += _listed("Broken rules:", "broken", rows)
    lines += ["", *_listed("Impossible motion:", "impossible", rows)]
    slips = mean(row["feet"] for row in rows)
    there = mean(row["feet of captures"] for row in rows)
    gap = max(row["ball gap"] for row in rows)
    lines.append(
        f"Feet on the ground slide by {slips:.3f} m/s on average, in their captures by"
        f" {there:.3f} m/s. The middle of a held ball is at most {gap:.2f} m from a palm."
    )
    return lines


def baseline_part(rows: Rows, ours: Rows) -> list[str]:
    """The paper's own procedure at ten times our time."""
    lines = [
        "## Compared with the paper's procedure",
        "",
        "The paper's procedure is one chain at T = 1: clips are drawn by their errors, subtrees are"
        " drawn again until P(X') > 0, and everything is evaluated from scratch at every step"
        " (`benchmarks/scene_tasks/paper_baseline.py`). The"
        " error is the lowest -log P(Z) reached before polish; ours is that of the same seed.",
        "",
        "| diagram | seed | processor s, paper's way | its error | our processor s | our error |",
        "|---|---|---|---|---|---|",
    ]
    mine = {(row["diagram"], row["seed"]): row for row in ours}
    for diagram, group in grouped(rows):
        for row in group:
            our_row = mine.get((diagram, row["seed"]))
            told = f"{our_row['processor']:.1f} | {our_row['error']:.1f}" if our_row else " | "
            lines.append(
                f"| {TITLES[diagram]} | {row['seed']} | {row['seconds']:.0f} | {row['error']:.1f} |"
                f" {told} |"
            )
    return lines


def update_part(rows: Rows) -> list[str]:
    """Warm starts."""
    lines = [
        "## Update after a small change",
        "",
        "The circle of the first attacker is moved by half a metre, and sampling continues from the"
        " earlier scene. Times are seconds of sampling and polishing together.",
        "",
        "| diagram | seeds | from scratch, s | changed, s | sampling, s | polishing, s | times"
        " faster | broken | collisions |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for diagram, group in grouped(rows):
        nothing, warm = (mean(r[k] for r in group) for k in ("from nothing", "seconds"))
        lines.append(
            f"| {TITLES[diagram]} | {len(group)} | {nothing:.1f} | {warm:.2f} |"
            f" {mean(r['parts']['sampling'] for r in group):.2f} |"
            f" {mean(r['parts']['polishing'] for r in group):.2f} | {nothing / warm:.0f} |"
            f" {sum(r['broken'] for r in group)} | {sum(r['collisions'] for r in group)} |"
        )
    return lines
