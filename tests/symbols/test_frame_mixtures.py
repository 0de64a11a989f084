"""How surprising frames are under a mixture of some of them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.symbols import activities


def surprise_slowly(
    values: np.ndarray, inside: np.ndarray, centres: np.ndarray, floor: float
) -> np.ndarray:
    """The same in plain NumPy, from given starts."""
    members = values[inside]
    centres = centres.copy()
    nearest = np.argmin(((members[:, None] - centres[None]) ** 2).sum(axis=2), axis=1)
    for _ in range(activities.ROUNDS):
        for part in np.unique(nearest):
            centres[part] = members[nearest == part].mean(axis=0)
        nearest = np.argmin(((members[:, None] - centres[None]) ** 2).sum(axis=2), axis=1)
    density = np.zeros(len(values))
    for part in np.unique(nearest):
        some = members[nearest == part]
        variance = some.var(axis=0) + floor * values.var(axis=0) + 1e-9
        squares = ((values - some.mean(axis=0)) ** 2 / variance).sum(axis=1)
        density += len(some) / len(members) * np.exp(-0.5 * squares) / np.sqrt(variance.prod())
    return -np.log(density)


def test_one_part_by_hand() -> None:
    values = np.array([[0.0], [2.0], [1.0]])
    inside = np.array([True, True, False])
    actual = activities.surprise(values, inside, np.random.default_rng(0), 1, 0.0)
    assert np.allclose(actual, [0.5, 0.5, 0.0], atol=1e-6)  # mean 1, variance 1


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 4))
def test_as_in_plain_numpy(seed: int, n_parts: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(40, 3))
    inside = np.arange(40) < 25
    starts = activities.far_apart(values[inside], n_parts, np.random.default_rng(seed))
    slow = surprise_slowly(values, inside, values[inside][starts], 0.3)
    quick = activities.surprise(values, inside, np.random.default_rng(seed), n_parts, 0.3)
    assert np.allclose(quick, slow)


def test_far_apart_frames_come_from_far_apart_groups() -> None:
    values = np.repeat([[0.0], [100.0], [-100.0]], 20, axis=0)
    chosen = activities.far_apart(values, 3, np.random.default_rng(3))
    assert sorted(values[chosen, 0].tolist()) == [-100.0, 0.0, 100.0]
