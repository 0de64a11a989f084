"""The path of the object: in hands, bounced, from player to player, to its target, lying.

Captures have no objects. The actions determine the holder. It moves

* in the hands: between the palms; if these are far apart, in front of the chest, and the hands are
  moved to it; a small object in the palm of one hand;
* borne by several: in the middle between them, with the hands on its sides;
* bounced: under the palm of the clip's hand, and between its release and its catch down to the
  floor and up again, each way a fall under gravity in the given time;
* given, or sent to whoever strikes it next: at constant horizontal speed, with gravity, in the time
  from release to catch; from foot to foot it rolls;
* sent: into a level target (a ring) from above at 45 degrees; to an upright one (a goal) or a head
  at the speed of a throw; then it falls and bounces;
* put down: on its target, or to the floor.

Hands are moved to the object where the capture's hands are not: during a few frames before it is
taken or put down, and while it is held in both hands.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6: trajectories of the ball are added when a scene is done.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, features, kinematics, pose_vectors, retarget, rotation
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.language.activity import GIVE, PUT, SEND
from motiondb.scene.thing.thing_acts import Aim, Possession, ThingActs

# Hands: where they are, and how arms move them somewhere else.


Bodies = Sequence[tuple[FloatArray, FloatArray]]  # Joints and rotations of every player
PALM = 0.09  # Distance from wrist to palm, m: half the length of a hand
_I = body.INDEX


def palms(positions: FloatArray) -> FloatArray:
    """Return both palms: array (frames, 2, 3), left and right, from joints (frames, 21, 3), m.

    A palm is a little beyond its wrist, along the forearm. Arms are chains of two bones. The hand
    moves to its target as far as the arm reaches, with the elbow bent in its plane.
    """
    wrists_and_palms = []
    for side in "lr":
        elbow, wrist = positions[:, _I[f"{side}_elbow"]], positions[:, _I[f"{side}_wrist"]]
        wrists_and_palms.append(wrist + PALM * rotation.normalize(wrist - elbow))
    return np.stack(wrists_and_palms, axis=1)


def reach(motion: Motion, targets: FloatArray, weights: FloatArray) -> Motion:
    """Return the motion with its palms moved towards targets.

    Shapes: `targets` (frames, 2, 3), m; `weights` (frames, 2).
    """
    if not np.any(weights > 0.0):
        return motion
    positions, world = retarget.motion_positions(motion)
    local = motion.local_rotations.astype(np.float64)
    down = np.broadcast_to(np.array([0.0, -1.0, 0.0]), (len(positions), 3))
    for hand, side in enumerate("lr"):
        if not np.any(weights[:, hand] > 0.0):
            continue
        collar, shoulder, elbow = (_I[f"{side}_{j}"] for j in ("collar", "shoulder", "elbow"))
        palm = palms(positions)[:, hand]
        wanted = palm + weights[:, hand, None] * (targets[:, hand] - palm)
        # the palm is a straight continuation of the forearm, so the chain may end there
        upper, lower = kinematics.two_bone(
            positions[:, shoulder], positions[:, elbow], palm, wanted, down
        )
        new_shoulder = rotation.multiply(upper, world[:, shoulder])
        new_elbow = rotation.multiply(lower, world[:, elbow])
        moved = weights[:, hand, None] > 0.0
        local[:, shoulder] = np.where(
            moved, rotation.relative(world[:, collar], new_shoulder), local[:, shoulder]
        )
        local[:, elbow] = np.where(
            moved, rotation.relative(new_shoulder, new_elbow), local[:, elbow]
        )
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))


# Where a held or dribbled ball is, and which hands are on it.

GRIP = 0.01  # How far a palm is inside the surface of a held object, m
ONE_HAND = 0.15  # Size below which one hand holds an object, m
CARRIED = np.array([0.0, -0.06, 0.34])
"""Where an object is carried relative to the chest, m, in the frame of the heading: left, up,
ahead."""
CLOSE, FAR = 0.1, 0.31
"""Distances between palms beyond the size of a ball, m: up to the first both are on the object,
from the second on they are not."""
LEAST_AHEAD = 0.12  # Least distance of an object below the neck before the chest, m, and its radius
_TURN = 8  # Frames in which a ball passes from both hands to one
_OUT = 2.0  # Standard deviation of the smoothing of :func:`clearance`, frames
_LIMBS = (
    ("pelvis", "neck", 0.1),
    ("neck", "head", 0.08),
    ("l_hip", "l_knee", 0.06),
    ("r_hip", "r_knee", 0.06),
    ("l_knee", "l_ankle", 0.05),
    ("r_knee", "r_ankle", 0.05),
)
"""Capsules of the body: from joint to joint, with their radius in m. Chosen by hand: slimmer than
limbs, so that a held ball may touch clothes."""


@dataclass(frozen=True, eq=False)
class HeldThing:
    """Per frame, whether held or not: where the object would be."""

    ball: FloatArray  # (frames, 3), m: its centre
    # (frames, 2): weight with which the left and the right palm are to be at ``palms``
    hands: FloatArray
    palms: FloatArray  # (frames, 2, 3), m: targets of the palms


def held_thing(
    possession: Possession, joints: FloatArray, rotations: FloatArray, size: float
) -> HeldThing:
    """Return where the object of a size, m, is while a player has it.

    If it would be inside the player's body, it is moved out, and the hands with it.

    Shapes: `joints` (frames, 21, 3), m; `rotations` (frames, 21, 4).
    """
    from scipy.ndimage import gaussian_filter1d

    n_frames = len(joints)
    heading = pose_vectors.yaw(features.headings(rotations))
    left = rotation.rotate(heading, np.broadcast_to(np.array([1.0, 0.0, 0.0]), (n_frames, 3)))
    both = palms(joints)
    two, radius = _between(both, joints, heading, size), size / 2.0
    hand = possession.hand_at(n_frames)
    one = both[np.arange(n_frames), hand]
    single = _smooth(possession.one_handed(n_frames, _gap(both)))
    single = np.ones(n_frames) if size < ONE_HAND else single
    dribbled = _smooth(possession.dribbled(n_frames))
    under = one - np.array([0.0, radius - GRIP, 0.0]) * dribbled[:, None]
    ball = (1.0 - single)[:, None] * two + single[:, None] * under
    out = gaussian_filter1d(clearance(ball, joints, radius), _OUT, axis=0, mode="nearest")
    ball = ball + out
    aside = np.stack([left, -left], axis=1) * (radius - GRIP)
    led = _smooth(np.stack([hand == 0, hand == 1], axis=1).astype(float))
    beside = both + led[:, :, None] * out[:, None]
    share = single[:, None, None]
    wanted = (1.0 - share) * (ball[:, None] + aside) + share * beside
    other = (1.0 - single)[:, None]
    return HeldThing(ball, np.maximum(led * np.sign(single)[:, None], other), wanted)


def _smooth(values: FloatArray) -> FloatArray:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, _TURN / 3.0, axis=0, mode="nearest"))


def clearance(ball: FloatArray, joints: FloatArray, size: float) -> FloatArray:
    """Return the least horizontal displacement (frames, 3) of balls (frames, 3) out of a body.

    `size`: Radius of the balls, m.

    It is 0 outside. Trunk, head, thighs and shins are capsules; joints (frames, 21, 3), m.
    """
    out = np.zeros_like(ball)
    for first, second, radius in _LIMBS:
        a, b = joints[:, _I[first]], joints[:, _I[second]]
        along = b - a
        share = np.sum((ball + out - a) * along, axis=1) / np.sum(along * along, axis=1)
        away = ball + out - (a + np.clip(share, 0.0, 1.0)[:, None] * along)
        level = away * np.array([1.0, 0.0, 1.0])
        flat = np.linalg.norm(level, axis=1)
        wide = np.sqrt(np.maximum((radius + size) ** 2 - away[:, 1] ** 2, 0.0))
        out += level * (np.maximum(wide - flat, 0.0) / np.maximum(flat, 1e-6))[:, None]
    return out


def _gap(both: FloatArray) -> FloatArray:
    return np.linalg.norm(both[:, 0] - both[:, 1], axis=1)


def _between(both: FloatArray, joints: FloatArray, heading: FloatArray, size: float) -> FloatArray:
    """Return the object in both hands: between the palms, or in front of the chest if far apart."""
    chest = joints[:, _I["chest"]]
    middle = rotation.rotate(rotation.conjugate(heading), both.mean(axis=1) - chest)
    share = np.clip((_gap(both) - size - CLOSE) / (FAR - CLOSE), 0.0, 1.0)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    middle = (1.0 - share) * middle + share * CARRIED
    below = np.clip(1.0 - (middle[:, 1] - 0.2) / 0.2, 0.0, 1.0)
    middle[:, 2] += below * np.maximum(LEAST_AHEAD + size / 2.0 - middle[:, 2], 0.0)
    return chest + rotation.rotate(heading, middle)


GRAVITY = 9.81  # m/s^2
THROW = 14.0  # Speed of what is sent at an upright target or a head, m/s. Chosen by hand
ENTRY = math.radians(45.0)
"""Angle at which something comes down into a level target, rad; 43 to 47 degrees are usual for a
ring."""
BOUNCE = 0.7
"""Fraction of the speed after the floor. Chosen by hand: the rules of basketball ask for 0.82 to
0.87 for a new ball dropped from 1.8 m; the net takes more."""
CAUGHT = 40  # Frames after something is sent within which somebody may take it in flight
_ROLLS = 0.35  # Height of both ends of a way, m, below which what is sent rolls
STRIKING = 15
"""Frames around the event of a strike in which a foot or hand may meet what lies: captures of kicks
have their event where the foot is highest."""
_STRIKING = [_I[name] for name in ("l_ankle", "r_ankle", "l_toe", "r_toe", "l_wrist", "r_wrist")]
REACHING = 8  # Frames over which hands move to the object and away from it
_BEFORE_FEET = 0.4  # How far from a player something is put that is put down for them, m
_LIFT = 12  # Frames in which an object goes from where it lies to where it is held


@dataclass(frozen=True)
class Sent:
    """Something that was sent to a target."""

    player: int
    frame: int  # The frame of the release
    target: str
    at: tuple[float, float, float]  # x, height, z, m, of the target's middle at the arrival
    width: float  # m


@dataclass(frozen=True, eq=False)
class Ball:
    """The path of the object."""

    positions: FloatArray  # (frames, 3), m: its centre
    # (frames,), int: the player who has it in the hands or dribbles it; -1 in flight
    holder: IntArray
    # (frames,), m: distance from the centre to the nearest palm of the holder; NaN in flight and
    # while it bounces
    gap: FloatArray
    size: float = 0.24  # Diameter, m
    sent: tuple[Sent, ...] = ()  # What was sent where
    # Who takes or strikes it: player, frame, and how far it is from hands and feet then, m
    met: tuple[tuple[int, int, float], ...] = ()
    helpers: tuple[tuple[int, int, int], ...] = ()  # Who bears it beside the holder, from, to


def fly(acts: ThingActs, motions: Sequence[Motion]) -> tuple[Ball, list[Motion]]:
    """Return the path of the object, and the motions with hands moved to it."""
    n_frames, size = motions[0].n_frames, acts.thing.size
    positions, holder = np.zeros((n_frames, 3)), np.full(n_frames, -1)
    moved = list(motions)
    joints = [retarget.motion_positions(motion) for motion in motions]
    free = np.zeros(n_frames, dtype=bool)
    sent: list[Sent] = []
    met: list[tuple[int, int, float]] = []
    helpers: list[tuple[int, int, int]] = []
    is_loose = acts.lies is not None
    if acts.lies is not None:
        positions[:] = acts.lies.at
    before: Possession | None = None
    n_added = 0  # To what was sent, by the possession before
    nexts = [of.since for of in acts.possessions[1:]] + [n_frames]
    for of, end in zip(acts.possessions, nexts):
        since_then = slice(0 if before is None else before.until + 1, end)
        flies = of.is_struck and before is not None and _is_caught(before, of)
        lies = of.is_struck and not flies
        possession = _struck(of, joints, positions, since_then) if lies else of
        since, until = possession.since, possession.until
        held = held_thing(possession, *joints[possession.player], size)
        caught = before is not None and _is_caught(before, possession)
        if flies:
            held = replace(held, ball=np.tile(_limb(possession, joints), (n_frames, 1)))
            met.append((possession.player, since, 0.0))
        held = _shared(possession, held, joints, size)
        if is_loose and not caught:
            met += _met(possession, joints, positions[since], size)
            held = _taken(held, since, positions[since].copy())
        if possession.left == PUT:
            there = _put_at(possession, held, joints, size)
            held = _taken(held, until, there, ahead=False)
            positions[until:] = there
        frames = np.arange(since, until + 1)
        positions[frames] = held.ball[frames]
        if not possession.is_struck:
            holder[frames] = possession.player
            moved[possession.player] = _brought(moved[possession.player], possession, held)
        for helper in possession.helpers:
            grasped = _grasped(held, np.ones(n_frames), joints[helper[0]][0], size)
            moved[helper[0]] = _brought(moved[helper[0]], Possession(*helper), grasped)
        helpers += possession.helpers
        for bounce in possession.bounces:
            inner = np.arange(bounce.release, bounce.catch + 1)
            ends = held.ball[bounce.release], held.ball[bounce.catch]
            way = bounced(*ends, len(inner), size / 2.0)
            body_there = joints[possession.player][0][inner]
            positions[inner] = way + _around(way, body_there, size / 2.0)
            free[inner[1:-1]] = True
        if before is not None and (before.left == GIVE or caught):
            _pass(positions, before.until, since)
            sent = sent[: len(sent) - n_added * caught]
        added = _send(positions, possession, joints, size) if possession.left == SEND else []
        sent, n_added = [*sent, *added], len(added)
        is_loose, before = possession.left in (SEND, PUT), possession
    gaps = _gaps(positions, holder, free, moved)
    return Ball(positions, holder, gaps, size, tuple(sent), tuple(met), tuple(helpers)), moved


def _is_caught(before: Possession, after: Possession) -> bool:
    """Return whether what somebody sends is taken in flight: within :data:`CAUGHT` frames.

    Only whom it was sent to strikes it in flight, and in twice the time, for it may be high.
    """
    later, aim = after.since - before.until, before.aim
    awaited = aim is not None and aim.player == after.player
    soon = 0 < later <= CAUGHT * (1 + after.is_struck)
    return before.left == SEND and soon and (awaited or not after.is_struck)


def _limb(possession: Possession, joints: Bodies) -> FloatArray:
    """Return where a player strikes what flies: at the foot or hand that is fastest then, m."""
    frame, limbs = possession.until, joints[possession.player][0][:, _STRIKING]
    moved = limbs[min(frame + 2, len(limbs) - 1)] - limbs[max(frame - 2, 0)]
    return np.asarray(limbs[frame, int(np.argmax(np.linalg.norm(moved, axis=1)))])


def _met(
    possession: Possession, joints: Bodies, spot: FloatArray, size: float
) -> Iterator[tuple[int, int, float]]:
    """Yield who takes or strikes what lies at a spot, the frame, and how far hands and feet are."""
    for who, frame in ((possession.player, possession.since), *(h[:2] for h in possession.helpers)):
        limbs = joints[who][0][max(frame - _LIFT, 0) : frame + _LIFT + 1, _STRIKING]
        yield who, frame, float(np.linalg.norm(limbs - spot, axis=2).min()) - size / 2.0


def _shared(possession: Possession, held: HeldThing, joints: Bodies, size: float) -> HeldThing:
    """Return an object that several bear: in their middle, as high as they would hold it."""
    if not possession.helpers:
        return held

    def at(ball: FloatArray, who: int) -> FloatArray:
        return np.where([True, False, True], joints[who][0][:, _I["pelvis"]], ball)

    frames, total = np.arange(len(held.ball)), np.ones(len(held.ball))
    middle = at(held.ball, possession.player)
    for who, since, until in possession.helpers:
        theirs = held_thing(Possession(who, since, until), *joints[who], size)
        share = np.clip(1.0 - np.maximum(since - frames, frames - until) / _LIFT, 0.0, 1.0)
        middle, total = middle + share[:, None] * at(theirs.ball, who), total + share
    all_of_it = np.minimum(total - 1.0, 1.0)
    ball = held.ball + all_of_it[:, None] * (middle / total[:, None] - held.ball)
    return _grasped(replace(held, ball=ball), all_of_it, joints[possession.player][0], size)


def _grasped(held: HeldThing, share: FloatArray, joints: FloatArray, size: float) -> HeldThing:
    """Return an object with a player's palms on its sides, by a share (frames,) of the way."""
    away = (joints[:, _I["pelvis"]] - held.ball) * np.array([1.0, 0.0, 1.0])
    away = rotation.normalize(away + 1e-9)
    aside = np.cross(np.array([0.0, 1.0, 0.0]), away)
    sides = np.stack([aside, -aside], axis=1)  # the left hand of who faces it comes first
    palms_at = held.ball[:, None] + (0.6 * away[:, None] - 0.8 * sides) * (size / 2.0 - GRIP)
    by = share[:, None, None]
    both = np.maximum(held.hands, share[:, None])
    return HeldThing(held.ball, both, (1.0 - by) * held.palms + by * palms_at)


