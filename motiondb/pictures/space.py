"""Symbol space: symbols as points, clusters as colours, shapes and ellipses of 1 and 2 sigma.

The first two dimensions are drawn large and labelled with words; if there is a third, two small
panels show it against the first and the second, labelled with numbers. Both axes of a panel have
one scale, so that distances on the page are distances in the space. Dimensions beyond the third are
not drawn; in a space of one dimension the height of the ellipses has no meaning.

Labels are placed one after the other, those with the fewest neighbours first. Each is placed at the
first free position on rings around its point, nearest ring first; if none is free, at the position
of least overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.records import FloatArray, SymbolSpace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Radii of the rings of places for a label, in units of the gap, and angles, the most readable first
_RINGS = (1.0, 1.8, 2.8, 4.0, 5.5, 7.5)
_ANGLES = np.deg2rad([0, 90, 270, 180, 45, 315, 135, 225, 20, 340, 160, 200, 65, 295, 115, 245])
_SIDE, _LEFT, _FOOT = 8.2, 0.75, 1.15
"""Inches: side of the large panel, margin left of a panel, margin below."""
_MAX_LEGEND = 24  # clusters in the legend; more would not fit below the panels
_CROWD = 80  # More symbols than this are labelled in smaller type


def space_figure(space: SymbolSpace, labels: Sequence[str] = ()) -> Figure:
    """Draw the symbol space; the first axes are those of the large panel."""
    n_symbols, n_dimensions = space.coordinates.shape
    if n_symbols == 0:
        raise MotionDBError("symbol space: expected at least 1 symbol, found 0. Run learn first.")
    labels = list(labels) or [""] * n_symbols
    if len(labels) != n_symbols:
        raise MotionDBError(
            f"symbol space: expected {n_symbols} labels, one a symbol, found {len(labels)}. "
            "Run motiondb learn again, so that words and symbols agree."
        )
    pairs = [(0, 1)] if n_dimensions < 3 else [(0, 1), (0, 2), (1, 2)]
    tall = _SIDE if n_dimensions > 1 else _SIDE / 3.0
    side = (_SIDE - 0.75) / 2.0
    width = _LEFT + _SIDE + (_LEFT + side if len(pairs) > 1 else 0.0) + 0.25
    height = _FOOT + tall + 0.55
    with style.drawing():
        figure = style.new_page(width, height, "Symbol space", (_LEFT, 0.3), "top")
        for number, pair in enumerate(pairs):
            box = (_LEFT, _FOOT, _SIDE, tall)
            if number > 0:
                box = (2.0 * _LEFT + _SIDE, _FOOT + (2 - number) * (side + 0.75), side, side)
            axes = style.add_axes(figure, *box, f"dimensions {pair[0] + 1} and {pair[1] + 1}")
            _draw_panel(axes, space, pair, labels if number == 0 else None)
        _draw_legend(figure, space, _LEFT / width)
    return figure


def _draw_panel(
    axes: Axes, space: SymbolSpace, pair: tuple[int, int], labels: Sequence[str] | None
) -> None:
    points = _columns(space.coordinates, pair)
    spread = np.sqrt(_columns(np.diagonal(space.covars, axis1=1, axis2=2), pair))
    means = _columns(space.means, pair)
    if space.coordinates.shape[1] <= pair[1]:
        axes.yaxis.set_visible(False)
        axes.spines["left"].set_visible(False)
    _frame(axes, np.concatenate([points, means - 2.0 * spread, means + 2.0 * spread]))
    axes.set_xlabel(f"dimension {pair[0] + 1}  (nats per frame)", color=style.FAINT)
    axes.set_ylabel(f"dimension {pair[1] + 1}", color=style.FAINT)
    for cluster in range(len(space.weights)):
        chosen = space.clusters == cluster
        colour, marker = cluster_look(cluster)
        _draw_ellipses(axes, means[cluster], _block(space.covars[cluster], pair), colour)
        look: Any = {"color": colour, "marker": marker, "edgecolor": "white", "linewidth": 0.7}
        x, y = points[chosen].T
        axes.scatter(x, y, s=46 if labels is not None else 20, zorder=4, **look)
    texts = [
        f"{n} {labels[n]}".strip() if labels is not None else str(n) for n in range(len(points))
    ]
    if labels is None:
        _write_labels(axes, points, texts, 5.5, 2.8)
    else:
        _write_labels(axes, points, texts, 7.5 if len(points) <= _CROWD else 6.2, 4.2)


def cluster_look(cluster: int) -> tuple[str, str]:
    """Colour and shape of a cluster; the shape changes where the colours repeat."""
    n_colours = len(style.STRONG)
    shape = (cluster + cluster // n_colours) % len(style.MARKERS)
    return style.STRONG[cluster % n_colours], style.MARKERS[shape]


def _columns(rows: FloatArray, pair: tuple[int, int]) -> FloatArray:
    """Two columns of (rows, dimensions); a missing second dimension is 0."""
    if rows.shape[1] > pair[1]:
        return rows[:, list(pair)]
    return np.stack([rows[:, 0], np.zeros(len(rows))], axis=1)


def _block(covar: FloatArray, pair: tuple[int, int]) -> FloatArray:
    """Covariance of two dimensions: a marginal of the Gaussian."""
    if len(covar) > pair[1]:
        return covar[np.ix_(pair, pair)]
    return np.diag([covar[0, 0], covar[0, 0] / 16.0])


def _frame(axes: Axes, points: FloatArray) -> None:
    """Set the limits of the axes around points with one scale, and hide unneeded lines."""
    low, high = points.min(axis=0), points.max(axis=0)
    box = axes.get_window_extent()
    tall = box.height / box.width
    reach = 0.54 * max(float(high[0] - low[0]), float(high[1] - low[1]) / tall, 1e-6)
    middle = (low + high) / 2.0
    axes.set_xlim(middle[0] - reach, middle[0] + reach)
    axes.set_ylim(middle[1] - tall * reach, middle[1] + tall * reach)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=7, length=2.5)


def _draw_ellipses(axes: Axes, mean: FloatArray, covar: FloatArray, colour: str) -> None:
    """Draw the 1 and 2 sigma ellipses of a Gaussian in the plane."""
    from matplotlib.patches import Ellipse

    variances, directions = np.linalg.eigh(covar)
    sizes = 2.0 * np.sqrt(np.maximum(variances, 0.0))
    angle = float(np.rad2deg(np.arctan2(directions[1, 1], directions[0, 1])))
    for sigma, alpha in ((2.0, 0.07), (1.0, 0.12)):
        wide, high = (sigma * sizes[::-1]).tolist()
        ellipse = Ellipse((float(mean[0]), float(mean[1])), wide, high, angle=angle, zorder=1)
        ellipse.set(facecolor=(colour, alpha), edgecolor=(colour, 0.55), linewidth=0.8)
        ellipse.set_gid("ellipse")
        axes.add_patch(ellipse)


def _write_labels(
    axes: Axes, points: FloatArray, texts: Sequence[str], size: float, radius: float
) -> None:
    """Draw labels beside points, with a thin line if far; sizes in typographic points."""
    to_pixels = axes.transData
    pixels = to_pixels.transform(points)
    scale = axes.figure.dpi / 72.0
    sizes = np.array([(0.60 * size * scale * len(t) + 2, 1.25 * size * scale) for t in texts])
    low, high = axes.transAxes.transform([(0.0, 0.0), (1.0, 1.0)])
    gap = radius * scale
    middles = place_labels(pixels, sizes, gap, low, high)
    places = to_pixels.inverted().transform(middles)
    for point, place, text, offset in zip(
        points, places, texts, np.abs(middles - pixels) - sizes / 2
    ):
        if offset.max() > 2.0 * gap:
            axes.plot(*zip(point, place), color=style.FAINT, lw=0.5, zorder=2)
        style.write(axes, place[0], place[1], text, size, zorder=5, gid="label")


def _draw_legend(figure: Figure, space: SymbolSpace, left: float) -> None:
    from matplotlib.lines import Line2D

    handles = []
    for cluster in range(min(len(space.weights), _MAX_LEGEND)):
        colour, marker = cluster_look(cluster)
        label = f"cluster {cluster}: {int(np.sum(space.clusters == cluster))}"
        handles.append(Line2D([], [], color=colour, marker=marker, ls="", ms=5, label=label))
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(left - 0.01, 0.0),
        borderaxespad=0.3,
        ncols=8,
        frameon=False,
        fontsize=7.5,
        handletextpad=0.1,
        columnspacing=1.2,
    )


def place_labels(
    points: FloatArray, sizes: FloatArray, gap: float, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Centres of labels (labels, 2), pixels, for points and sizes (labels, 2)."""
    crowd = np.sum(_distances(points) < 12.0 * gap, axis=1)
    discs = np.concatenate([points - gap, points + gap], axis=1)
    taken = discs
    middles = np.array(points, dtype=float)
    for label in np.argsort(crowd, kind="stable"):
        places = _places(points[label], sizes[label], gap)
        boxes = np.concatenate([places - sizes[label] / 2, places + sizes[label] / 2], axis=1)
        away = np.maximum(low - boxes[:, :2], 0).sum(1) + np.maximum(boxes[:, 2:] - high, 0).sum(1)
        cost = _overlaps(boxes, taken) + 1e3 * away
        best = int(np.argmin(cost > 0.0)) if (cost <= 0.0).any() else int(np.argmin(cost))
        middles[label] = places[best]
        taken = np.concatenate([taken, boxes[best : best + 1]])
    return middles


def _places(point: FloatArray, size: FloatArray, gap: float) -> FloatArray:
    """Possible centres of a label around its point, nearest ring first."""
    turns = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
    reach = 1.2 * gap + size / 2.0
    rings = [turns * (reach + (ring - 1.0) * 2.0 * gap) for ring in _RINGS]
    return point + np.concatenate(rings)


def _overlaps(boxes: FloatArray, taken: FloatArray) -> FloatArray:
    """Area of every box (n, 4) that boxes (m, 4) cover, pixels squared."""
    low = np.maximum(boxes[:, None, :2], taken[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], taken[None, :, 2:])
    return np.prod(np.maximum(high - low, 0.0), axis=2).sum(axis=1)


def _distances(points: FloatArray) -> FloatArray:
    return np.linalg.norm(points[:, None] - points[None], axis=2)
