"""Two motions side by side: the distance of all their poses, and the alignment through it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from motiondb.pictures import style
from motiondb.records import FloatArray

if TYPE_CHECKING:
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
