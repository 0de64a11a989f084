"""The page docs/measured/start.md and its pictures, from the results of the tasks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from start_tasks.judging import CALIBRATION, WITHHELD

STUDIOS = {"cmu": "CMU", "bandai": "Bandai-Namco"}
WITH, WITHOUT = "with start", "without start"
MEASURES = (
    "words to motion, mAP",
    "motion to words, reciprocal rank",
    "motion to words, F1",
    "nothing matches, balanced accuracy",
)
NOTES = Path(__file__).with_name("notes.md")


def write_page(results: Path, docs: Path) -> None:
    """Write the page and a picture for each direction; tasks without results are left out."""
    results_of = {
        task: json.loads((results / f"{task}.json").read_text(encoding="utf-8"))
        for task in ("cmu", "bandai", "unseen")
        if (results / f"{task}.json").exists()
    }
    parts = [NOTES.read_text(encoding="utf-8").rstrip()]
    if "unseen" in results_of:
        parts.append(_unseen(results_of["unseen"]))
    for task in ("cmu", "bandai"):
        if task in results_of:
            _draw(results_of[task], docs / "pictures" / f"start-{task}.png")
            parts.append(_curves(results_of[task], f"start-{task}.png"))
    (docs / "start.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _unseen(results: dict[str, Any]) -> str:
    lines = [
        "## CMU performers never seen, without captions",
        "",
        "Five folds by performer: knowledge is learned from the captures of four folds. The fifth "
        "fold is a separate database without captions that learns with this knowledge. The target "
        "for the mean average precision of words to motion was .48.",
        "",
        "| words of the start | mAP | motion to words, reciprocal rank | F1 | nothing matches, "
        "balanced accuracy | calibration error of the start's probabilities, not given | "
        "questions |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, row in results["rows"].items():
        values = [_cell(row[m]) for m in (*MEASURES, WITHHELD)]
        lines.append(f"| {name} | {' | '.join(values)} | {row['queries']} |")
    first = next(iter(results["rows"].values()))
    shift = _shift(first["oracle shift"])
    lines += ["", f"The probabilities of the first row, which are not given. {shift}", ""]
    return "\n".join([*lines, *_diagram(first["diagram of the start"])])


def _shift(oracle: list[float]) -> str:
    """What the best constant for all answers would leave of an error."""
    return (
        "The best constant to add, which can be known only from their captions, is "
        f"{oracle[0]:+.2f} nats; with it, the error would be {oracle[1]:.3f}."
    )


def _diagram(bins: list[list[float]]) -> list[str]:
    """A reliability diagram as a table."""
    rows = [
        f"| {low:.1f} to {low + 0.1:.1f} | {mean:.2f} | {right:.2f} | {int(n)} |"
        for low, mean, right, n in bins
    ]
    return ["| said | mean | right | answers |", "|---|---|---|---|", *rows]


def _curves(results: dict[str, Any], picture: str) -> str:
    source, target = STUDIOS[results["source"]], STUDIOS[results["target"]]
    lines = [
        f"## {source} to {target}",
        "",
        f"{results['captures']} captures of {target}; {results['queries']} questions of one word "
        f"over five folds. Symbols: {results['symbols'][WITH]} with initial "
        f"knowledge, {results['symbols'][WITHOUT]} without. Share of motion that the initial "
        f"symbols explain worse than the background model does: {results['strange']:.0%}.",
        "",
        "![Four curves over the number of captions, with initial knowledge and without]"
        f"(pictures/{picture})",
    ]
    for measure in MEASURES:
        lines += ["", f"**{measure}**", "", "| own captions | with start | without | difference |",
                  "|---|---|---|---|"]  # fmt: skip
        for row in results["rows"]:
            cells = [_cell(row[kind][measure]) for kind in (WITH, WITHOUT, "difference")]
            lines.append(f"| {row['captions']} | {' | '.join(cells)} |")
    lines += [
        "",
        f"**{CALIBRATION}**",
        "",
        "Of the probabilities that are given; - where none is.",
        "",
        "| own captions | with start | its answers | without | its answers |",
        "|---|---|---|---|---|",
    ]
    for row in results["rows"]:
        answers = row["answers with a probability"]
        cells = [
            f"{_cell(row[kind][CALIBRATION], alone=True)} | {answers[kind]}"
            for kind in (WITH, WITHOUT)
        ]
        lines.append(f"| {row['captions']} | {' | '.join(cells)} |")
    first = results["rows"][0]
    lines += [
        "",
        "The probabilities without captions of the database, which are not given: calibration "
        f"error {_cell(first[WITH][WITHHELD], alone=True)}. {_shift(first['oracle shift'])}",
        "",
        *_diagram(first["diagram of the start"]),
    ]
    worse = [
        f"{m} with {row['captions']} captions ({_cell(row['difference'][m])})"
        for row in results["rows"] for m in MEASURES
        if row["difference"][m] is not None and row["difference"][m][2] < 0.0
    ]  # fmt: skip
    told = "; ".join(worse) if worse else "nowhere"
    return "\n".join([*lines, "", f"Significantly worse with initial knowledge: {told}."])


def _cell(value: list[float] | None, alone: bool = False) -> str:
    if value is None:
        return "-"
    middle, low, high = value
    return f"{middle:.3f}" if alone or low == high else f"{middle:.3f} ({low:.3f} to {high:.3f})"


def _draw(results: dict[str, Any], path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    rows = results["rows"]
    places = range(len(rows))
    for axes, measure in zip(figure.subplots(2, 2).ravel(), MEASURES):
        for kind, colour in ((WITH, "C0"), (WITHOUT, "C1")):
            values = [row[kind][measure] for row in rows]
            axes.plot(places, [v[0] for v in values], "o-", color=colour, label=kind)
            axes.fill_between(
                places, [v[1] for v in values], [v[2] for v in values], color=colour, alpha=0.2
            )
        alone = rows[0][WITH][measure][0]
        axes.axhline(alone, color="C0", linestyle=":", label="start alone")
        axes.set_xticks(list(places), [str(row["captions"]) for row in rows])
        axes.set_xlabel("own captions")
        axes.set_title(measure, fontsize=10)
        axes.grid(alpha=0.3)
    axes.legend(frameon=False, loc="lower right")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100, metadata={"Software": None})
