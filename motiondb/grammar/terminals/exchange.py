"""Search segmentation and terminals together: exchange medoids, cut by the cheapest path.

Once the medoids are known, the best segmentation needs no search. The cost of a cell
(:mod:`.candidates`) is the least of L(s) D(s, s_k^c) over the medoids, and the cheapest path
through the cells is the segmentation of the largest F with these medoids, exactly. The search is
therefore over the K medoids only, which may be any K cells, and works like the swap search
(:mod:`.medoids`): a cell is tried as a medoid, the costs of all cells to it are computed, and for
every current medoid that it could replace, the cheapest path is found from the least and second
least cost of every cell. The best exchange is made if it lowers

    G = T d_max / (1 - w) / F + sum over cuts c of (price + rest s(c)) u

where u is the mean distance of a pose from the mean pose and s(c) the speed at the cut relative to
the mean speed of the takes. ``price`` prevents ever shorter segments. ``rest`` decides between
equally good segmentations by how still the body is at the cuts. This is needed because a
segmentation that is shifted by half a movement repeats as well as the true one. With both 0, F
itself is maximised.

Cells are tried at random: those of the current segmentation, in proportion to their cost;
neighbours of a medoid; and any. Worse exchanges are accepted with a probability that falls
(simulated annealing). There are several starts: medoids far from one another, or the medoids of a
segmentation of one rhythm that is cut where the body rests.

*Divisions* are exchanges that need two steps at once. The search exchanges one medoid at a time. It
cannot leave a segmentation in
which one terminal holds two movements that always follow each other, such as lowering the fists at
the end of a bout and raising them at the beginning of the next. If only one of the two parts
becomes a medoid, the other part is like no medoid, wherever it occurs, so this step costs much.
Both parts together may cost less than the whole: they also stand for the places at which one of
them occurs alone, such as the two ends of a take.

A division takes the place of medoid k. Its cell, or that of a segment like it, [a, b) is cut at a
candidate c, the cell [a, c) becomes medoid k, and [c, b) is exchanged for the medoid that is least
needed then. So their number does not change. All medoids, some segments of each and all their
candidates are tried, and the division of least G is made, until none lowers G.

This replaces the genetic algorithm of Park, Lee and Lee (2011), section 4.2. Alternating between
grouping and cutting is the idea of segmental k-means (Rabiner, Wilpon, Juang 1986) and of aligned
cluster analysis (Zhou, De la Torre, Hodgins 2013).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from motiondb.grammar.kernels import maker
from motiondb.grammar.terminals.candidates import Cells, cheapest_path, path_costs
from motiondb.grammar.terminals.distances import Poses, segment_distances
from motiondb.grammar.terminals.medoids import group_by_medoids, two_least
from motiondb.records import Float32Array, FloatArray, IntArray


class Graph(NamedTuple):
    """Cells as a graph, as in ``Cells``, and the cost of each cut."""

    firsts: IntArray
    pointers: IntArray
    cut_costs: FloatArray


class KnownCosts(NamedTuple):
    """Least and second least cost and nearest medoid of the cells, and costs to the tried cell."""

    least: Float32Array
    second: Float32Array
    nearest: IntArray
    tried: Float32Array


class Prices(NamedTuple):
    """Costs of the current medoids (K,), and of the tried cell as a medoid."""

    medoids: FloatArray
    tried: float


@maker
def frame_distances(
    columns: Float32Array, squares: Float32Array, start: int, end: int
) -> Float32Array:
    """Return d of all frames to the frames [start, end): array (medoid's frames, frames).

    Not a matrix product: the libraries for these start their own threads, which slow down
    simultaneous searches.
    """
    n_dimensions, n_frames = columns.shape
    table = np.empty((end - start, n_frames), np.float32)
    for u in range(end - start):
        row = table[u]
        for t in range(n_frames):
            row[t] = np.float32(0.0)
        for d in range(0, n_dimensions, 4):
            a, b, c, e = columns[d], columns[d + 1], columns[d + 2], columns[d + 3]
            x, y, z, w = a[start + u], b[start + u], c[start + u], e[start + u]
            for t in range(n_frames):
                row[t] += x * a[t] + y * b[t] + z * c[t] + w * e[t]
        for t in range(n_frames):
            square = squares[t] + squares[start + u] - np.float32(2.0) * row[t]
            row[t] = np.sqrt(max(square, np.float32(0.0)))
    return table


@maker
def warped_costs(
    table: Float32Array, cuts: IntArray, firsts: IntArray, pointers: IntArray, out: Float32Array
) -> None:
    """Sum distances (medoid's frames, frames) over warped cells, into ``out``."""
    n_medoid = table.shape[0]
    for j in range(len(cuts)):
        for c in range(pointers[j], pointers[j + 1]):
            first, length = cuts[firsts[c]], cuts[j] - cuts[firsts[c]]
            total, behind, at = np.float32(0.0), 0, 0
            if length >= n_medoid:
                for t in range(first, first + length):
                    total += table[at, t]
                    behind += n_medoid
                    if behind >= length:
                        behind -= length
                        at += 1
                out[c] = total
            else:
                for u in range(n_medoid):
                    total += table[u, first + at]
                    behind += length
                    if behind >= n_medoid:
                        behind -= n_medoid
                        at += 1
                out[c] = total * np.float32(length) / np.float32(n_medoid)


@maker
def best_exchange(
    graph: Graph, known: KnownCosts, prices: Prices, bound: float
) -> tuple[int, float]:
    """Return the medoid to replace by the tried cell, and the new G; -1 if none is below ``bound``.

    No exchange is cheaper than adding the new medoid and keeping all others. If that does not lower
    the cost, nothing is tried.
    """
    firsts, pointers, cut_costs = graph
    least, second, nearest, tried = known
    reached = np.empty(len(cut_costs))
    before = np.empty(len(cut_costs), np.int64)
    costs = np.minimum(least, tried)
    paid = prices.medoids.sum() + prices.tried
    floor = path_costs(firsts, pointers, costs, cut_costs, reached, before)
    floor += paid
    best = -1
    for k in range(len(prices.medoids)):
        if floor - prices.medoids[k] >= bound:
            continue
        for c in range(len(costs)):
            costs[c] = min(second[c] if nearest[c] == k else least[c], tried[c])
        total = path_costs(firsts, pointers, costs, cut_costs, reached, before)
        total += paid - prices.medoids[k]
        if total < bound:
            bound, best = total, k
    return best, bound


LEAST_GAIN = 1e-9
"""Smallest relative decrease of G by an exchange; smaller ones are rounding errors."""

WARMEST = 0.015  # First temperature, as a share of G. Chosen on one take of each sample grammar

N_TEMPERATURES = 8  # Number of temperatures from the first to 0

_NEAR = 2  # Largest number of cuts by which a neighbour of a medoid differs

_FROM_PATH, _ANYWHERE = 0.5, 0.25
"""Shares of tried cells from the current segmentation, and of any cells; the others are neighbours
of medoids."""


@dataclass(frozen=True, eq=False)
class Task:
    """The search problem."""

    poses: Poses  # Poses at the rate of the cells' frames
    cells: Cells  # The segments that are allowed
    cut_costs: FloatArray  # (cuts,): cost of each cut
    medoid_price: float  # Cost of a medoid's frame
    n_groups: int

    @cached_property
    def columns(self) -> Float32Array:
        """Poses by dimension (dimensions, frames), padded with rows of zeros to a multiple of 4."""
        values = self.poses.values
        padded = np.zeros((-(-values.shape[1] // 4) * 4, len(values)), dtype=np.float32)
        padded[: values.shape[1]] = values.T
        return padded

    @cached_property
    def squares(self) -> Float32Array:
        """Squared norm |x_t|^2 of every frame."""
        return np.asarray((self.poses.values**2).sum(axis=1), dtype=np.float32)


@dataclass(eq=False)
class State:
    """Medoids and the segmentation that they give."""

    medoids: IntArray  # (K,): the medoids, cells
    table: Float32Array  # (K, cells): cost of each cell to each medoid
    path: IntArray  # (segments,): the cheapest path, cells
    cost: float
    least: Float32Array  # (cells,): least cost of each cell to a medoid
    second: Float32Array  # (cells,): second least cost of each cell to a medoid
    nearest: IntArray  # (cells,): medoid of least cost for each cell


def exchange_search(
    task: Task,
    rng: np.random.Generator,
    n_starts: int,
    n_trials: int,
    advance: Callable[[float], None] | None = None,
) -> list[State]:
    """Search from several starts.

    `rng`: Each start gets a separate generator, so the result does not depend on the number of
    threads.
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
    """Exchange medoids at a falling temperature, finally 0; return the best state visited."""
    best = state
    for part in range(N_TEMPERATURES):
        share = 1.0 - part / (N_TEMPERATURES - 1)
        start = best if share == 0.0 else state
        state, seen = improve(task, start, rng, n_trials // N_TEMPERATURES, WARMEST * share**2)
        best = min(best, seen, key=lambda one: one.cost)
    return best


def first_state(task: Task, rng: np.random.Generator) -> State:
    """Draw medoids far apart: each is a segment of the cheapest path so far, drawn by its cost."""
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
    return settle(task, np.array(chosen), table)


def rhythmic_state(task: Task, rng: np.random.Generator) -> State:
    """Draw medoids from a segmentation into segments of about one random length.

    It is cut where the body rests, so that the medoids share the phase of the movements.
    """
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
    return settle(task, path[medoids], table)


def improve(
    task: Task, state: State, rng: np.random.Generator, n_trials: int, temperature: float = 0.0
) -> tuple[State, State]:
    """Try cells as medoids.

    `temperature`: As a share of G: an exchange that raises G by x is accepted with probability
    exp(-x / (temperature G)).
    """
    best = state
    tried = np.empty(len(task.cells.firsts), dtype=np.float32)
    for _ in range(n_trials):
        cell = _propose(task, state, rng)
        allowed = temperature * rng.exponential() - LEAST_GAIN
        if cell < 0 or cell in state.medoids:
            continue
        cell_costs(task, cell, tried)
        k = exchange_of(task, state, cell, tried, state.cost * (1.0 + allowed))
        if k >= 0:
            medoids, table = state.medoids.copy(), state.table.copy()
            medoids[k], table[k] = cell, tried
            state = settle(task, medoids, table)
            if state.cost < best.cost:
                best = state
    return state, best


def exchange_of(task: Task, state: State, cell: int, tried: Float32Array, bound: float) -> int:
    """Return the medoid whose exchange for a cell gives the least G; -1 if none is below a bound.

    Shapes: `tried` (cells,).
    """
    cells = task.cells
    lengths = cells.ends - cells.starts
    k, _ = best_exchange(
        Graph(cells.firsts, cells.pointers, task.cut_costs),
        KnownCosts(state.least, state.second, state.nearest, tried),
        Prices(
            np.asarray(task.medoid_price * lengths[state.medoids], dtype=np.float64),
            float(task.medoid_price * lengths[cell]),
        ),
        bound,
    )
    return k


def cell_costs(task: Task, medoid: int, out: Float32Array) -> None:
    """Write L(s) D(s, medoid) of all cells s into ``out``."""
    cells = task.cells
    start, end = int(cells.starts[medoid]), int(cells.ends[medoid])
    table = frame_distances(task.columns, task.squares, start, end)
    warped_costs(table, cells.cuts, cells.firsts, cells.pointers, out)


def settle(task: Task, medoids: IntArray, table: Float32Array) -> State:
    """Return the state of medoids (K,) with the costs (K, cells) of all cells to them."""
    n_cells = table.shape[1]
    least, second = np.empty(n_cells, np.float32), np.empty(n_cells, np.float32)
    nearest = np.empty(n_cells, np.int64)
    two_least(table, least, second, nearest)
    cost, path = cheapest_path(task.cells, least, task.cut_costs)
    lengths = task.cells.ends[medoids] - task.cells.starts[medoids]
    total = cost + task.medoid_price * float(lengths.sum())
    return State(medoids, table, path, total, least, second, nearest)


def _draw(path: IntArray, costs: Float32Array, rng: np.random.Generator) -> int:
    weights = costs.astype(np.float64) + 1e-9
    return int(path[rng.choice(len(path), p=weights / weights.sum())])


def _propose(task: Task, state: State, rng: np.random.Generator) -> int:
    """Draw a cell to try, -1 if there is none."""
    kind = rng.random()
    if kind < _FROM_PATH:
        return _draw(state.path, state.least[state.path], rng)
    if kind < _FROM_PATH + _ANYWHERE:
        return int(rng.integers(len(task.cells.firsts)))
    cells = task.cells
    medoid = state.medoids[rng.integers(task.n_groups)]
    first = cells.firsts[medoid] + rng.integers(-_NEAR, _NEAR + 1)
    last = cells.lasts[medoid] + rng.integers(-_NEAR, _NEAR + 1)
    if not 0 <= first < last < len(cells.cuts):
        return -1
    some = slice(cells.pointers[last], cells.pointers[last + 1])
    places = np.flatnonzero(cells.firsts[some] == first)
    return int(cells.pointers[last] + places[0]) if len(places) else -1


def path_medoids(task: Task, state: State, path: IntArray) -> IntArray:
    """Choose for every terminal a segment of the path as its first medoid.

    It is the cheapest segment of the terminal, or a free one if it has none.
    """
    left = set(range(len(path)))
    chosen: list[int] = []
    for k in range(task.n_groups):
        members = [n for n in left if state.nearest[path[n]] == k] or sorted(left)
        lengths = task.cells.ends[path[members]] - task.cells.starts[path[members]]
        best = members[int(np.argmin(state.table[k, path[members]] / lengths))]
        chosen.append(best)
        left.discard(best)
    return np.array(chosen)


_SEGMENTS = 6
"""Segments of each terminal that are tried in the place of its medoid. Not every segment has a
candidate cut at the right frame. Chosen by hand, to bound the time; not tuned."""


def divide(task: Task, state: State) -> State:
    """Divide medoids as long as that lowers G."""
    while True:
        divided = (  # one at a time: each holds a table of distances
            one
            for k in range(len(state.medoids))
            for cell in _cells_of(task, state, k)
            for first, second in parts_of(task, cell)
            if (one := _division(task, state, k, first, second)) is not None
        )
        best = min(divided, key=lambda one: one.cost, default=None)
        if best is None:
            return state
        state = best


def _cells_of(task: Task, state: State, k: int) -> list[int]:
    """Return medoid k and the segments of its terminal that are most like it."""
    path = state.path[state.nearest[state.path] == k]
    lengths = task.cells.ends[path] - task.cells.starts[path]
    near = path[np.argsort(state.table[k, path] / lengths, kind="stable")[:_SEGMENTS]]
    return list(dict.fromkeys([int(state.medoids[k]), *near.tolist()]))


def parts_of(task: Task, medoid: int) -> Iterator[tuple[int, int]]:
    """Yield the pairs of cells into which a cell can be cut, in order of the cut."""
    cells = task.cells
    first, last = int(cells.firsts[medoid]), int(cells.lasts[medoid])
    for cut in range(first + 1, last):
        before, after = _cell(task, first, cut), _cell(task, cut, last)
        if before >= 0 and after >= 0:
            yield before, after


def _cell(task: Task, first: int, last: int) -> int:
    """Return the cell between two cuts, -1 if it is not allowed."""
    low, high = task.cells.pointers[last : last + 2]
    places = np.flatnonzero(task.cells.firsts[low:high] == first)
    return int(low + places[0]) if len(places) else -1


def _division(task: Task, state: State, k: int, first: int, second: int) -> State | None:
    """Return the state with ``first`` in place of medoid k and ``second`` of another.

    The other one is the medoid that is least needed then. None if that does not lower G.
    """
    if first in state.medoids or second in state.medoids:
        return None
    medoids, table = state.medoids.copy(), state.table.copy()
    medoids[k] = first
    cell_costs(task, first, table[k])
    begun = settle(task, medoids, table)
    tried = np.empty_like(begun.least)
    cell_costs(task, second, tried)
    given_up = exchange_of(task, begun, second, tried, state.cost * (1.0 - LEAST_GAIN))
    if given_up < 0:
        return None
    medoids[given_up], table[given_up] = second, tried
    return settle(task, medoids, table)
