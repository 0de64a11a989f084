"""The report of a task of the quality benchmark, and its form in Markdown.

A task is a module ``quality_tasks/NAME.py`` with ``run(data: Path, seed: int) -> TaskReport``.
Reports become sections of ``docs/measured/quality.md``; a section is between two marks, so that one
task can be run again without the others.
"""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Measure:
    """A figure with its 95 % interval; ``low`` None: no interval (a count, a time)."""

    value: float
    low: float | None = None
    high: float | None = None
    digits: int = 3

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return _number(self.value, self.digits)
        bounds = f"{_number(self.low, self.digits)} to {_number(self.high, self.digits)}"
        return f"{_number(self.value, self.digits)} ({bounds})"


@dataclass(frozen=True)
class Picture:
    """A picture below ``docs/pictures``: name such as ``quality-words.png``, caption, PNG bytes."""

    name: str
    caption: str
    png: bytes


@dataclass(frozen=True)
class TaskReport:
    """One table of results.

    Attributes
    ----------
    title : heading of the section.
    protocol : training data, questions and measures, in a sentence or two.
    columns : headings, the first one for the methods.
    rows : one tuple per method, as long as ``columns``: text, numbers or :class:`Measure`.
    notes : paragraphs below the table (Markdown).
    pictures : drawn below the notes.
    parts : further tables of the same task, a heading lower.
    """

    title: str
    protocol: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str | float | Measure, ...], ...]
    notes: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    parts: tuple[TaskReport, ...] = ()


def draw(figure: Figure, name: str, caption: str) -> Picture:
    """A matplotlib figure as a :class:`Picture`."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100, metadata={"Software": None})
    return Picture(name, caption, buffer.getvalue())


def to_markdown(report: TaskReport, level: int = 2) -> str:
    """The section of a report.

    >>> print(to_markdown(TaskReport("T", "P.", ("method", "x"), (("a", Measure(0.5, 0.4, 0.6)),))))
    ## T
    <BLANKLINE>
    P.
    <BLANKLINE>
    | method | x |
    | --- | --- |
    | a | .500 (.400 to .600) |
    <BLANKLINE>
    """
    lines = [f"{'#' * level} {report.title}", "", report.protocol, ""]
    lines += [_row(report.columns), _row(["---"] * len(report.columns))]
    lines += [_row([_cell(value) for value in row]) for row in report.rows] + [""]
    for note in report.notes:
        lines += [note, ""]
    for picture in report.pictures:
        lines += [f"![{picture.caption}](pictures/{picture.name})", ""]
    return "\n".join(lines + [to_markdown(part, level + 1) for part in report.parts])


def pictures_of(report: TaskReport) -> list[Picture]:
    """The pictures of a report and its parts."""
    return [*report.pictures, *(p for part in report.parts for p in pictures_of(part))]


def write_section(path: Path, name: str, text: str, head: str) -> None:
    """Put a task's section in place of its former one, or at the end; ``head`` opens the file."""
    old = path.read_text(encoding="utf-8") if path.exists() else ""
    sections = dict(re.findall(r"<!-- task (\S+) -->\n(.*?)<!-- end -->\n", old, flags=re.DOTALL))
    sections[name] = text if text.endswith("\n") else text + "\n"
    body = "\n".join(f"<!-- task {n} -->\n{t}<!-- end -->\n" for n, t in sections.items())
    path.write_text(f"{head.rstrip()}\n\n{body}", encoding="utf-8")


def _row(cells: tuple[str, ...] | list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(value: str | float | Measure) -> str:
    return _number(value, 3) if isinstance(value, float) else str(value)


def _number(value: float, digits: int) -> str:
    """Three digits, without the zero before the point; large numbers with fewer digits."""
    if value != value:
        return "-"
    if abs(value) >= 10:
        return f"{value:.{max(digits - 2, 0)}f}" if abs(value) < 1000 else f"{value:.0f}"
    return f"{value:.{digits}f}".replace("0.", ".", 1) if abs(value) < 1 else f"{value:.{digits}f}"
