"""Small steps in place: feet stay where they are until the body has turned or moved too far.

A body that is turned or shifted over a clip of standing would drag its feet or twist its legs.
While a player waits, each foot has its own place. It stays there until it is 9 cm or 25 degrees
from where the clip would have it. Then, if the other foot is down, it is lifted and set down within
0.3 s where the clip will have it. Before the wait ends, both feet step to where the next clip has
them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, features, kinematics, pose_vectors, retarget, rotation
from motiondb.body.features import runs
from motiondb.records import FloatArray, Motion

SWING = 9  # Frames of a step: 0.3 s
LIFT = 0.07  # Height to which a stepping foot is raised, m
APART, TURNED = 0.09, np.radians(25.0)
"""Distance, m, and turn, rad, from its place at which a foot steps."""
_SETTLED, _SOLE = 0.015, 0.02
"""Distance, m, at which a foot needs no last step; lowest height of a toe, m."""
_I = body.INDEX


def footing(wanted: FloatArray, leading: bool) -> FloatArray:
    """Return both feet's places while a player stands: array (frames, 2, 4), x, y, z and heading.

    Shapes: `wanted` (frames, 2, 4), m and rad.

    >>> still = np.zeros((40, 2, 4))
    >>> bool((footing(still, True) == 0.0).all())
    True
    """
    n_frames = len(wanted)
    positions = np.repeat(wanted[:1], n_frames, axis=0)
    floor = np.minimum(wanted[0, :, 1], np.quantile(wanted[:, :, 1], 0.2, axis=0))
    positions[:, :, 1] = floor + (wanted[0, :, 1] - floor) * _fading(n_frames)
    busy = 0
    for frame in range(1, n_frames - SWING):
        if frame < busy:
            continue
        off = [_off(positions[frame, foot], wanted[frame, foot]) for foot in range(2)]
        foot = int(np.argmax(off))
        left = n_frames - 1 - frame
        settle = leading and left in (SWING, 2 * SWING) and off[foot] > _SETTLED
        if off[foot] < APART and not settle:
            continue
        if leading and not settle and left < 3 * SWING:
            continue  # the last two steps are kept for the end
        landing = min(frame + SWING + SWING // 2, n_frames - 1)
        landing = n_frames - 1 if settle else landing
        _step(positions[:, foot], wanted[landing, foot], frame)
        busy = frame + SWING
    return positions


def _fading(n_frames: int) -> FloatArray:
    """Return weights from 1 to 0 within a step, array (frames, 1)."""
    return np.clip(1.0 - np.arange(n_frames) / SWING, 0.0, 1.0)[:, None]


def _off(now: FloatArray, wanted: FloatArray) -> float:
    """Return how far a foot is from where it should be, m; 25 degrees count as 9 cm."""
    turn = abs(float(now[3] - wanted[3])) * APART / TURNED
    return max(float(np.hypot(now[0] - wanted[0], now[2] - wanted[2])), turn)


def _step(places: FloatArray, to: FloatArray, frame: int) -> None:
    """Lift a foot at ``frame``, set it down SWING frames later, and leave it there."""
    since = places[frame].copy()
    share = np.linspace(0.0, 1.0, SWING + 1)
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    here = slice(frame, frame + SWING + 1)
    ground = places[here, 1].copy()
    places[here] = since + smooth * (to - since)
    far = min(1.0, float(np.hypot(*(to - since)[[0, 2]])) / APART + abs(to[3] - since[3]) / TURNED)
    places[here, 1] = ground + LIFT * far * np.sin(np.pi * share)
    places[frame + SWING :, [0, 2, 3]] = to[[0, 2, 3]]


def step_feet(motion: Motion, waits: NDArray[np.bool_]) -> Motion:
    """Return the motion with its feet standing or stepping while it ``waits``, array (frames,)."""
    if not waits.any():
        return motion
    positions, world = retarget.motion_positions(motion)
    wanted = _wanted(positions, world)
    target, moved = wanted.copy(), np.zeros(len(wanted), dtype=bool)
    for start, end in runs(waits):
        if end - start > SWING:
            target[start:end] = footing(wanted[start:end], end < len(wanted))
            moved[start:end] = True
    toes = positions[:, [_I["l_toe"], _I["r_toe"]], 1] - wanted[:, :, 1]
    target[:, :, 1] = np.maximum(target[:, :, 1], _SOLE - toes)
    turns = target[:, :, 3] - wanted[:, :, 3]
    return move_ankles(motion, (positions, world), target[:, :, :3], moved, turns)


def move_ankles(
    motion: Motion,
    joints: tuple[FloatArray, FloatArray],
    target: FloatArray,
    moved: NDArray[np.bool_],
    turns: FloatArray | None = None,
) -> Motion:
    """Return the motion with its ankles moved by two-bone inverse kinematics.

    Shapes: `target` (frames, 2, 3), m; `moved` (frames,), bool; `turns` (frames, 2), rad.
    """
    positions, world = joints
    local = motion.local_rotations.astype(np.float64)
    ahead = rotation.rotate(world[:, 0], np.broadcast_to([0.0, 0.0, 1.0], (len(world), 3)))
    for foot, side in enumerate("lr"):
        hip, knee, ankle = (_I[f"{side}_{j}"] for j in ("hip", "knee", "ankle"))
        upper, lower = kinematics.two_bone(
            positions[:, hip], positions[:, knee], positions[:, ankle], target[:, foot], ahead
        )
        new_hip = rotation.multiply(upper, world[:, hip])
        new_knee = rotation.multiply(lower, world[:, knee])
        new_ankle = world[:, ankle]
        if turns is not None:
            new_ankle = rotation.multiply(pose_vectors.yaw(turns[:, foot]), new_ankle)
        for joint, turned in (
            (hip, rotation.relative(world[:, 0], new_hip)),
            (knee, rotation.relative(new_hip, new_knee)),
            (ankle, rotation.relative(new_knee, new_ankle)),
        ):
            local[moved, joint] = turned[moved]
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))


def _wanted(positions: FloatArray, world: FloatArray) -> FloatArray:
    """Return ankles and the heading of the body: array (frames, 2, 4)."""
    heading = np.unwrap(features.headings(world))
    feet = positions[:, [_I["l_ankle"], _I["r_ankle"]]]
    return np.concatenate([feet, np.repeat(heading[:, None, None], 2, axis=1)], axis=2)
