"""From channels (what pelvis, trunk, feet and hands do) to joint rotations, by inverse kinematics.

Legs and arms are chains of two bones: with u the unit vector from hip to ankle, p the pole (where
the knee points) made orthogonal to u, and a the angle at the hip from the law of cosines, the thigh
points along u cos(a) + p sin(a). Knees and elbows are pure hinges, so they bend one way only.
A planted foot is never moved: where a leg is too short to reach it, the pelvis comes down.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import rotation
from motiondb.records import FloatArray, Skeleton

from .performers import INDEX, ROLES, Performer

Channels = dict[str, FloatArray]

REACH = 0.997
"""Share of a limb's length that it may span."""
_HEEL_BACK = 0.05


def solve(channels: Channels, person: Performer, bones: Skeleton) -> tuple[FloatArray, FloatArray]:
    """Local rotations (frames, 21, 4) and root positions (frames, 3), metres, of the channels.

    channels : name -> array (frames,), as :data:`sample_data.score.CHANNELS` lists them; metres
        and degrees in the world, hands in arm lengths.
    """
    n_frames = len(channels["px"])
    world = np.tile(rotation.IDENTITY, (n_frames, len(ROLES), 1))
    place = np.zeros((n_frames, len(ROLES), 3))
    world[:, 0] = _turn(channels, ("yaw", "tilt", "roll"), "YXZ")
    ankles = {side: _ankle(channels, side, bones) for side in "lr"}
    place[:, 0] = _lowered_pelvis(channels, world[:, 0], ankles, bones)
    bend = _turn(channels, ("twist", "lean", "side"), "YXZ", share=0.5)
    for joint in (1, 2):
        _follow(world, place, bones, joint, bend)
    gaze = -0.35 * (channels["lean"] + channels["tilt"]) + 0.5 * channels["nod"]
    half = rotation.from_euler(np.stack([0.5 * channels["look"], gaze], axis=-1), "YX")
    for joint in (3, 4):
        _follow(world, place, bones, joint, half)
    for side in "lr":
        _leg(world, place, bones, channels, side, ankles[side])
        _arm(world, place, bones, channels, side, person)
    local = world.copy()
    for joint, (_, parent) in enumerate(ROLES):
        if parent >= 0:
            back = rotation.conjugate(world[:, parent])
            local[:, joint] = rotation.multiply(back, world[:, joint])
    return rotation.normalize(local), place[:, 0]


