"""Medoids, the objective, cells and the exchange search."""

import naive_terminals as naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import candidates, exchange
from motiondb.grammar.terminals.distances import Poses
from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.terminals import score


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


def test_costs_of_cells_are_lengths_times_distances() -> None:
    from motiondb.grammar.terminals.distances import distances_to

    task = made_task(3)
    cells = task.cells
    for medoid in (0, 17, 40):
        out = np.empty(len(cells.firsts), dtype=np.float32)
        exchange.cell_costs(task, medoid, out)
        exact = distances_to(
            task.poses.values, cells.starts[medoid], cells.ends[medoid], cells.starts, cells.ends
        )
        assert np.allclose(out, exact * (cells.ends - cells.starts), rtol=1e-3, atol=0.1)


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
