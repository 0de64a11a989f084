"""Medoids, the objective, cells and the exchange search."""

import naive_terminals as naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import candidates, distances, exchange, tuning
from motiondb.grammar.terminals.distances import (
    Poses,
    segment_distance,
    segment_distances,
)
from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.terminals import score
from motiondb.records import Motion


def points(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(n, 2))
    return np.linalg.norm(places[:, None] - places[None], axis=2)


def energy(
    distances: np.ndarray, medoids: np.ndarray, weights: np.ndarray, prices: np.ndarray
) -> float:
    return float((weights * distances[:, medoids].min(axis=1)).sum() + prices[medoids].sum())


@settings(max_examples=30, deadline=None)
@given(st.integers(2, 9), st.data(), st.integers(0, 10_000))
def test_no_single_swap_lowers_the_sum(n: int, data: st.DataObject, seed: int) -> None:
    k = data.draw(st.integers(1, n))
    rng = np.random.default_rng(seed)
    distances, weights, prices = points(n, seed), rng.uniform(1, 3, n), rng.uniform(0, 0.5, n)
    medoids, labels = group_by_medoids(distances, k, weights=weights, prices=prices)
    actual = energy(distances, medoids, weights, prices)
    assert actual >= naive.best_medoids(distances, k, weights, prices) - 1e-9
    for position in range(k):
        for other in set(range(n)) - set(medoids.tolist()):
            swapped = medoids.copy()
            swapped[position] = other
            assert energy(distances, swapped, weights, prices) >= actual - 1e-9
    assert (labels[medoids] == np.arange(k)).all()


def test_swaps_end_near_the_best_and_below_medoids_by_turns() -> None:
    """The sums of E over sixty small cases; every answer is compared with all choices."""
    ones, none = np.ones(9), np.zeros(9)
    swapped, turned, best = [], [], []
    for seed in range(60):
        distances = points(9, seed)
        swapped.append(energy(distances, group_by_medoids(distances, 3)[0], ones, none))
        turned.append(energy(distances, naive.medoids_by_turns(distances, 3), ones, none))
        best.append(naive.best_medoids(distances, 3, ones, none))
    assert sum(best) <= sum(swapped) < 1.02 * sum(best)
    assert sum(swapped) < sum(turned)


def test_things_that_coincide_leave_no_group_empty() -> None:
    medoids, labels = group_by_medoids(np.zeros((5, 5)), 3)
    assert sorted(np.unique(labels)) == [0, 1, 2]
    assert len(set(medoids.tolist())) == 3


def test_more_groups_than_things_are_refused() -> None:
    with pytest.raises(GrammarError, match="expected 1 to 3 groups for 3 segments, found 4"):
        group_by_medoids(np.zeros((3, 3)), 4)
    with pytest.raises(GrammarError, match="found 0"):
        group_by_medoids(np.zeros((3, 3)), 0)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 8), st.data(), st.integers(0, 10_000))
def test_r_and_e_are_shares_and_r_is_1_exactly_where_every_segment_is_a_medoid(
    n: int, data: st.DataObject, seed: int
) -> None:
    k = data.draw(st.integers(1, n))
    distances = points(n, seed)
    lengths = np.random.default_rng(seed).integers(1, 30, n)
    medoids, labels = group_by_medoids(distances, k)
    gaps = distances[np.arange(n), medoids[labels]]
    largest = max(float(distances.max()), 1e-9)
    actual = score(lengths, medoids, gaps, largest, 0.5)
    assert 0.0 < actual.repetition <= 1.0
    assert 0.0 <= actual.error <= 1.0
    assert (actual.repetition == 1.0) == (n == k)
    assert actual.objective == pytest.approx(2.0 / (actual.repetition + actual.error))


def made_poses(bounds: list[int], seed: int = 0) -> Poses:
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.normal(0, 0.3, (bounds[-1], 3)), axis=0).astype(np.float32)
    return Poses(values, np.array(bounds), 10.0, rng.uniform(0, 1, bounds[-1]))


def test_cuts_are_never_farther_apart_than_the_grid() -> None:
    poses = made_poses([0, 45, 200])
    cuts = candidates.candidate_cuts(poses, 10, 8)
    assert np.diff(cuts).max() <= 10
    assert set(poses.bounds) <= set(cuts)


def test_cells_stay_in_their_take_and_in_their_bounds() -> None:
    poses = made_poses([0, 5, 60, 121])
    cuts = candidates.candidate_cuts(poses, 6, 8)
    cells = candidates.make_cells(cuts, cuts, poses.bounds, 8, 30)
    lengths = cells.ends - cells.starts
    take = np.searchsorted(poses.bounds, cells.starts, side="right")
    assert (cells.ends <= poses.bounds[take]).all()
    assert (lengths <= 30).all()
    assert lengths[lengths < 8].tolist() == [5]  # the first take is shorter than a segment


