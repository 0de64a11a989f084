"""A motion of the canonical body on the joints and proportions of another skeleton, a *rig*.

Notation: C the world rotations of the canonical body in the pose in which the rig stands, R those
of the rig's joints there, C_t those of the motion at frame t. A rig's joint that has a role turns
by D_t = C_t C^-1 from its rest, so that it stands at D_t R; joints of the spine without a role turn
by a share between their neighbours, others with the joint from which they hang. So neither the pose
nor the axes of the rig matter.

The hips are placed by the length of the legs. Then two-bone inverse kinematics brings the ankles
and the wrists to their places in the motion, scaled alike; where the arms of the rig have other
proportions than ``LIKE_ARMS`` allows, the wrists keep their way from the shoulder, scaled by the
arm. Feet in contact are held as in generated motion (:mod:`.contact`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, changes, kinematics, retarget, rotation
from motiondb.body.contacts import find_contacts, foot_slip
from motiondb.body.joint_names import joint_map
from motiondb.generate import contact
from motiondb.records import MOTION_FPS, Clip, Fit, FloatArray, Motion, Skeleton

LIKE_ARMS = 1.25
"""Ratio of arm to leg, relative to the canonical body's, within which the hands are brought to
their places; beyond it they would pull arms straight or fold them."""
_TOE_HEIGHT = 0.02  # Of a toe over the ground in a flat stance of the canonical body, metres
_LOW, _HIGH = 0.02, 0.2  # Heights of an ankle over the ground that are believed, by the legs' scale
_I = body.INDEX


@dataclass(frozen=True, eq=False)
class Fitted:
    """A motion on a rig."""

    clip: Clip  # With y up
    rig: Clip  # The same, so that y is up
    fit: Fit


@dataclass(frozen=True, eq=False)
class _Rig:
    """A rig in its rest pose, with y up."""

    skeleton: Skeleton
    offsets: FloatArray  # (joints, 3): from the parent in the parent's frame
    places: FloatArray  # (joints, 3)
    turns: FloatArray  # (joints, 4): R
    points: FloatArray  # (21, 3): the canonical joints
    canonical: FloatArray  # (21, 4): C
    roles: Mapping[str, int]  # Role -> joint; those with a joint of their own
    hips: int
    drivers: Mapping[int, str]  # Joint -> role whose turn it has
    between: Mapping[int, tuple[str, str, float]]  # Joint -> roles above and below it, and share


def onto(motion: Motion, rig: Clip, user_map: Mapping[str, str] | None = None) -> Fitted:
    """Put a motion on a rig, which stands in the first frame of a clip (SkeletonError)."""
    turned = changes.upright(rig, user_map)
    one = _read_rig(turned, user_map)
    scale = retarget.legs_of(one.points[None]) / body.LEG_LENGTH
    places, world = retarget.motion_positions(motion)
    lift = _ankle_height(one, scale) - scale * body.ANKLE_HEIGHT
    wanted = places * scale + np.array([0.0, lift, 0.0])
    turns = rotation.normalize(rotation.multiply(world, rotation.conjugate(one.canonical)))
    moves = motion.n_frames > 1
    contacts = find_contacts(places) if moves else np.zeros((1, 2), dtype=bool)
    hips = _hips(one, wanted, turns)
    hands, how = _hand_targets(one, places, wanted, scale)
    turns = _reach_hands(one, turns, hips, hands)
    feet = {side: wanted[:, _I[f"{side}_ankle"]] for side in "lr"}
    turns = _reach_feet(one, turns, hips, feet)
    held = _held(one, turns, hips, contacts, (scale, lift))
    turns = _reach_feet(one, held[0], hips, held[1])
    local, at = _pose(one, turns, hips)
    clip = replace(
        turned,
        fps=MOTION_FPS,
        local_rotations=rotation.unroll(local),
        root_positions=at[:, 0].copy(),
        joint_positions=_moved(one, local, at),
        notes=(),
    )
    toes = {side: _toes(one, at, _joint_turns(one, turns), side) for side in feet}
    fit = _measure(one, at, (feet, hands, toes), contacts, scale, how)
    slip = foot_slip(motion) * scale if moves else 0.0
    return Fitted(clip, turned, replace(fit, slip_of_motion=slip))


def _read_rig(rig: Clip, user_map: Mapping[str, str] | None) -> _Rig:
    """Find what drives each joint of a rig."""
    skeleton = rig.skeleton
    first = changes.part(rig, 0, 1)
    roles = joint_map(skeleton, user_map)
    points = retarget.clip_keypoints(first, user_map)
    solved = retarget.solve_rotations(points)
    canonical = kinematics.forward(body.PARENTS, body.OFFSETS, solved, points[:, 0])[1][0]
    places, turns = (values[0] for values in kinematics.clip_positions(first))
    offsets = skeleton.offsets if rig.joint_positions is None else rig.joint_positions[0]
    hips = changes.hips_joint(skeleton, user_map)
    own = {role: joint for role, joint in roles.items() if joint >= 0}
    drivers = {joint: role for role, joint in own.items() if joint != hips}
    drivers[hips] = "pelvis"
    for side in "lr":
        above = int(skeleton.parents[own[f"{side}_shoulder"]])
        if above not in drivers and not kinematics.is_below(skeleton.parents, own["neck"], above):
            drivers[above] = f"{side}_collar"
    between = _between(skeleton, drivers, hips, own)
    return _Rig(skeleton, offsets, places, turns, points[0], canonical, own, hips, drivers, between)


def _between(
    skeleton: Skeleton, drivers: Mapping[int, str], hips: int, own: Mapping[str, int]
) -> dict[int, tuple[str, str, float]]:
    """Return the joints from the hips to the head without a role, with their neighbours."""
    chain = [own.get("head", own["neck"])]
    while chain[-1] != hips and skeleton.parents[chain[-1]] >= 0:
        chain.append(int(skeleton.parents[chain[-1]]))
    chain = chain[::-1]
    known = [place for place, joint in enumerate(chain) if joint in drivers]
    found = {}
    for low, high in pairwise(known):
        for place in range(low + 1, high):
            share = (place - low) / (high - low)
            found[chain[place]] = (drivers[chain[low]], drivers[chain[high]], share)
    return found


def _joint_turns(rig: _Rig, turns: FloatArray) -> FloatArray:
    """Return the turn of every joint from its rest: array (frames, joints, 4)."""
    n_joints = len(rig.skeleton.names)
    each = np.empty((len(turns), n_joints, 4))
    for joint in range(n_joints):
        parent = int(rig.skeleton.parents[joint])
        if joint in rig.drivers:
            each[:, joint] = turns[:, _I[rig.drivers[joint]]]
        elif joint in rig.between:
            above, below, share = rig.between[joint]
            shares = np.full(len(turns), share)
            each[:, joint] = rotation.slerp(turns[:, _I[above]], turns[:, _I[below]], shares)
        else:
            each[:, joint] = each[:, parent] if parent >= 0 else rotation.IDENTITY
    return each


def _pose(rig: _Rig, turns: FloatArray, hips: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return local rotations (frames, joints, 4) and places (frames, joints, 3) of a rig."""
    each = _joint_turns(rig, turns)
    world = rotation.multiply(each, np.broadcast_to(rig.turns, each.shape))
    local, places = world.copy(), np.empty((*world.shape[:2], 3))
    for joint, parent in enumerate(rig.skeleton.parents.tolist()):
        if parent >= 0:
            local[:, joint] = rotation.relative(world[:, parent], world[:, joint])
        if joint == rig.hips:
            places[:, joint] = hips
        elif parent < 0:
            places[:, joint] = rig.places[joint]
        else:
            way = np.broadcast_to(rig.offsets[joint], (len(world), 3))
            places[:, joint] = places[:, parent] + rotation.rotate(world[:, parent], way)
    return local, places


