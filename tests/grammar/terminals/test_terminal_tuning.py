"""Slide and Resize: what is updated is what it would be from nothing."""

import numpy as np
import pytest

from motiondb.grammar.terminals import tuning
from motiondb.grammar.terminals.distances import segment_distances
from motiondb.grammar.terminals.medoids import group_by_medoids

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


def test_a_group_of_one_keeps_its_last_segment() -> None:
    grouping, costs = made(2, n_groups=len(made(2)[0].labels) - 1)
    best, _ = tuning.tune(
        grouping, costs, np.random.default_rng(1), tuning.TuningSettings(most_steps=800)
    )
    n_groups = len(grouping.medoids)
    assert sorted(np.unique(best.labels)) == list(range(n_groups))