def all_paths(cells: candidates.Cells, cut: int) -> list[list[int]]:
    if cut == 0:
        return [[]]
    return [
        [*path, c]
        for c in range(cells.pointers[cut], cells.pointers[cut + 1])
        for path in all_paths(cells, int(cells.firsts[c]))
    ]


def test_the_cheapest_path_is_the_cheapest_of_all() -> None:
    cuts = np.array([0, 4, 6, 9, 13, 15, 20])
    cells = candidates.make_cells(cuts, cuts, np.array([0, 9, 20]), 4, 11)
    rng = np.random.default_rng(3)
    costs, at_cuts = rng.uniform(0, 1, len(cells.firsts)), rng.uniform(0, 0.2, len(cuts))
    actual, path = candidates.cheapest_path(cells, costs, at_cuts)
    prices = [sum(costs[c] + at_cuts[cells.lasts[c]] for c in p) for p in all_paths(cells, 6)]
    assert actual == pytest.approx(min(prices))
    assert actual == pytest.approx(sum(costs[path] + at_cuts[cells.lasts[path]]))


def test_a_bounded_path_has_as_many_cells_as_asked() -> None:
    cuts = np.arange(0, 101, 5)
    cells = candidates.make_cells(cuts, cuts, np.array([0, 100]), 5, 50)
    costs, none = np.random.default_rng(0).uniform(0, 1, len(cells.firsts)), np.zeros(len(cuts))
    for fewest, most in ((1, 3), (8, None), (20, None), (4, 9)):
        path = candidates.bounded_path(cells, costs, none, fewest, most)
        assert fewest <= len(path) <= (most or 20)


def made_task(n_groups: int, price: float = 0.2) -> exchange.Task:
    poses = made_poses([0, 60, 140])
    cuts = candidates.candidate_cuts(poses, 10, 8)
    cells = candidates.make_cells(cuts, cuts, poses.bounds, 8, 40)
    return exchange.Task(poses, cells, np.full(len(cuts), 0.5), price, n_groups)


@pytest.mark.parametrize("n_groups", [1, 4])
def test_exchanges_lower_the_cost_to_what_it_is_from_nothing(n_groups: int) -> None:
    task = made_task(n_groups)
    rng = np.random.default_rng(0)
    state = exchange.first_state(task, rng)
    before = state.cost
    _, state = exchange.improve(task, state, rng, 300)
    assert state.cost < before
    again = exchange.anneal(task, exchange.rhythmic_state(task, rng), rng, 300)
    assert abs(again.cost / state.cost - 1.0) < 0.3
    table = np.empty((n_groups, len(task.cells.firsts)), dtype=np.float32)
    for k, medoid in enumerate(state.medoids):
        exchange.cell_costs(task, int(medoid), table[k])
    path_cost, _ = candidates.cheapest_path(task.cells, table.min(axis=0), task.cut_costs)
    lengths = (task.cells.ends - task.cells.starts)[state.medoids]
    assert state.cost == pytest.approx(path_cost + task.medoid_price * lengths.sum(), rel=1e-6)


N_FRAMES = 300
BOUNDS = (0, 110, 300)


def made(seed: int, n_groups: int = 5) -> tuple[tuning.Grouping, tuning.Costs]:
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.normal(0, 0.2, (N_FRAMES, 3)), axis=0).astype(np.float32)
    values = np.sin(values).astype(np.float32)
    fixed = np.isin(np.arange(N_FRAMES + 1), BOUNDS)
    rest = rng.uniform(0, 1e-4, N_FRAMES + 1)
    costs = tuning.Costs(values, fixed, rest, 0.1 / N_FRAMES, 0.9 / N_FRAMES / 3.5, 6)
    cuts = np.unique(np.concatenate([np.arange(0, N_FRAMES, 15), BOUNDS]))
    cuts = cuts[np.append(np.diff(cuts) >= 6, True)]
    lengths = np.diff(cuts)
    distances = segment_distances(values, cuts[:-1], cuts[1:])
    medoids, labels = group_by_medoids(
        distances, n_groups, weights=costs.weight * lengths, prices=costs.price * lengths
    )
    return tuning.Grouping(cuts, labels, medoids), costs


def best_medoid(grouping: tuning.Grouping, costs: tuning.Costs, k: int) -> float:
    """The least that a group can cost with its members, from nothing."""
    starts, ends = grouping.cuts[:-1], grouping.cuts[1:]
    members = np.flatnonzero(grouping.labels == k)
    gaps = segment_distances(costs.values, starts[members], ends[members])
    lengths = (ends - starts)[members]
    return float((costs.weight * lengths @ gaps + costs.price * lengths).min())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("temperature", [0.0, 0.5])
