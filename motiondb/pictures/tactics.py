"""A tactics diagram as coaches draw it, on a half court seen from above with the rim at the top.

Attackers are circles and defenders crosses, with their names. A solid curve with an arrow is a
move, a waved one a dribble, and one that ends in a T a screen. A dashed arrow is a pass, a heavy
straight one to the rim a shot, a short zigzag a feint, fake or pivot. A dotted line leads to the
player who is guarded or whose shot is blocked. Numbers are the steps. Court lines are those of FIBA
(Official Basketball Rules 2022, article 2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motiondb.pictures import style
from motiondb.pictures.space import place_labels
from motiondb.records import FloatArray
from motiondb.scene.language.expressions import Item, expressions, smooth_curve
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import DEFENCE, FEINTS, SHOTS, STANDS, Diagram, Element

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SCALE = 0.5  # Inches a metre
_MARGIN = 0.6  # Margin around the court, m
_RADIUS = 0.36  # Radius of the circle of a player, m
_WAVE = {"dribble": (0.14, 0.7), "zigzag": (0.20, 0.45)}
"""Height and length of the waves of a dribble and the teeth of a zigzag, m."""


@dataclass(frozen=True)
class _Stroke:
    """A line of the drawing, near which the number of its step is placed."""

    points: FloatArray
    step: int


def tactics_figure(diagram: Diagram) -> Figure:
    """Return a diagram as a figure with one panel, in metres."""
    court = diagram.court
    width, height = court.width + 2 * _MARGIN, court.length + 2 * _MARGIN
    head = 0.22
    with style.drawing():
        across, high = _SCALE * width, _SCALE * height
        at = 0.02 * across, 0.012 * (high + head)
        figure = style.new_page(across, high + head, diagram.name, at, "top")
        axes = style.add_axes(figure, 0.0, 0.0, across, high, "court")
        axes.set_xlim(-width / 2, width / 2)
        axes.set_ylim(court.length - court.behind_rim + _MARGIN, -court.behind_rim - _MARGIN)
        axes.set_axis_off()
        _draw_court(axes, diagram)
        strokes = [*_draw_elements(axes, diagram)]
        _draw_players(axes, diagram, strokes)
        _number(axes, strokes, diagram)
    return figure


def _draw_court(axes: Axes, diagram: Diagram) -> None:
    from matplotlib.patches import Rectangle

    court = diagram.court
    corner = (-court.width / 2, -court.behind_rim)
    axes.add_patch(Rectangle(corner, court.width, court.length, fill=False, ec=style.FAINT, lw=1.2))
    if not court.lines:
        for name, spot in diagram.places:
            if name != "rim":
                axes.plot([spot.x], [spot.z], marker="s", ms=6, color=style.FAINT)
                axes.text(spot.x + 0.5, spot.z, name, fontsize=8, va="center", color=style.INK)
        return
    for points in court_lines(court.behind_rim, court.length):
        axes.plot(*points.T, color=style.GROUND, lw=1.0, zorder=1)
    axes.plot([-0.9, 0.9], [-0.375, -0.375], color=style.INK, lw=2.0, zorder=2)
    axes.plot(*_arc(0.225, 0.0, 360.0, 0.0).T, color=style.RIGHT, lw=1.6, zorder=2)


def _arc(radius: float, first: float, last: float, z: float) -> FloatArray:
    """Return points of an arc around (0, z), angles in degrees from +x towards +z."""
    angle = np.radians(np.linspace(first, last, 73))
    return np.stack([radius * np.cos(angle), z + radius * np.sin(angle)], axis=1)


def court_lines(behind_rim: float, length: float) -> list[FloatArray]:
    """Return the key, its circle, the three-point line, no-charge half circle, centre circle."""
    base, free, middle = -behind_rim, 5.8 - behind_rim, length - behind_rim
    side, corner = 6.6, float(np.sqrt(6.75**2 - 6.6**2))
    turn = float(np.degrees(np.arctan2(corner, side)))
    ends = np.array([[side, base]]), np.array([[-side, base]])
    three = np.concatenate([ends[0], _arc(6.75, turn, 180.0 - turn, 0.0), ends[1]])
    key = np.array([[-2.45, base], [-2.45, free], [2.45, free], [2.45, base]])
    return [
        key,
        _arc(1.8, 0.0, 180.0, free),
        three,
        _arc(1.25, 0.0, 180.0, 0.0),
        _arc(1.8, 180.0, 360.0, middle),
    ]


def _draw_elements(axes: Axes, diagram: Diagram) -> list[_Stroke]:
    """Draw all elements and return their strokes; a pass ends where its receiver catches."""
    items = expressions(diagram)
    strokes = []
    for name, row in items.items():
        colour = _colour(diagram, name)
        for item in row:
            if item.element < 0:
                continue
            element = diagram.elements[item.element]
            if element.player != name:
                continue
            ends = _link_end(diagram, items, item, element)
            points = _draw_item(axes, item, element, colour, ends)
            if len(points) > 1:
                strokes.append(_Stroke(points, element.step))
    return strokes


def _colour(diagram: Diagram, name: str) -> str:
    return style.LEFT if diagram.player[name].team == DEFENCE else style.RIGHT


def _link_end(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], item: Item, element: Element
) -> Spot | None:
    """Return the point that a pass, a shot, a guard or a block leads to."""
    if element.kind in SHOTS:
        return dict(diagram.places)["rim"]
    if element.kind == "pass":
        return items[item.other][item.other_item].way[0]
    if element.kind in STANDS:
        return _place_at(diagram, items[item.other], item.other, element.step)
    return None


def _place_at(diagram: Diagram, row: tuple[Item, ...], name: str, step: int) -> Spot:
    """Return where a player stands at a step: the end of their last move of an earlier step."""
    place = diagram.player[name].at
    for item in row:
        if item.element >= 0 and diagram.elements[item.element].step < step:
            place = item.way[-1]
    return place


def _draw_item(
    axes: Axes, item: Item, element: Element, colour: str, link: Spot | None
) -> FloatArray:
    way = smooth_curve(np.array([(spot.x, spot.z) for spot in item.way]))
    if link is not None:
        points = _shortened(np.array([way[-1], (link.x, link.z)]), element.kind)
        looks = {"pass": ((0, (5, 3)), 1.5), "shoot": ("-", 2.8), "layup": ("-", 2.8)}
        dashes, heavy = looks.get(element.kind, ((0, (1, 2)), 1.1))
        _line(axes, points, colour, dashes, heavy, arrow=element.kind not in STANDS)
    elif element.kind in FEINTS:
        if len(way) < 2:  # on the spot: a short zigzag beside the player
            way = np.array([way[0] + (0.45, 0.0), way[0] + (1.25, 0.0)])
        else:
            way = _from_circle(way)
        points = _zigzag(way)
        _line(axes, points, colour, "-", 1.6, arrow=len(item.way) > 1)
    elif len(way) < 2:  # a screen where the player stands already
        points = way
    else:
        points = _from_circle(way)
        waved = _waved(points) if item.actions == ("dribble",) else points
        _line(axes, waved, colour, "-", 1.8, arrow=element.kind != "screen")
    if element.kind == "screen" and (item.actions == ("screen",)) == (element.to is None):
        along = points[-1] - points[-8] if len(points) > 8 else np.array([0.0, 1.0])
        _t_end(axes, points[-1], along, colour)
    return points


def _t_end(axes: Axes, end: FloatArray, along: FloatArray, colour: str) -> None:
    """Draw the bar at the end of a screener's path, across it."""
    along = along / max(float(np.linalg.norm(along)), 1e-9)
    across = 0.42 * np.array([-along[1], along[0]])
    bar = np.array([end - across, end + across])
    axes.plot(*bar.T, color=colour, lw=2.4, solid_capstyle="butt", zorder=4, gid="screen")


