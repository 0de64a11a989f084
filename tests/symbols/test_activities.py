"""Activities of a take: groups by context, changes found again, their number by length."""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.symbols import activities


def moving(n_frames: int, period: float, height: float, rng: np.random.Generator) -> np.ndarray:
    """A made-up activity: eight features that swing at one pace about one height."""
    phase = 2 * np.pi * np.arange(n_frames)[:, None] / period
    swing = np.sin(phase + np.arange(8)) * (1.0 + 0.1 * np.arange(8))
    return height * np.linspace(-1, 1, 8) + swing + rng.normal(0, 0.05, (n_frames, 8))


def take_of_three(rng: np.random.Generator) -> np.ndarray:
    """Waves, stands, waves again, then something higher: 75 frames each."""
    still = rng.normal(0, 0.05, (75, 8)) + 1.0
    return np.concatenate(
        [moving(75, 12.0, 0.0, rng), still, moving(75, 12.0, 0.0, rng), moving(75, 20.0, 4.0, rng)]
    )


def best_runs_slowly(costs: np.ndarray, switch: float, shortest: int) -> float:
    """Least cost over every labelling whose runs are long enough."""
    n_frames, n_labels = costs.shape
    least = np.inf
    for labels in product(range(n_labels), repeat=n_frames):
        cuts = [0, *(np.flatnonzero(np.diff(labels)) + 1), n_frames]
        if min(np.diff(cuts)) >= shortest:
            cost = sum(costs[t, g] for t, g in enumerate(labels)) + switch * (len(cuts) - 2)
            least = min(least, cost)
    return least


def test_a_repeated_activity_keeps_its_number() -> None:
    features = take_of_three(np.random.default_rng(1))
    actual = activities.find_activities(features, np.random.default_rng(0), 3)
    assert [activity for _, _, activity in actual] == [0, 1, 0, 2]
    assert np.allclose([start for start, _, _ in actual], [0, 75, 150, 225], atol=8)


def test_without_a_number_the_take_tells_its_activities_apart() -> None:
    features = take_of_three(np.random.default_rng(1))
    actual = activities.find_activities(features, np.random.default_rng(0))
    wave, stand, again, high = (
        next(k for start, end, k in actual if start <= t < end) for t in (37, 112, 187, 262)
    )
    assert wave == again
    assert len({wave, stand, high}) == 3


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 2**31),
    st.integers(1, 9),
    st.integers(1, 2),
    st.integers(1, 4),
    st.sampled_from([0.0, 0.3, 2.0]),
)
def test_the_best_runs_are_those_of_a_search_over_all(
    seed: int, n_frames: int, n_labels: int, shortest: int, switch: float
) -> None:
    costs = np.random.default_rng(seed).random((n_frames, n_labels))
    if n_frames < shortest:
        return
    labels, cost = activities._best_runs(costs, switch, shortest)
    assert np.isclose(cost, best_runs_slowly(costs, switch, shortest))
    cuts = [0, *(np.flatnonzero(np.diff(labels)) + 1), n_frames]
    assert min(np.diff(cuts)) >= shortest
    paid = costs[np.arange(n_frames), labels].sum() + switch * (len(cuts) - 2)
    assert paid <= cost + 1e-9


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**31), st.integers(60, 200))
def test_activities_tile_the_capture(seed: int, n_frames: int) -> None:
    features = np.cumsum(np.random.default_rng(seed).normal(size=(n_frames, 3)), axis=0)
    actual = activities.find_activities(features, np.random.default_rng(seed))
    assert actual[0][0] == 0
    assert actual[-1][1] == n_frames
    assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(actual))


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


@pytest.mark.parametrize("n_frames", [0, 1, 59, 300])
def test_a_capture_that_is_short_or_still_is_one_activity(n_frames: int) -> None:
    features = np.ones((n_frames, 4))
    actual = activities.find_activities(
        features, np.random.default_rng(0), 5 if n_frames < 60 else None
    )
    assert actual == ([(0, n_frames, 0)] if n_frames else [])
