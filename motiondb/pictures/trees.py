"""Draw derivation trees, with nonterminals above and coloured terminals below, all at one scale.

Each leaf has the same width. All leaves are on the bottom line, and a node is centred above its
children. A node that derives the empty string has a place of its own and a small circle, so that
empty rules are visible. The edges run only vertically and horizontally, so that no edge crosses
another node. Narrow trees are drawn side by side.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from motiondb.errors import MotionDBError
from motiondb.grammar.cfg.context_free import Tree
from motiondb.pictures import style

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
