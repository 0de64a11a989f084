"""What a library holds, as tables whose cells are darker the more there is."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from motiondb.pictures import style

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
