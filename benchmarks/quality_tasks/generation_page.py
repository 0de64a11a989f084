"""A page of generated motions to look at: one row of stick figures for each sentence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.pictures.stick import draw_figure, view_motion
from motiondb.records import MOTION_FPS, Motion

if TYPE_CHECKING:
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

    figure = Figure(figsize=(16.0, 1.75 * len(motions)), layout="constrained")
    axes = figure.subplots(len(motions), 1, squeeze=False)[:, 0]
    for number, (ax, (title, motion)) in enumerate(zip(axes, motions), start=first):
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
    return figure
