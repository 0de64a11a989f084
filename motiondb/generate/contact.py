"""Foot contacts: removal of foot sliding by inverse kinematics.

Contacts are those of :mod:`motiondb.body.contacts`. A contact has phases:
the ankle is down until the heel is lifted, the toe from when it touches the ground. What is down is
held in place; where both are, it is the one that moves less, and the foot does not turn. So a foot
rolls over its toe and neither end slides. The place is that of least correction, the median over
the contact; before and after, the correction fades out over ``FADE`` frames, so that the motion
stays continuous. Two-bone inverse kinematics moves the ankle to the corrected place, or as near to
it as is possible without snapping the knee straight. Otherwise the foot keeps its orientation in
the world, and it is lifted where ankle or toe would be below the ground.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from motiondb.body import body, kinematics, retarget, rotation
from motiondb.body.contacts import TOE_HEIGHT, find_contacts, steady
from motiondb.body.features import runs
from motiondb.body.pose_vectors import yaw
from motiondb.records import FloatArray, Motion

FADE = 6  # Frames (0.2 s) over which a correction fades in and out
DOWN = 0.015  # Height above its lowest in a contact up to which an ankle or toe is down, metres
CLEARANCE, CLEARED = 0.04, 3
"""A foot that would swing below the ground is lifted by up to that many metres above it, rising
over that many frames from its last contact."""
LOW_SWING = 0.03
"""Height, metres, below which a foot that swings through a seam is lifted too: between two poses it
would glide over the ground."""
MOST_TURN = 0.6  # Largest correction of the direction of a foot, radians
_I = body.INDEX


def lock_feet(
    motion: Motion,
    free: NDArray[np.bool_] | None = None,
    contacts: NDArray[np.bool_] | None = None,
    bent: NDArray[np.bool_] | None = None,
) -> Motion:
    """Hold the feet in place while they are in contact; bone lengths do not change.

    Never at frames that are `free` (frames,); `contacts` (frames, 2) adds to those detected; `bent`
    (frames,): which frames a seam bends.
    """
    if motion.n_frames < 3:
        return motion
    positions, world = retarget.motion_positions(motion)
    seen = find_contacts(positions)
    contacts = seen if contacts is None else steady(seen | contacts)
    if free is not None:
        contacts[free] = False
    local = motion.local_rotations.astype(np.float64)
    for foot, side in enumerate("lr"):
        hip, knee, ankle, toe = (_I[f"{side}_{j}"] for j in ("hip", "knee", "ankle", "toe"))
        turned, moved = hold(positions[:, ankle], positions[:, toe], contacts[:, foot], bent)
        target = without_pop(positions[:, hip], positions[:, knee], positions[:, ankle], moved)
        ahead = rotation.rotate(
            world[:, 0], np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(target), 3))
        )
        upper, lower = kinematics.two_bone(
            positions[:, hip], positions[:, knee], positions[:, ankle], target, ahead
        )
        new_hip = rotation.multiply(upper, world[:, hip])
        new_knee = rotation.multiply(lower, world[:, knee])
        local[:, hip] = rotation.relative(world[:, 0], new_hip)
        local[:, knee] = rotation.relative(new_hip, new_knee)
        local[:, ankle] = rotation.relative(new_knee, rotation.multiply(turned, world[:, ankle]))
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))


def hold(
    ankle: FloatArray,
    toe: FloatArray,
    contact: NDArray[np.bool_],
    bent: NDArray[np.bool_] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Turns (frames, 4) of a foot and displacements (frames, 3) of its ankle that hold it in place.

    `ankle` and `toe` (frames, 3) on the standard body, `contact` (frames,); `bent` (frames,): which
    frames a seam bends.
    """
    phases = _phases(np.stack([ankle, toe], axis=1)[..., 1], contact)
    along = toe - ankle
    turned = yaw(_turns(along, phases))
    swing = np.zeros(len(ankle)) if bent is None else LOW_SWING * bent.astype(np.float64)
    moved = _corrections(ankle, ankle + rotation.rotate(turned, along), contact, phases, swing)
    return turned, moved


