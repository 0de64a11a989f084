"""Slide and Resize: the cuts of a segmentation are moved a little, groups and medoids follow.

A step picks a segment s_i = [t_i, t_{i+1}) at random and moves

    Slide   both its ends by +d or -d:   s_{i-1} and s_{i+1} give and take,
    Resize  its end by +d or -d:         s_{i+1} begins later or earlier; its far end stays

(print lets the far end move too, which would move every segment behind). Only what changed is done
again: the changed segments leave their groups and join those of the nearest medoids, groups that
lost or gained members choose their medoid anew (the one with which F is largest), and R and E' are
sums over groups, so F is known from the changed groups alone. It equals F computed from nothing. A
group never loses its last segment, no cut leaves its take or makes a segment too short.

d begins large and is halved whenever a number of steps brought no gain, and the search ends when
the smallest d does. A step is taken if it lowers

    cost = w R + (1 - w) E' + sum over cuts of rest(c)   (= 1 / F where cuts cost nothing),

and, at a temperature above 0, one that raises it with probability exp(-rise / temperature); the
temperature falls with every step. At the end the best that was seen counts.

Source: Park, Lee and Lee (2011), section 4.3, which takes a step only if it is better
(temperature 0).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from motiondb.grammar.terminals.segment_distance import segment_distance, segment_distances
from motiondb.records import Float32Array, FloatArray, IntArray


@dataclass(frozen=True)
class TuningSettings:
    """largest_step, smallest_step : frames, of d. patience : steps without gain, as a multiple of
    the number of segments, before d is halved. temperature : at the beginning, as a share of the
    cost per segment (0: only better steps). cooling : factor of the temperature per segment-wise
    round. most_steps : the search ends here at the latest."""

    largest_step: int = 8
    smallest_step: int = 1
    patience: float = 2.0
    temperature: float = 0.02
    cooling: float = 0.8
    most_steps: int = 20_000


@dataclass(frozen=True, eq=False)
class Grouping:
    """A segmentation with its groups.

    cuts : array (segments + 1,), frames of all takes in a row. labels : array (segments,). medoids
    : array (K,), segments.
    """

    cuts: IntArray
    labels: IntArray
    medoids: IntArray


@dataclass(frozen=True, eq=False)
class Costs:
    """What a step is judged by: poses (frames, dimensions); fixed (frames + 1,), which cuts may not
    move; rest (frames + 1,), the cost of a cut; price of a medoid's frame, w / T, and weight of a
    frame's distance, (1 - w) / (T d_max); least length of a segment."""

    values: Float32Array
    fixed: np.ndarray
    rest: FloatArray
    price: float
    weight: float
    shortest: int


def tune(
    grouping: Grouping,
    costs: Costs,
    rng: np.random.Generator,
    settings: TuningSettings | None = None,
    advance: Callable[[float], None] | None = None,
) -> tuple[Grouping, int]:
    """The best grouping that was seen, never worse than the given; and the number of steps."""
    settings = settings or TuningSettings()
    starts, ends = grouping.cuts[:-1], grouping.cuts[1:]
    distances = segment_distances(costs.values, starts, ends).astype(np.float32)
    sums = np.zeros(len(starts))
    state = (
        grouping.cuts.copy(), grouping.labels.copy(), grouping.medoids.copy(), distances, sums
    )  # fmt: skip
    _add_up(state, np.arange(len(grouping.medoids)))
    n = len(starts)
    errors = np.array([_group_error(state, costs.weight, k) for k in range(len(grouping.medoids))])
    total = float(errors.sum() + costs.price * (ends - starts)[grouping.medoids].sum())
    total += float(costs.rest[grouping.cuts].sum())
    best, best_total = Grouping(*(part.copy() for part in state[:3])), total
    step, steps, chance = settings.largest_step, 0, settings.temperature * total / n
    batch = max(1, round(settings.patience * n))
    while steps < settings.most_steps:
        draws = rng.random((min(batch, settings.most_steps - steps), 4))
        before = best_total
        total, best_total = _steps(
            state, errors, _arrays(costs), draws, (step, chance, total, best_total), _parts(best)
        )
        steps += len(draws)
        chance *= settings.cooling**settings.patience
        if advance:
            advance(steps / settings.most_steps)
        if best_total >= before * (1.0 - 1e-9):
            if step <= settings.smallest_step:
                break
            step //= 2
    return best, steps