def _from_circle(way: FloatArray) -> FloatArray:
    """Return a path without the part inside the circle that it starts from."""
    out = np.linalg.norm(way - way[0], axis=1) > _RADIUS
    return way[max(int(np.argmax(out)), 0) :] if out.any() else way


def _shortened(points: FloatArray, kind: str) -> FloatArray:
    """Return a straight link from circle to circle, or to the ring."""
    along = points[1] - points[0]
    length = max(float(np.linalg.norm(along)), 1e-9)
    end = 0.25 if kind in SHOTS else _RADIUS
    if length < _RADIUS + end + 0.1:
        return points
    along /= length
    return np.array([points[0] + _RADIUS * along, points[1] - end * along])


def _along(points: FloatArray, spacing: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points along a line at about equal distances, these distances, and normals."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, way[-1], max(int(way[-1] / spacing), 2) + 1)
    even = np.stack([np.interp(at, way, points[:, k]) for k in (0, 1)], axis=1)
    tangent = np.gradient(even, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    return even, at, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def _waved(points: FloatArray) -> FloatArray:
    """Return a line with waves, straight at its end so that an arrow fits there."""
    height, length = _WAVE["dribble"]
    even, at, normal = _along(points, 0.03)
    fade = np.clip((at[-1] - 0.45 - at) / 0.2, 0.0, 1.0) * np.clip(at / 0.2, 0.0, 1.0)
    return even + (height * fade * np.sin(2.0 * np.pi * at / length))[:, None] * normal


def _zigzag(points: FloatArray) -> FloatArray:
    """Return a line with teeth; its ends are kept."""
    height, length = _WAVE["zigzag"]
    even, _, normal = _along(points, length / 2.0)
    side = np.where(np.arange(len(even)) % 2, 1.0, -1.0) * height
    side[[0, -1]] = 0.0
    return even + side[:, None] * normal


def _line(
    axes: Axes,
    points: FloatArray,
    colour: str,
    dashes: object,
    width: float,
    arrow: bool,
) -> None:
    """Draw a line; with an arrow its end is the tip of the arrow."""
    axes.plot(
        *points.T, color=colour, lw=width, ls=dashes, zorder=3, solid_joinstyle="miter", gid="line"
    )
    if arrow:
        behind = points[-1] - points[max(len(points) - 8, 0)]
        behind = behind / max(float(np.linalg.norm(behind)), 1e-9)
        axes.annotate(
            "",
            xy=tuple(points[-1] + 0.1 * behind),
            xytext=tuple(points[-1] - 0.12 * behind),
            arrowprops={
                "arrowstyle": "-|>,head_width=0.32,head_length=0.5",
                "color": colour,
                "lw": width,
                "shrinkA": 0,
                "shrinkB": 0,
            },
            zorder=4,
        )


def _draw_players(axes: Axes, diagram: Diagram, strokes: list[_Stroke]) -> None:
    from matplotlib.patches import Circle

    for player in diagram.players:
        at = (player.at.x, player.at.z)
        colour = _colour(diagram, player.name)
        if player.team == DEFENCE:
            reach = 0.62 * _RADIUS
            for sign in (-1.0, 1.0):
                xs = [at[0] - reach, at[0] + reach]
                axes.plot(xs, [at[1] - sign * reach, at[1] + sign * reach], color=colour, lw=2.4)
            x, z = _freest_corner(np.array(at), strokes, diagram)
            style.write(axes, x, z, player.name, 8.5, color=colour, zorder=6)
            continue
        axes.add_patch(Circle(at, _RADIUS, fc="white", ec=colour, lw=1.8, zorder=5, gid="player"))
        style.write(axes, *at, player.name, 8.5, color=colour, zorder=6)


def _freest_corner(at: FloatArray, strokes: list[_Stroke], diagram: Diagram) -> FloatArray:
    """Return the place beside a cross where a name is farthest from lines and players."""
    corners = at + 0.52 * np.array([[1, -0.75], [1, 0.75], [-1, -0.75], [-1, 0.75]])
    taken = [np.array([(p.at.x, p.at.z) for p in diagram.players])]
    taken += [_along(stroke.points, 0.2)[0] for stroke in strokes]
    apart = np.linalg.norm(corners[:, None] - np.concatenate(taken)[None], axis=2)
    return np.asarray(corners[int(np.argmax(apart.min(axis=1)))])


def _number(axes: Axes, strokes: list[_Stroke], diagram: Diagram) -> None:
    """Write the step of every stroke near its middle, off the lines and the players."""
    if not strokes:
        return
    to_pixels = axes.transData
    middles = np.array([s.points[len(s.points) // 2] for s in strokes])
    straight = [len(s.points) == 2 for s in strokes]
    for number, stroke in enumerate(strokes):
        if straight[number]:
            middles[number] = stroke.points.mean(axis=0)
    obstacles = [np.array([(p.at.x, p.at.z) for p in diagram.players])]
    obstacles += [_along(s.points, 0.35)[0] for s in strokes]
    taken = to_pixels.transform(np.concatenate(obstacles))
    pixels = to_pixels.transform(middles)
    size = 13.0 * axes.figure.dpi / 110.0
    sizes = np.concatenate([np.full((len(pixels), 2), size), np.full((len(taken), 2), 1.0)])
    low, high = axes.transAxes.transform([(0.0, 0.0), (1.0, 1.0)])
    every = np.concatenate([pixels, taken])
    places = place_labels(every, sizes, 4.0, low, high)[: len(pixels)]
    for stroke, place in zip(strokes, to_pixels.inverted().transform(places), strict=True):
        style.write(axes, place[0], place[1], str(stroke.step), 8, zorder=7, gid="step")
