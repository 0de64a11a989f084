"""A gait: the feet from above, and the angles of hip, knee and ankle over the cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body.gait import FootPrint, JointAngles
from motiondb.pictures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