def total_cost(grouping: Grouping, costs: Costs) -> float:
    """The cost of a grouping, from nothing."""
    starts, ends = grouping.cuts[:-1], grouping.cuts[1:]
    lengths = ends - starts
    total = costs.price * float(lengths[grouping.medoids].sum())
    for i, k in enumerate(grouping.labels):
        m = grouping.medoids[k]
        gap = segment_distance(costs.values, starts[i], ends[i], starts[m], ends[m])
        total += costs.weight * float(lengths[i]) * gap
    return total + float(costs.rest[grouping.cuts].sum())


def _arrays(costs: Costs):  # type: ignore[no-untyped-def]
    return (
        costs.values, costs.fixed, costs.rest, costs.price, costs.weight, costs.shortest,
    )  # fmt: skip


def _parts(grouping: Grouping):  # type: ignore[no-untyped-def]
    return grouping.cuts, grouping.labels, grouping.medoids


def _group_error(state, weight: float, group: int) -> float:  # type: ignore[no-untyped-def]
    cuts, labels, medoids, distances, _ = state
    own = np.flatnonzero(labels == group)
    return float(weight * (np.diff(cuts)[own] @ distances[own, medoids[group]]))


@njit(cache=True, nogil=True)
def _steps(state, errors, costs, draws, schedule, best):  # type: ignore[no-untyped-def]
    """Steps of one size; changes ``state``, ``errors`` and ``best``; cost now and of the best."""
    step, chance, total, best_total = schedule
    cuts, labels, medoids, _, _ = state
    n = len(labels)
    for draw in draws:
        i = min(int(draw[0] * n), n - 1)
        move = step if draw[1] < 0.5 else -step
        first = i if draw[2] < 0.5 else i + 1  # Slide moves cuts i and i + 1, Resize i + 1
        new = cuts[first : i + 2] + move
        if not _allowed(cuts, first, new, costs[1], costs[5]):
            continue
        change = _try(state, errors, costs, first, new)
        gain, segments, groups, heads, losses, rows = change
        if gain < 0.0 or (chance > 0.0 and draw[3] < np.exp(-gain / chance)):
            medoids[:], errors[:] = heads, losses
            _commit(state, first, new, segments, groups, rows, costs[0])
            total += gain
            if total < best_total * (1.0 - 1e-12):
                best_total = total
                best[0][:], best[1][:], best[2][:] = cuts, labels, medoids
    return total, best_total


@njit(cache=True)
def _allowed(cuts, first, new, fixed, shortest):  # type: ignore[no-untyped-def]
    last = first + len(new) - 1
    if first < 1 or last > len(cuts) - 2:
        return False
    for c in range(first, last + 1):
        if fixed[cuts[c]]:
            return False
    return new[0] - cuts[first - 1] >= shortest and cuts[last + 1] - new[-1] >= shortest


@njit(cache=True)
def _try(state, errors, costs, first, new):  # type: ignore[no-untyped-def]
    """The change of the cost, and all that it would make new."""
    cuts, labels, medoids, distances, _ = state
    values, _, rest, price, weight, _ = costs
    low, high = first - 1, first + len(new)  # the changed segments, [low, high)
    moved = cuts[low : high + 1].copy()
    moved[1:-1] = new
    heads = medoids.copy()
    left = _without(state, low, high)
    _release(labels, heads, left, low, high)
    groups = np.empty(high - low, np.int64)
    for s in range(low, high):
        groups[s - low] = _nearest(values, cuts, moved, heads, labels, low, s, medoids)
    touched = np.unique(np.concatenate((labels[low:high], groups)))
    rows = np.full((high - low, len(labels)), np.nan, np.float32)
    gain = 0.0
    for c in range(len(new)):
        gain += rest[new[c]] - rest[cuts[first + c]]
    losses = errors.copy()
    after = labels.copy()
    after[low:high] = groups
    ends = cuts.copy()
    ends[low : high + 1] = moved
    for k in touched:
        members = np.flatnonzero(after == k)
        known = (values, distances, rows, ends, left)
        heads[k], losses[k], size = _choose(known, members, low, high, heads[k], price, weight)
        gain += losses[k] + size - errors[k] - price * (cuts[medoids[k] + 1] - cuts[medoids[k]])
    return gain, (low, high), groups, heads, losses, rows


