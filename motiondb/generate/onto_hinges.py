"""A motion of the canonical body on a robot: values of its hinges within their limits.

The motion is put on the robot as on any rig (:mod:`.onto`), as if its joints could turn freely.
Then the pose of the root and the hinges is fitted to the places of hips, knees, ankles, toes,
shoulders, elbows and wrists; the feet are as far apart as the robot's hips ask. x minimises, in
each frame,

    sum w_p |p(x) - p*|^2 + r |q - q_0|^2 + s |q - q_s|^2

by damped Gauss-Newton steps for all frames at once, with hinges held at their limits. q_0 is the
pose in which the model stands, q_s the solution of the round before, smoothed in time (0 in the
first round).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from motiondb.body import body, hinges, retarget, rotation, world
from motiondb.body.contacts import find_contacts
from motiondb.body.features import runs
from motiondb.body.hinges import Robot
from motiondb.body.joint_names import joint_map
from motiondb.generate.onto import onto
from motiondb.records import MOTION_FPS, Clip, Fit, FloatArray, IntArray, Motion

_WEIGHTS = {
    "hip": 0.5, "knee": 1.0, "ankle": 4.0, "toe": 2.0,
    "shoulder": 0.5, "elbow": 1.0, "wrist": 2.0,
}  # fmt: skip
_FEET = {"knee": 0.5, "ankle": 1.0, "toe": 1.0, "sole": 1.0}  # Shares of the way of a foot
_HIPS = [body.INDEX["l_hip"], body.INDEX["r_hip"]]
_SOLE = 1.0  # Weight of a point beside the ankle, which keeps the sole flat
_REST, _SMOOTH, _DAMPING = 1e-4, (0.0, 0.02, 0.02), 1e-4
"""r; s of every round; what is added to the diagonal, so that steps stay small. In square metres a
square radian: .02 gives way by a centimetre for a tenth of a radian."""
_STEPS, _CHUNK = 25, 256  # Steps a round; frames that are fitted at once
_LONGEST = 0.3  # Radians or metres of a step
_MEDIAN, _SIGMA = 7, 1.0  # Frames of the filters that give q_s


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """A motion of a robot, z up, metres and radians."""

    robot: Robot
    fps: float
    root: FloatArray  # (frames, 3)
    turns: FloatArray  # (frames, 4): w, x, y, z
    values: FloatArray  # (frames, joints)

    def posed(self) -> hinges.Posed:
        """Return where links and joints are."""
        return hinges.pose(self.robot, self.root, self.turns, self.values)

    def clip(self) -> Clip:
        """Return the links as a clip, y up."""
        return hinges.to_clip(self.robot, self.posed(), self.fps)

    def resampled(self, fps: float, speed: float = 1.0) -> RobotMotion:
        """Return the motion at another rate, `speed` times as fast."""
        n_frames = max(1, round(len(self.root) * fps / self.fps / speed))
        times = np.minimum(np.arange(n_frames) * self.fps * speed / fps, len(self.root) - 1.0)
        below = times.astype(np.int64)
        above, share = np.minimum(below + 1, len(self.root) - 1), (times - below)[:, None]
        return RobotMotion(
            self.robot,
            fps,
            self.root[below] * (1.0 - share) + self.root[above] * share,
            rotation.slerp(self.turns[below], self.turns[above], share[:, 0]),
            self.values[below] * (1.0 - share) + self.values[above] * share,
        )


@dataclass(frozen=True, eq=False)
class FittedRobot:
    """A motion on a robot, and how well it follows."""

    motion: RobotMotion
    fit: Fit
    joint_error: float  # Mean distance of all joints from their places, metres
    most_joint_error: float


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of links that should be somewhere."""

    roles: tuple[str, ...]  # What each point is
    links: IntArray  # (points,)
    offsets: FloatArray  # (points, 3): in the frame of the link
    targets: FloatArray  # (frames, points, 3)
    weights: FloatArray  # (points,)


def onto_robot(
    motion: Motion, robot: Robot, user_map: Mapping[str, str] | None = None
) -> FittedRobot:
    """Put a motion on a robot (SkeletonError)."""
    zero = hinges.at_zero(robot)
    rig = hinges.to_clip(robot, zero, MOTION_FPS)
    fitted = onto(motion, rig, user_map)
    points = _points(robot, rig, fitted.clip, zero, joint_map(rig.skeleton, user_map))
    width = float(np.linalg.norm(np.diff(retarget.clip_keypoints(rig, user_map)[0, _HIPS], axis=0)))
    points = _astride(points, motion, width / 2.0 - body.OFFSETS[_HIPS[0], 0] * fitted.fit.scale)
    back = rotation.conjugate(world.to_y_up("z"))
    turn = np.broadcast_to(back, (motion.n_frames, 4))
    root = rotation.rotate(turn, fitted.clip.root_positions)
    turned = rotation.multiply(turn, fitted.clip.local_rotations[:, 0])
    turns = rotation.multiply(turned, rotation.conjugate(turn))
    found = _solve(robot, points, root, turns)
    at = _places(found.posed(), points)
    away = np.linalg.norm(at - points.targets, axis=-1)
    parts = [role.rpartition("_")[2] for role in points.roles]
    feet, hands = (away[:, [p == part for p in parts]] for part in ("ankle", "wrist"))
    joints = away[:, [part != "sole" for part in parts]]
    fit = replace(
        fitted.fit,
        foot_error=float(feet.mean()),
        most_foot_error=float(feet.max()),
        hand_error=float(hands.mean()) if hands.size else 0.0,
        most_hand_error=float(hands.max()) if hands.size else 0.0,
        slip=_slip(at, parts, motion),
        joints=len(robot.joints),
        driven=len(robot.free),
    )
    return FittedRobot(found, fit, float(joints.mean()), float(joints.max()))


