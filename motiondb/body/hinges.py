"""Robots: trees of rigid links that hinges and slides move, and their forward kinematics.

Notation: link l stands at the place p_l, turned by R_l, in the frame of its parent. Each of its
joints, in order, turns it by the angle q - ref about an axis through a point of the link, or slides
it along the axis; both are given in the link's own frame. So the transform of a link is
T(p) R T(a_1) R(axis_1, q_1) T(-a_1) T(a_2) ... as in MuJoCo; the joints of URDF have a = 0.

World frames of robots have z up. :func:`to_clip` turns them so that y is up, and gives all links
frames that are parallel in the pose in which all joints are 0, so that other formats can hold them.

Source: MuJoCo documentation, "Computation", kinematics (https://mujoco.readthedocs.io); URDF
(https://wiki.ros.org/urdf/XML/joint).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.body import kinematics, rotation, world
from motiondb.body.robot_names import is_named, missing_neck
from motiondb.records import Clip, FloatArray, IntArray, Skeleton


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint with one degree of freedom, which moves a link."""

    name: str
    link: int  # The link that it moves
    axis: tuple[float, float, float]  # Unit vector in the frame of the link
    anchor: tuple[float, float, float] = (0.0, 0.0, 0.0)  # A point of the axis, metres
    slides: bool = False  # Along the axis, metres, in place of turning about it, radians
    limits: tuple[float, float] | None = None  # Radians or metres
    ref: float = 0.0  # The value at which the link stands as the model says
    # (number of another joint, a, b): its value is a times that of the other, plus b
    mimics: tuple[int, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Robot:
    """The links and joints of a robot, whose first link moves freely."""

    name: str
    links: tuple[str, ...]  # Names; parents come before children
    parents: IntArray  # (links,): -1 for the first
    places: FloatArray  # (links, 3): metres, in the frame of the parent
    turns: FloatArray  # (links, 4): in the frame of the parent
    joints: tuple[Joint, ...]  # In the order of the model
    notes: tuple[str, ...] = ()

    @property
    def free(self) -> tuple[int, ...]:
        """Numbers of the joints that mimic no other."""
        return tuple(n for n, joint in enumerate(self.joints) if joint.mimics is None)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints."""
        return tuple(joint.name for joint in self.joints)

    @property
    def is_rigid(self) -> bool:
        """Whether every link keeps its place in the frame of its parent."""
        return not any(joint.slides or any(joint.anchor) for joint in self.joints)


@dataclass(frozen=True, eq=False)
class Posed:
    """Where links and joints are in the world, z up."""

    places: FloatArray  # (frames, links, 3)
    turns: FloatArray  # (frames, links, 4)
    anchors: FloatArray  # (frames, joints, 3)
    axes: FloatArray  # (frames, joints, 3)


def with_mimics(robot: Robot, values: FloatArray) -> FloatArray:
    """Return values (frames, joints) in which joints that mimic others have theirs."""
    values = values.copy()
    for number, joint in enumerate(robot.joints):
        if joint.mimics is not None:
            other, factor, offset = joint.mimics
            values[:, number] = factor * values[:, other] + offset
    return values


def pose(robot: Robot, root: FloatArray, root_turns: FloatArray, values: FloatArray) -> Posed:
    """Place all links; `root` (frames, 3), `root_turns` (frames, 4), `values` (frames, joints)."""
    n_frames = len(values)
    places = np.empty((n_frames, len(robot.links), 3))
    turns = np.empty((n_frames, len(robot.links), 4))
    anchors = np.empty((n_frames, len(robot.joints), 3))
    axes = np.empty((n_frames, len(robot.joints), 3))
    moved_by: dict[int, list[int]] = {}
    for number, joint in enumerate(robot.joints):
        moved_by.setdefault(joint.link, []).append(number)
    for link, parent in enumerate(robot.parents):
        if parent < 0:
            at, turn = root, root_turns
        else:
            above = turns[:, parent]
            at = places[:, parent] + rotation.rotate(above, _all(robot.places[link], n_frames))
            turn = rotation.multiply(above, _all(robot.turns[link], n_frames))
        for number in moved_by.get(link, ()):
            joint = robot.joints[number]
            value = values[:, number] - joint.ref
            arm = _all(np.array(joint.anchor), n_frames)
            anchors[:, number] = at + rotation.rotate(turn, arm)
            axes[:, number] = rotation.rotate(turn, _all(np.array(joint.axis), n_frames))
            if joint.slides:
                at = at + axes[:, number] * value[:, None]
            else:
                turn = rotation.multiply(turn, rotation.from_axis_angle(joint.axis, value))
                at = anchors[:, number] - rotation.rotate(turn, arm)
        places[:, link], turns[:, link] = at, turn
    return Posed(places, turns, anchors, axes)


def _all(value: FloatArray, n_frames: int) -> FloatArray:
    """The same vector for every frame."""
    return np.broadcast_to(value, (n_frames, len(value)))


def at_zero(robot: Robot) -> Posed:
    """Place all links (one frame) with all joints at 0 and the first link unturned at 0, 0, 0."""
    still = with_mimics(robot, np.zeros((1, len(robot.joints))))
    return pose(robot, np.zeros((1, 3)), rotation.IDENTITY[None], still)


def joint_labels(robot: Robot) -> tuple[str, ...]:
    """Return a name a link that tells the part of the body: the link's, or that of its hinge."""
    moves: dict[int, list[str]] = {}
    for joint in robot.joints:
        moves.setdefault(joint.link, []).append(joint.name)
    labels: list[str] = []
    for number, link in enumerate(robot.links):
        hinges = [name for name in moves.get(number, ()) if is_named(name)]
        use = hinges and (len(hinges) == 1 or not is_named(link))
        label = hinges[0] if use and hinges[0] not in labels else link
        labels.append(label)
    return tuple(labels)


def to_clip(robot: Robot, posed: Posed, fps: float, up: str = "") -> Clip:
    """Return the links as joints of a clip with y up; `up`: the axis that is up instead of z."""
    rest = at_zero(robot)
    back = np.broadcast_to(rotation.conjugate(rest.turns), posed.turns.shape)
    turns = rotation.multiply(posed.turns, back)
    names = joint_labels(robot)
    return of_frames(
        names, robot.parents, posed.places, turns, fps, rest.places[0], robot.is_rigid, up or "z"
    )


def of_frames(
    names: tuple[str, ...],
    parents: IntArray,
    places: FloatArray,
    turns: FloatArray,
    fps: float,
    rest: FloatArray | None = None,
    is_rigid: bool = False,
    up: str = "z",
) -> Clip:
    """Return a clip of links in the world: `places` (frames, links, 3), `turns` (frames, links, 4).

    `rest`: places (links, 3) where nothing is turned; None: the medians in the parents' frames.
    `is_rigid`: whether links keep their places there. `up`: the axis up of the arrays; z becomes y.
    """
    if up == "z":
        turn = np.broadcast_to(world.to_y_up("z"), turns.shape)
        places = rotation.rotate(turn, places)
        turns = rotation.multiply(rotation.multiply(turn, turns), rotation.conjugate(turn))
        rest = None if rest is None else rotation.rotate(turn[0], rest)
        up = "y"
    local, offsets = kinematics.to_local(parents, places, turns)
    below = parents[:, None] >= 0
    if rest is None:
        usual = np.where(below, np.median(offsets, axis=0), 0.0)
    else:
        usual = np.where(below, rest - rest[parents.clip(0)], 0.0)
    skeleton = Skeleton(names, parents, usual)
    neck, notes = missing_neck(skeleton), tuple[str, ...]()
    if neck is not None:
        skeleton = Skeleton(
            (*names, "neck"), np.append(parents, neck[0]), np.vstack([usual, neck[1]])
        )
        local = np.concatenate([local, _frames_of(rotation.IDENTITY, len(local))], axis=1)
        offsets = np.concatenate([offsets, _frames_of(neck[1], len(local))], axis=1)
        notes = ("The model has no neck; one is taken over the middle of its shoulders.",)
    return Clip(
        skeleton=skeleton,
        fps=fps,
        local_rotations=rotation.normalize(local),
        root_positions=places[:, 0].copy(),
        joint_positions=None if is_rigid else offsets,
        format="robot",
        notes=notes,
        up=up,
    )


def _frames_of(value: FloatArray, n_frames: int) -> FloatArray:
    """One more joint with the same value in every frame: array (frames, 1, ...)."""
    return np.broadcast_to(value, (n_frames, 1, len(value)))


_ALONG = 0.9  # Mean cosine of a base with an axis along which it lies for the whole take


def lying_notes(turns: FloatArray) -> tuple[str, ...]:
    """Note a base that lies along one axis for the whole take, as where another axis is up."""
    way = rotation.rotate(turns, np.array([0.0, 0.0, 1.0])).mean(axis=0)
    axis = int(np.abs(way).argmax())
    if (axis == 2 and way[2] > 0.0) or abs(way[axis]) < _ALONG:
        return ()
    up = ("-" if way[axis] < 0.0 else "") + "xyz"[axis]
    return (f"z is taken for up, and the robot lies along {up}. If it stands, give --up {up}.",)


def limit_notes(robot: Robot, values: FloatArray) -> tuple[str, ...]:
    """Note the joints that leave their limits."""
    found = []
    for number, joint in enumerate(robot.joints):
        if joint.limits is None or joint.slides or joint.mimics is not None:
            continue
        low, high = joint.limits
        beyond = np.maximum(low - values[:, number], values[:, number] - high)
        if float(beyond.max()) > np.deg2rad(0.5):
            found.append((float(beyond.max()), int((beyond > np.deg2rad(0.5)).sum()), joint))
    if not found:
        return ()
    most, count, joint = max(found, key=lambda each: each[0])
    assert joint.limits is not None
    low, high = np.rad2deg(joint.limits)
    return (
        f"{len(found)} joints leave the limits of the model, {joint.name} the most: by "
        f"{np.rad2deg(most):.1f} degrees ({low:.0f} to {high:.0f} are allowed), in {count} frames.",
    )
