"""Made-up motions on the canonical body, smooth in time, for the tests of poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.records import FloatArray, Motion

MotionMaker = Callable[..., Motion]
SWINGING = [
    n for n, j in enumerate(body.JOINTS) if j[2:] in ("hip", "knee", "ankle", "shoulder", "elbow")
]


def swings(n_frames: int, seed: int, size: float) -> FloatArray:
    """Local rotations (frames, 21, 4) whose limbs swing without twist about slow random axes."""
    rng = np.random.default_rng(seed)
    time = np.arange(n_frames)[:, None] / 30.0
    local = np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))
    for joint in SWINGING:
        child = int(np.flatnonzero(joint == body.PARENTS)[0])
        bone = body.OFFSETS[child] / np.linalg.norm(body.OFFSETS[child])
        phases, rates = rng.uniform(0, 6, 3), rng.uniform(1, 4, 3)
        vector = size * np.sin(rates * time + phases)
        local[:, joint] = rotation.exp(vector - np.sum(vector * bone, axis=1)[:, None] * bone)
    return local


@pytest.fixture(scope="session")
def make_motion() -> MotionMaker:
    """A maker of smooth motions: limbs swing, the pelvis turns, walks a curve and bobs."""

    def make(n_frames: int = 90, seed: int = 0, size: float = 0.5, turn: float = 1.0) -> Motion:
        time = np.arange(n_frames) / 30.0
        local = swings(n_frames, seed, size)
        local[:, 0] = rotation.from_euler(
            np.stack([np.rad2deg(turn * time), 8 * np.sin(time), 5 * np.cos(2 * time)], axis=1),
            "YXZ",
        )
        root = np.stack([0.3 * time, 0.95 + 0.03 * np.sin(3 * time), np.sin(time)], axis=1)
        return Motion(local.astype(np.float32), root.astype(np.float32), 0.9)

    return make
