"""Medoids that hold two movements are divided, and never at a cost."""

import numpy as np
import pytest

from motiondb.grammar.terminals import candidates, exchange
from motiondb.grammar.terminals.distances import Poses, largest_distance
from motiondb.grammar.terminals.exchange import divide, parts_of

BUMPS = {"a": 0, "b": 1, "c": 2}
LENGTH = 8


def task_of(takes: tuple[str, ...], n_groups: int) -> exchange.Task:
    """Takes of movements of eight frames: a bump in one dimension for each letter."""
    bump = np.sin(np.arange(LENGTH) * np.pi / LENGTH)
    values = np.zeros((LENGTH * sum(map(len, takes)), 3), dtype=np.float32)
    for number, letter in enumerate("".join(takes)):
        values[LENGTH * number : LENGTH * (number + 1), BUMPS[letter]] = bump
    bounds = LENGTH * np.cumsum([0, *map(len, takes)])
    poses = Poses(values, bounds, largest_distance(values), np.zeros(len(values)))
    cuts = np.arange(0, len(values) + 1, LENGTH // 2)
    cells = candidates.make_cells(cuts, cuts, bounds, LENGTH // 2, 3 * LENGTH)
    return exchange.Task(poses, cells, np.full(len(cuts), 0.5), 0.2, n_groups)


def state_of(task: exchange.Task, spans: list[tuple[int, int]]) -> exchange.State:
    """The state of given medoids, as first and last frame."""
    cells = task.cells
    medoids = np.array(
        [int(np.flatnonzero((cells.starts == a) & (cells.ends == b))[0]) for a, b in spans]
    )
    table = np.empty((len(medoids), len(cells.firsts)), dtype=np.float32)
    for k, medoid in enumerate(medoids.tolist()):
        exchange.cell_costs(task, medoid, table[k])
    return exchange.settle(task, medoids, table)


def spans_of(task: exchange.Task, state: exchange.State) -> set[tuple[int, int]]:
    cells = task.cells
    return {(int(cells.starts[m]), int(cells.ends[m])) for m in state.medoids}


def test_two_movements_that_follow_each_other_are_divided_where_each_occurs_alone() -> None:
    # a b stands five times, b alone at the beginning, a alone at the end. With the medoids a b and
    # two times c, single exchanges stay: b and a alone are like no medoid.
    task = task_of(("bcabc", "abcabcabca"), 3)
    begun = state_of(task, [(16, 32), (8, 16), (56, 64)])
    divided = divide(task, begun)
    letters = "bcabcabcabcabca"
    held = sorted(letters[a // LENGTH : b // LENGTH] for a, b in spans_of(task, divided))
    assert divided.cost < begun.cost
    assert held == ["a", "b", "c"]
    assert len(divided.path) == len(letters)


@pytest.mark.parametrize("seed", range(4))
def test_a_division_is_the_best_that_trying_all_of_them_finds(seed: int) -> None:
    task = task_of(("abcab", "bcacb"), 3)
    begun = exchange.first_state(task, np.random.default_rng(seed))
    divided = divide(task, begun)
    assert divided.cost <= begun.cost
    assert divide(task, divided) is divided
    spans = spans_of(task, divided)
    for medoid in divided.medoids.tolist():
        for first, second in parts_of(task, medoid):
            parts = {
                (int(task.cells.starts[part]), int(task.cells.ends[part]))
                for part in (first, second)
            }
            others = spans - {(int(task.cells.starts[medoid]), int(task.cells.ends[medoid]))}
            for dropped in others:
                tried = sorted((others - {dropped}) | parts)
                if len(tried) == task.n_groups:
                    assert state_of(task, tried).cost >= divided.cost * (1.0 - 1e-5)
