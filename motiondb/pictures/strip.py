"""A capture on a page: stick figures over time, with timelines of symbols and words below.

The horizontal axis is time: every figure is drawn above its own time, not at its place in the
world. Long captures are divided into rows of equal duration, all at one scale. A timeline shows
labelled intervals as bars, in lanes where they overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.pictures import style
from motiondb.pictures.stick import View, draw_figure, view_motion
from motiondb.records import MOTION_FPS, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _LEFT, _RIGHT = 12.0, 0.75, 0.25
"""Width of the figure and of its margins in inches."""
_INNER = _WIDTH - _LEFT - _RIGHT  # Width of a row's axes, inches
_FIGURES, _LANE, _AXIS, _GAP, _TITLE = 1.55, 0.21, 0.34, 0.12, 0.45  # Inches
_SECONDS_PER_ROW = 12.0  # Seconds in a row, unless there would be too many rows
_MAX_ROWS = 10  # Rows on a page


@dataclass(frozen=True)
class _Layout:
    """Rows of ``seconds`` each, with their parts of the timelines."""

    seconds: float
    duration: float
    n_figures: int  # In a row
    metres_wide: float  # Of a row, at the scale of the figures
    metres_high: float
    rows: tuple[tuple[Timeline, ...], ...]

    @property
    def tops(self) -> tuple[float, ...]:
        """Distance from the top of the page to each row, then to the end of the page, inches."""
        heights = [
            _FIGURES + _LANE * sum(map(n_lanes, timelines)) + _AXIS + _GAP
            for timelines in self.rows
        ]
        return tuple(accumulate([_TITLE, *heights]))


def strip_figure(motion: Motion, title: str = "", timelines: Sequence[Timeline] = ()) -> Figure:
    """Draw rows of stick figures, each with its timelines and a scale of seconds below."""
    view = view_motion(motion)
    layout = _layout(view, timelines)
    with style.drawing():
        figure = style.new_page(_WIDTH, layout.tops[-1], title, (_LEFT, 0.24))
        style.legend(figure)
        for row in range(len(layout.rows)):
            _draw_row(figure, view, layout, row)
    return figure


def _layout(view: View, timelines: Sequence[Timeline]) -> _Layout:
    duration = view.n_frames / MOTION_FPS
    wanted = max(_SECONDS_PER_ROW, duration / _MAX_ROWS)
    n_rows = max(1, int(np.ceil(duration / wanted - 1e-9)))
    seconds = duration if n_rows == 1 else float(np.ceil(duration / n_rows))
    rows = tuple(
        tuple(cut_timeline(timeline, row * seconds, (row + 1) * seconds) for timeline in timelines)
        for row in range(n_rows)
    )
    high = max(view.top, 1.5) + 0.2
    wide = high * _INNER / _FIGURES
    room = int(np.clip(wide / (0.95 * view.width), 3, 24))
    n_figures = min(room, max(1, round(seconds * MOTION_FPS)))
    return _Layout(seconds, duration, n_figures, wide, high, rows)


def _draw_row(figure: Figure, view: View, layout: _Layout, row: int) -> None:
    """Draw one row: figures, timelines, scale of seconds."""
    start = row * layout.seconds
    end = start + layout.seconds
    stop = min(end, layout.duration)
    low = layout.tops[-1] - layout.tops[row]

    def add_axes(name: str, high: float) -> Axes:
        nonlocal low
        low -= high
        return style.add_axes(figure, _LEFT, low, _INNER, high, f"{name} {row}")

    axes = add_axes("figures", _FIGURES)
    axes.set_xlim(0.0, layout.metres_wide)
    axes.set_ylim(-0.2, layout.metres_high - 0.2)
    axes.set_axis_off()
    reach = (stop - start) / layout.seconds * layout.metres_wide
    axes.plot([0.0, reach], [0.0, 0.0], color=style.GROUND, lw=0.8, zorder=0)
    for number in range(layout.n_figures):
        part = (number + 0.5) / layout.n_figures
        frame = int((start + part * layout.seconds) * MOTION_FPS)
        if frame < view.n_frames:
            draw_figure(axes, view, frame, part * layout.metres_wide)
    for timeline in layout.rows[row]:
        axes = add_axes(timeline.name, _LANE * n_lanes(timeline))
        draw_timeline(axes, timeline, start, end, layout.seconds / _INNER)
    _draw_ruler(add_axes("time", 0.04), start, end, stop)


def _draw_ruler(axes: Axes, start: float, end: float, stop: float) -> None:
    """Draw a scale of seconds from ``start`` to ``stop`` on axes that end at ``end``."""
    from matplotlib.ticker import MaxNLocator

    axes.set_xlim(start, end)
    axes.set_yticks([])
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.spines["bottom"].set_bounds(start, stop)
    ticks = MaxNLocator(nbins=12, steps=[1, 2, 5, 10]).tick_values(start, end)
    kept = [float(tick) for tick in ticks if start - 1e-6 <= tick <= stop + 1e-6]
    axes.set_xticks(kept, [f"{tick:g} s" for tick in kept])
    axes.tick_params(axis="x", length=3, pad=2, labelsize=7.5)


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
        colours: Any = {"facecolor": style.tint(key), "edgecolor": "white", "linewidth": 0.8}
        axes.add_artist(Rectangle((left, lane + 0.08), right - left, 0.84, gid="span", **colours))
        text = fit_label(label, right - left - 0.5 * letter, letter)
        if text:
            style.write(axes, (left + right) / 2.0, lane + 0.52, text, 7.5, gid="label")
    axes.set_ylim(n_lanes(timeline), 0)
    axes.set_xlim(start, end)
    axes.set_axis_off()
    look = {"ha": "right", "color": style.FAINT, "transform": axes.transAxes}
    style.write(axes, -0.008, 0.5, timeline.name, 8, **look)
