"""A choice that covers: against slow twins, and against the best of all choices."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from motiondb.curate import covering
from motiondb.records import Float32Array, FloatArray, IntArray


def some(seed: int) -> tuple[Float32Array, IntArray, FloatArray]:
    """Windows of twelve intervals, and what these cost."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 4, 12)
    owner = np.repeat(np.arange(12), counts)
    centres = rng.normal(size=(4, 3))[rng.integers(0, 4, 12)]
    vectors = centres[owner] + 0.4 * rng.normal(size=(len(owner), 3))
    return vectors.astype(np.float32), owner, counts + rng.uniform(0.0, 0.9, 12)


def mean_of(
    vectors: Float32Array, owner: IntArray, chosen: tuple[int, ...], weights: FloatArray
) -> float:
    inside = vectors[np.isin(owner, chosen)]
    apart = np.linalg.norm(vectors[:, None].astype(float) - inside[None], axis=2).min(axis=1)
    return float(weights @ apart / weights.sum())


@pytest.mark.parametrize("neighbours", [4, 1000])
@pytest.mark.parametrize("seed", range(6))
def test_no_choice_of_the_same_length_is_nearer_than_the_bound(seed: int, neighbours: int) -> None:
    vectors, owner, costs = some(seed)
    weights, budget = np.random.default_rng(seed).uniform(0.5, 2.0, len(owner)), 7.0
    found = covering.choose(vectors, owner, costs, weights, budget, neighbours=neighbours)
    assert costs[found.intervals].sum() <= budget
    assert found.mean == pytest.approx(
        mean_of(vectors, owner, tuple(found.intervals.tolist()), weights), abs=1e-4
    )
    best = min(
        mean_of(vectors, owner, each, weights)
        for size in range(1, 8)
        for each in combinations(range(12), size)
        if costs[list(each)].sum() <= budget
    )
    assert found.bound <= best + 1e-4
    assert best <= found.mean + 1e-4


@pytest.mark.parametrize("seed", range(4))
def test_the_lazy_choice_is_that_of_computing_every_gain_anew(seed: int) -> None:
    vectors, owner, costs = some(seed)
    found = covering.choose(vectors, owner, costs, np.ones(len(owner)), 9.0)
    apart = np.linalg.norm(vectors[:, None].astype(float) - vectors[None], axis=2)
    near = np.stack([apart[:, owner == n].min(axis=1) for n in range(12)])
    left, taken, spent = apart.max(axis=1), list[int](), 0.0
    while True:
        gains = np.maximum(left - near, 0.0).sum(axis=1) / costs
        gains[[n for n in range(12) if n in taken or spent + costs[n] > 9.0]] = -1.0
        if gains.max() < 0.0:
            break
        taken.append(int(gains.argmax()))
        spent += costs[taken[-1]]
        left = np.minimum(left, near[taken[-1]])
    assert found.intervals.tolist() == taken


def test_all_is_chosen_where_there_is_room_and_one_where_there_is_none() -> None:
    vectors, owner, costs = some(0)
    ones = np.ones(len(owner))
    every = covering.choose(vectors, owner, costs, ones, 1e9)
    assert sorted(every.intervals.tolist()) == list(range(12))
    assert max(every.mean, every.bound) < 1e-4  # of float32
    assert np.array_equal(every.nearest, owner)
    assert len(covering.choose(vectors, owner, costs, ones, 0.1).intervals) == 1


def test_distances_between_intervals_are_those_of_their_seconds() -> None:
    vectors = np.array([[0.0], [1.0], [5.0], [7.0]], dtype=np.float32)
    found = covering.between(vectors, np.array([0, 0, 1, 2]), np.array([2, 0]))
    assert found[0, 1] == pytest.approx(6.0)  # 7 to the nearer of 0 and 1
    assert found[1, 0] == pytest.approx(6.5)  # 0 and 1 to 7
    assert np.isinf(found.diagonal()).all()


def test_nobody_is_in_both_splits_and_the_share_is_near() -> None:
    seconds = {f"p{n}": 10.0 + n for n in range(10)}
    found = [covering.split(seconds, 0.2, np.random.default_rng(seed)) for seed in range(20)]
    for aside in found:
        assert 0 < len(aside) < 10
        assert abs(sum(seconds[name] for name in aside) - 0.2 * 145.0) <= 10.0
    assert len({tuple(sorted(aside)) for aside in found}) > 1
    assert covering.split({"a": 1.0, "b": 99.0}, 0.2, np.random.default_rng(0)) == {"a"}


@pytest.mark.parametrize("seed", range(3))
def test_motion_and_its_mirror_image_are_covered_by_that_of_others(seed: int) -> None:
    """By the slow twin, and under no choice's distance, with the bound."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(60, 3)).astype(np.float32)
    owner, costs = np.arange(60) // 2, np.full(30, 2.0)
    groups = rng.integers(5, size=30)[owner]
    images = vectors * np.array([-1.0, 1.0, 1.0], dtype=np.float32)
    apart = np.linalg.norm(np.concatenate([vectors, images])[:, None] - vectors, axis=2)
    apart[np.tile(groups, 2)[:, None] == groups] = np.inf
    weights = np.tile(np.bincount(groups)[groups] ** -0.5, 2)
    found = covering.choose(vectors, owner, costs, np.ones(60), 10.0, groups, images)

    def mean(intervals: list[int]) -> float:
        near = apart[:, np.isin(owner, intervals)].min(axis=1)
        return float(np.average(np.where(np.isfinite(near), near, far), weights=weights))

    far = np.where(np.isfinite(apart), apart, 0.0).max(axis=1)
    taken: list[int] = []
    for _ in range(5):
        left = [n for n in range(30) if n not in taken]
        taken.append(min(left, key=lambda n: mean([*taken, n])))
    assert found.intervals.tolist() == taken
    assert found.mean == pytest.approx(mean(taken), abs=1e-6)
    for _ in range(200):
        other = rng.choice(30, 5, replace=False).tolist()
        assert mean(other) >= found.bound - 1e-6


def test_a_window_is_shared_by_the_nearest_chosen_windows() -> None:
    vectors = np.arange(12.0, dtype=np.float32)[:, None]
    nearest, apart, stands = covering.nearest_of(vectors, np.arange(12) // 2, np.array([4, 0]))
    assert nearest.tolist() == [0] * 5 + [4] * 7
    assert apart.tolist() == [0, 0, 1, 2, 3, 3, 2, 1, 0, 0, 1, 2]
    assert stands.tolist() == [3, 3] + [0] * 6 + [3, 3] + [0] * 2  # four are fewer than ten
    vectors[5] += 0.1  # all but the farthest of eleven: 5 are not given to 10, and 7 not to 0
    stands = covering.nearest_of(vectors, np.arange(12), np.arange(11))[2]
    assert stands == pytest.approx([0.5, *[1.2] * 9, 0.7, 0.0])
