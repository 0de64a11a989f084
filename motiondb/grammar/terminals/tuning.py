"""Slide and Resize: move the cuts of a segmentation a little; groups and medoids follow.

A step picks a segment s_i = [t_i, t_{i+1}) at random and moves

    Slide   both its ends by +d or -d:   s_{i-1} and s_{i+1} give and take,
    Resize  its end by +d or -d:         s_{i+1} begins later or earlier; its far end stays

(in print the far end moves too, which would move every later segment). Only changed terms are
computed again. The changed segments leave their groups and join those of the nearest medoids.
Groups that lost or gained members choose their medoid again, the one of the largest F. R and E' are
sums over groups, so F follows from the changed groups alone, and equals F computed from scratch. A
group never loses its last segment, no cut leaves its take, and no segment becomes shorter than
allowed.

d starts large. It is halved after a number of steps without gain; the search ends when the smallest
d gives no gain. A step is accepted if it lowers

    cost = w R + (1 - w) E' + sum over cuts of rest(c)   (= 1 / F where cuts cost nothing),

and, at a temperature above 0, a step that raises the cost is accepted with probability
exp(-rise / temperature); the temperature falls with every step. The result is the best grouping
that was visited.

Source: Park, Lee and Lee (2011), section 4.3, which accepts a step only if it is better
(temperature 0).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from motiondb.grammar.kernels import maker
from motiondb.grammar.terminals.distances import segment_distance, segment_distances
from motiondb.records import BoolArray, Float32Array, FloatArray, IntArray

_RELATIVE_GAIN = 1e-12
"""Smallest relative decrease of the cost that counts; smaller ones are rounding errors."""


class Costs(NamedTuple):
    """The cost of a grouping."""

    values: Float32Array  # (frames, dimensions): the poses
    fixed: BoolArray  # (frames + 1,): whether each cut is fixed
    rest: FloatArray  # (frames + 1,): cost of a cut
    price: float  # Cost of a medoid's frame, w / T
    weight: float  # Cost of a frame's distance, (1 - w) / (T d_max)
    shortest: int  # Smallest number of frames of a segment


class State(NamedTuple):
    """The grouping during the search, with the data from which its cost is updated."""

    cuts: IntArray  # (segments + 1,): frames of all takes in a row
    labels: IntArray  # (segments,): group of each segment
    medoids: IntArray  # (K,): medoid of each group, a segment
    distances: Float32Array  # (segments, segments): d, valid within groups
    sums: FloatArray  # (segments,): distances of the frames of its group to each segment, summed
    errors: FloatArray  # (K,): cost of the distances of each group


class Best(NamedTuple):
    """The best grouping so far, as in :class:`Grouping`."""

    cuts: IntArray
    labels: IntArray
    medoids: IntArray


class Pace(NamedTuple):
    """Size of the steps (frames), temperature, and the cost now and of the best."""

    step: int
    temperature: float
    total: float
    best_total: float


class _Move(NamedTuple):
    """Cuts from ``first`` on that get new frames; the segments [low, high) change."""

    first: int
    new: IntArray
    low: int
    high: int


class _Known(NamedTuple):
    """Distances for a move: those that are known, and new ones (changed segments, segments)."""

    values: Float32Array
    distances: Float32Array
    rows: Float32Array
    ends: IntArray
    sums: FloatArray


@maker
def take_steps(
    state: State, costs: Costs, draws: FloatArray, pace: Pace, best: Best
) -> tuple[float, float]:
    """Take steps of one size; changes ``state`` and ``best``. Returns both costs."""
    step, temperature, total, best_total = pace
    cuts, n = state.cuts, len(state.labels)
    for draw in draws:
        i = min(int(draw[0] * n), n - 1)
        shift = step if draw[1] < 0.5 else -step
        first = i if draw[2] < 0.5 else i + 1  # Slide moves cuts i and i + 1, Resize i + 1
        new = cuts[first : i + 2] + shift
        if not _allowed(cuts, first, new, costs):
            continue
        move = _Move(first, new, first - 1, first + len(new))
        gain, groups, heads, losses, rows = _try_move(state, costs, move)
        if gain < 0.0 or (temperature > 0.0 and draw[3] < np.exp(-gain / temperature)):
            state.medoids[:], state.errors[:] = heads, losses
            _commit(state, move, groups, rows, costs.values)
            total += gain
            if total < best_total * (1.0 - _RELATIVE_GAIN):
                best_total = total
                best.cuts[:], best.labels[:] = cuts, state.labels
                best.medoids[:] = state.medoids
    return total, best_total


@maker
def _allowed(cuts: IntArray, first: int, new: IntArray, costs: Costs) -> bool:
    """Whether cuts from ``first`` on may get new frames."""
    last = first + len(new) - 1
    if first < 1 or last > len(cuts) - 2:
        return False
    for c in range(first, last + 1):
        if costs.fixed[cuts[c]]:
            return False
    room = min(new[0] - cuts[first - 1], cuts[last + 1] - new[-1])
    return bool(room >= costs.shortest)


@maker
def _try_move(
    state: State, costs: Costs, move: _Move
) -> tuple[float, IntArray, IntArray, FloatArray, Float32Array]:
    """Return the change of the cost, and the groups, medoids, errors and distances it makes."""
    cuts, labels, medoids = state.cuts, state.labels, state.medoids
    low, high = move.low, move.high
    ends = cuts.copy()
    ends[move.first : move.first + len(move.new)] = move.new
    heads = medoids.copy()
    left = _sums_without(state, low, high)
    _release(labels, heads, left, low, high)
    groups = np.empty(high - low, np.int64)
    for s in range(low, high):
        groups[s - low] = _nearest(state, costs.values, ends, heads, s)
    touched = np.unique(np.concatenate((labels[low:high], groups)))
    rows = np.full((high - low, len(labels)), np.nan, np.float32)
    known = _Known(costs.values, state.distances, rows, ends, left)
    gain = 0.0
    for c in range(len(move.new)):
        gain += costs.rest[move.new[c]] - costs.rest[cuts[move.first + c]]
    losses = state.errors.copy()
    after = labels.copy()
    after[low:high] = groups
    for k in touched:
        members = np.flatnonzero(after == k)
        heads[k], losses[k], size = _choose_medoid(known, members, move, heads[k], costs)
        old = costs.price * (cuts[medoids[k] + 1] - cuts[medoids[k]])
        gain += losses[k] + size - state.errors[k] - old
    return gain, groups, heads, losses, rows


@maker
def sum_distances(state: State, groups: IntArray) -> None:
    """Fill ``state.sums`` for all segments of some groups."""
    cuts = state.cuts
    for k in groups:
        members = np.flatnonzero(state.labels == k)
        for c in members:
            state.sums[c] = 0.0
            for i in members:
                state.sums[c] += (cuts[i + 1] - cuts[i]) * state.distances[i, c]


@maker
def _sums_without(state: State, low: int, high: int) -> FloatArray:
    """Return ``state.sums`` after the segments [low, high) have left their groups."""
    cuts, labels = state.cuts, state.labels
    left = state.sums.copy()
    for s in range(low, high):
        for c in range(len(labels)):
            if labels[c] == labels[s]:
                left[c] -= (cuts[s + 1] - cuts[s]) * state.distances[s, c]
    return left


@maker
def _release(labels: IntArray, heads: IntArray, left: FloatArray, low: int, high: int) -> None:
    """Choose another medoid, among unchanged segments, for groups whose medoid changes.

    -1 if the group has no unchanged segment.
    """
    for s in range(low, high):
        k = labels[s]
        if not low <= heads[k] < high:
            continue
        heads[k] = -1
        least = np.inf
        for c in range(len(labels)):
            if labels[c] == k and not low <= c < high and left[c] < least:
                least, heads[k] = left[c], c


@maker
def _nearest(state: State, values: Float32Array, ends: IntArray, heads: IntArray, s: int) -> int:
    """Return the group of a changed segment; a group with nothing else left keeps its medoid."""
    nearest = state.labels[s]
    if heads[nearest] < 0 and state.medoids[nearest] == s:
        return int(nearest)
    least = np.inf
    for k in range(len(heads)):
        if heads[k] >= 0:
            a, b = state.cuts[heads[k]], state.cuts[heads[k] + 1]
            gap = segment_distance(values, ends[s], ends[s + 1], a, b)
            if gap < least:
                least, nearest = gap, k
    return int(nearest)


@maker
def _gap(known: _Known, i: int, c: int, move: _Move) -> np.float32:
    """Return D of two segments after a move; new ones are computed once and kept in ``rows``."""
    low, high, ends = move.low, move.high, known.ends
    if low <= c < high:
        i, c = c, i
    if not low <= i < high:
        return known.distances[i, c]
    if i == c:
        return np.float32(0.0)
    if np.isnan(known.rows[i - low, c]):
        gap = segment_distance(known.values, ends[i], ends[i + 1], ends[c], ends[c + 1])
        known.rows[i - low, c] = gap
        if low <= c < high:
            known.rows[c - low, i] = gap
    return known.rows[i - low, c]


@maker
def _choose_medoid(
    known: _Known, members: IntArray, move: _Move, head: int, costs: Costs
) -> tuple[int, float, float]:
    """Return the best medoid of a group, its members' error, and the cost of the medoid.

    The current medoid is tried first. The sum of another candidate, begun with known distances, is
    abandoned as soon as it is larger, so few new distances are computed.
    """
    ends = known.ends
    low, high = move.low, move.high
    least, best, error, size = np.inf, -1, 0.0, 0.0
    for turn in range(-1, len(members)):
        c = head if turn < 0 else members[turn]
        if c < 0 or (turn >= 0 and c == head):
            continue
        price = costs.price * (ends[c + 1] - ends[c])
        is_new = low <= c < high
        total = 0.0 if is_new else known.sums[c]
        limit = (least - price) / max(costs.weight, 1e-300)
        for i in members if is_new else np.arange(low, high):
            if total >= limit:
                break
            if is_new or np.any(members == i):
                total += (ends[i + 1] - ends[i]) * _gap(known, i, c, move)
        if costs.weight * total + price < least:
            least, best, error, size = costs.weight * total + price, c, costs.weight * total, price
    return best, error, size


@maker
def _commit(
    state: State, move: _Move, groups: IntArray, rows: Float32Array, values: Float32Array
) -> None:
    """Take a step; the distances within the groups of the changed segments are completed."""
    labels = state.labels
    touched = np.unique(np.concatenate((labels[move.low : move.high], groups)))
    state.cuts[move.first : move.first + len(move.new)] = move.new
    labels[move.low : move.high] = groups
    known = _Known(values, state.distances, rows, state.cuts, state.sums)
    for s in range(move.low, move.high):
        for c in range(len(labels)):
            if labels[c] == labels[s]:
                state.distances[s, c] = _gap(known, s, c, move)
                state.distances[c, s] = state.distances[s, c]
    sum_distances(state, touched)


@dataclass(frozen=True)
class TuningSettings:
    """Settings of the tuning of cuts. All values were chosen on one take of each sample grammar."""

    largest_step: int = 8  # First d, in frames
    smallest_step: int = 1  # Last d, in frames
    # Steps without gain before d is halved, as a multiple of the number of segments
    patience: float = 2.0
    # First temperature, as a share of the cost per segment; 0 accepts better steps only
    temperature: float = 0.02
    cooling: float = 0.8  # Factor of the temperature for as many steps as there are segments
    most_steps: int = 20_000  # Largest number of steps


@dataclass(frozen=True, eq=False)
class Grouping:
    """A segmentation with its groups."""

    cuts: IntArray  # (segments + 1,): frames of all takes in a row
    labels: IntArray  # (segments,): group of each segment
    medoids: IntArray  # (K,): medoid of each group, a segment


def tune(
    grouping: Grouping,
    costs: Costs,
    rng: np.random.Generator,
    settings: TuningSettings | None = None,
    advance: Callable[[float], None] | None = None,
) -> tuple[Grouping, int]:
    """Move cuts at random as long as the cost falls."""
    settings = settings or TuningSettings()
    n, lengths = len(grouping.labels), np.diff(grouping.cuts)
    state = _begin(grouping, costs)
    total = float(state.errors.sum() + costs.price * lengths[grouping.medoids].sum())
    total += float(costs.rest[grouping.cuts].sum())
    best, best_total = Best(*(part.copy() for part in state[:3])), total
    step, steps, temperature = settings.largest_step, 0, settings.temperature * total / n
    batch = max(1, round(settings.patience * n))
    while steps < settings.most_steps:
        draws = rng.random((min(batch, settings.most_steps - steps), 4))
        before = best_total
        pace = Pace(step, temperature, total, best_total)
        total, best_total = take_steps(state, costs, draws, pace, best)
        steps += len(draws)
        temperature *= settings.cooling**settings.patience
        if advance:
            advance(steps / settings.most_steps)
        if best_total >= before * (1.0 - 1e-9):
            if step <= settings.smallest_step:
                break
            step //= 2
    return Grouping(*best), steps


def _begin(grouping: Grouping, costs: Costs) -> State:
    """Compute the data of a grouping that are kept during the search."""
    n_groups = len(grouping.medoids)
    distances = segment_distances(costs.values, grouping.cuts[:-1], grouping.cuts[1:])
    state = State(
        grouping.cuts.copy(),
        grouping.labels.copy(),
        grouping.medoids.copy(),
        distances.astype(np.float32),
        np.zeros(len(grouping.labels)),
        np.zeros(n_groups),
    )
    sum_distances(state, np.arange(n_groups))
    state.errors[:] = [_group_error(state, costs.weight, k) for k in range(n_groups)]
    return state


def total_cost(grouping: Grouping, costs: Costs) -> float:
    """Compute the cost of a grouping from scratch."""
    starts, ends = grouping.cuts[:-1], grouping.cuts[1:]
    lengths = ends - starts
    total = costs.price * float(lengths[grouping.medoids].sum())
    for i, k in enumerate(grouping.labels):
        m = grouping.medoids[k]
        gap = segment_distance(costs.values, starts[i], ends[i], starts[m], ends[m])
        total += costs.weight * float(lengths[i]) * gap
    return total + float(costs.rest[grouping.cuts].sum())


def _group_error(state: State, weight: float, group: int) -> float:
    members = np.flatnonzero(state.labels == group)
    to_medoid = state.distances[members, state.medoids[group]]
    return float(weight * (np.diff(state.cuts)[members] @ to_medoid))
