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

import numpy as np

from motiondb.grammar.terminals.segment_distance import segment_distance, segment_distances
from motiondb.grammar.terminals.tuning_steps import (
    Best,
    Costs,
    Pace,
    State,
    sum_distances,
    take_steps,
)
from motiondb.records import IntArray


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
