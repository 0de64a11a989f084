"""Charts of what was measured, without bodies.

Two motions side by side: the distance of all their poses, and the alignment through it. A gait: the
feet from above, and the angles of hip, knee and ankle over the cycle. What a library holds: tables
whose cells are darker the more there is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from motiondb.body.gait import FootPrint, JointAngles
from motiondb.pictures import style
from motiondb.records import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def comparison_figure(
    names: tuple[str, str],
    costs: FloatArray,
    times: tuple[FloatArray, FloatArray],
    spans: tuple[tuple[float, float], tuple[float, float]],
) -> Figure:
    """Draw distances of poses, metres, with the alignment (steps,), seconds, through them."""
    (low, high), (first, last) = spans
    with style.drawing():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7.0, 7.5))
        upper, lower = figure.subplots(2, 1, gridspec_kw={"height_ratios": [3, 1]}, sharex=True)
        shown = upper.imshow(
            costs.T, origin="lower", aspect="auto", extent=(low, high, first, last), cmap="viridis"
        )
        upper.plot(*times, color="white", linewidth=1.5)
        upper.set_ylabel(f"{names[1]} (s)")
        upper.set_title(f"{names[0]} and {names[1]}: distance of poses, and alignment", loc="left")
        bar = figure.colorbar(shown, ax=[upper, lower], shrink=0.6)
        bar.set_label("mean distance of joints (m)")
        places = [
            np.clip(np.round((t - a) / max(b - a, 1e-9) * (n - 1)).astype(int), 0, n - 1)
            for t, (a, b), n in zip(times, spans, costs.shape)
        ]
        lower.plot(times[0], costs[places[0], places[1]], color="C0")
        lower.set_xlabel(f"{names[0]} (s)")
        lower.set_ylabel("distance (m)")
        lower.set_ylim(bottom=0.0)
    return figure


_JOINTS = ("hip", "knee", "ankle")
_COLOURS = {"l": style.LEFT, "r": style.RIGHT}
_FOOT = 0.2  # Metres of the stroke that stands for a foot


def gait_figure(
    name: str,
    prints: Sequence[FootPrint],
    angles: Sequence[JointAngles],
    stances: dict[str, float],
) -> Figure:
    """Draw the strikes of the feet from above, and mean angles with a band of one deviation.

    `stances`: side -> mean share of the cycle in which the foot is on the ground.
    """
    with style.drawing():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.0, 6.0), layout="constrained")
        grid = figure.add_gridspec(2, 3, height_ratios=[2, 3])
        above = figure.add_subplot(grid[0, :])
        _draw_prints(above, prints)
        above.set_title(f"{name}: foot strikes from above", loc="left")
        for column, joint in enumerate(_JOINTS):
            axes = figure.add_subplot(grid[1, column])
            _draw_angles(axes, [each for each in angles if each.joint == joint], stances)
            axes.set_title(joint, loc="left")
            if column == 0:
                axes.set_ylabel("flexion (degrees), mean and deviation")
        handles, labels = axes.get_legend_handles_labels()
        if handles:
            axes.legend(handles, labels, frameon=False, loc="best")
    return figure


def _draw_prints(axes: Axes, prints: Sequence[FootPrint]) -> None:
    """Draw a stroke from heel to toe for each strike, along the longer way of the walk."""
    places = np.array([[p.z, p.x] for p in prints]).reshape(-1, 2)
    centred = places - places.mean(axis=0) if len(places) else places
    _, _, ways = np.linalg.svd(centred) if len(places) > 1 else (0, 0, np.eye(2))
    along = ways[0] * (1.0 if len(places) < 2 or (places[-1] - places[0]) @ ways[0] >= 0 else -1.0)
    turn = np.array([along, [-along[1], along[0]]])  # so that left stays left
    for foot in prints:
        angle = np.radians(foot.heading)
        way = turn @ np.array([np.cos(angle), np.sin(angle)])
        heel = turn @ (np.array([foot.z, foot.x]))
        ends = np.stack([heel - 0.25 * _FOOT * way, heel + 0.75 * _FOOT * way])
        axes.plot(*ends.T, color=_COLOURS[foot.side], linewidth=4, solid_capstyle="round")
        axes.annotate(
            f"{foot.seconds:.1f}",
            ends[1],
            textcoords="offset points",
            xytext=(3, 5),
            fontsize=6,
            color=style.FAINT,
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("metres (beside each foot: seconds)")


def _draw_angles(axes: Axes, angles: Sequence[JointAngles], stances: dict[str, float]) -> None:
    """Draw mean and band of each side, and where its foot leaves the ground."""
    for each in angles:
        colour, mean = _COLOURS[each.side], np.array(each.mean)
        places, band = np.linspace(0.0, 100.0, len(mean)), np.array(each.deviation)
        label = {"l": "left", "r": "right"}[each.side]
        axes.fill_between(places, mean - band, mean + band, color=colour, alpha=0.2, linewidth=0)
        axes.plot(places, mean, color=colour, label=label)
        if each.side in stances:
            axes.axvline(100.0 * stances[each.side], color=colour, linewidth=0.8, linestyle=":")
    axes.set_xlim(0.0, 100.0)
    axes.set_xlabel("% of the cycle (dotted: foot off)")


Grid: TypeAlias = list[tuple[str, str, float, str, int]]
"""Row, column, amount, its unit, and performers, of every cell, row by row."""
_CELL, _HIGH, _LABEL, _TOP, _LOW = 1.05, 0.52, 1.45, 0.75, 0.35
_FEW = style.RIGHT  # Colour of what stands on the shot list


def coverage_figure(going: Grid, changes: Grid) -> Figure:
    """Draw two tables beside one another; cells with little, or of one performer, are marked."""
    tables = (("How the library goes", going), ("Changes, by the foot ahead", changes))
    sizes = [(len(_names(g, 0)), len(_names(g, 1))) for _, g in tables]
    width = sum(_LABEL + _CELL * columns + 0.3 for _, columns in sizes)
    high = max(_HIGH * rows for rows, _ in sizes)
    with style.drawing():
        page = style.new_page(width, _TOP + high + _LOW)
        left = 0.0
        for (title, grid), (rows, columns) in zip(tables, sizes):
            left += _LABEL
            low = _LOW + high - _HIGH * rows
            axes = style.add_axes(page, left, low, _CELL * columns, _HIGH * rows, title)
            _draw(axes, grid, title)
            left += _CELL * columns + 0.3
        style.write(
            page,
            0.01,
            0.15 / (_TOP + high + _LOW),
            "Framed: less than a second or one performer, which is the shot list. Only upright.",
            7.5,
            ha="left",
        )
    return page


def _names(grid: Grid, which: int) -> Sequence[str]:
    return list(dict.fromkeys(str(cell[which]) for cell in grid))


def _draw(axes: Axes, grid: Grid, title: str) -> None:
    from matplotlib.patches import Rectangle

    rows, columns = _names(grid, 0), _names(grid, 1)
    most = np.log1p(max((cell[2] for cell in grid), default=1.0))
    for row, column, amount, unit, performers in grid:
        x, y = columns.index(column), rows.index(row)
        shade = 0.55 * float(np.log1p(amount) / most) if most > 0.0 else 0.0
        axes.add_patch(Rectangle((x, y), 1, 1, color=style.LEFT, alpha=shade, lw=0))
        few = amount < 1.0 or performers < 2
        if few:
            axes.add_patch(Rectangle((x + 0.04, y + 0.06), 0.92, 0.88, fill=False, ec=_FEW, lw=1.3))
        said = "none" if not amount else f"{amount:.0f} s" if amount >= 10 else f"{amount:.1f} s"
        said = f"{amount:.0f} x" if unit != "s" and amount else said
        style.write(axes, x + 0.5, y + 0.38, said, 9, color=_FEW if few else style.INK)
        who = f"{performers} performer{'' if performers == 1 else 's'}"
        if amount:
            style.write(axes, x + 0.5, y + 0.74, who, 6.5, color=_FEW if few else style.TRUNK)
    axes.set_xlim(0, len(columns))
    axes.set_ylim(len(rows), 0)
    axes.set_xticks(np.arange(len(columns)) + 0.5, columns)
    axes.set_yticks(np.arange(len(rows)) + 0.5, rows)
    axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    axes.spines[:].set_visible(False)
    axes.set_title(title, fontsize=10, loc="left", pad=10)