def _struck(
    possession: Possession, joints: Bodies, positions: FloatArray, within: slice
) -> Possession:
    """Return when something is struck where it lies: when a foot or hand is nearest to it.

    `within`: The frames between the possession before and the next one; at least half of those
    before the next one are left to the flight.
    """
    first = max(possession.until - STRIKING, within.start)
    behind = possession.until + min(STRIKING, (within.stop - possession.until) // 2) + 1
    if not first <= possession.until < behind:
        return possession
    around = slice(first, behind)
    limbs = joints[possession.player][0][around, _STRIKING]
    apart = np.linalg.norm(limbs - positions[around, None], axis=2).min(axis=1)
    early = np.abs(np.arange(len(apart)) + first - possession.until)
    frame = first + int(np.argmin(apart + 1e-3 * early))  # the event, if no frame is nearer
    return replace(possession, since=frame, until=frame)


def _put_at(possession: Possession, held: HeldThing, joints: Bodies, size: float) -> FloatArray:
    """Return where an object is put: on its target, before a player, or below the hands."""
    if possession.aim is not None and possession.aim.player >= 0:
        x, _, z = held.ball[possession.until]
        theirs = joints[possession.aim.player][0][possession.until, _I["pelvis"]]
        away = np.array([x - theirs[0], 0.0, z - theirs[2]])
        at = theirs + away * (_BEFORE_FEET / max(float(np.linalg.norm(away)), _BEFORE_FEET))
        return np.array([at[0], size / 2.0, at[2]])
    if possession.aim is not None:
        x, height, z = possession.aim.at
        return np.array([x, height + size / 2.0, z])
    x, _, z = held.ball[possession.until]
    return np.array([x, size / 2.0, z])


def _taken(held: HeldThing, frame: int, lies: FloatArray, ahead: bool = True) -> HeldThing:
    """Return a held object that is where it lies at a frame; ``ahead``: it is taken, else put."""
    frames = np.arange(len(held.ball))
    away = np.clip((frames - frame if ahead else frame - frames) / _LIFT, 0.0, 1.0)
    share = (1.0 - away * away * (3.0 - 2.0 * away))[:, None]
    by = share * (lies - held.ball)
    return HeldThing(held.ball + by, held.hands, held.palms + by[:, None])


def bounced(start: FloatArray, end: FloatArray, n_frames: int, radius: float) -> FloatArray:
    """Return the path from a hand to the floor and up to a hand: array (n_frames, 3).

    The ends are included. The floor is touched in the middle frame or the one before; at least 3
    frames.

    >>> bounced(np.array([0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]), 3, 0.12)[1].round(3).tolist()
    [0.5, 0.12, 0.0]
    """
    share = np.linspace(0.0, 1.0, n_frames)[:, None]
    way = start + share * (end - start)
    seconds = (n_frames - 1) / MOTION_FPS
    half = (n_frames - 1) // 2 / MOTION_FPS
    time = share[:, 0] * seconds
    down, up = (
        thrown(start[1], radius, half, time),
        thrown(radius, end[1], seconds - half, time - half),
    )
    way[:, 1] = np.maximum(np.where(time <= half + 1e-9, down, up), radius)
    return np.asarray(way)


def thrown(start: float, end: float, seconds: float, time: FloatArray) -> FloatArray:
    """Return heights, m, at times of a ball that goes from ``start`` to ``end`` in ``seconds``."""
    speed = (end - start) / seconds + GRAVITY * seconds / 2.0
    return np.asarray(start + speed * time - GRAVITY * time * time / 2.0)


def shot_seconds(distance: float, height: float) -> float:
    """Return how long a shot flies that comes down at :data:`ENTRY`, from distance and rise, m.

    >>> round(shot_seconds(4.5, 0.85), 2)
    1.04
    """
    return math.sqrt(max(2.0 * (height + distance * math.tan(ENTRY)) / GRAVITY, 0.04))


def _pass(positions: FloatArray, release: int, catch: int) -> None:
    """Fill the frames between release and catch."""
    share = np.linspace(0.0, 1.0, catch - release + 1)
    start, end = positions[release].copy(), positions[catch].copy()
    seconds = (catch - release) / MOTION_FPS
    positions[release : catch + 1] = start + share[:, None] * (end - start)
    if max(start[1], end[1]) < _ROLLS:
        return
    positions[release : catch + 1, 1] = thrown(start[1], end[1], seconds, share * seconds)


def _send(positions: FloatArray, possession: Possession, joints: Bodies, size: float) -> list[Sent]:
    """Fill the frames after a release: to the target, down, and bouncing."""
    release, aim, start = possession.until, possession.aim, positions[possession.until].copy()
    if aim is None:  # nobody says where to: it drops
        aim = Aim("", (float(start[0]), float(start[1]), float(start[2])))
    end = np.array(aim.at)
    if aim.player >= 0:
        head = joints[aim.player][0][:, _I["head"]]
        arrives = release + int(np.linalg.norm(head[release] - start) / THROW * MOTION_FPS)
        end = head[min(arrives, len(head) - 1)]
    distance = float(np.hypot(end[0] - start[0], end[2] - start[2]))
    straight = aim.upright or aim.player >= 0
    rise = float(end[1] - start[1])
    seconds = max(distance / THROW, 0.1) if straight else shot_seconds(distance, rise)
    time = np.arange(len(positions) - release) / MOTION_FPS
    share = np.clip(time / seconds, 0.0, 1.0)
    way = start + share[:, None] * (end - start)
    way[:, 1] = thrown(start[1], end[1], seconds, time)
    after = time > seconds
    way[after, 1] = _falling(time[after] - seconds, float(end[1]), size / 2.0)
    positions[release:] = way
    at = (float(end[0]), float(end[1]), float(end[2]))
    return [Sent(possession.player, release, aim.name, at, aim.width)] if aim.name else []


def _falling(time: FloatArray, start: float, radius: float) -> FloatArray:
    """Return heights of an object that was stopped at a height: down to the floor and up again."""
    heights, speed, begin = np.full(len(time), radius), 0.0, 0.0
    for _ in range(12):
        fall = max(start - radius, 0.0)
        lasts = (speed + math.sqrt(speed * speed + 2.0 * GRAVITY * fall)) / GRAVITY
        inside = (time >= begin) & (time <= begin + lasts)
        fall_time = time[inside] - begin
        heights[inside] = start + speed * fall_time - GRAVITY * fall_time * fall_time / 2.0
        begin, speed = begin + lasts, BOUNCE * (GRAVITY * lasts - speed)
        start = radius
    return np.maximum(heights, radius)


def _around(way: FloatArray, joints: FloatArray, radius: float) -> FloatArray:
    """Return how far a bounce has to avoid the legs: array (frames, 3), 0 at its ends."""
    from scipy.ndimage import gaussian_filter1d

    out = gaussian_filter1d(clearance(way, joints, radius), 2.0, axis=0, mode="constant")
    return np.asarray(out * np.minimum(1.0, 3.0 * np.sin(np.linspace(0, np.pi, len(way))))[:, None])


def _brought(motion: Motion, possession: Possession, held: HeldThing) -> Motion:
    """Return a motion with its palms at the ball while it is held, and moving to it before."""
    n_frames = motion.n_frames
    frames = np.arange(n_frames)
    inside = np.clip(frames, possession.since, possession.until)
    near = 1.0 - np.maximum(possession.since - frames, frames - possession.until) / REACHING
    ramp = np.clip(near, 0.0, 1.0)
    if possession.since == 0:
        ramp[: possession.since + 1] = 1.0
    weights = held.hands[inside] * (ramp * ramp * (3.0 - 2.0 * ramp))[:, None]
    return reach(motion, held.palms[inside], weights)


def _gaps(
    positions: FloatArray, holder: IntArray, free: NDArray[np.bool_], motions: Sequence[Motion]
) -> FloatArray:
    gaps = np.full(len(positions), np.nan)
    for player in set(holder[holder >= 0].tolist()):
        joints, _ = retarget.motion_positions(motions[player])
        apart = np.linalg.norm(palms(joints) - positions[:, None], axis=2).min(axis=1)
        here = (holder == player) & ~free
        gaps[here] = apart[here]
    return gaps
