"""Where the answers go wrong, with pictures: the words that fail, and the changes that are missed.

Words: the captures that the section ``words`` of ``docs/measured/quality.md`` names for each word
that fails
(the first answers and the true captures, for unseen performers) are drawn as strips of stick
figures, two of each. Changes: the true and the found activities of the four long takes, as
timelines. The causes are what a person saw in these pictures, kept in ``errors_notes.md``.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread

from motiondb.body.features import FEATURE_FPS
from motiondb.pictures.strip import strip_figure
from motiondb.records import FloatArray
from motiondb.symbols import activities
from quality_protocol.captures import Capture, load_cmu
from quality_protocol.report import TaskReport, draw
from quality_protocol.takes import LongTake, load_takes
from real_tasks.notes import Notes, read_notes

PAGE = Path(__file__).parents[2] / "docs" / "measured" / "quality.md"
NOTES = Path(__file__).with_name("errors_notes.md")
N_DRAWN = 2
"""Captures drawn for each kind of failure."""
_FAILED = re.compile(
    r"^- \*\*(?P<word>[^*]+)\*\*, (?P<ap>[\d.]+), fold (?P<fold>\d+): first (?P<first>.*?)\. "
    r"True: (?P<true>.*)\.$",
    re.MULTILINE,
)
_CAPTURE = re.compile(r"(\S+/\S+) \(")


@dataclass(frozen=True)
class Failure:
    """A word, its average precision in a fold, the first answers and the true captures."""

    word: str
    average_precision: float
    fold: int
    first: tuple[str, ...]
    true: tuple[str, ...]


def run(data: Path, seed: int) -> TaskReport:
    """The failures of the page, drawn; the changes of the long takes."""
    captures = {c.name: c for c in load_cmu(data)}
    failures = read_failures(PAGE.read_text(encoding="utf-8"))
    notes = read_notes(NOTES)
    rows = tuple(
        (f.word, str(f.fold), f.average_precision, _cause(notes, f.word)) for f in failures
    )
    takes = load_takes(data, list(captures.values()))
    parts = (*(_show(f, captures, notes) for f in failures), _show_changes(takes, notes, seed))
    return TaskReport(
        "Causes of errors",
        "Words that fail although several captures show them (section *Words to motion*), for "
        "unseen performers: the first answers, the true captures, and the cause as seen in the "
        "pictures. Possible causes are a bad caption, too few examples, segmentation, or "
        "confusion of symbols.",
        ("word", "fold", "average precision", "cause"),
        rows,
        (notes["summary"].prose,) if "summary" in notes else (),
        (),
        parts,
    )


def read_failures(page: str) -> list[Failure]:
    """The failing words of a page, each once, the worst fold of it.

    >>> page = "- **turn**, 0.06, fold 4: first 1/1_02 (a); 1/1_03 (b). True: 2/2_01 (c)."
    >>> read_failures(page)[0].first
    ('1/1_02', '1/1_03')
    """
    failures: dict[str, Failure] = {}
    for match in _FAILED.finditer(page):
        first, true = (tuple(_CAPTURE.findall(match[key])) for key in ("first", "true"))
        failure = Failure(match["word"], float(match["ap"]), int(match["fold"]), first, true)
        failures.setdefault(failure.word, failure)
    return list(failures.values())


def _cause(notes: dict[str, Notes], word: str) -> str:
    """The first sentence of a word's note."""
    prose = notes[f"word: {word}"].prose if f"word: {word}" in notes else "not looked at yet."
    return prose.replace("\n", " ").split(". ")[0].rstrip(".") + "."


def _show(failure: Failure, captures: dict[str, Capture], notes: dict[str, Notes]) -> TaskReport:
    key = f"word: {failure.word}"
    drawn = [
        _strip(captures[name], f"{what}: {name}")
        for what, names in (("stood first", failure.first), ("true", failure.true))
        for name in names[:N_DRAWN]
        if name in captures
    ]
    name = f"errors-{failure.word.replace(' ', '-')}.png"
    picture = draw(_stack(drawn), name, f"{failure.word}: the first answers and the true captures")
    rows = tuple(
        (what, name, "; ".join(captures[name].captions))
        for what, names in (("first", failure.first), ("true", failure.true))
        for name in names
        if name in captures
    )
    return TaskReport(
        f"{failure.word}, fold {failure.fold}",
        notes[key].prose if key in notes else "Not looked at yet.",
        ("", "capture", "what is written of it"), rows, (), (picture,),
    )  # fmt: skip


def _strip(capture: Capture, title: str) -> FloatArray:
    """A capture's strip as an image, array (rows, columns, 4)."""
    said = capture.captions[0] if capture.captions else "nothing written"
    figure = strip_figure(capture.motion, f"{title} ({said})")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=72)
    buffer.seek(0)
    return np.asarray(imread(buffer), dtype=np.float64)


def _stack(images: Sequence[FloatArray]) -> Figure:
    """Images one below another."""
    width = max(image.shape[1] for image in images)
    rows = [
        np.pad(i, ((0, 0), (0, width - i.shape[1]), (0, 0)), constant_values=1.0) for i in images
    ]
    whole = np.concatenate(rows)
    figure = Figure(figsize=(whole.shape[1] / 100.0, whole.shape[0] / 100.0), facecolor="white")
    figure.figimage(whole)
    return figure


def _show_changes(takes: Sequence[LongTake], notes: dict[str, Notes], seed: int) -> TaskReport:
    figure = Figure(figsize=(10.0, 1.5 * len(takes)), facecolor="white", layout="constrained")
    for axes, take in zip(figure.subplots(len(takes), 1), takes):
        truth = [(a, b, label) for a, b, label in take.parts]
        features = take.capture.features
        n_true = int(take.labels.max()) + 1
        lanes = [truth]
        for number in (None, n_true):
            activities_found = activities.find_activities(
                features, np.random.default_rng(seed), number
            )
            lanes.append(
                [(a / FEATURE_FPS, b / FEATURE_FPS, str(k)) for a, b, k in activities_found]
            )
        _draw_lanes(axes, lanes, take.capture.name)
    return TaskReport(
        "Changes of activity in the long takes",
        notes["changes"].prose if "changes" in notes else "Not looked at yet.",
        ("take", "true changes, s"),
        tuple((take.capture.name, _times(take.parts)) for take in takes),
        (),
        (draw(figure, "errors-changes.png", "True and found activities of the four takes"),),
    )  # fmt: skip


def _draw_lanes(
    axes: Axes, lanes: Sequence[Sequence[tuple[float, float, str]]], title: str
) -> None:
    from matplotlib import colormaps

    colours = colormaps["tab10"]
    for lane, parts in enumerate(lanes):
        number: dict[str, int] = {}
        for start, end, label in parts:
            colour = colours(number.setdefault(label, len(number)) % 10)
            axes.barh(-lane, end - start, left=start, color=colour, edgecolor="white", height=0.8)
            axes.text((start + end) / 2, -lane, label, ha="center", va="center", fontsize=6)
    for start, _, _ in lanes[0][1:]:
        axes.axvline(start, color="black", linewidth=0.6)
    axes.set_yticks([0, -1, -2], ["true", "own number", "true number"], fontsize=7)
    axes.set_title(title, fontsize=8, loc="left")
    axes.set_xlim(0.0, lanes[0][-1][1])
    axes.tick_params(axis="x", labelsize=6)


def _times(parts: Sequence[tuple[float, float, str]]) -> str:
    return ", ".join(f"{start:.1f}" for start, _, _ in parts[1:])
