"""A scene as an animated GIF, from above or from the front, and as paths over its diagram.

The camera in front is behind the play and above it, looks up the diagram, and is far away (no
perspective): a point (x, y, z) is drawn at x to the right and y cos e - z sin e upwards, where e is
the elevation. From above, a character is a disc with a nose that shows where the body faces, and
its feet. Both run in real time, and both show ground, object, its shadow and names. They are drawn
with Pillow alone, like animations of single motions (:mod:`.animation`).

The paths of all characters and of the object lie over the faint diagram that they play. A path has
the colour of its character, begins at a ring and ends at a dot. Small dots are full seconds, and
short strokes show where the body faces then. The path of the object is orange, and dashed where it
is faster than anybody carries it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.body import body, retarget, rotation
from motiondb.body.pose_vectors import heading_rotations
from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.pictures.animation import (
    FINE,
    in_one_palette,
    paint_body,
    paint_disc,
    shown_frames,
)
from motiondb.pictures.stick import HEAD_RADIUS, check_motion, head_centre, world_points
from motiondb.pictures.tactics import is_second, tactics_figure
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.language.activity import Place
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import Diagram

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont, ImageFont

ELEVATION = np.deg2rad(28.0)
"""Elevation of the camera, rad, so that players hide one another seldom."""
_MAX_SECONDS = 120.0  # Longest animation, s; a longer one would take hundreds of megabytes
_MARGIN = 0.9  # Margin around all that moves, m
_OVER = 0.9  # Margin above what stands on the ground, m
_BODY, _NOSE = 0.22, 0.36  # Radius of a body from above, and the distance of the tip of its nose, m
BALL = "#C9641B"  # Colour of the ball and its path
WARM = ("#D55E00", "#AA3377", "#B8860B", "#882255", "#E0803A")
COLD = ("#0072B2", "#009E73", "#332288", "#56B4E9", "#117733")
_FAINT = 0.28  # Opacity of the diagram
_FLIGHT = 4.5  # Speed over the ground, m/s, above which the ball counts as flying
_FACING = 0.45  # Length of the stroke that shows where a player faces, m
_FEET = [body.INDEX[name] for name in ("l_ankle", "r_ankle")]


@dataclass(frozen=True, eq=False)
class _Stage:
    """What is drawn, and how metres become pixels (of the finer picture)."""

    names: tuple[str, ...]  # Names of the characters
    colours: tuple[str, ...]
    points: FloatArray  # (characters, frames, joints and ends, 3), m: joints in the world
    facing: FloatArray  # (characters, frames), rad: headings
    looking: FloatArray  # (characters, frames, 3): unit vectors along which heads look
    ball: FloatArray | None  # (frames, 3) or None, m: centre of the object
    radius: float  # Of the object, m
    # (3,): how far up in the picture a metre along each axis goes; from above (0, 0, -1)
    up: FloatArray
    scale: float
    left_top: FloatArray  # (2,), m: the corner of the picture
    size: tuple[int, int]  # Width and height, pixels

    @property
    def above(self) -> bool:
        """Whether the camera looks straight down."""
        return self.up[1] == 0.0

    def pixels(self, points: FloatArray) -> FloatArray:
        """Return the pixels of points (..., 3)."""
        flat = _flat(points, self.up)
        return np.asarray((flat - self.left_top) * np.array([self.scale, -self.scale]))


def _flat(points: FloatArray, up: FloatArray) -> FloatArray:
    """Return right and up, m, of points (..., 3)."""
    return np.stack([points[..., 0], points @ up], axis=-1)


def draw_scene_animation(
    diagram: Diagram,
    performers: Mapping[str, Motion],
    path: str | Path,
    ball: FloatArray | None = None,
    *,
    above: bool = False,
    width: int = 640,
) -> Path:
    """Write a scene as an animated GIF, 20 pictures a second; who has ended stands still."""
    path = style.check_gif(path)
    images = scene_images(diagram, performers, ball, above=above, width=width)
    return style.save_gif(images, path)


def scene_images(
    diagram: Diagram,
    performers: Mapping[str, Motion],
    ball: FloatArray | None = None,
    *,
    above: bool = False,
    width: int = 640,
) -> list[Image]:
    """Return the pictures of an animation, one for every twentieth of a second, in one palette."""
    check_performers(diagram, performers)
    stage = _stage(diagram, performers, ball, above, width)
    frames = shown_frames(stage.points.shape[1], _MAX_SECONDS, "Make a shorter scene.")
    ground = _ground(stage, diagram)
    pictures = [_picture(stage, ground, int(frame)) for frame in frames]
    return in_one_palette(pictures, pictures[len(pictures) // 2], 96)


def _stage(
    diagram: Diagram,
    performers: Mapping[str, Motion],
    ball: FloatArray | None,
    above: bool,
    width: int,
) -> _Stage:
    n = max(motion.n_frames for motion in performers.values())
    points = np.stack([_held(world_points(motion), n) for motion in performers.values()])
    facing = np.stack([_held(heading_rotations(motion)[1], n) for motion in performers.values()])
    looking = np.stack([_held(_looking(motion), n) for motion in performers.values()])
    ball = None if ball is None or not len(ball) else _held(np.asarray(ball, dtype=float), n)
    up = np.array([0.0, 0.0, -1.0])
    if not above:
        up = np.array([0.0, np.cos(ELEVATION), -np.sin(ELEVATION)])
    ground = points[:, :, 0] * np.array([1.0, 0.0, 1.0])
    seen = [_flat(points, up).reshape(-1, 2), _flat(ground, up).reshape(-1, 2)]
    standing = [line for line in _lines(diagram) if (line[:, 1] > 0.0).any()]
    over = np.array([0.0, _OVER, 0.0])
    seen += [_flat(part, up) for line in standing for part in (line + over, line)]
    sized = [(diagram.activity.place.get(name), spot) for name, spot in diagram.places]
    seen += [_flat(outline(place, spot), up) for place, spot in sized if place and place.width]
    low = np.concatenate(seen).min(axis=0) - _MARGIN
    high = np.concatenate(seen).max(axis=0) + _MARGIN
    wide = max(high[0] - low[0], 0.75 * (high[1] - low[1]), 4.0)
    middle = (low[0] + high[0]) / 2.0
    scale = width * FINE / wide
    size = (width * FINE, FINE * max(round((high[1] - low[1]) * scale / FINE), 32))
    left_top = np.array([middle - wide / 2.0, high[1]])
    colours = performer_colours(diagram)
    return _Stage(
        tuple(performers),
        tuple(colours[name] for name in performers),
        points,
        facing,
        looking,
        ball,
        (diagram.activity.thing.size if diagram.activity.thing else 0.24) / 2.0,
        up,
        scale,
        left_top,
        size,
    )


def _looking(motion: Motion) -> FloatArray:
    """Return unit vectors (frames, 3) along which a head looks."""
    _, turned = retarget.motion_positions(motion)
    head = turned[:, body.INDEX["head"]]
    return rotation.rotate(head, np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(head), 3)))


def _held(values: FloatArray, n: int) -> FloatArray:
    """Return the values with the last row repeated until there are ``n``."""
    rows: IntArray = np.minimum(np.arange(n), len(values) - 1)
    return np.asarray(values)[rows]


def _ground(stage: _Stage, diagram: Diagram) -> Image:
    """Return a picture of the ground with what stands on it, which does not move."""
    from PIL import Image as PilImage
    from PIL import ImageDraw as PilDraw

    image = PilImage.new("RGB", stage.size, "white")
    draw = PilDraw.Draw(image)
    left, right, back, front = diagram.court.corners
    x, z = [left, right, right, left, left], [back, back, front, front, back]
    _line(draw, stage.pixels(np.stack([x, np.zeros(5), z], axis=1)), style.GROUND, 1.2)
    for line in _lines(diagram):
        raised = bool((line[:, 1] > 0.0).any())
        look = (style.FAINT, 1.8) if raised else (style.GROUND, 1.2)
        _line(draw, stage.pixels(line), *look)
    for name, spot in diagram.places:
        place = diagram.activity.place.get(name, Place(name))
        if place.width:
            _line(draw, stage.pixels(outline(place, spot)), style.RIGHT, 2.0)
        if place.at is None:
            x, y = stage.pixels(np.array([spot.x, 0.0, spot.z]))
            if not place.width:
                draw.rectangle((x - 5, y - 5, x + 5, y + 5), fill=style.FAINT)
            draw.text((x + 9, y - 9), name, fill=style.INK, font=_font(18))
    return image


def _lines(diagram: Diagram) -> list[FloatArray]:
    """Return the marks of the ground, and the legs of level places at a height, (points, 3), m."""
    lines = [np.array(mark) for mark in diagram.court.marks] if diagram.ground is None else []
    for name, spot in diagram.places:
        place = diagram.activity.place.get(name)
        if place is not None and place.at is None and place.width and not place.is_upright:
            for x in (spot.x - place.width / 2, spot.x + place.width / 2):
                lines.append(np.array([[x, 0.0, spot.z], [x, place.height, spot.z]]))
    return lines


def outline(place: Place, spot: Spot) -> FloatArray:
    """Return the edge of a place with a size, (points, 3), m: a disc, or an upright rectangle."""
    if place.is_upright:
        half, up = place.width / 2, place.tall / 2
        corners = [(-half, -up), (half, -up), (half, up), (-half, up), (-half, -up)]
        rows = [(spot.x + dx, place.height + dy, spot.z) for dx, dy in corners]
        return np.array(rows)
    turn = np.linspace(0.0, 2 * np.pi, 25)
    x, z = place.width / 2 * np.cos(turn), place.width / 2 * np.sin(turn)
    return np.stack([spot.x + x, np.full(25, place.height), spot.z + z], axis=1)


def _picture(stage: _Stage, ground: Image, frame: int) -> Image:
    from PIL import ImageDraw as PilDraw

    image = ground.copy()
    draw = PilDraw.Draw(image)
    roots = stage.points[:, frame, 0]
    for root in roots:
        _disc(draw, stage, root * np.array([1.0, 0.0, 1.0]), 0.28, style.SHADOW)
    ball = None if stage.ball is None else stage.ball[frame]
    if ball is not None:
        _disc(draw, stage, ball * np.array([1.0, 0.0, 1.0]), stage.radius, style.FAINT)
    order = [(float(roots[k, 2]), k) for k in range(len(roots))]
    if ball is not None:
        order.append((float(ball[2]) if not stage.above else 99.0, -1))
    for _, k in sorted(order):
        if k < 0:
            assert ball is not None
            _ball(draw, stage, ball)
        elif stage.above:
            _from_above(draw, stage, k, frame)
        else:
            _figure(draw, stage, k, frame)
    draw.text((12, 8), f"{frame / MOTION_FPS:.1f} s", fill=style.INK, font=_font(24))
    return image.reduce(FINE)


def _disc(draw: ImageDraw, stage: _Stage, at: FloatArray, radius: float, colour: str) -> None:
    """Draw a disc on the ground, foreshortened as the camera sees it."""
    x, y = stage.pixels(at)
    r = radius * stage.scale
    flat = r * -float(stage.up[2])
    draw.ellipse((x - r, y - flat, x + r, y + flat), fill=colour)


def _ball(draw: ImageDraw, stage: _Stage, at: FloatArray) -> None:
    radius = max(stage.radius * stage.scale, 4.0)
    paint_disc(draw, stage.pixels(at), radius, fill=BALL, outline=style.INK, width=FINE)


def _figure(draw: ImageDraw, stage: _Stage, k: int, frame: int) -> None:
    """Draw a stick figure, far limbs first, with the name above."""
    world, colour = stage.points[k, frame], stage.colours[k]
    points, radius = stage.pixels(world), HEAD_RADIUS * stage.scale
    thick = max(2, round(0.06 * stage.scale))
    paint_body(draw, points, world[:, 2], radius, thick, lambda _: colour, (colour, thick))
    x, y = head_centre(points)
    tip = stage.pixels(head_centre(world) + 0.17 * stage.looking[k, frame])
    _line(draw, np.array([[x, y], tip]), colour, thick / FINE)
    _name(draw, (x, y - radius - 12 * FINE), stage.names[k], colour)


def _from_above(draw: ImageDraw, stage: _Stage, k: int, frame: int) -> None:
    """Draw feet, a disc with a nose, and the name in it."""
    world, facing = stage.points[k, frame], stage.facing[k, frame]
    colour = stage.colours[k]
    for foot in _FEET:
        _disc(draw, stage, world[foot], 0.07, colour)
    nose = np.array([np.sin(facing), 0.0, np.cos(facing)])
    x, y = stage.pixels(world[0])
    _line(draw, np.array([[x, y], stage.pixels(world[0] + _NOSE * nose)]), colour, 4.0)
    for wrist in ("l_wrist", "r_wrist"):
        hand = stage.pixels(np.array([world[body.INDEX["neck"]], world[body.INDEX[wrist]]]))
        _line(draw, hand, colour, 2.0)
    look = {"fill": "white", "outline": colour, "width": 2 * FINE}
    paint_disc(draw, np.array([x, y]), _BODY * stage.scale, **look)
    _name(draw, (x, y), stage.names[k], colour)


def _name(draw: ImageDraw, at: tuple[float, float], name: str, colour: str) -> None:
    draw.text(at, name, fill=colour, font=_font(11 * FINE), anchor="mm")


def _font(size: int) -> FreeTypeFont | ImageFont:
    from PIL import ImageFont

    return ImageFont.load_default(size=size)


def _line(draw: ImageDraw, points: FloatArray, colour: str, width: float) -> None:
    draw.line([tuple(p) for p in points], fill=colour, width=max(1, round(width * FINE)))


def performer_colours(diagram: Diagram) -> dict[str, str]:
    """Return a colour for every player: cold ones for the second role, warm ones for all others."""
    counts = {True: 0, False: 0}
    colours = {}
    for player in diagram.players:
        defends = is_second(diagram, player.name)
        tints = COLD if defends else WARM
        colours[player.name] = tints[counts[defends] % len(tints)]
        counts[defends] += 1
    return colours


def check_performers(diagram: Diagram, performers: Mapping[str, Motion]) -> None:
    """Refuse no characters, and names that are not in the diagram."""
    if not performers:
        raise MotionDBError(
            "picture: expected at least 1 character, found 0. Make the scene again."
        )
    for name, motion in performers.items():
        if name not in diagram.player:
            known = ", ".join(diagram.player)
            raise MotionDBError(
                f"{name}: expected a player of the diagram ({known}), found another."
                " Name its own diagram."
            )
        check_motion(motion, name)


def scene_paths_figure(
    diagram: Diagram, performers: Mapping[str, Motion], ball: FloatArray | None = None
) -> Figure:
    """Return the paths over the diagram as a figure with one panel, in metres."""
    check_performers(diagram, performers)
    figure = tactics_figure(diagram)
    axes = figure.axes[0]
    for artist in axes.get_children():
        artist.set_alpha(_FAINT)
        arrow = getattr(artist, "arrow_patch", None)
        if arrow is not None:
            arrow.set_alpha(_FAINT)
    colours = performer_colours(diagram)
    with style.drawing():
        for name, motion in performers.items():
            _draw_way(axes, motion, colours[name], name)
        if ball is not None and len(ball):
            _draw_ball_path(axes, ball)
    return figure


def _draw_way(axes: Axes, motion: Motion, colour: str, name: str) -> None:
    way = motion.root_positions[:, [0, 2]].astype(float)
    facing = heading_rotations(motion)[1]
    axes.plot(*way.T, color=colour, lw=1.8, zorder=8, solid_capstyle="round", gid=f"way {name}")
    seconds = np.arange(0, len(way), round(MOTION_FPS))
    for frame in seconds:
        along = _FACING * np.array([np.sin(facing[frame]), np.cos(facing[frame])])
        axes.plot(*np.array([way[frame], way[frame] + along]).T, color=colour, lw=0.9, zorder=8)
    axes.plot(*way[seconds].T, ls="", marker="o", ms=2.6, color=colour, zorder=9)
    axes.plot(*way[:1].T, ls="", marker="o", ms=7, mfc="white", mec=colour, mew=1.6, zorder=9)
    axes.plot(*way[-1:].T, ls="", marker="o", ms=6, color=colour, zorder=9)
    look: Any = {"color": colour, "fontsize": 8, "fontweight": "bold", "zorder": 11}
    axes.annotate(name, way[-1], xytext=(5, -7), textcoords="offset points", **look)


def _draw_ball_path(axes: Axes, ball: FloatArray) -> None:
    ground = np.asarray(ball, dtype=float)[:, [0, 2]]
    speed = np.linalg.norm(np.diff(ground, axis=0), axis=1) * MOTION_FPS
    flies = np.concatenate([speed > _FLIGHT, [False]])
    for flying, look in ((False, "-"), (True, (0, (3, 2)))):
        drawn = ground.copy()
        hidden = flies != flying
        hidden[1:] &= hidden[:-1]  # both ends of a flight belong to it
        drawn[hidden] = np.nan
        axes.plot(*drawn.T, color=BALL, lw=1.3, ls=look, zorder=10, gid="ball")
