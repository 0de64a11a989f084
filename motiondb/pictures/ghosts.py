"""A capture in its own size over its floor, with boxes for what it needs, and its findings.

The camera is level, so heights are true: a scale of metres stands at the left. Every figure is
drawn above its own time; a box stands where it is, relative to the pelvis of that figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body import body
from motiondb.pictures import style
from motiondb.pictures.stick import BONES, best_azimuth, bone_colour
from motiondb.pictures.strip import Timeline, draw_timeline, n_lanes
from motiondb.records import Finding, FloatArray, Quality

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _LEFT, _RIGHT, _HIGH, _LANE, _AXIS, _TITLE = 12.0, 0.75, 0.25, 2.2, 0.21, 0.4, 0.45
_N_FIGURES = 14
_GHOST = "#E8A15C"
_LIMBS = [bone for bone in BONES if max(bone) < len(body.JOINTS)]
_LIMBS.append((body.INDEX["neck"], body.INDEX["head"]))
_SAID = 6.0  # Shortest time, of 12, over which a sentence is written in its bar


def ghosts_figure(points: FloatArray, fps: float, quality: Quality, title: str = "") -> Figure:
    """Draw figures of joints (frames, 21, 3), metres, y up, with boxes and a timeline below."""
    seconds = len(points) / fps
    timeline = Timeline("findings", [_bar(each, seconds) for each in quality.findings])
    high = _HIGH + _LANE * n_lanes(timeline) + _AXIS
    with style.drawing():
        page = style.new_page(_WIDTH, _TITLE + high, title, (_LEFT, 0.24))
        inner = _WIDTH - _LEFT - _RIGHT
        axes = style.add_axes(page, _LEFT, high - _HIGH, inner, _HIGH, "figures")
        _draw_figures(axes, points, fps, quality)
        low = high - _HIGH - _LANE * n_lanes(timeline)
        lanes = style.add_axes(page, _LEFT, low, inner, high - _HIGH - low, "findings")
        draw_timeline(lanes, timeline, 0.0, seconds, seconds / inner)
    return page


def _bar(each: Finding, seconds: float) -> tuple[float, float, str, str]:
    """The bar of a finding, at least wide enough to be seen."""
    width = max(each.end - each.start, seconds / 300.0)
    said = each.sentence.rpartition(", ")[0] if width > seconds / _SAID else each.kind
    return each.start, min(seconds, each.start + width), said, each.kind


def _draw_figures(axes: Axes, points: FloatArray, fps: float, quality: Quality) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Rectangle

    known = np.asarray(np.isfinite(points).all(axis=(1, 2)))
    azimuth = best_azimuth(points[known]) if known.any() else 0.0
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    n = min(_N_FIGURES, len(points))
    top = max(2.0, float(np.nanmax(points[..., 1])) - quality.floor + 0.3)
    wide = top * (_WIDTH - _LEFT - _RIGHT) / _HIGH
    for number in range(n):
        frame = int((number + 0.5) / n * len(points))
        if not known[frame]:
            continue
        time, x = frame / fps, (number + 0.5) / n * wide
        figure = points[frame] - np.array([0.0, quality.floor, 0.0])
        pelvis = float(figure[0] @ right)
        flat = np.stack([figure @ right - pelvis + x, figure[:, 1]], axis=1)
        for left, low, width, high in _boxes(quality.findings, time, right):
            at = (left - pelvis + x, low - quality.floor)
            axes.add_patch(Rectangle(at, width, high, color=_GHOST, alpha=0.35, lw=0, zorder=1))
            axes.add_patch(Rectangle(at, width, high, fill=False, ec=_GHOST, lw=0.8, zorder=1))
        axes.add_collection(
            LineCollection(
                [flat[list(bone)] for bone in _LIMBS],
                colors=[bone_colour(child) for _, child in _LIMBS],
                linewidths=1.8,
                capstyle="round",
                zorder=3,
            ),
            autolim=False,
        )
        head = flat[body.INDEX["head"]]
        axes.plot(*head, "o", ms=4, mfc="white", mec=style.TRUNK, mew=1.2, zorder=4)
        style.write(axes, x, -0.16 * top / 2.0, f"{time:.1f} s", 7)
    axes.plot([0.0, wide], [0.0, 0.0], color=style.GROUND, lw=0.8, zorder=0)
    axes.set_xlim(0.0, wide)
    axes.set_ylim(-0.25 * top / 2.0, top)
    axes.set_xticks([])
    axes.set_yticks(np.arange(0.0, top, 0.5), [f"{y:g} m" for y in np.arange(0.0, top, 0.5)])
    axes.spines[["top", "right", "bottom"]].set_visible(False)


def _boxes(
    findings: Sequence[Finding], time: float, right: FloatArray
) -> list[tuple[float, float, float, float]]:
    """Left edge, lower edge, width and height of the boxes at a time, as a camera sees them."""
    out = []
    for each in findings:
        for box in each.boxes if each.start <= time < each.end else ():
            half = float(np.abs(right) @ np.array(box.size)) / 2.0
            x, y, high = float(np.array(box.centre) @ right), box.centre[1], box.size[1]
            out.append((x - half, y - high / 2.0, 2.0 * half, high))
    return out