@njit(cache=True)
def _add_up(state, groups):  # type: ignore[no-untyped-def]
    """sums[c], the group's frames' distances to c, for all segments of some groups."""
    cuts, labels, _, distances, sums = state
    for k in groups:
        members = np.flatnonzero(labels == k)
        for c in members:
            sums[c] = 0.0
            for i in members:
                sums[c] += (cuts[i + 1] - cuts[i]) * distances[i, c]


@njit(cache=True)
def _without(state, low, high):  # type: ignore[no-untyped-def]
    """``sums`` when the segments [low, high) have left their groups."""
    cuts, labels, _, distances, sums = state
    left = sums.copy()
    for s in range(low, high):
        for c in range(len(labels)):
            if labels[c] == labels[s]:
                left[c] -= (cuts[s + 1] - cuts[s]) * distances[s, c]
    return left


@njit(cache=True)
def _release(labels, heads, left, low, high):  # type: ignore[no-untyped-def]
    """Groups whose medoid is among the changed segments choose another of the unchanged; -1 where
    there is none."""
    for s in range(low, high):
        k = labels[s]
        if not low <= heads[k] < high:
            continue
        heads[k] = -1
        least = np.inf
        for c in range(len(labels)):
            if labels[c] == k and not low <= c < high and left[c] < least:
                least, heads[k] = left[c], c


@njit(cache=True)
def _nearest(values, cuts, moved, heads, labels, low, s, medoids):  # type: ignore[no-untyped-def]
    """The group of a changed segment: a group of which nothing else is left keeps its medoid."""
    own = labels[s]
    if heads[own] < 0 and medoids[own] == s:
        return own
    least, found = np.inf, own
    for k in range(len(heads)):
        if heads[k] >= 0:
            a, b = cuts[heads[k]], cuts[heads[k] + 1]
            gap = segment_distance(values, moved[s - low], moved[s - low + 1], a, b)
            if gap < least:
                least, found = gap, k
    return found


@njit(cache=True)
def _gap(known, i, c, low, high):  # type: ignore[no-untyped-def]
    """Distance of two segments as they would be; what is new is computed once and kept in rows."""
    values, distances, rows, ends, _ = known
    if low <= c < high:
        i, c = c, i
    if not low <= i < high:
        return distances[i, c]
    if i == c:
        return np.float32(0.0)
    if np.isnan(rows[i - low, c]):
        gap = segment_distance(values, ends[i], ends[i + 1], ends[c], ends[c + 1])
        rows[i - low, c] = gap
        if low <= c < high:
            rows[c - low, i] = gap
    return rows[i - low, c]


@njit(cache=True)
def _choose(known, members, low, high, head, price, weight):  # type: ignore[no-untyped-def]
    """The best medoid of a group, its members' error, and what the medoid costs.

    The present one is looked at first; of another the sum, begun with what is known, is given up as
    soon as it is larger, so that few new distances are computed.
    """
    ends, left = known[3], known[4]
    least, found, error, size = np.inf, -1, 0.0, 0.0
    for turn in range(-1, len(members)):
        c = head if turn < 0 else members[turn]
        if c < 0 or (turn >= 0 and c == head):
            continue
        own = price * (ends[c + 1] - ends[c])
        is_new = low <= c < high
        total, limit = 0.0 if is_new else left[c], (least - own) / max(weight, 1e-300)
        for i in members if is_new else np.arange(low, high):
            if total >= limit:
                break
            if is_new or np.any(members == i):
                total += (ends[i + 1] - ends[i]) * _gap(known, i, c, low, high)
        if weight * total + own < least:
            least, found, error, size = weight * total + own, c, weight * total, own
    return found, error, size


@njit(cache=True)
def _commit(state, first, new, segments, groups, rows, values):  # type: ignore[no-untyped-def]
    """Take the step; distances within the groups of the changed segments are made complete."""
    cuts, labels, _, distances, sums = state
    low, high = segments
    touched = np.unique(np.concatenate((labels[low:high], groups)))
    cuts[first : first + len(new)] = new
    labels[low:high] = groups
    known = (values, distances, rows, cuts, sums)
    for s in range(low, high):
        for c in range(len(labels)):
            if labels[c] == labels[s]:
                distances[s, c] = _gap(known, s, c, low, high)
                distances[c, s] = distances[s, c]
    _add_up(state, touched)
