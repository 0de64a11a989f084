"""Draw grammars: derivation trees, and captures as strings.

Trees have nonterminals above and coloured terminals below, all at one scale. Each leaf has the same
width. All leaves are on the bottom line, and a node is centred above its children. A node that
derives the empty string has a place of its own and a small circle, so that empty rules are visible.
The edges run only vertically and horizontally, so that no edge crosses another node. Narrow trees
are drawn side by side.

Strings have a card with figures for each terminal, and a bar for each take. The cards are above. A
card shows the name of the terminal on its colour, its words, and three frames of its medoid, the
segment that represents the terminal. The bars are below. A bar shows the coloured terminals of a
take over time, with the numbered sentences under them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from motiondb.errors import MotionDBError
from motiondb.grammar.cfg.context_free import Tree
from motiondb.pictures import style
from motiondb.pictures.stick import HEAD_RADIUS, draw_figure, view_motion
from motiondb.pictures.strip import Timeline, cut_timeline, draw_timeline, n_lanes
from motiondb.records import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _PLACE, _LEVEL, _MARGIN, _TITLE, _CAPTION = 12.0, 0.34, 0.36, 0.2, 0.45, 0.28
"""Widths of the page and of a leaf, height of a level, margin, heights of the title and of a
caption, in inches."""


@dataclass(frozen=True)
class TreePicture:
    """A tree with a caption."""

    caption: str  # Text above the tree
    tree: Tree
    marked: Collection[int] = ()  # Nodes that are highlighted, by their number in preorder from 0


@dataclass(frozen=True)
class _Node:
    """A node with its position."""

    symbol: str  # The terminal or nonterminal
    x: float  # Horizontal position, in widths of a leaf
    level: int  # Level from the top, from 0
    parent: int  # Number of the parent; -1 for the root
    kind: str = "nonterminal"  # "nonterminal", "terminal" or "empty"


@dataclass(frozen=True)
class _Placed:
    """A tree with the positions of its nodes and its place on the page."""

    picture: TreePicture
    nodes: Sequence[_Node]  # All nodes in preorder
    width: float
    height: float
    left: float = 0.0  # Distance from the left edge of the page, in inches
    top: float = 0.0  # Distance from the top of the page below the title, in inches


def trees_figure(
    trees: Sequence[TreePicture], title: str = "", colours: Mapping[str, int] | None = None
) -> Figure:
    """Return a figure with axes for each tree; `colours`: terminal -> number of its tint."""
    if not trees:
        raise MotionDBError("trees: expected at least one tree to draw, found none. Parse first.")
    placed, width, height = _arrange([_lay_out(tree) for tree in trees])
    with style.drawing():
        figure = style.new_page(width, height + _TITLE, title, (_MARGIN, 0.24))
        for one in placed:
            low, name = height - one.top - one.height, one.picture.caption
            axes = style.add_axes(figure, one.left, low, one.width, one.height, name)
            _draw_tree(axes, one, colours or {})
    return figure


def _lay_out(picture: TreePicture) -> _Placed:
    """Position all nodes: leaves from left to right, each parent centred above its children."""
    nodes: list[Tree] = []
    parents: list[int] = []
    levels: list[int] = []
    waiting = [(picture.tree, -1, 0)]
    while waiting:  # in preorder: children follow their parents
        tree, parent, level = waiting.pop()
        number = len(nodes)
        nodes.append(tree)
        parents.append(parent)
        levels.append(level)
        waiting.extend((child, number, level + 1) for child in reversed(tree.children))
    depth = max(levels)
    xs = [0.0] * len(nodes)
    children: dict[int, list[int]] = {}
    for number, parent in enumerate(parents):
        children.setdefault(parent, []).append(number)
    at = 0
    for number in range(len(nodes)):
        if number not in children:
            xs[number] = at + 0.5
            at += 1
    for number in reversed(range(len(nodes))):
        if number in children:
            child_xs = [xs[child] for child in children[number]]
            xs[number] = (child_xs[0] + child_xs[-1]) / 2.0
    placed = [
        _Node(
            node.symbol,
            xs[n],
            depth if node.is_leaf else levels[n],
            parents[n],
            "terminal" if node.is_leaf else "nonterminal" if n in children else "empty",
        )
        for n, node in enumerate(nodes)
    ]
    width = max(at * _PLACE, 0.075 * len(picture.caption)) + 2 * _MARGIN
    return _Placed(picture, placed, width, (depth + 1) * _LEVEL + _CAPTION + _MARGIN)


def _arrange(trees: Sequence[_Placed]) -> tuple[list[_Placed], float, float]:
    """Arrange the trees in rows, in their order; return also the width and height of the page."""
    least = 4.0 if len(trees) == 1 else _WIDTH
    page = max(least, *(tree.width for tree in trees))
    placed: list[_Placed] = []
    left = top = shelf = 0.0
    for tree in trees:
        if left and left + tree.width > page:
            left, top, shelf = 0.0, top + shelf, 0.0
        placed.append(replace(tree, left=left, top=top))
        left += tree.width
        shelf = max(shelf, tree.height)
    return placed, page, top + shelf


def _draw_tree(axes: Axes, placed: _Placed, colours: Mapping[str, int]) -> None:
    """Draw the edges, and then the nodes above them; one unit of the axes is an inch."""
    from matplotlib.patches import FancyBboxPatch

    axes.set_xlim(-_MARGIN, placed.width - _MARGIN)
    axes.set_ylim(placed.height, 0.0)
    axes.set_axis_off()
    caption = placed.picture.caption
    axes.text(0.0, 0.12, caption, fontsize=7.5, color=style.FAINT, va="center", gid="caption")
    places = [(n.x * _PLACE, _CAPTION + (n.level + 0.5) * _LEVEL) for n in placed.nodes]
    marked = set(placed.picture.marked)
    for number, node in enumerate(placed.nodes):
        if node.parent >= 0:
            (x0, y0), (x1, y1) = places[node.parent], places[number]
            strong = number in marked and node.parent in marked
            colour, width = (style.RIGHT, 1.6) if strong else (style.GROUND, 0.9)
            bar = y0 + 0.5 * _LEVEL
            xs, ys = [x0, x0, x1, x1], [y0, bar, bar, y1]
            axes.plot(xs, ys, color=colour, lw=width, zorder=1 + 0.5 * strong, gid="edge")
    for number, (node, (x, y)) in enumerate(zip(placed.nodes, places)):
        edge = style.RIGHT if number in marked else "white"
        if node.kind == "terminal":
            key = colours.get(node.symbol, node.symbol)
            half = _PLACE * 0.44
            tile = FancyBboxPatch((x - half, y - 0.11), 2 * half, 0.22, zorder=2, gid="terminal")
            tile.set_boxstyle("round", pad=0, rounding_size=0.05)
            tile.set(facecolor=style.tint(key), edgecolor=edge, linewidth=1.2)
            axes.add_patch(tile)
        elif node.kind == "empty":
            axes.plot([x], [y + 0.16], "o", ms=3, mfc="white", mec=style.FAINT, zorder=2)
        look: dict[str, Any] = {"color": style.INK, "fontweight": "bold"}
        if node.kind != "terminal":
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
            look = {"color": style.RIGHT if number in marked else style.INK, "bbox": box}
        size = 7.5 if len(node.symbol) < 5 else 6.0
        style.write(axes, x, y, node.symbol, size, zorder=3, gid="symbol", **look)


_WIDE, _LEFT, _RIGHT, _HEAD = 12.0, 0.95, 0.25, 0.45
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
    height = _HEAD + n_cards * (_CARD + _GAP) + _GAP + sum(heights)
    with style.drawing():
        figure = style.new_page(_WIDE, height, title)
        _draw_cards(figure, cards, height)
        low = height - _HEAD - n_cards * (_CARD + _GAP) - _GAP
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
    width = (_WIDE - 0.5) / _CARDS
    for number, card in enumerate(cards):
        row, column = divmod(number, _CARDS)
        top = height - _HEAD - row * (_CARD + _GAP)
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
    inner, start = _WIDE - _LEFT - _RIGHT, span[0]
    if name:
        y = (low - _NAME / 2) / height
        style.write(figure, _LEFT / _WIDE, y, name, 8, ha="left", color=style.FAINT)
        low -= _NAME
    for line in lines:
        high = _LANE * n_lanes(line)
        low -= high
        axes = style.add_axes(figure, _LEFT, low, inner, high, f"{line.name} {name} {start:g}")
        draw_timeline(axes, line, start, start + seconds, seconds / inner)
    first = int(-(-start // 5) * 5)
    for second in range(first, int(span[1]) + 1, 5):
        x = (_LEFT + inner * (second - start) / seconds) / _WIDE
        style.write(figure, x, (low - 0.08) / height, f"{second} s", 6, color=style.FAINT)