def _moved(rig: _Rig, local: FloatArray, places: FloatArray) -> FloatArray | None:
    """Return the places in the parents' frames, if the hips move below another joint."""
    if rig.hips == 0:
        return None
    moved = np.repeat(rig.offsets[None], len(local), axis=0)
    moved[:, 0] = places[:, 0]
    above = int(rig.skeleton.parents[rig.hips])
    back = np.broadcast_to(rotation.conjugate(rig.turns[above]), (len(local), 4))
    moved[:, rig.hips] = rotation.rotate(back, places[:, rig.hips] - places[:, above])
    return moved


def _hips(rig: _Rig, wanted: FloatArray, turns: FloatArray) -> FloatArray:
    """Return the places (frames, 3) of the joint of the hips, from those between the legs."""
    middle = rig.points[0] - rig.places[rig.hips]
    return wanted[:, 0] - rotation.rotate(turns[:, 0], np.broadcast_to(middle, (len(turns), 3)))


def _ankle_height(rig: _Rig, scale: float) -> float:
    """Return the height of the ankles over the ground on which a rig stands, metres."""
    ankles = rig.points[[_I["l_ankle"], _I["r_ankle"]], 1].mean()
    toes = rig.points[[_I["l_toe"], _I["r_toe"]], 1].mean()
    height = float(ankles - toes) + _TOE_HEIGHT * scale
    return float(np.clip(height, _LOW * scale, _HIGH * scale))


