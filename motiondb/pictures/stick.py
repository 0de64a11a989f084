"""Stick figures: projection of a motion by a camera, and drawing of a figure on axes.

The camera has the azimuth a (0: on +z, which a figure in rest pose faces) and an elevation of 10
degrees; the projection is parallel, so that proportions are true. With c = (sin a, 0, cos a)
towards the camera and e the elevation, a point p is drawn at x = p . (cos a, 0, -sin a) and
y = p_y cos e - (p . c) sin e. Every frame is projected relative to the place of the pelvis on the
ground; the path of the root is shown by the place of the figure in the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body import body, kinematics, rotation
from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.records import FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ELEVATION = np.deg2rad(10.0)  # e, radians
HEAD_RADIUS = 0.105  # Radius of the disc that is the head, metres

_N_JOINTS = len(body.JOINTS)
_END_PARENTS: IntArray = np.array([joint for joint, _ in body.END_SITES])
_END_OFFSETS: FloatArray = np.array([offset for _, offset in body.END_SITES])
_HEAD = body.INDEX["head"]
_HEAD_END = _N_JOINTS + [joint for joint, _ in body.END_SITES].index(_HEAD)
_PARENTS: IntArray = np.concatenate([body.PARENTS, _END_PARENTS])
_NAMES = (*body.JOINTS, *(body.JOINTS[joint] for joint in _END_PARENTS))
BONES: tuple[tuple[int, int], ...] = tuple(
    (int(parent), child)
    for child, parent in enumerate(_PARENTS)
    if parent >= 0 and child not in (_HEAD_END, _HEAD)
)  # (from, to) of every line of a figure; the head is a disc


@dataclass(frozen=True, eq=False)
class View:
    """A projected motion."""

    # (frames, joints and end sites, 2): right and up, metres; the origin is on the ground under the
    # pelvis
    points: FloatArray
    depths: FloatArray  # (frames, joints and end sites): distance towards the camera, metres
    # (frames, 2): place of the pelvis on the ground, right and towards the camera, metres
    track: FloatArray

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.points)

    @property
    def width(self) -> float:
        """Width of a figure, metres: its 90th percentile over frames."""
        x = self.points[..., 0]
        return float(np.quantile(x.max(axis=1) - x.min(axis=1), 0.9)) + 0.1

    @property
    def top(self) -> float:
        """Height of the highest point of any frame, metres."""
        return float(self.points[..., 1].max()) + HEAD_RADIUS


def check_motion(motion: Motion, where: str = "picture") -> None:
    """Refuse a motion without frames or with values that are not finite."""
    if motion.n_frames == 0:
        raise MotionDBError(
            f"{where}: expected a motion of at least 1 frame, found 0. Choose a longer interval."
        )
    if not (np.isfinite(motion.local_rotations).all() and np.isfinite(motion.root_positions).all()):
        raise MotionDBError(
            f"{where}: expected finite rotations and positions, found NaN or infinity. "
            "Add the capture again."
        )


def view_motion(motion: Motion, azimuth: float | None = None) -> View:
    """Project a motion."""
    check_motion(motion)
    places = world_points(motion)
    azimuth = best_azimuth(places) if azimuth is None else azimuth
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    towards = np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
    ground = places[:, :1] * np.array([1.0, 0.0, 1.0])
    local = places - ground
    near = local @ towards
    points = np.stack(
        [local @ right, local[..., 1] * np.cos(ELEVATION) - near * np.sin(ELEVATION)], axis=-1
    )
    depths = near * np.cos(ELEVATION) + local[..., 1] * np.sin(ELEVATION)
    track = np.stack([ground[:, 0] @ right, ground[:, 0] @ towards], axis=-1)
    return View(points, depths, track)


def world_points(motion: Motion) -> FloatArray:
    """Positions of joints, then of end sites: array (frames, 26, 3), metres."""
    positions, rotations = kinematics.forward(
        body.PARENTS,
        body.OFFSETS,
        motion.local_rotations.astype(np.float64),
        motion.root_positions.astype(np.float64),
    )
    shape = (len(positions), len(_END_PARENTS), 3)
    offsets = rotation.rotate(rotations[:, _END_PARENTS], np.broadcast_to(_END_OFFSETS, shape))
    return np.concatenate([positions, positions[:, _END_PARENTS] + offsets], axis=1)


def best_azimuth(places: FloatArray) -> float:
    """Of four views beside the mean heading, radians, the one that shows most movement."""
    across = places[:, body.INDEX["l_hip"]] - places[:, body.INDEX["r_hip"]]
    facing = np.arctan2((-across[:, 2]).sum(), across[:, 0].sum())
    local = places - places[:, :1]
    turns = np.deg2rad([35.0, -35.0, 55.0, -55.0])
    azimuths = facing + turns
    across_view = np.stack([np.cos(azimuths), np.zeros(4), -np.sin(azimuths)])
    spread = np.std(local @ across_view, axis=0).mean(axis=0)
    return float(azimuths[int(np.argmax(np.round(spread, 6)))])


def bone_colour(child: int) -> str:
    """Colour of the line that ends at a joint or end site, by the side of the body."""
    name = _NAMES[child]
    return {"l_": style.LEFT, "r_": style.RIGHT}.get(name[:2], style.TRUNK)


def head_centre(points: FloatArray) -> FloatArray:
    """Centre of the head: array (..., 2), from `points` (..., 26, 2)."""
    return (points[..., _HEAD, :] + points[..., _HEAD_END, :]) / 2.0


def draw_figure(axes: Axes, view: View, frame: int, x: float, line_width: float = 2.2) -> None:
    """Draw one frame on axes in metres, far limbs first."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle, Ellipse

    points = view.points[frame] + np.array([x, 0.0])
    depth = view.depths[frame]
    order = sorted(BONES, key=lambda bone: float(depth[bone[0]] + depth[bone[1]]))
    axes.add_artist(
        Ellipse((x, 0.0), 0.62, 0.62 * np.sin(ELEVATION), color=style.SHADOW, lw=0, zorder=1)
    )
    lines = LineCollection(
        [points[list(bone)] for bone in order],
        colors=[bone_colour(child) for _, child in order],
        linewidths=line_width,
        capstyle="round",
        joinstyle="round",
        zorder=3,
        gid="figure",
        clip_on=False,
    )
    axes.add_collection(lines, autolim=False)
    axes.add_artist(
        Circle(
            tuple(head_centre(points)),
            HEAD_RADIUS,
            facecolor="white",
            edgecolor=style.TRUNK,
            linewidth=line_width * 0.8,
            zorder=3.5,
            clip_on=False,
        )
    )
