"""Pose runs: worked cuts, a slow twin that tries all, and movement of known phases."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import pose_runs
from motiondb.grammar.terminals.distances import Poses
from motiondb.records import FloatArray


def naive_cost(costs: FloatArray, price: float, shortest: int) -> float:
    """The least cost of runs, by trying the cluster of every frame."""
    least = np.inf
    for labels in product(range(costs.shape[1]), repeat=len(costs)):
        edges = [0, *(n for n in range(1, len(labels)) if labels[n] != labels[n - 1]), len(labels)]
        if min(b - a for a, b in pairwise(edges)) >= shortest:
            total = sum(costs[t, k] for t, k in enumerate(labels)) + price * (len(edges) - 1)
            least = min(least, total)
    return float(least)


@pytest.mark.parametrize("seed", range(12))
def test_cuts_cost_as_little_as_the_best_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs, price, shortest = rng.random((8, 3)), float(rng.random()), int(rng.integers(1, 4))
    firsts, kinds = pose_runs._runs(costs, price, shortest)
    edges = [*firsts.tolist(), len(costs)]
    assert all(a != b for a, b in pairwise(kinds.tolist()))
    assert min(b - a for a, b in pairwise(edges)) >= shortest
    total = sum(
        costs[a:b, k].sum() + price for (a, b), k in zip(pairwise(edges), kinds, strict=True)
    )
    assert total == pytest.approx(naive_cost(costs, price, shortest))


def test_a_short_take_is_one_run_of_its_nearest_cluster() -> None:
    firsts, kinds = pose_runs._runs(np.array([[1.0, 0.0], [0.0, 0.5], [1.0, 0.0]]), 0.0, 2)
    assert (firsts.tolist(), kinds.tolist()) == ([0], [1])


def phases(order: str, length: int, rng: np.random.Generator) -> FloatArray:
    """Poses that stay near one of four corners for each letter, with noise."""
    corners = {letter: np.eye(4)[n] for n, letter in enumerate("abcd")}
    rows = [corners[letter] for letter in order for _ in range(length)]
    return np.array(rows) + 0.05 * rng.standard_normal((len(rows), 4))


def test_phases_are_found_named_by_appearance_and_told_apart() -> None:
    rng = np.random.default_rng(0)
    takes = [phases("abcd" * 3, 15, rng), phases("cdab" * 3, 15, rng)]
    clusters = pose_runs.find_clusters(takes, 4, 0.5, 0)
    bounds = np.cumsum([0, *map(len, takes)])
    values = np.concatenate(takes).astype(np.float32)
    found = pose_runs.runs_as_terminals(Poses(values, bounds, 2.0, np.zeros(len(values))), clusters)
    assert found.takes.tolist() == [0] * 12 + [1] * 12
    assert found.starts[:12].tolist() == list(range(0, 180, 15))
    assert "".join(found.names[k] for k in found.labels) == "abcd" * 3 + "cdab" * 3
    assert (found.labels[found.medoids] == np.arange(4)).all()
    assert "".join(clusters.string(phases("dcba", 20, rng))) == "".join(
        clusters.string(takes[0])[n] for n in (3, 2, 1, 0)
    )


def test_the_number_and_length_that_foresee_are_chosen() -> None:
    """Of two clusters, windows have no shuffles without equal neighbours; four are in a cycle."""
    rng = np.random.default_rng(1)
    takes = [phases("abcd" * 6, 15, rng) for _ in range(5)]
    clusters, tried = pose_runs.choose_clusters(
        takes, np.random.default_rng(0), numbers=(2, 4), seconds=(0.5,)
    )
    assert [(one.number, one.windows) for one in tried] == [(2, 0), (4, 100)]
    assert tried[1].foreseen == 1.0
    assert len(clusters.centres) == 4


def test_parts_hold_every_frame_once_also_of_few_takes() -> None:
    takes = [np.arange(7.0)[:, None], 7.0 + np.arange(20.0)[:, None]]
    parts = pose_runs.divided(takes, np.random.default_rng(0))
    assert len(parts) == pose_runs.PARTS
    rows = np.concatenate([take for part in parts for take in part])[:, 0]
    assert sorted(rows.tolist()) == list(range(27))
    with pytest.raises(GrammarError, match="at least 30 different poses"):
        pose_runs.find_clusters(takes, 30, 0.5, 0)