def without_pop(
    hip: FloatArray, knee: FloatArray, ankle: FloatArray, moved: FloatArray
) -> FloatArray:
    """Targets (frames, 3) of the ankle that do not snap the knee straight.

    When the leg is nearly straight, a millimetre of reach moves the knee by centimetres. Therefore
    the knee's distance from the line through hip and ankle may decrease by no more than the ankle
    is moved; otherwise the target is moved towards the hip.
    """
    a, b = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    line = rotation.normalize(ankle - hip)
    aside = np.linalg.norm(np.cross(knee - hip, line), axis=1)
    least = np.maximum(aside - np.linalg.norm(moved, axis=1), 0.0)
    longest = np.sqrt(np.maximum(a * a - least * least, 0.0))
    longest += np.sqrt(np.maximum(b * b - least * least, 0.0))
    wanted = ankle + moved - hip
    reach = np.linalg.norm(wanted, axis=1)
    return hip + wanted * np.minimum(1.0, longest / np.maximum(reach, 1e-9))[:, None]


def _phases(heights: FloatArray, contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of ankle and toe is down in a contact: array (frames, 2); heights (frames, 2), m."""
    phases = np.zeros((len(heights), 2), dtype=bool)
    for start, end in runs(contact):
        above = heights[start:end] - heights[start:end].min(axis=0)
        phases[start:end] = above <= np.maximum(above.min(axis=1, keepdims=True), DOWN)
    return phases


def _turns(along: FloatArray, phases: NDArray[np.bool_]) -> FloatArray:
    """Turns that hold the direction of a foot (frames, 3) while all of it is down: (frames,)."""
    angle = np.unwrap(np.arctan2(along[:, 0], along[:, 2]))
    flat = np.asarray(phases.all(axis=1))
    turns = np.zeros((len(along), 1))
    for start, end in runs(flat):
        turns[start:end, 0] = np.median(angle[start:end]) - angle[start:end]
    turns = np.clip(turns, -MOST_TURN, MOST_TURN)
    return _fade(turns, flat)[:, 0] if flat.any() else turns[:, 0]


def _corrections(
    ankle: FloatArray,
    toe: FloatArray,
    contact: NDArray[np.bool_],
    phases: NDArray[np.bool_],
    swing: FloatArray,
) -> FloatArray:
    """Displacement of the ankle in every frame: array (frames, 3), metres.

    `swing` (frames,): height, metres, below which a foot that swings is lifted.
    """
    n_frames = len(ankle)
    moved = np.zeros((n_frames, 3))
    for start, end in runs(contact):
        steps = np.diff(np.stack([ankle, toe], axis=1)[start:end][..., [0, 2]], axis=0)
        flat = np.asarray(phases[start:end].all(axis=1))
        flat = flat[1:] & flat[:-1]
        toe_moves_less = _length(steps[flat, 1]) < _length(steps[flat, 0])
        by_toe = np.where(flat, toe_moves_less, phases[start + 1 : end, 1])
        held = -np.cumsum(np.where(by_toe[:, None], steps[:, 1], steps[:, 0]), axis=0)
        held = np.concatenate([np.zeros((1, 2)), held])
        moved[start:end, [0, 2]] = held - np.median(held, axis=0)
    lowest = np.minimum(ankle[:, 1] - body.ANKLE_HEIGHT, toe[:, 1] - TOE_HEIGHT)
    swings = uniform_filter1d(1.0 - contact, 2 * CLEARED + 1) * ~contact
    swings = uniform_filter1d(swings * (lowest < swing), CLEARED)
    moved[:, 1] = np.maximum(-lowest, 0.0) + CLEARANCE * swings * ~contact
    if contact.any():
        moved[:, [0, 2]] = _fade(moved[:, [0, 2]], contact)
    return moved


def _fade(moved: FloatArray, fixed: NDArray[np.bool_]) -> FloatArray:
    """Corrections between fixed frames, blended from one to the next, or to 0 over FADE frames."""
    frames = np.arange(len(moved))
    known = np.flatnonzero(fixed)
    after = np.searchsorted(known, frames)
    before_at = known[np.clip(after - 1, 0, len(known) - 1)]
    after_at = known[np.clip(after, 0, len(known) - 1)]
    left = np.clip(1.0 - (frames - before_at) / FADE, 0.0, 1.0) * (frames >= before_at)
    right = np.clip(1.0 - (after_at - frames) / FADE, 0.0, 1.0) * (frames <= after_at)
    left, right = left * left * (3 - 2 * left), right * right * (3 - 2 * right)
    total = np.maximum(left + right, 1.0)[:, None]
    blended = (left[:, None] * moved[before_at] + right[:, None] * moved[after_at]) / total
    return np.where(fixed[:, None], moved, blended)


def _length(steps: FloatArray) -> float:
    return float(np.linalg.norm(steps, axis=-1).sum())