def _hand_targets(
    rig: _Rig, places: FloatArray, wanted: FloatArray, scale: float
) -> tuple[dict[str, FloatArray], str]:
    """Return the places (frames, 3) of the wrists, and how they were found; none without wrists."""
    lengths = []
    for side in "lr":
        arm = [_I[f"{side}_{joint}"] for joint in ("shoulder", "elbow", "wrist")]
        steps = np.diff(rig.points[arm], axis=0), np.diff(places[:1, arm][0], axis=0)
        lengths.append([float(np.linalg.norm(step, axis=1).sum()) for step in steps])
    ratio = float(np.mean([ours / theirs for ours, theirs in lengths]))
    is_like = 1.0 / LIKE_ARMS < ratio / scale < LIKE_ARMS
    found = {}
    for side in "lr":
        wrist, shoulder = _I[f"{side}_wrist"], _I[f"{side}_shoulder"]
        if is_like:
            found[side] = wanted[:, wrist]
        else:
            found[side] = wanted[:, shoulder] + ratio * (places[:, wrist] - places[:, shoulder])
    return found, "in place" if is_like else "by the arm"


def _reach(
    rig: _Rig,
    turns: FloatArray,
    hips: FloatArray,
    chain: tuple[str, str, str],
    target: FloatArray,
    ahead: FloatArray,
) -> FloatArray:
    """Turn the upper two joints of a chain so that its end reaches a target (frames, 3)."""
    if any(role not in rig.roles for role in chain):
        return turns
    at = _pose(rig, turns, hips)[1]
    first, second, end = (at[:, rig.roles[role]] for role in chain)
    target = contact.without_pop(first, second, end, target - end)
    upper, lower = kinematics.two_bone(first, second, end, target, ahead)
    new = turns.copy()
    new[:, _I[chain[0]]] = rotation.multiply(upper, turns[:, _I[chain[0]]])
    new[:, _I[chain[1]]] = rotation.multiply(lower, turns[:, _I[chain[1]]])
    return new


def _reach_hands(
    rig: _Rig, turns: FloatArray, hips: FloatArray, targets: Mapping[str, FloatArray]
) -> FloatArray:
    """Bring the wrists to their places; the hand turns with the forearm."""
    back = rotation.rotate(turns[:, _I["chest"]], np.tile([0.0, 0.0, -1.0], (len(turns), 1)))
    for side in "lr":
        chain = (f"{side}_shoulder", f"{side}_elbow", f"{side}_wrist")
        before = turns[:, _I[chain[1]]]
        turns = _reach(rig, turns, hips, chain, targets[side], back)
        added = rotation.multiply(turns[:, _I[chain[1]]], rotation.conjugate(before))
        turns[:, _I[chain[2]]] = rotation.multiply(added, turns[:, _I[chain[2]]])
    return turns


def _reach_feet(
    rig: _Rig, turns: FloatArray, hips: FloatArray, targets: Mapping[str, FloatArray]
) -> FloatArray:
    """Bring the ankles to their places; the feet keep their direction."""
    ahead = rotation.rotate(turns[:, 0], np.tile([0.0, 0.0, 1.0], (len(turns), 1)))
    for side in "lr":
        chain = (f"{side}_hip", f"{side}_knee", f"{side}_ankle")
        turns = _reach(rig, turns, hips, chain, targets[side], ahead)
    return turns


def _toes(rig: _Rig, at: FloatArray, each: FloatArray, side: str) -> FloatArray:
    """Return the places (frames, 3) of a toe, of the rig or where the foot ends."""
    if f"{side}_toe" in rig.roles:
        return at[:, rig.roles[f"{side}_toe"]]
    ankle = rig.roles[f"{side}_ankle"]
    way = rig.points[_I[f"{side}_toe"]] - rig.points[_I[f"{side}_ankle"]]
    return at[:, ankle] + rotation.rotate(each[:, ankle], np.broadcast_to(way, at[:, ankle].shape))