def test_the_incremental_cost_is_the_cost_from_nothing(seed: int, temperature: float) -> None:
    grouping, costs = made(seed)
    settings = tuning.TuningSettings(temperature=temperature, most_steps=1500)
    state, total = tuning._begin(grouping, costs), tuning.total_cost(grouping, costs)
    draws = np.random.default_rng(seed).random((1500, 4))
    actual = tuning.Best(*(part.copy() for part in state[:3]))
    chance = settings.temperature * total / len(grouping.labels)
    pace = tuning.Pace(4, chance, total, total)
    total, best_total = tuning.take_steps(state, costs, draws, pace, actual)
    best = tuning.Grouping(*actual)
    now = tuning.Grouping(*state[:3])
    assert total == pytest.approx(tuning.total_cost(now, costs), rel=1e-6)
    assert best_total == pytest.approx(tuning.total_cost(best, costs), rel=1e-6)
    assert best_total < tuning.total_cost(grouping, costs)
    by_groups = sum(best_medoid(now, costs, k) for k in range(5)) + costs.rest[now.cuts].sum()
    assert total == pytest.approx(by_groups, rel=1e-6)


@pytest.mark.parametrize("temperature", [0.0, 0.1])
def test_tuning_keeps_takes_lengths_and_groups(temperature: float) -> None:
    grouping, costs = made(7)
    settings = tuning.TuningSettings(temperature=temperature, most_steps=4000)
    best, steps = tuning.tune(grouping, costs, np.random.default_rng(0), settings)
    assert 0 < steps <= 4000
    assert tuning.total_cost(best, costs) < tuning.total_cost(grouping, costs)
    assert set(BOUNDS) <= set(best.cuts.tolist())
    assert np.diff(best.cuts).min() >= costs.shortest
    assert len(best.cuts) == len(grouping.cuts)
    assert sorted(np.unique(best.labels)) == list(range(5))
    assert (best.labels[best.medoids] == np.arange(5)).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 10_000))
def test_it_is_the_printed_formula_symmetric_and_zero_for_itself(n: int, m: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(n + m, 3)).astype(np.float32)
    actual = segment_distance(values, 0, n, n, n + m)
    assert actual == pytest.approx(naive.segment_distance(values, 0, n, n, n + m), rel=1e-5)
    assert actual == segment_distance(values, n, n + m, 0, n)
    assert segment_distance(values, 0, n, 0, n) == 0.0


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 8), st.integers(1, 4), st.integers(1, 3), st.integers(0, 10_000))
def test_repeating_every_frame_changes_nothing(
    length: int, slower: int, times: int, seed: int
) -> None:
    """Where one length is a multiple of the other; rounding down is exact there."""
    values = np.random.default_rng(seed).normal(size=(length * (slower + 1), 3)).astype(np.float32)
    twice = np.repeat(values, times, axis=0)
    a, b = length * slower, len(values)
    assert segment_distance(twice, 0, a * times, a * times, b * times) == pytest.approx(
        segment_distance(values, 0, a, a, b), rel=1e-5
    )
    one = values[:length]
    both = np.concatenate([one, np.repeat(one, times, axis=0)])
    assert segment_distance(both, 0, length, length, len(both)) == 0.0


def test_poses_do_not_see_place_and_heading() -> None:
    motion = naive.swinging_motion(60)
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(1.1))
    rotations = motion.local_rotations.astype(np.float64)
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    root = rotation.rotate(turn, motion.root_positions.astype(np.float64)) + np.array(
        [3.0, 0.0, -2.0]
    )
    moved = Motion(rotations.astype(np.float32), root.astype(np.float32))
    assert np.allclose(distances.pose_vectors(motion), distances.pose_vectors(moved), atol=2e-5)


def test_principal_axes_keep_the_distances() -> None:
    motion = naive.swinging_motion(80)
    raw = distances.pose_vectors(motion)
    values = distances.make_poses([motion]).values
    assert values.shape[1] < raw.shape[1]
    full = np.linalg.norm(raw[:, None] - raw[None], axis=2)
    kept = np.linalg.norm(values[:, None] - values[None], axis=2)
    assert (kept <= full + 1e-4).all()
    assert (kept**2).sum() >= distances.KEPT * (full**2).sum() - 1e-6


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 60), st.integers(1, 4), st.integers(0, 10_000))
def test_the_largest_distance_is_exact(n: int, dimensions: int, seed: int) -> None:
    values = np.random.default_rng(seed).standard_t(2, size=(n, dimensions))
    full = np.linalg.norm(values[:, None] - values[None], axis=2)
    assert distances.largest_distance(values, block=5) == pytest.approx(full.max(), rel=1e-9)


def test_takes_that_cannot_be_used_are_named() -> None:
    good = naive.swinging_motion(20)
    broken = Motion(good.local_rotations, np.full((20, 3), np.nan, dtype=np.float32))
    empty = Motion(good.local_rotations[:0], good.root_positions[:0])
    with pytest.raises(GrammarError, match=r"expected at least one take, found none\. Name"):
        distances.make_poses([])
    with pytest.raises(GrammarError, match=r"take 2: expected frames, found none\. Leave it out"):
        distances.make_poses([good, empty])
    with pytest.raises(GrammarError, match=r"take 2: expected numbers, found NaN or infinity"):
        distances.make_poses([good, broken])