def _astride(points: _Points, motion: Motion, wider: float) -> _Points:
    """Set the feet apart by as much as the hips of the robot are wider (metres a side).

    A foot in contact is moved by the same way in all frames of the contact.
    """
    places = retarget.motion_positions(motion)[0]
    left = (places[:, _HIPS[0]] - places[:, _HIPS[1]]) * [1.0, 0.0, 1.0]
    back = np.broadcast_to(rotation.conjugate(world.to_y_up("z")), (len(left), 4))
    left = rotation.rotate(back, rotation.normalize(left))
    down = find_contacts(places) if motion.n_frames > 1 else np.ones((1, 2), dtype=bool)
    targets = points.targets.copy()
    for foot, side in enumerate("lr"):
        known, ways = list[int](), list[FloatArray]()
        for start, end in runs(down[:, foot]):
            known += range(start, end)
            ways += [left[start:end].mean(axis=0)] * (end - start)
        if not known:
            known, ways = list(range(len(left))), list(left)
        frames, shift = np.arange(len(left)), np.array(ways)
        way = np.stack([np.interp(frames, known, shift[:, axis]) for axis in range(3)], axis=-1)
        way *= wider if side == "l" else -wider
        for number, role in enumerate(points.roles):
            share = _FEET.get(role.rpartition("_")[2], 0.0) * (role[0] == side)
            targets[:, number] += share * way
    return replace(points, targets=targets)


def _slip(at: FloatArray, parts: list[str], motion: Motion) -> float:
    """Return the mean ground speed (m/s) of feet in contact, by the slower of ankle and toe."""
    if motion.n_frames < 2:
        return 0.0
    contacts = find_contacts(retarget.motion_positions(motion)[0])
    speeds = np.linalg.norm(np.gradient(at[..., :2], axis=0), axis=-1) * MOTION_FPS
    slips: list[float] = []
    ends = [[n for n, part in enumerate(parts) if part == name] for name in ("ankle", "toe")]
    for foot, pair in enumerate(zip(*ends)):
        slips += speeds[:, pair].min(axis=1)[contacts[:, foot]].tolist()
    return float(np.mean(slips)) if slips else 0.0


def _points(
    robot: Robot, rig: Clip, free: Clip, zero: hinges.Posed, roles: Mapping[str, int]
) -> _Points:
    """Return the points of the links with roles, and where they are if joints turn freely."""
    at, turned = free.world_positions(), free.world_rotations()
    rest = retarget.clip_keypoints(rig)[0]
    to_z = rotation.conjugate(world.to_y_up("z"))
    names, links, offsets, targets, weights = [], [], [], [], []

    def add(role: str, link: int, way: FloatArray, weight: float) -> None:
        """Add a point at a way from a link in the world of the rig, y up, at rest."""
        moved = at[:, link] + rotation.rotate(
            turned[:, link], np.broadcast_to(way, at[:, link].shape)
        )
        frame = rotation.conjugate(zero.turns[0, link])
        names.append(role)
        links.append(link)
        offsets.append(rotation.rotate(frame, rotation.rotate(to_z, way)))
        targets.append(rotation.rotate(np.broadcast_to(to_z, (len(moved), 4)), moved))
        weights.append(weight)

    for side in "lr":
        for part, weight in _WEIGHTS.items():
            role = f"{side}_{part}"
            link = roles.get(role, -1)
            if 0 <= link < len(robot.links):
                add(role, link, np.zeros(3), weight)
            elif part == "toe" and roles[f"{side}_ankle"] >= 0:
                ankle = rest[body.INDEX[f"{side}_ankle"]]
                add(role, roles[f"{side}_ankle"], rest[body.INDEX[role]] - ankle, weight)
        across = rest[body.INDEX["l_hip"]] - rest[body.INDEX["r_hip"]]
        add(f"{side}_sole", roles[f"{side}_ankle"], across / 2.0, _SOLE)
    return _Points(
        tuple(names),
        np.array(links, dtype=np.int64),
        np.array(offsets),
        np.stack(targets, axis=1),
        np.array(weights),
    )


def _places(posed: hinges.Posed, points: _Points) -> FloatArray:
    """Return where the points are: array (frames, points, 3)."""
    turns = posed.turns[:, points.links]
    ways = np.broadcast_to(points.offsets, (*turns.shape[:2], 3))
    return posed.places[:, points.links] + rotation.rotate(turns, ways)


