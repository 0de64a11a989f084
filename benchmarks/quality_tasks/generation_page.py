"""A page of generated motions to look at: one row of stick figures for each sentence.

Beside the figures stands the way from above, with the heading at every figure, because the side
view does not show where somebody faces.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body import features, retarget
from motiondb.pictures.stick import draw_figure, view_motion
from motiondb.records import MOTION_FPS, IntArray, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = 16
"""Figures in a row, at equal times from the first frame to the last."""
ROWS = 10
"""Motions on a page."""


def draw_pages(
    motions: Sequence[tuple[str, Motion]], folder: Path, stem: str, dpi: int = 75
) -> list[Path]:
    """Draw pages of ROWS motions each; the motions are numbered throughout."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    paths = []
    for page in range(-(-len(motions) // ROWS)):
        part = motions[page * ROWS : (page + 1) * ROWS]
        figure = page_figure(part, 1 + page * ROWS)
        paths.append(folder / f"{stem}-{page + 1}.png")
        FigureCanvasAgg(figure)
        figure.savefig(paths[-1], dpi=dpi)
    return paths


def page_figure(motions: Sequence[tuple[str, Motion]], first: int) -> Figure:
    """One page; the place of a figure is its time, not its place in the world."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(18.0, 1.75 * len(motions)), layout="constrained")
    rows = figure.subplots(len(motions), 2, squeeze=False, width_ratios=(9.0, 1.0))
    for number, ((ax, above), (title, motion)) in enumerate(zip(rows, motions), start=first):
        view = view_motion(motion)
        frames = np.linspace(0, motion.n_frames - 1, FIGURES).round().astype(int)
        for place, frame in enumerate(frames):
            draw_figure(ax, view, int(frame), 1.5 * place)
        ax.set_xlim(-0.9, 1.5 * FIGURES - 0.6)
        ax.set_ylim(-0.15, max(view.top, 1.9))
        ax.set_aspect("equal")
        ax.axis("off")
        seconds = motion.n_frames / MOTION_FPS
        ax.set_title(f"{number}. {title}   ({seconds:.1f} s)", fontsize=9, loc="left", pad=2)
        draw_way(above, motion, frames)
    return figure


def draw_way(ax: Axes, motion: Motion, frames: IntArray) -> None:
    """The way of the pelvis from above, from its dot on, and the heading at some frames."""
    positions, world = retarget.motion_positions(motion)
    x, z = positions[:, 0, 0], positions[:, 0, 2]
    heading = features.headings(world)[frames]
    reach = max(float(np.ptp(x)), float(np.ptp(z)), 1.0)
    ax.plot(x, -z, color="0.6", linewidth=1.0)
    ax.plot(x[:1], -z[:1], "o", color="0.3", markersize=4)
    ax.quiver(
        x[frames], -z[frames], np.sin(heading), -np.cos(heading), np.linspace(0.2, 1.0, FIGURES),
        cmap="viridis", angles="xy", scale_units="xy", scale=6.0 / reach, width=0.02,
    )  # fmt: skip
    middle = (float(x.max() + x.min()) / 2.0, -float(z.max() + z.min()) / 2.0)
    ax.set_xlim(middle[0] - 0.8 * reach, middle[0] + 0.8 * reach)
    ax.set_ylim(middle[1] - 0.8 * reach, middle[1] + 0.8 * reach)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_title(f"{reach:.1f} m", fontsize=8, pad=2)
