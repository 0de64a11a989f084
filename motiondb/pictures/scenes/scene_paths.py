"""A scene from above: the paths of all characters and of the ball over the diagram that they play.

The diagram is faint in the background. A path has the colour of its character, begins at a ring and
ends at a dot. Small dots are full seconds, and short strokes show where the body faces then. The
path of the ball is orange, and dashed where it is faster than anybody carries it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body.pose_vectors import heading_rotations
from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.pictures.scenes.tactics import tactics_figure
from motiondb.pictures.stick import check_motion
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.language.tactics import DEFENCE, Diagram

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BALL = "#C9641B"
"""Colour of the ball and its path."""
ATTACKERS = ("#D55E00", "#AA3377", "#B8860B", "#882255", "#E0803A")
DEFENDERS = ("#0072B2", "#009E73", "#332288", "#56B4E9", "#117733")
_FAINT = 0.28  # Opacity of the diagram
_FLIGHT = 4.5  # Speed over the ground, m/s, above which the ball counts as flying
_FACING = 0.45  # Length of the stroke that shows where a player faces, m


def performer_colours(diagram: Diagram) -> dict[str, str]:
    """Return a colour for every player: warm ones attack, cold ones defend."""
    counts = {True: 0, False: 0}
    colours = {}
    for player in diagram.players:
        defends = player.team == DEFENCE
        tints = DEFENDERS if defends else ATTACKERS
        colours[player.name] = tints[counts[defends] % len(tints)]
        counts[defends] += 1
    return colours


def draw_scene_paths(
    diagram: Diagram,
    performers: Mapping[str, Motion],
    path: str | Path,
    ball: FloatArray | None = None,
) -> Path:
    """Write the paths over the diagram as PNG; return the file's path; `ball` (frames, 3), m."""
    return style.save_png(scene_paths_figure(diagram, performers, ball), path)


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
            _draw_ball(axes, ball)
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
    axes.annotate(
        name,
        way[-1],
        xytext=(5, -7),
        textcoords="offset points",
        color=colour,
        fontsize=8,
        fontweight="bold",
        zorder=11,
    )


def _draw_ball(axes: Axes, ball: FloatArray) -> None:
    ground = np.asarray(ball, dtype=float)[:, [0, 2]]
    speed = np.linalg.norm(np.diff(ground, axis=0), axis=1) * MOTION_FPS
    flies = np.concatenate([speed > _FLIGHT, [False]])
    for flying, look in ((False, "-"), (True, (0, (3, 2)))):
        drawn = ground.copy()
        hidden = flies != flying
        hidden[1:] &= hidden[:-1]  # both ends of a flight belong to it
        drawn[hidden] = np.nan
        axes.plot(*drawn.T, color=BALL, lw=1.3, ls=look, zorder=10, gid="ball")
