"""A tactics diagram as coaches draw it, on its ground seen from above.

Players are circles, those of the grammar's second role crosses, with their names. A solid curve
with an arrow is a way, a waved one a way with the object, and one that ends in a T leads to
something that is done there. A dashed arrow is something given, a heavy straight one something sent
to its target, a short zigzag something done in place. A dotted line leads to the other player of an
element. Numbers are the steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motiondb.pictures import style
from motiondb.pictures.space import place_labels
from motiondb.records import FloatArray
from motiondb.scene.language.activity import GIVE, KEEPING, SEND
from motiondb.scene.language.expressions import Item, expressions, smooth_curve
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import Diagram, Element

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SCALE = 0.5  # Inches a metre
_MARGIN = 0.6  # Margin around the court, m
_RADIUS = 0.36  # Radius of the circle of a player, m
_WAVE = {"wave": (0.14, 0.7), "zigzag": (0.20, 0.45)}
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
        left, right, back, front = court.corners
        axes.set_xlim(left - _MARGIN, right + _MARGIN)
        axes.set_ylim(front + _MARGIN, back - _MARGIN)
        axes.set_axis_off()
        _draw_court(axes, diagram)
        strokes = [*_draw_elements(axes, diagram)]
        _draw_players(axes, diagram, strokes)
        _number(axes, strokes, diagram)
    return figure


def _draw_court(axes: Axes, diagram: Diagram) -> None:
    from matplotlib.patches import Rectangle

    court = diagram.court
    corner = (court.left, court.back)
    axes.add_patch(Rectangle(corner, court.width, court.length, fill=False, ec=style.FAINT, lw=1.2))
    if diagram.ground is None:
        for mark in court.marks:
            points = np.array(mark)
            raised = bool((points[:, 1] > 0.0).any())
            look = (style.INK, 2.0) if raised else (style.GROUND, 1.0)
            axes.plot(points[:, 0], points[:, 2], color=look[0], lw=look[1], zorder=1 + raised)
    for name, spot in diagram.places:
        place = diagram.activity.place.get(name)
        if place is not None and place.width and not place.is_upright:
            ring = np.linspace(0.0, 2.0 * np.pi, 73)
            x, z = spot.x + place.width / 2 * np.cos(ring), spot.z + place.width / 2 * np.sin(ring)
            axes.plot(x, z, color=style.RIGHT, lw=1.6, zorder=2)
        elif place is not None and place.width:
            ends = [spot.x - place.width / 2, spot.x + place.width / 2]
            axes.plot(ends, [spot.z, spot.z], color=style.RIGHT, lw=2.4, zorder=2)
        else:
            axes.plot([spot.x], [spot.z], marker="s", ms=6, color=style.FAINT)
        if place is None or place.at is None:
            axes.text(spot.x + 0.5, spot.z, name, fontsize=8, va="center", color=style.INK)


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
            look = _look(diagram, item, element)
            points = _draw_item(axes, item, element, (colour, look), ends)
            if len(points) > 1:
                strokes.append(_Stroke(points, element.step))
    return strokes


def is_second(diagram: Diagram, name: str) -> bool:
    """Return whether a player has the second role of the grammar, as defenders in a game."""
    roles = [role for role, _ in diagram.activity.roles]
    return diagram.player[name].team in roles[1:2]


def _colour(diagram: Diagram, name: str) -> str:
    return style.LEFT if is_second(diagram, name) else style.RIGHT


def _look(diagram: Diagram, item: Item, element: Element) -> str:
    """Return how an item is drawn, see :mod:`motiondb.scene.language.activity`."""
    activity = diagram.activity
    keeps = any(activity.deed(action) in KEEPING for action in item.actions)
    look = activity.look(element.kind, keeps)
    if look == "act" and element.to and item.repeated:
        return "wave" if keeps else "way"
    if look in ("way", "link") and len(diagram.verb(element).steps) > 1:
        return "bar"
    return "link" if look == "act" and element.other and len(item.way) < 2 else look


def _link_end(
    diagram: Diagram, items: dict[str, tuple[Item, ...]], item: Item, element: Element
) -> Spot | None:
    """Return the point that a straight line of an element leads to."""
    look = _look(diagram, item, element)
    if look == SEND:
        name = item.target or diagram.activity.aim(item.actions[0])
        return (
            dict(diagram.places).get(name)
            if name or not item.other
            else _other(diagram, items, item)
        )
    if look in (GIVE, "link") and item.other:
        return _other(diagram, items, item)
    return dict(diagram.places).get(item.target) if look == "link" else None


def _other(diagram: Diagram, items: dict[str, tuple[Item, ...]], item: Item) -> Spot:
    """Return where the other player of an item is then."""
    if item.other_item >= 0:
        return items[item.other][item.other_item].way[0]
    return _place_at(diagram, items[item.other], item.other, diagram.elements[item.element].step)


def _place_at(diagram: Diagram, row: tuple[Item, ...], name: str, step: int) -> Spot:
    """Return where a player stands at a step: the end of their last move of an earlier step."""
    place = diagram.player[name].at
    for item in row:
        if item.element >= 0 and diagram.elements[item.element].step < step:
            place = item.way[-1]
    return place


def _draw_item(
    axes: Axes, item: Item, element: Element, drawn: tuple[str, str], link: Spot | None
) -> FloatArray:
    colour, look = drawn
    way = smooth_curve(np.array([(spot.x, spot.z) for spot in item.way]))
    if link is not None:
        points = _shortened(np.array([way[-1], (link.x, link.z)]), look)
        looks = {GIVE: ((0, (5, 3)), 1.5), SEND: ("-", 2.8)}
        dashes, heavy = looks.get(look, ((0, (1, 2)), 1.1))
        _line(axes, points, colour, dashes, heavy, arrow=look != "link")
    elif look == "act":
        if len(way) < 2:  # on the spot: a short zigzag beside the player
            way = np.array([way[0] + (0.45, 0.0), way[0] + (1.25, 0.0)])
        else:
            way = _from_circle(way)
        points = _zigzag(way)
        _line(axes, points, colour, "-", 1.6, arrow=len(item.way) > 1)
    elif len(way) < 2:  # something done where the player stands already
        points = way
    else:
        points = _from_circle(way)
        waved = _waved(points) if look == "wave" else points
        _line(axes, waved, colour, "-", 1.8, arrow=look != "bar")
    if look == "bar" and bool(item.other or item.target) == (element.to is None):
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


def _shortened(points: FloatArray, look: str) -> FloatArray:
    """Return a straight link from circle to circle, or to the target."""
    along = points[1] - points[0]
    length = max(float(np.linalg.norm(along)), 1e-9)
    end = 0.25 if look == SEND else _RADIUS
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
    height, length = _WAVE["wave"]
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
        if is_second(diagram, player.name):
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
