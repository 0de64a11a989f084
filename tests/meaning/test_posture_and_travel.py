"""How a body bears itself: numbers by hand, a slow twin, and what it tells apart."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body.features import N_FEATURES
from motiondb.meaning import movement

SPREAD = 2.0 / 3.0 * np.array([0.3, 0.3, 0.6, 0.9])
"""One spread of the four weighted velocities: 2 * (m/s or rad/s) * a third of a second."""


def slow_twin(features: np.ndarray, start: int, end: int) -> list[float]:
    """Every column by a loop over frames."""
    n_frames = len(features)
    r = [[float(features[t, 126 + d]) / SPREAD[d] for d in range(4)] for t in range(n_frames)]
    smooth = [
        np.mean([r[s] for s in range(max(t - 15, 0), min(t + 16, n_frames))], axis=0)
        for t in range(n_frames)
    ]
    posture = [np.mean([features[t, d] for t in range(start, end)]) for d in range(63)]
    places = [
        np.mean([1 / (1 + np.exp(-(smooth[t][d] - level) / 0.25)) for t in range(start, end)])
        for level in (-1.5, -0.75, 0.0, 0.75, 1.5)
        for d in range(4)
    ]
    sizes = [np.mean([abs(r[t][d]) for t in range(start, end)]) for d in range(4)]
    return [*posture, *places, *sizes]


def test_columns_equal_a_loop_over_frames() -> None:
    features = np.random.default_rng(0).normal(size=(47, N_FEATURES)).astype(np.float32)
    starts, ends = np.array([0, 20]), np.array([20, 47])
    actual = movement.describe_posture_and_travel(features, starts, ends)
    assert actual.shape == (2, movement.N_POSTURE + movement.N_TRAVEL) == (2, 87)
    for row, start, end in zip(actual, starts, ends):
        np.testing.assert_allclose(row, slow_twin(features, start, end), atol=1e-5)


def test_spreads_are_velocities() -> None:
    """0.3 m/s and 0.9 rad/s, as the features weigh them, are one spread."""
    root = 2.0 / 3.0 * np.array([[0.3, -0.3, 0.6, 0.9]])
    actual = movement.travel(root.astype(np.float32))[0]
    np.testing.assert_allclose(actual[20:], 1.0, rtol=1e-6)
    np.testing.assert_allclose(actual[[12, 5, 14, 15]], 1 / (1 + np.exp([-1.0, 1.0, -1.0, -1.0])))


def test_a_turn_to_the_left_is_not_one_to_the_right() -> None:
    root = np.zeros((40, 4), dtype=np.float32)
    root[:, 3] = SPREAD[3]
    left, right = (
        movement.travel(root).mean(axis=0),
        movement.travel(-root).mean(axis=0),
    )
    turning = np.arange(3, 20, 4)
    np.testing.assert_allclose(left[turning], 1.0 - right[turning][::-1])
    assert left[15] > 0.7 > 0.1 > right[15]  # surely above 0.75 spreads, and not
    assert left[23] == right[23] == pytest.approx(1.0)
