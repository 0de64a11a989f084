"""Draw captures as strings: a card with figures for each terminal, and a bar for each take.

The cards are above. A card shows the name of the terminal on its colour, its words, and three
frames of its medoid, the segment that represents the terminal. The bars are below. A bar shows the
coloured terminals of a take over time, with the numbered sentences under them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.pictures.stick import HEAD_RADIUS, draw_figure, view_motion
from motiondb.pictures.strip import Timeline, cut_timeline, draw_timeline, n_lanes
from motiondb.records import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _LEFT, _RIGHT, _TITLE = 12.0, 0.95, 0.25, 0.45
"""Width of the page, left margin, right margin and height of the title, in inches."""
_CARD, _CARDS, _LANE, _NAME, _GAP, _AXIS = 1.45, 6, 0.2, 0.2, 0.1, 0.22
"""Height of a card, number of cards in a row, height of a lane, of a name, of a gap and of the time
axis. All but the number are in inches."""
_SECONDS_PER_ROW, _MAX_ROWS = 20.0, 40
"""Fewest seconds in a row of a bar, unless all bars are shorter, and the number of rows above which
rows become longer."""
_CLOSE = 0.8
"""Least width of a card, as a share of the sum of the widths of its figures. A lying figure is wide
and is therefore drawn smaller."""


@dataclass(frozen=True, eq=False)
class TerminalCard:
    """A terminal with the motion that represents it."""

    name: str  # Name of the terminal
    text: str  # Text beside the name, such as its words. It is cut if it is too long
    key: int  # Number of its tint
    motion: Motion


@dataclass(frozen=True)
class StringBar:
    """A take with its timelines."""

    name: str  # Name of the take
    seconds: float  # Duration of the take
    # The terminals, and further timelines such as the sentences; times in seconds
    timelines: Sequence[Timeline]


def strings_figure(
    cards: Sequence[TerminalCard], bars: Sequence[StringBar], title: str = ""
) -> Figure:
    """Return the picture as a figure: axes for each card, then for each timeline of each row."""
    if not cards and not bars:
        raise MotionDBError("strings: expected terminals or strings to draw, found none.")
    longest = max((bar.seconds for bar in bars), default=_SECONDS_PER_ROW)
    total = sum(bar.seconds for bar in bars)
    seconds = min(longest, max(_SECONDS_PER_ROW, total / _MAX_ROWS))
    rows = [row for bar in bars for row in _rows(bar, seconds)]
    n_cards = -(-len(cards) // _CARDS)
    heights = [
        _NAME * bool(name) + _LANE * sum(map(n_lanes, lines)) + _AXIS for name, _, _, lines in rows
    ]
    height = _TITLE + n_cards * (_CARD + _GAP) + _GAP + sum(heights)
    with style.drawing():
        figure = style.new_page(_WIDTH, height, title)
        _draw_cards(figure, cards, height)
        low = height - _TITLE - n_cards * (_CARD + _GAP) - _GAP
        for (name, start, stop, lines), high in zip(rows, heights):
            _draw_row(figure, name, (start, stop), lines, seconds, low, height)
            low -= high
    return figure


def _rows(bar: StringBar, seconds: float) -> list[tuple[str, float, float, list[Timeline]]]:
    """Divide a bar into rows: name, start and stop in seconds, and the timelines between them."""
    starts = [0.0]
    while starts[-1] + seconds < bar.seconds - 1e-9:
        starts.append(starts[-1] + seconds)
    return [
        (
            bar.name if start == 0.0 else "",
            start,
            min(start + seconds, bar.seconds),
            [cut_timeline(line, start, start + seconds) for line in bar.timelines],
        )
        for start in starts
    ]


def _draw_cards(figure: Figure, cards: Sequence[TerminalCard], height: float) -> None:
    """Draw the cards in rows; ``height`` is the height of the page in inches."""
    width = (_WIDTH - 0.5) / _CARDS
    for number, card in enumerate(cards):
        row, column = divmod(number, _CARDS)
        top = height - _TITLE - row * (_CARD + _GAP)
        left, name = 0.25 + column * width, f"terminal {card.name}"
        axes = style.add_axes(figure, left, top - _CARD, width - _GAP, _CARD, name)
        _draw_card(axes, card, width - _GAP)


def _draw_card(axes: Axes, card: TerminalCard, width: float) -> None:
    """Draw name and text on the terminal's colour, and three frames below; one unit is a metre."""
    from matplotlib.patches import Rectangle

    view = view_motion(card.motion)
    frames = [moment * (view.n_frames - 1) // 2 for moment in (0, 1, 2)]
    sides = [
        (float(x.min()) - HEAD_RADIUS, float(x.max()) + HEAD_RADIUS)
        for x in (view.points[frame, :, 0] for frame in frames)
    ]
    taken = sum(right - left for left, right in sides)
    scale = max((max(view.top, 1.2) + 0.25) / (_CARD - 0.26), _CLOSE * taken / width)
    across, high = width * scale, _CARD * scale
    axes.set_xlim(0.0, across)
    axes.set_ylim(-0.25, high - 0.25)
    axes.set_axis_off()
    band = 0.22 * scale
    low, colour = high - 0.25 - band, style.tint(card.key)
    axes.add_patch(Rectangle((0.0, low), across, band, facecolor=colour, lw=0, gid="band"))
    y = high - 0.25 - band / 2.0
    axes.text(0.06 * scale, y, card.name, fontsize=9, va="center", fontweight="bold", gid="name")
    room = int((width - 0.12 - 0.09 * len(card.name) - 0.1) / 0.068)
    text = card.text if len(card.text) <= room else card.text[: max(room - 1, 0)] + "…"
    axes.text(across - 0.06 * scale, y, text, fontsize=7, va="center", ha="right", gid="words")
    axes.plot([0.0, across], [0.0, 0.0], color=style.GROUND, lw=0.6, zorder=0)
    place, free = 0.0, (across - taken) / len(frames)  # if negative, the figures overlap
    for frame, (left, right) in zip(frames, sides):
        draw_figure(axes, view, frame, place + free / 2.0 - left, 1.4)
        place += right - left + free


def _draw_row(
    figure: Figure,
    name: str,
    span: tuple[float, float],
    lines: Sequence[Timeline],
    seconds: float,
    low: float,
    height: float,
) -> None:
    """Draw one row downwards from ``low`` (inches): name, timelines and every fifth second."""
    inner, start = _WIDTH - _LEFT - _RIGHT, span[0]
    if name:
        y = (low - _NAME / 2) / height
        style.write(figure, _LEFT / _WIDTH, y, name, 8, ha="left", color=style.FAINT)
        low -= _NAME
    for line in lines:
        high = _LANE * n_lanes(line)
        low -= high
        axes = style.add_axes(figure, _LEFT, low, inner, high, f"{line.name} {name} {start:g}")
        draw_timeline(axes, line, start, start + seconds, seconds / inner)
    first = int(-(-start // 5) * 5)
    for second in range(first, int(span[1]) + 1, 5):
        x = (_LEFT + inner * (second - start) / seconds) / _WIDTH
        style.write(figure, x, (low - 0.08) / height, f"{second} s", 6, color=style.FAINT)
