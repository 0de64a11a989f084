"""Timelines: labelled intervals of time as bars, in lanes where they overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from motiondb.pictures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Span = tuple[float, float, str, int | str]
"""(start, end, label, colour key), seconds; equal keys have equal colours."""


@dataclass(frozen=True)
class Timeline:
    """A named row of intervals, such as the symbols or the words of a capture."""

    name: str
    spans: Sequence[Span]


def lanes(spans: Sequence[Span]) -> tuple[int, ...]:
    """Lane, from 0, of every interval, so that no two in a lane overlap.

    >>> lanes([(0.0, 2.0, "a", 0), (1.0, 3.0, "b", 1), (2.0, 4.0, "c", 2)])
    (0, 1, 0)
    """
    free_from: list[float] = []
    assigned = [0] * len(spans)
    for number in sorted(range(len(spans)), key=lambda n: spans[n][:2]):
        start, end = spans[number][:2]
        lane = next((k for k, t in enumerate(free_from) if t <= start + 1e-9), len(free_from))
        if lane == len(free_from):
            free_from.append(end)
        free_from[lane] = end
        assigned[number] = lane
    return tuple(assigned)


def n_lanes(timeline: Timeline) -> int:
    """Number of lanes of a timeline, at least 1."""
    return max(lanes(timeline.spans), default=0) + 1


def cut_timeline(timeline: Timeline, start: float, end: float) -> Timeline:
    """Part of a timeline between two times.

    >>> cut_timeline(Timeline("words", [(0.0, 2.0, "a", 0), (2.0, 3.0, "b", 1)]), 1.5, 2.0).spans
    [(1.5, 2.0, 'a', 0)]
    """
    parts = [(max(a, start), min(b, end), label, key) for a, b, label, key in timeline.spans]
    return Timeline(timeline.name, [part for part in parts if part[1] > part[0]])


def fit_label(label: str, width: float, letter: float) -> str:
    """Shorten a label to a width; empty if it does not fit.

    >>> fit_label("cartwheel", 5.0, 1.0), fit_label("jump", 5.0, 1.0), fit_label("17", 1.5, 1.0)
    ('cart…', 'jump', '')
    """
    room = int(width / letter)
    if len(label) <= room:
        return label
    return label[: room - 1] + "…" if room >= 3 and not label.isdigit() else ""


def draw_timeline(
    axes: Axes, timeline: Timeline, start: float, end: float, seconds_per_inch: float
) -> None:
    """Draw a timeline on axes between two times; lanes have height 1, from the top down."""
    from matplotlib.patches import Rectangle

    letter = 0.075 * seconds_per_inch
    for (left, right, label, key), lane in zip(timeline.spans, lanes(timeline.spans)):
        axes.add_patch(
            Rectangle(
                (left, lane + 0.08),
                right - left,
                0.84,
                facecolor=style.tint(key),
                edgecolor="white",
                linewidth=0.8,
                gid="span",
            )
        )
        text = fit_label(label, right - left - 0.5 * letter, letter)
        if text:
            middle = (left + right) / 2.0
            axes.text(
                middle, lane + 0.52, text, ha="center", va="center", fontsize=7.5, gid="label"
            )
    axes.set_ylim(n_lanes(timeline), 0)
    axes.set_xlim(start, end)
    axes.set_axis_off()
    axes.text(
        -0.008,
        0.5,
        timeline.name,
        transform=axes.transAxes,
        ha="right",
        va="center",
        fontsize=8,
        color=style.FAINT,
    )