def _held(
    rig: _Rig,
    turns: FloatArray,
    hips: FloatArray,
    contacts: NDArray[np.bool_],
    size: tuple[float, float],
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return turns of the feet, and places of the ankles, that hold feet which are in contact.

    `size`: The rig's scale, and its height above the scaled body.
    """
    scale, lift = size
    at, each = _pose(rig, turns, hips)[1], _joint_turns(rig, turns)
    targets, turns = {}, turns.copy()
    for foot, side in enumerate("lr"):
        if f"{side}_ankle" not in rig.roles:
            continue
        ankle = at[:, rig.roles[f"{side}_ankle"]]
        up = np.array([0.0, lift, 0.0])
        ends = (ankle - up) / scale, (_toes(rig, at, each, side) - up) / scale
        turned, moved = contact.hold(*ends, contacts[:, foot])
        targets[side] = ankle + moved * scale
        for joint in ("ankle", "toe"):
            number = _I[f"{side}_{joint}"]
            turns[:, number] = rotation.multiply(turned, turns[:, number])
    return turns, targets


def _measure(
    rig: _Rig,
    at: FloatArray,
    targets: tuple[Mapping[str, FloatArray], ...],
    contacts: NDArray[np.bool_],
    scale: float,
    how: str,
) -> Fit:
    """Measure how far feet and hands are from their places, and how feet in contact slide.

    `targets`: Where ankles and wrists should be, and where the toes are, by side.
    """
    errors = []
    for joint, wanted in zip(("ankle", "wrist"), targets):
        sides = [side for side in "lr" if f"{side}_{joint}" in rig.roles]
        away = [at[:, rig.roles[f"{side}_{joint}"]] - wanted[side] for side in sides]
        errors.append(np.linalg.norm(np.array(away).reshape(-1, 3), axis=-1))
    feet, hands = (error if len(error) else np.zeros(1) for error in errors)
    slips = []
    for foot, side in enumerate("lr"):
        if len(at) > 1:
            ends = np.stack([at[:, rig.roles[f"{side}_ankle"]], targets[2][side]], axis=1)
            steps = np.gradient(ends[..., [0, 2]], axis=0)
            speeds = np.linalg.norm(steps, axis=-1).min(axis=1) * MOTION_FPS
            slips += speeds[contacts[:, foot]].tolist()
    return Fit(
        float(scale),
        float(feet.mean()),
        float(feet.max()),
        float(hands.mean()),
        float(hands.max()),
        how,
        float(np.mean(slips)) if slips else 0.0,
        0.0,
        len(rig.skeleton.names),
        len(rig.drivers) + len(rig.between),
    )


def at_rest(clip: Clip, rig: Clip) -> Clip:
    """Return a clip on a rig so that the pose in which the rig stands has no rotations, as in BVH.

    The frames of all joints are then parallel to the world's in that pose.
    """
    turns = kinematics.clip_positions(changes.part(rig, 0, 1))[1][0]
    parents = clip.skeleton.parents
    world = kinematics.clip_positions(clip)[1]
    world = rotation.multiply(world, np.broadcast_to(rotation.conjugate(turns), world.shape))
    local, offsets = world.copy(), clip.skeleton.offsets.copy()
    moved = None if clip.joint_positions is None else clip.joint_positions.copy()
    for joint, parent in enumerate(parents.tolist()):
        if parent >= 0:
            local[:, joint] = rotation.relative(world[:, parent], world[:, joint])
            offsets[joint] = rotation.rotate(turns[parent], offsets[joint])
            if moved is not None:
                turn = np.broadcast_to(turns[parent], (len(moved), 4))
                moved[:, joint] = rotation.rotate(turn, moved[:, joint])
    ends = tuple(
        (joint, tuple(rotation.rotate(turns[joint], np.array(end)).tolist()))
        for joint, end in clip.skeleton.end_sites
    )
    skeleton = replace(clip.skeleton, offsets=offsets, end_sites=ends)
    return replace(
        clip,
        skeleton=skeleton,
        local_rotations=rotation.unroll(local),
        joint_positions=moved,
    )