def _solve(robot: Robot, points: _Points, root: FloatArray, turns: FloatArray) -> RobotMotion:
    """Fit the root and the hinges to the points, in rounds."""
    low, high = _limits(robot)
    rest = np.clip(np.zeros(len(robot.joints)), low, high)
    values = np.tile(rest, (len(root), 1))
    smooth = values
    for weight in _SMOOTH:
        parts = []
        for start in range(0, len(root), _CHUNK):
            some = slice(start, start + _CHUNK)
            part = replace(points, targets=points.targets[some])
            begin = root[some], turns[some], smooth[some]
            parts.append(_round(robot, part, begin, smooth[some], weight, rest))
        root, turns, values = (np.concatenate(each) for each in zip(*parts))
        wide = median_filter(values, (_MEDIAN, 1), mode="nearest")
        smooth = np.clip(gaussian_filter1d(wide, _SIGMA, axis=0, mode="nearest"), low, high)
    return RobotMotion(robot, MOTION_FPS, root, rotation.unroll(turns), values)


def _limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest value of every joint."""
    limits = [joint.limits or (-np.inf, np.inf) for joint in robot.joints]
    return np.array([low for low, _ in limits]), np.array([high for _, high in limits])


def _round(
    robot: Robot,
    points: _Points,
    begin: tuple[FloatArray, FloatArray, FloatArray],
    smooth: FloatArray,
    weight: float,
    rest: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Take Gauss-Newton steps for some frames; returns root, turns and values."""
    root, turns, values = begin
    low, high = _limits(robot)
    free = list(robot.free)
    moves = _moves(robot, points)
    for _ in range(_STEPS):
        values = hinges.with_mimics(robot, values)
        posed = hinges.pose(robot, root, turns, values)
        at = _places(posed, points)
        slopes = _slopes(robot, posed, at, root, moves)
        scaled = slopes * points.weights[:, None, None]
        flat = slopes.reshape(len(root), -1, slopes.shape[-1])
        flat_scaled = scaled.reshape(flat.shape)
        left = (points.targets - at).reshape(len(root), -1, 1)
        normal = flat_scaled.transpose(0, 2, 1) @ flat
        slope = (flat_scaled.transpose(0, 2, 1) @ left)[..., 0]
        diagonal = np.full(normal.shape[-1], _DAMPING)
        diagonal[6:] += _REST + weight
        slope[:, 6:] += _REST * (rest - values)[:, free] + weight * (smooth - values)[:, free]
        now = values[:, free]
        stuck = ((now <= low[free]) & (slope[:, 6:] < 0.0)) | (
            (now >= high[free]) & (slope[:, 6:] > 0.0)
        )
        keep = np.concatenate([np.ones((len(root), 6), dtype=bool), ~stuck], axis=1)
        normal = normal * keep[:, :, None] * keep[:, None, :] + np.eye(len(diagonal)) * diagonal
        step = np.linalg.solve(normal, (slope * keep)[..., None])[..., 0]
        step *= np.minimum(1.0, _LONGEST / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        root = root + step[:, :3]
        turns = rotation.normalize(rotation.multiply(rotation.exp(step[:, 3:6]), turns))
        values = values.copy()
        values[:, free] = np.clip(now + step[:, 6:], low[free], high[free])
    return root, turns, hinges.with_mimics(robot, values)


def _moves(robot: Robot, points: _Points) -> FloatArray:
    """Return by how much each joint moves each point with a free joint: (points, joints, free)."""
    moves = np.zeros((len(points.links), len(robot.joints), len(robot.free)))
    place = {number: n for n, number in enumerate(robot.free)}
    for point, link in enumerate(points.links):
        above = set[int]()
        at = int(link)
        while at >= 0:
            above.add(at)
            at = int(robot.parents[at])
        for number, joint in enumerate(robot.joints):
            if joint.link in above:
                other, factor, _ = joint.mimics or (number, 1.0, 0.0)
                moves[point, number, place[other]] = factor
    return moves


def _slopes(
    robot: Robot, posed: hinges.Posed, at: FloatArray, root: FloatArray, moves: FloatArray
) -> FloatArray:
    """Return the derivatives of the points: array (frames, points, 3, 6 + free joints)."""
    arms = at[:, :, None] - posed.anchors[:, None]
    axes = np.broadcast_to(posed.axes[:, None], arms.shape)
    slides = np.array([joint.slides for joint in robot.joints])
    each = np.where(slides[:, None], axes, np.cross(axes, arms))
    by_joint = np.einsum("fpjx,pjk->fpxk", each, moves)
    by_place = np.broadcast_to(np.eye(3), (*at.shape[:2], 3, 3))
    arm = at - root[:, None]
    by_turn = np.stack([np.cross(axis, arm) for axis in np.eye(3)], axis=-1)
    return np.concatenate([by_place, by_turn, by_joint], axis=-1)
