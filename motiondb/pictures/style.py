"""Common style of all pictures: colours for colour-blind readers too, type, and saving.

Left limbs are blue and right limbs vermilion (a pair of Okabe and Ito), the trunk is dark grey.
Symbols and words have muted tints (after Paul Tol) on which dark type is readable. There are more
symbols than tints, so that each bar also shows the symbol's number. Pictures are drawn on figures
of their own, never through pyplot, and files are renamed to their final name when complete.
"""

from __future__ import annotations

import io
import warnings
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb.errors import MotionDBError, QueryError
from motiondb.files.own_files import SEAL, seal
from motiondb.files.safe_files import output_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image

LEFT, RIGHT, TRUNK = "#0072B2", "#D55E00", "#3C4048"
INK, FAINT, GROUND, GRID, SHADOW = "#24272D", "#8A9099", "#B9BEC6", "#D5D8DE", "#E6E8EC"
DOTS_PER_INCH = 110  # Resolution of the pictures. Chosen by eye
FRAME_SECONDS = 0.05  # Seconds a picture: the shortest delay of a GIF that all browsers keep

TINTS: tuple[str, ...] = (
    "#88CCEE",
    "#DDCC77",
    "#CC99BB",
    "#99CC88",
    "#EE9988",
    "#77BBAA",
    "#BBBBDD",
    "#E5BB99",
    "#BBCC55",
    "#88AADD",
    "#EEAABB",
    "#C5C9D0",
)  # Fill colours of bars, light enough for dark type

STRONG: tuple[str, ...] = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#AA3377",
    "#B8860B",
    "#332288",
    "#56B4E9",
    "#882255",
    "#117733",
    "#7A7A7A",
)  # Colours of points and outlines

MARKERS = "osD^vPXph*"  # Shapes of points, so that clusters can be distinguished without colour

_RC: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.0,
    "text.color": INK,
    "text.parse_math": False,
    "axes.edgecolor": GROUND,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
}  # Settings of matplotlib for all pictures. Chosen by eye


@contextmanager
def drawing() -> Iterator[None]:
    """Apply the settings of all pictures, and ignore warnings about glyphs that the font lacks."""
    from matplotlib import rc_context

    with rc_context(_RC), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        yield


def new_page(
    width: float,
    height: float,
    title: str = "",
    at: tuple[float, float] = (0.25, 0.24),
    va: str = "center",
) -> Figure:
    """Return a white page of a size in inches; `at`: place of the title from the left and top."""
    from matplotlib.figure import Figure as MplFigure

    page = MplFigure(figsize=(width, height), dpi=DOTS_PER_INCH, facecolor="white")
    if title:
        left, down = at[0] / width, 1.0 - at[1] / height
        page.text(left, down, title, fontsize=11, fontweight="bold", va=va)
    return page


def legend(page: Figure, more: str = "") -> None:
    """Say at the top right which side of the body has which colour, and what else is there."""
    width, height = page.get_size_inches()
    said = ((2.55, "left limbs", LEFT), (1.85, "right limbs", RIGHT), (1.1, more, FAINT))
    for inches, text, colour in said:
        page.text(1.0 - inches / width, 1.0 - 0.24 / height, text, color=colour, va="center")


def add_axes(
    page: Figure, left: float, low: float, width: float, height: float, label: str
) -> Axes:
    """Add axes to a page; their left and lower edge and their size in inches."""
    across, high = page.get_size_inches()
    return page.add_axes((left / across, low / high, width / across, height / high), label=label)


def write(where: Axes | Figure, x: float, y: float, text: str, size: float, **look: Any) -> None:  # noqa: ANN401
    """Write a text around a point; `look`: what matplotlib's text takes besides."""
    centred: dict[str, Any] = {"fontsize": size, "ha": "center", "va": "center"}
    where.text(x, y, text, **centred | look)


def tint(key: int | str) -> str:
    """Fill colour of a symbol number or a word, the same in every picture.

    >>> tint(0) == tint(12), tint(0) == tint(1), tint("walk") == tint("walk")
    (True, False, True)
    """
    number = key if isinstance(key, int) else zlib.crc32(key.encode())
    return TINTS[number % len(TINTS)]


def save_png(figure: Figure, path: str | Path | None) -> Path | Figure:
    """Write a figure as PNG, whole or not at all; equal figures give equal bytes.

    Without a path return the figure, which shows itself in a notebook.
    """
    if path is None:
        vars(figure)["_repr_png_"] = partial(_png, figure)
        return figure
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise QueryError(
            f"{path}: expected a name that ends in .png, found {path.suffix or 'no ending'!r}. "
            "Pictures are written as PNG."
        )
    with output_file(path) as draft:
        draft.write_bytes(_png(figure))
        seal(draft)
    return path


def _png(figure: Figure) -> bytes:
    """The bytes of a figure as PNG."""
    data = io.BytesIO()
    with drawing():
        figure.savefig(data, format="png", dpi=DOTS_PER_INCH, metadata={"Software": SEAL})
    return data.getvalue()


def check_gif(path: str | Path) -> Path:
    """Return the path of an animation."""
    path = Path(path)
    if path.suffix.lower() != ".gif":
        raise MotionDBError(
            f"{path}: expected a name that ends in .gif, found {path.suffix or 'no ending'!r}. "
            "Animations are written as GIF."
        )
    return path


def save_gif(images: Sequence[Image], path: Path) -> Path:
    """Write images, one every ``FRAME_SECONDS``, as a GIF that repeats endlessly."""
    with output_file(path) as draft:
        images[0].save(
            draft,
            format="GIF",
            save_all=True,
            append_images=images[1:],
            duration=round(1000 * FRAME_SECONDS),
            loop=0,
            optimize=False,
            comment=SEAL.encode(),
        )
        seal(draft)
    return path
