"""Tempo: speeds that "slowly" and "fast" ask for, and playing at another rate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import body, pose_vectors, rotation
from motiondb.generate import excerpt_motion


def _path(n_frames: int, speed: float) -> tuple[np.ndarray, np.ndarray]:
    path = np.zeros((n_frames, 4))
    path[:, 0], path[:, 2] = 0.9, speed
    return path, np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))


@given(st.floats(0.7, 1.4))
def test_another_rate_keeps_the_way(rate: float) -> None:
    path, turned = _path(61, 1.0)
    played, _ = excerpt_motion.resample(path, turned, rate)
    assert len(played) == int(60 / rate + 1e-9) + 1
    way = pose_vectors.from_path(path, turned).root_positions[-1, 2]
    turned = np.tile(turned[:1], (len(played), 1, 1))
    new = pose_vectors.from_path(played, turned).root_positions[-1, 2]
    assert new == pytest.approx(way, abs=rate / 30 + 1e-6)


def test_twice_the_rate_takes_every_second_frame() -> None:
    path, turned = _path(9, 1.0)
    path[:, 0] = np.arange(9)
    played, _ = excerpt_motion.resample(path, turned, 2.0)
    assert played[:, 0].tolist() == [0.0, 2.0, 4.0, 6.0, 8.0]
    assert played[:, 2].tolist() == [2.0] * 5


def test_speed_is_the_mean_over_the_joints() -> None:
    motion = pose_vectors.from_path(*_path(30, 1.5))
    np.testing.assert_allclose(excerpt_motion.joint_speeds(motion), 1.5, atol=1e-3)
    still = pose_vectors.from_path(*_path(1, 1.5))
    assert excerpt_motion.joint_speeds(still).tolist() == [0.0]


@given(st.floats(0.2, 4.0), st.lists(st.floats(0.2, 4.0), min_size=2, max_size=8), st.booleans())
def test_a_natural_rate_stays_within_the_captures(
    speed: float, speeds: list[float], fast: bool
) -> None:
    recorded = np.array([speed, *speeds])
    wanted = excerpt_motion.wanted_speed(recorded, fast)
    rate = excerpt_motion.natural_rate(speed, wanted, recorded, fast)
    assert recorded.min() - 1e-9 <= speed * rate <= recorded.max() + 1e-9
    assert (rate >= 1.0) if fast else (rate <= 1.0)
    assert 1.0 / excerpt_motion.MOST_CHANGE - 1e-9 <= rate <= excerpt_motion.MOST_CHANGE + 1e-9
