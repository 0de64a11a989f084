"""Smoothness of a motion beside its sources, with numbers worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.generate.material import SequenceMotion
from motiondb.generate.smoothness import measure_smoothness
from motiondb.records import Motion

STANDING = body.LEG_LENGTH + body.ANKLE_HEIGHT


def _standing(n_frames: int) -> Motion:
    local = np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))
    root = np.tile([0.0, STANDING, 0.0], (n_frames, 1))
    return Motion(local.astype(np.float32), root.astype(np.float32))


def _made(motion: Motion, capture: int) -> SequenceMotion:
    n = motion.n_frames
    return SequenceMotion(motion, np.full(n, capture), np.arange(n, dtype=float), ("",) * n, (n,))


def test_a_figure_that_slides_and_then_stops_beside_one_that_stands() -> None:
    """It slides at .3 m/s for 30 frames, 2 cm above the ground, and stops at once."""
    there = _standing(60)
    root = there.root_positions.copy()
    root[:, 2] = 0.01 * np.minimum(np.arange(60), 30)
    root[:, 1] += 0.02
    found = measure_smoothness(
        _made(replace(there, root_positions=root), 7), {7: there}.__getitem__
    )
    assert found.speed_jump == pytest.approx(0.3, abs=1e-4)
    # 30 frames at .3, one at .15 and 29 at 0: the central difference
    assert found.foot_slip == pytest.approx((30 * 0.3 + 0.15) / 60, abs=1e-4)
    assert found.toe_slip == pytest.approx(found.foot_slip)
    assert found.floating == pytest.approx(0.02, abs=1e-5)
    assert found.foot_slip_of_sources == found.toe_slip_of_sources == 0.0
    assert found.speed_jump_of_sources == 0.0
    assert found.floating_of_sources == pytest.approx(0.0, abs=1e-6)


def test_a_motion_of_no_capture_stands_alone() -> None:
    found = measure_smoothness(_made(_standing(30), -1), {}.__getitem__)
    assert found.foot_slip == found.speed_jump == 0.0
    assert found.foot_slip_of_sources is None
    assert found.floating_of_sources is None
