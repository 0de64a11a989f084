"""Segmentation and terminals together: K medoids exchanged one by one, cuts by the cheapest path.

Once the medoids are known, the best segmentation is no search: the cost of a cell (``candidates``)
is the least of L(s) D(s, s_k^c) over the medoids, and the cheapest path through the cells is the
segmentation of largest F with these medoids, found exactly. So the search is over K medoids alone,
any K cells, and goes as the swap search does (``medoids``): a cell is tried as a medoid, all cells'
costs to it are computed, and for every present medoid it could replace, the cheapest path is found
from the least and second least cost of every cell. The best exchange is made if it lowers

    G = T d_max / (1 - w) / F + sum over cuts c of (price + rest s(c)) u

where u is the mean distance of a pose from the mean pose and s(c) the speed at the cut relative to
the takes' mean: ``price`` holds against ever shorter segments, ``rest`` lets equally good
segmentations be told apart by where the body rests (a segmentation moved on by half a step repeats
as well as the true one). Both 0: the largest F.

Cells are tried at random: those of the present segmentation more often the more they cost, a
medoid's neighbours, and any. An exchange for the worse is made now and then, less and less often
(annealing). There are several starts: medoids far from one another, or those of a segmentation of
one rhythm that is cut where the body rests.

This takes the place of the genetic algorithm of Park, Lee and Lee (2011), section 4.2, which is
kept in ``genetic``; the idea that grouping and cutting can be done in turn is that of segmental
k-means (Rabiner, Wilpon, Juang 1986) and of aligned cluster analysis (Zhou, De la Torre, Hodgins
2013).
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from motiondb.grammar.terminals.candidates import Cells, cheapest_path, path_costs
from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.pose_distance import Poses
from motiondb.grammar.terminals.segment_distance import segment_distances
from motiondb.records import Float32Array, FloatArray, IntArray

_LEAST_GAIN = 1e-9
WARMEST = 0.015
N_TEMPERATURES = 8
_NEAR = 2  # cuts by which a neighbour of a medoid differs


@dataclass(frozen=True, eq=False)
class Task:
    """What is searched: poses (at the rate of the cells' frames), cells, costs of cuts (cuts,), the
    price of a medoid's frame, and K."""

    poses: Poses
    cells: Cells
    cut_costs: FloatArray
    medoid_price: float
    n_groups: int

    @cached_property
    def columns(self) -> Float32Array:
        """The poses, a row for every dimension, with rows of zeros to a number divisible by 4."""
        values = self.poses.values
        found = np.zeros((-(-values.shape[1] // 4) * 4, len(values)), dtype=np.float32)
        found[: values.shape[1]] = values.T
        return found

    @cached_property
    def squares(self) -> Float32Array:
        """|x_t|^2 of every frame."""
        return np.asarray((self.poses.values**2).sum(axis=1), dtype=np.float32)


@dataclass(eq=False)
class State:
    """Medoids (K,), cells; ``table`` (K, cells) of costs; the path of cells and its cost G."""

    medoids: IntArray
    table: Float32Array
    path: IntArray
    cost: float
    least: Float32Array
    second: Float32Array
    nearest: IntArray


def exchange_search(
    task: Task,
    rng: np.random.Generator,
    n_starts: int,
    n_trials: int,
    advance: Callable[[float], None] | None = None,
) -> list[State]:
    """The best states of the starts, the cheapest first.

    Parameters
    ----------
    rng : for the starts and the cells that are tried; a start has its own generator, so the result
        does not depend on the number of threads.
    n_starts, n_trials : the trials are divided among the starts.
    advance : called with the share that is done.
    """
    each = -(-n_trials // n_starts)

    def search(job: tuple[int, np.random.Generator]) -> State:
        begin = first_state if job[0] % 2 else rhythmic_state
        return anneal(task, begin(task, job[1]), job[1], each)

    states: list[State] = []
    with ThreadPoolExecutor(2) as pool:
        for number, state in enumerate(pool.map(search, enumerate(rng.spawn(n_starts)))):
            states.append(state)
            if advance:
                advance((number + 1) / n_starts)
    return sorted(states, key=lambda state: state.cost)


def anneal(task: Task, state: State, rng: np.random.Generator, n_trials: int) -> State:
    """Exchanges at a falling temperature, the last ones at 0; the best state that was seen."""
    best = state
    for part in range(N_TEMPERATURES):
        share = 1.0 - part / (N_TEMPERATURES - 1)
        start = best if share == 0.0 else state
        state, seen = improve(task, start, rng, n_trials // N_TEMPERATURES, WARMEST * share**2)
        best = min(best, seen, key=lambda one: one.cost)
    return best


def first_state(task: Task, rng: np.random.Generator) -> State:
    """Medoids far apart: each is a segment of the best path so far, drawn by its cost."""
    cells, n_cells = task.cells, len(task.cells.firsts)
    chosen = [int(rng.integers(n_cells))]
    table = np.empty((task.n_groups, n_cells), dtype=np.float32)
    cell_costs(task, chosen[0], table[0])
    current = table[0].copy()
    for k in range(1, task.n_groups):
        _, path = cheapest_path(cells, current, task.cut_costs)
        chosen.append(_draw(path, current[path], rng))
        cell_costs(task, chosen[-1], table[k])
        current = np.minimum(current, table[k])
    return _settle(task, np.array(chosen), table)


def rhythmic_state(task: Task, rng: np.random.Generator) -> State:
    """Medoids of a first segmentation into segments of about one length, drawn at random, that are
    cut where the body rests; they share the phase of the movements."""
    cells = task.cells
    lengths = cells.ends - cells.starts
    wished = rng.uniform(lengths.min(), 0.7 * lengths.max())
    surprise = np.square(np.log(lengths / wished)) * float(np.ptp(task.cut_costs) + 1e-12)
    _, path = cheapest_path(cells, surprise * rng.exponential(1.0, len(lengths)), task.cut_costs)
    if len(path) < task.n_groups:
        return first_state(task, rng)
    distances = segment_distances(task.poses.values, cells.starts[path], cells.ends[path])
    medoids, _ = group_by_medoids(
        distances,
        task.n_groups,
        weights=lengths[path].astype(np.float64),
        prices=task.medoid_price * lengths[path],
        initial=rng.permutation(len(path))[: task.n_groups],
    )
    table = np.empty((task.n_groups, len(lengths)), dtype=np.float32)
    for k, medoid in enumerate(path[medoids]):
        cell_costs(task, int(medoid), table[k])
    return _settle(task, path[medoids], table)


def improve(
    task: Task, state: State, rng: np.random.Generator, n_trials: int, temperature: float = 0.0
) -> tuple[State, State]:
    """The last and the best state when ``n_trials`` cells are tried as medoids.

    temperature : as a share of G; an exchange that raises G by x is made with probability
        exp(-x / (temperature G)).
    """
    cells, best = task.cells, state
    lengths = cells.ends - cells.starts
    tried = np.empty(len(cells.firsts), dtype=np.float32)
    for _ in range(n_trials):
        cell = _propose(task, state, rng)
        allowed = temperature * rng.exponential() - _LEAST_GAIN
        if cell < 0 or cell in state.medoids:
            continue
        cell_costs(task, cell, tried)
        k, _ = _best_exchange(
            (cells.firsts, cells.pointers, task.cut_costs),
            (state.least, state.second, state.nearest, tried),
            task.medoid_price * lengths[state.medoids],
            float(task.medoid_price * lengths[cell]),
            state.cost * (1.0 + allowed),
        )
        if k >= 0:
            medoids, table = state.medoids.copy(), state.table.copy()
            medoids[k], table[k] = cell, tried
            state = _settle(task, medoids, table)
            if state.cost < best.cost:
                best = state
    return state, best


def cell_costs(task: Task, medoid: int, out: Float32Array) -> None:
    """L(s) D(s, medoid) for all cells s, into ``out``."""
    cells = task.cells
    start, end = int(cells.starts[medoid]), int(cells.ends[medoid])
    table = _distances_to(task.columns, task.squares, start, end)
    _cell_costs(table, cells.cuts, cells.firsts, cells.pointers, out)


def _settle(task: Task, medoids: IntArray, table: Float32Array) -> State:
    n_cells = table.shape[1]
    least, second = np.empty(n_cells, np.float32), np.empty(n_cells, np.float32)
    nearest = np.empty(n_cells, np.int64)
    _two_least(table, least, second, nearest)
    cost, path = cheapest_path(task.cells, least, task.cut_costs)
    lengths = task.cells.ends[medoids] - task.cells.starts[medoids]
    total = cost + task.medoid_price * float(lengths.sum())
    return State(medoids, table, path, total, least, second, nearest)


def _draw(path: IntArray, costs: Float32Array, rng: np.random.Generator) -> int:
    weights = costs.astype(np.float64) + 1e-9
    return int(path[rng.choice(len(path), p=weights / weights.sum())])


def _propose(task: Task, state: State, rng: np.random.Generator) -> int:
    """A cell to try, -1 where none was found."""
    kind = rng.random()
    if kind < 0.5:
        return _draw(state.path, state.least[state.path], rng)
    if kind < 0.75:
        return int(rng.integers(len(task.cells.firsts)))
    cells = task.cells
    medoid = state.medoids[rng.integers(task.n_groups)]
    first = cells.firsts[medoid] + rng.integers(-_NEAR, _NEAR + 1)
    last = cells.lasts[medoid] + rng.integers(-_NEAR, _NEAR + 1)
    if not 0 <= first < last < len(cells.cuts):
        return -1
    some = slice(cells.pointers[last], cells.pointers[last + 1])
    found = np.flatnonzero(cells.firsts[some] == first)
    return int(cells.pointers[last] + found[0]) if len(found) else -1


def path_medoids(task: Task, state: State, path: IntArray) -> IntArray:
    """For every terminal a segment of the path to begin with: the cheapest of its own, or a free
    one."""
    left = set(range(len(path)))
    chosen: list[int] = []
    for k in range(task.n_groups):
        own = [n for n in left if state.nearest[path[n]] == k] or sorted(left)
        lengths = task.cells.ends[path[own]] - task.cells.starts[path[own]]
        best = own[int(np.argmin(state.table[k, path[own]] / lengths))]
        chosen.append(best)
        left.discard(best)
    return np.array(chosen)


@njit(cache=True, fastmath=True, nogil=True)
def _distances_to(columns, squares, start, end):  # type: ignore[no-untyped-def]
    """d of all frames to the frames [start, end): array (medoid's frames, frames).

    Not a product of matrices: the libraries for these bring threads of their own, which stand in
    each other's way when several searches run at once.
    """
    n_dimensions, n_frames = columns.shape
    table = np.empty((end - start, n_frames), np.float32)
    for u in range(end - start):
        row = table[u]
        for t in range(n_frames):
            row[t] = np.float32(0.0)
        for d in range(0, n_dimensions, 4):
            a, b, c, e = columns[d], columns[d + 1], columns[d + 2], columns[d + 3]
            own = a[start + u], b[start + u], c[start + u], e[start + u]
            for t in range(n_frames):
                row[t] += own[0] * a[t] + own[1] * b[t] + own[2] * c[t] + own[3] * e[t]
        for t in range(n_frames):
            square = squares[t] + squares[start + u] - np.float32(2.0) * row[t]
            row[t] = np.sqrt(max(square, np.float32(0.0)))
    return table


@njit(cache=True, fastmath=True, nogil=True)
def _cell_costs(table, cuts, firsts, pointers, out):  # type: ignore[no-untyped-def]
    """Sums over warped cells of distances (medoid's frames, frames)."""
    n_own = table.shape[0]
    for j in range(len(cuts)):
        for c in range(pointers[j], pointers[j + 1]):
            first, length = cuts[firsts[c]], cuts[j] - cuts[firsts[c]]
            total, behind, at = np.float32(0.0), 0, 0
            if length >= n_own:
                for t in range(first, first + length):
                    total += table[at, t]
                    behind += n_own
                    if behind >= length:
                        behind -= length
                        at += 1
                out[c] = total
            else:
                for u in range(n_own):
                    total += table[u, first + at]
                    behind += length
                    if behind >= n_own:
                        behind -= n_own
                        at += 1
                out[c] = total * np.float32(length) / np.float32(n_own)


@njit(cache=True, nogil=True)
def _two_least(table, least, second, nearest):  # type: ignore[no-untyped-def]
    for c in range(table.shape[1]):
        least[c], second[c], nearest[c] = np.inf, np.inf, -1
        for k in range(table.shape[0]):
            cost = table[k, c]
            if cost < least[c]:
                second[c], least[c], nearest[c] = least[c], cost, k
            elif cost < second[c]:
                second[c] = cost


@njit(cache=True, nogil=True)
def _best_exchange(graph, known, prices, price, bound):  # type: ignore[no-untyped-def]
    """Which medoid to replace (-1: none gets below ``bound``), and G then.

    No exchange is cheaper than keeping all medoids beside the new one: where that is not enough,
    nothing is tried.
    """
    firsts, pointers, cut_costs = graph
    least, second, nearest, tried = known
    reached = np.empty(len(cut_costs))
    before = np.empty(len(cut_costs), np.int64)
    costs = np.minimum(least, tried)
    floor = path_costs(firsts, pointers, costs, cut_costs, reached, before)
    floor += prices.sum() + price
    found = -1
    for k in range(len(prices)):
        if floor - prices[k] >= bound:
            continue
        for c in range(len(costs)):
            costs[c] = min(second[c] if nearest[c] == k else least[c], tried[c])
        total = path_costs(firsts, pointers, costs, cut_costs, reached, before)
        total += prices.sum() + price - prices[k]
        if total < bound:
            bound, found = total, k
    return found, bound
