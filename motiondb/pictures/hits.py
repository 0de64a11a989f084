"""Rows of stick figures: the answers of a search."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.pictures.stick import View, draw_figure, view_motion
from motiondb.records import MOTION_FPS, Match, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _LEFT, _RIGHT = 11.0, 2.9, 0.2
"""Width of the figure and of its margins in inches. Chosen by eye."""
_ROW, _TITLE, _FOOT = 1.35, 0.5, 0.1  # Inches
_PATH = 1.0  # Width of the path from above, inches
_PARTS = style.STRONG[2:]  # Colours of the parts of a sequence: not those of the limbs
_FIGURES = 7  # In a row


def hits_figure(
    hits: Sequence[tuple[Match, Motion]],
    title: str = "",
    query: tuple[str, Motion] | None = None,
) -> Figure:
    """Draw the answer of a search, one row a hit, all at one scale; first the example, if any."""
    if not hits:
        raise MotionDBError("hits: expected at least 1 hit, found 0. Search for something else.")
    rows: list[tuple[str, Motion, Match | None]] = []
    if query is not None:
        rows = [(f"{query[0]}\nexample", query[1], None)]
    rows += [(hit_label(m), cut_motion(motion, m), m) for m, motion in hits]
    views = [view_motion(motion) for _, motion, _ in rows]
    high = max(1.5, *(view.top for view in views)) + 0.2
    first = _TITLE
    height = first + len(rows) * _ROW + _FOOT
    with style.drawing():
        figure = style.new_page(_WIDTH, height, title, (0.2, 0.26))
        style.legend(figure, "path from above")
        for number, ((label, _, match), view) in enumerate(zip(rows, views)):
            place = (height - first - (number + 1) * _ROW, height, high)
            _draw_row(figure, label, view, place, match)
    return figure


def _draw_row(
    figure: Figure, label: str, view: View, place: tuple[float, float, float], match: Match | None
) -> None:
    """Draw a row; ``place``: lower edge and page height in inches, height of the row in metres."""
    low, height, metres_high = place
    inner = _WIDTH - _LEFT - _RIGHT - _PATH
    start = max(0.0, match.start) if match else 0.0
    name, _, rest = label.partition("\n")
    axes = style.add_axes(figure, _LEFT, low + 0.12, inner, _ROW - 0.12, name)
    metres_wide = metres_high * inner / (_ROW - 0.12)
    axes.set_xlim(0.0, metres_wide)
    axes.set_ylim(-0.3, metres_high - 0.3)
    axes.set_axis_off()
    axes.axhline(0.0, color=style.GROUND, lw=0.8, zorder=0)
    n_figures = min(_FIGURES, view.n_frames)
    frames = np.linspace(0, view.n_frames - 1, n_figures).round().astype(int)
    for number, frame in enumerate(frames):
        x = (number + 0.5) * metres_wide / n_figures
        draw_figure(axes, view, int(frame), x, line_width=1.9)
        time = f"{start + frame / MOTION_FPS:.1f} s"
        style.write(axes, x, -0.17, time, 6.5, color=style.FAINT)
    for number, part in enumerate(match.parts if match and len(match.parts) > 1 else ()):
        share = [
            (t - start) * MOTION_FPS / max(view.n_frames - 1, 1) for t in (part.start, part.end)
        ]
        ends = [(0.5 + s * (n_figures - 1)) * metres_wide / n_figures for s in share]
        look: dict[str, Any] = {"color": _PARTS[number % len(_PARTS)]}
        axes.plot(ends, [-0.06, -0.06], lw=2.5, solid_capstyle="butt", gid="part", **look)
        style.write(axes, sum(ends) / 2.0, metres_high - 0.36, part.words, 6.5, **look)
    _draw_path(
        style.add_axes(figure, _WIDTH - _RIGHT - _PATH, low + 0.2, _PATH, _ROW - 0.3, "path"), view
    )
    x, middle = 0.2 / _WIDTH, (low + 0.55 * _ROW) / height
    figure.text(x, middle, name, fontsize=9, fontweight="bold", va="bottom")
    below = middle - 0.05 / height
    figure.text(x, below, rest, fontsize=8, va="top", linespacing=1.4, color=style.INK)


def _draw_path(axes: Axes, view: View) -> None:
    """Draw the way over the ground, seen from above, from the dot on; at least 1 m wide."""
    axes.set_axis_off()
    track = view.track * [1.0, -1.0]
    axes.plot(*track.T, color=style.INK, lw=1.0)
    axes.plot(*track[0], "o", color=style.INK, ms=3.5)
    middle, reach = (track.min(axis=0) + track.max(axis=0)) / 2.0, np.ptp(track, axis=0).max()
    half = max(reach, 1.0) * 0.55
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set_aspect("equal")
    across = f"{reach:.1f} m"
    style.write(axes, 0.5, -0.02, across, 6.5, color=style.FAINT, transform=axes.transAxes)


def hit_label(match: Match) -> str:
    """Label of a hit: rank and capture, then times, probability and words.

    >>> print(hit_label(Match(1, "16/16_35", 0.5, 2.25, 0.8123, ("run", "jog"), "", 0.9)))
    1  16/16_35
    0.5 – 2.2 s,  probability 0.90
    run, jog
    """
    sure = "-" if match.probability is None else f"{match.probability:.2f}"
    times = f"{match.start:.1f} – {match.end:.1f} s,  probability {sure}"
    words = ", ".join(match.words) or match.reason
    words = words if len(words) <= 42 else f"{words[:41]}…"
    return f"{match.rank}  {match.capture}\n{times}\n{words}".rstrip()


def cut_motion(motion: Motion, match: Match) -> Motion:
    """Cut the frames of a match out of the motion of its capture, at least one."""
    start = max(0, round(match.start * MOTION_FPS))
    end = min(motion.n_frames, max(start + 1, round(match.end * MOTION_FPS)))
    if start >= end:
        raise MotionDBError(
            f"{match.capture}: expected an interval within its "
            f"{motion.n_frames / MOTION_FPS:.2f} s, found one from {match.start:.2f} s on. Run "
            f"motiondb learn again, so that search and captures agree."
        )
    return motion[start:end]