def two_bones(
    start: FloatArray, target: FloatArray, pole: FloatArray, upper: float, lower: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions of a chain of two bones from ``start`` towards ``target``.

    Parameters
    ----------
    start, target, pole : arrays (frames, 3), metres; the middle joint moves towards the pole.
    upper, lower : bone lengths, metres.

    Returns
    -------
    first : array (frames, 3), direction of the upper bone.
    bent : array (frames, 3), unit vector towards the pole, at right angles to the upper bone.
    angle : array (frames,), radians by which the lower bone turns away from the upper one.
    """
    span = target - start
    u = rotation.normalize(span)
    reach = np.linalg.norm(span, axis=-1).clip(
        abs(upper - lower) + 0.25 * lower, REACH * (upper + lower)
    )
    p = rotation.normalize(pole - np.sum(pole * u, axis=-1, keepdims=True) * u)
    cosine = (upper**2 + reach**2 - lower**2) / (2 * upper * reach)
    a = np.arccos(cosine.clip(-1, 1))[:, None]
    inner = (upper**2 + lower**2 - reach**2) / (2 * upper * lower)
    first = np.cos(a) * u + np.sin(a) * p
    bent = np.cos(a) * p - np.sin(a) * u
    return first, bent, np.pi - np.arccos(inner.clip(-1, 1))


def _ankle(channels: Channels, side: str, bones: Skeleton) -> tuple[FloatArray, FloatArray]:
    """Where a foot's ankle is (frames, 3) and how the foot is turned (frames, 4).

    The heel rises about the toe joint; the toes rise about the heel.
    """
    _, down, ahead = bones.offsets[INDEX["l_toe"]]
    height = -down / 0.06 * 0.08
    yaw = rotation.from_euler(channels[f"{side}yaw"][:, None], "Y")
    raised = rotation.from_euler(channels[f"{side}heel"][:, None], "X")
    dropped = rotation.from_euler(-channels[f"{side}toe"][:, None], "X")
    ball = np.array([0.0, down, ahead])
    heel = np.array([0.0, -height, -_HEEL_BACK])
    foot = rotation.multiply(dropped, raised)
    # toes up about the heel, after heel up about the ball
    from_ball = ball - rotation.rotate(raised, np.broadcast_to(ball, (len(yaw), 3)))
    offset = heel + rotation.rotate(dropped, from_ball - heel)
    ground = np.stack(
        [channels[f"{side}x"], channels[f"{side}y"] + height, channels[f"{side}z"]], -1
    )
    return ground + rotation.rotate(yaw, offset), rotation.multiply(yaw, foot)


def _lowered_pelvis(
    channels: Channels,
    turned: FloatArray,
    ankles: dict[str, tuple[FloatArray, FloatArray]],
    bones: Skeleton,
) -> FloatArray:
    """The pelvis (frames, 3), brought down smoothly until both legs reach their planted feet."""
    pelvis = np.stack([channels["px"], channels["py"], channels["pz"]], axis=-1)
    length = -(bones.offsets[INDEX["l_knee"], 1] + bones.offsets[INDEX["l_ankle"], 1])
    excess = np.zeros(len(pelvis))
    for side, (ankle, _) in ankles.items():
        hip = pelvis + rotation.rotate(
            turned, np.broadcast_to(bones.offsets[INDEX[f"{side}_hip"]], pelvis.shape)
        )
        flat = np.sum((hip - ankle)[:, [0, 2]] ** 2, axis=-1)
        highest = ankle[:, 1] + np.sqrt(((0.991 * length) ** 2 - flat).clip(0.04 * length**2))
        planted = channels[f"{side}y"] < 0.02
        excess = np.maximum(excess, np.where(planted, hip[:, 1] - highest, 0.0))
    widened = np.max([_shift(excess, n) for n in range(-2, 3)], axis=0)
    hann = np.hanning(7)[1:-1]
    padded = np.pad(widened, 2, mode="edge")
    pelvis[:, 1] -= np.convolve(padded, hann / hann.sum(), mode="valid")
    return pelvis


def _leg(
    world: FloatArray,
    place: FloatArray,
    bones: Skeleton,
    channels: Channels,
    side: str,
    ankle: tuple[FloatArray, FloatArray],
) -> None:
    hip, knee, foot, toe = (INDEX[f"{side}_{j}"] for j in ("hip", "knee", "ankle", "toe"))
    _follow(world, place, bones, hip)
    sign = 1.0 if side == "l" else -1.0
    facing = 0.5 * channels[f"{side}yaw"] + 0.5 * channels["yaw"] + sign * channels[f"{side}out"]
    ahead = rotation.from_euler(facing[:, None], "Y")
    pole = rotation.rotate(ahead, np.broadcast_to([0.0, 0.25, 1.0], (len(ahead), 3)))
    upper, lower = -bones.offsets[knee, 1], -bones.offsets[foot, 1]
    first, bent, angle = two_bones(place[:, hip], ankle[0], pole, upper, lower)
    left = np.cross(-first, bent)
    world[:, hip] = rotation.from_matrix(np.stack([left, -first, bent], axis=-1))
    _follow(world, place, bones, knee, _about("X", angle))
    _follow(world, place, bones, foot)
    world[:, foot] = ankle[1]
    _follow(world, place, bones, toe, _about("X", -np.deg2rad(channels[f"{side}bend"])))


def _arm(
    world: FloatArray,
    place: FloatArray,
    bones: Skeleton,
    channels: Channels,
    side: str,
    person: Performer,
) -> None:
    names = ("collar", "shoulder", "elbow", "wrist")
    collar, shoulder, elbow, wrist = (INDEX[f"{side}_{j}"] for j in names)
    sign = 1.0 if side == "l" else -1.0
    mirror = np.array([sign, 1.0, 1.0])

    def vector(letter: str) -> FloatArray:
        return mirror * np.stack([channels[f"{side}{letter}{axis}"] for axis in "xyz"], axis=-1)

    raised = np.deg2rad(14.0) * (channels[f"{side}hy"] + 0.4).clip(0.0, 1.2)
    _follow(world, place, bones, collar, _about("Z", sign * raised))
    _follow(world, place, bones, shoulder)
    chest = world[:, INDEX["chest"]]
    target = place[:, shoulder] + rotation.rotate(chest, person.arm * vector("h"))
    heading = rotation.from_euler(channels["yaw"][:, None], "Y")
    ground = place[:, 0] * np.array([1.0, 0.0, 1.0])
    fixed = ground + rotation.rotate(heading, person.scale * vector("g"))
    weight = channels[f"{side}w"].clip(0.0, 1.0)[:, None]
    target = target + weight * (fixed - target)
    upper, lower = abs(bones.offsets[elbow, 0]), abs(bones.offsets[wrist, 0])
    pole = rotation.rotate(chest, vector("e"))
    first, bent, angle = two_bones(place[:, shoulder], target, pole, upper, lower)
    x, z = sign * first, -bent
    world[:, shoulder] = rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))
    _follow(world, place, bones, elbow, _about("Y", -sign * angle))
    _follow(world, place, bones, wrist, _about("Z", -sign * np.deg2rad(channels[f"{side}flex"])))


def _follow(
    world: FloatArray,
    place: FloatArray,
    bones: Skeleton,
    joint: int,
    local: FloatArray | None = None,
) -> None:
    """Put a joint where its parent carries it, turned by ``local`` (frames, 4) within that."""
    parent = ROLES[joint][1]
    offset = np.broadcast_to(bones.offsets[joint], place[:, joint].shape)
    place[:, joint] = place[:, parent] + rotation.rotate(world[:, parent], offset)
    turned = world[:, parent]
    world[:, joint] = turned if local is None else rotation.multiply(turned, local)


def _turn(channels: Channels, names: tuple[str, ...], order: str, share: float = 1.0) -> FloatArray:
    return rotation.from_euler(share * np.stack([channels[name] for name in names], -1), order)


def _about(axis: str, angle: FloatArray) -> FloatArray:
    return rotation.from_axis_angle(np.eye(3)["XYZ".index(axis)], angle)


def _shift(values: FloatArray, n: int) -> FloatArray:
    padded = np.pad(values, abs(n), mode="edge")
    return padded[abs(n) + n : abs(n) + n + len(values)]
