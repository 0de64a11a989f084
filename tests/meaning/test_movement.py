"""How segments move: numbers by hand, a slow twin, and what likeness makes of it."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body.features import N_FEATURES
from motiondb.meaning import resemblance, score_vectors
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMap


def slow_twin(frames: np.ndarray, start: int, end: int) -> list[float]:
    """Every column by a loop over frames."""
    n_frames, n_dims = frames.shape
    places = [
        np.mean([1 / (1 + np.exp(-(frames[t, d] - level) / 0.25)) for t in range(start, end)])
        for level in (-1.5, -0.75, 0.0, 0.75, 1.5)
        for d in range(n_dims)
    ]
    joint = [
        np.mean([frames[t, a] * frames[t, b] for t in range(start, end)])
        for a in range(n_dims)
        for b in range(a, n_dims)
    ]
    rhythm = [
        np.mean([abs(frames[min(t + lag, n_frames - 1), d] - frames[t, d])
                 for t in range(start, end)])
        for lag in (1, 2, 4, 8, 15)
        for d in range(n_dims)
    ]  # fmt: skip
    return [*places, *joint, *rhythm]


def test_columns_equal_a_loop_over_frames() -> None:
    frames = np.random.default_rng(0).normal(size=(23, 3)).astype(np.float32)
    starts, ends = np.array([0, 9]), np.array([9, 23])
    actual = score_vectors.describe_movement(frames, starts, ends)
    assert actual.shape == (2, sum(score_vectors.block_sizes(actual.shape[1] + 87)[:3]))
    for row, start, end in zip(actual, starts, ends):
        np.testing.assert_allclose(row, slow_twin(frames, start, end), atol=1e-5)


@pytest.mark.parametrize("n_dims", [1, 2, 24])
def test_block_sizes_are_found_from_their_sum(n_dims: int) -> None:
    sizes = (5 * n_dims, n_dims * (n_dims + 1) // 2, 5 * n_dims)
    assert score_vectors.block_sizes(sum(sizes) + 87) == (*sizes, 63, 24)


def test_every_block_weighs_as_much_as_the_symbols() -> None:
    rng = np.random.default_rng(1)
    scores = rng.normal(size=(4000, 5)).astype(np.float32)
    # one dimension: 5 + 1 + 5, then posture and travel
    moving = rng.normal(2.0, 3.0, size=(4000, 11 + 63 + 24)).astype(np.float32)
    space = score_vectors.fit_score_space(scores, np.ones(4000, dtype=np.int64), moving)
    rows = space.standardise(scores, moving)
    energy = [
        np.mean(np.sum(rows[:, a:b] ** 2, axis=1))
        for a, b in ((0, 5), (5, 10), (10, 11), (11, 16), (16, 79), (79, 103))
    ]
    weights = [1.0, *(score_vectors.block_weight(block) for block in range(5))]
    np.testing.assert_allclose(energy, energy[0] * np.square(weights), rtol=0.05)


def test_likeness_is_the_cosine_or_four_parts_meaning() -> None:
    vectors = unit(np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))
    np.testing.assert_allclose(
        resemblance.resemblance(vectors[0], vectors), [1.0, 0.5**0.5, 0.0], atol=1e-12
    )
    deaf_to_second = WordMap(np.array([[2.0], [0.0]]), *np.zeros((3, 1)), np.array([1.0, 1, 0]))
    actual = resemblance.resemblance(vectors[0], vectors, deaf_to_second)
    np.testing.assert_allclose(actual, [1.0, (4 + 0.5**0.5) / 5, 0.0], atol=1e-12)
    space = resemblance.meaning_space(deaf_to_second, dtype=np.float64)
    rows = space.rows(vectors)
    np.testing.assert_allclose(rows @ rows[0], actual, atol=1e-12)
    moving = resemblance.resemblance(vectors[0], vectors, deaf_to_second, n_posture_and_travel=1)
    np.testing.assert_allclose(moving, [1.0, 1.0, 0.0], atol=1e-12)  # (1, 0), (1, 1): alike in x


SPREAD = 2.0 / 3.0 * np.array([0.3, 0.3, 0.6, 0.9])
"""One spread of the four weighted velocities: 2 * (m/s or rad/s) * a third of a second."""


def slow_posture_and_travel(features: np.ndarray, start: int, end: int) -> list[float]:
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


def test_posture_and_travel_equal_a_loop_over_frames() -> None:
    features = np.random.default_rng(0).normal(size=(47, N_FEATURES)).astype(np.float32)
    starts, ends = np.array([0, 20]), np.array([20, 47])
    actual = score_vectors.describe_posture_and_travel(features, starts, ends)
    assert actual.shape == (2, score_vectors.N_POSTURE + score_vectors.N_TRAVEL) == (2, 87)
    for row, start, end in zip(actual, starts, ends):
        np.testing.assert_allclose(row, slow_posture_and_travel(features, start, end), atol=1e-5)


def test_spreads_are_velocities() -> None:
    """0.3 m/s and 0.9 rad/s, as the features weigh them, are one spread."""
    root = 2.0 / 3.0 * np.array([[0.3, -0.3, 0.6, 0.9]])
    actual = score_vectors.travel(root.astype(np.float32))[0]
    np.testing.assert_allclose(actual[20:], 1.0, rtol=1e-6)
    np.testing.assert_allclose(actual[[12, 5, 14, 15]], 1 / (1 + np.exp([-1.0, 1.0, -1.0, -1.0])))
