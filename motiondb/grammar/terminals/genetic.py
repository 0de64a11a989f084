"""The genetic algorithm of the paper over candidate cuts, in parts.

A solution has a bit for every candidate cut (:mod:`.candidates`), which says whether it is used.
Its segments are grouped by the swap search, and its cost is that of :mod:`.tuning`: w R + (1 - w)
E' plus the cost of the cuts. Solutions are drawn in proportion to 1 / cost above the worst; two are
crossed at two places; bits flip or move to a neighbour; cuts nearer than the shortest segment are
removed. The best solution is kept.

One evaluation costs the square of the length. A long take is therefore divided into parts that are
searched one by one, each with a table of its poses' distances, and grouped as a whole afterwards.
Parts end where takes end or where the body rests.

Source: Park, Lee and Lee (2011), section 4.2 and the splitting described in section 7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit

from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.tuning_steps import Costs
from motiondb.records import Float32Array, FloatArray, IntArray

Bits = np.ndarray


@dataclass(frozen=True)
class GeneticSettings:
    """Settings of the genetic algorithm, chosen by hand."""

    population: int = 60  # Number of solutions in the population
    generations: int = 120
    mutation: float = 1.5  # Mean number of flipped bits of a solution
    part: int = 1000  # Length of a part, frames


def genetic_cuts(
    candidates: IntArray,
    costs: Costs,
    n_groups: int,
    rng: np.random.Generator,
    settings: GeneticSettings | None = None,
    advance: Callable[[float], None] | None = None,
) -> IntArray:
    """Search cuts by the genetic algorithm.

    Shapes: `candidates` (cuts,).

    `n_groups`: K of the whole; a part of T' of T frames is grouped into K sqrt(T' / T).
    """
    settings = settings or GeneticSettings()
    parts = split(candidates, costs.fixed, settings.part)
    n_frames = int(candidates[-1])
    cuts = [np.array([0])]
    for number, part_cuts in enumerate(parts):
        share = float(np.sqrt((part_cuts[-1] - part_cuts[0]) / n_frames))
        cuts.append(_search_part(part_cuts, costs, max(1, round(n_groups * share)), rng, settings))
        if advance:
            advance((number + 1) / len(parts))
    return np.unique(np.concatenate(cuts))


def split(candidates: IntArray, fixed: np.ndarray, part: int) -> list[IntArray]:
    """Divide candidates into parts of about ``part`` frames, both ends of each part included.

    >>> fixed = np.isin(np.arange(41), [0, 20, 40])
    >>> [own.tolist() for own in split(np.arange(0, 41, 5), fixed, 12)]
    [[0, 5, 10], [10, 15, 20], [20, 25, 30], [30, 35, 40]]
    """
    ends = candidates[fixed[candidates]]
    parts = []
    for a, b in pairwise(ends):
        inside = candidates[(candidates >= a) & (candidates <= b)]
        n_parts = max(1, round((b - a) / part))
        wished = a + (b - a) * np.arange(n_parts + 1) / n_parts
        at = np.unique([int(np.argmin(np.abs(inside - x))) for x in wished])
        parts += [inside[i : j + 1] for i, j in pairwise(at)]
    return parts


def _search_part(
    cuts: IntArray,
    costs: Costs,
    n_groups: int,
    rng: np.random.Generator,
    settings: GeneticSettings,
) -> IntArray:
    """Return the best cuts of one part."""
    first = int(cuts[0])
    table = _distances(costs.values[first : cuts[-1]])
    n_bits = max(len(cuts) - 2, 0)

    def cost(bits: Bits) -> float:
        return _cost(cuts[np.concatenate([[True], bits, [True]])], first, table, costs, n_groups)

    shares = rng.uniform(0.1, 0.6, settings.population)
    population = [_repair(rng.random(n_bits) < share, cuts, costs.shortest) for share in shares]
    values = np.array([cost(bits) for bits in population])
    for _ in range(settings.generations if n_bits else 0):
        best = int(np.argmin(values))
        children = [population[best]]
        chances = 1.0 / values - 1.0 / values.max() + 1e-12
        chances /= chances.sum()
        while len(children) < settings.population:
            mother, father = rng.choice(settings.population, 2, p=chances)
            child = _cross(population[mother], population[father], rng)
            child = _mutate(child, settings.mutation, rng)
            children.append(_repair(child, cuts, costs.shortest))
        values = np.array([values[best], *(cost(bits) for bits in children[1:])])
        population = children
    return cuts[np.concatenate([[True], population[int(np.argmin(values))], [True]])]


def _distances(values: Float32Array) -> Float32Array:
    squares = (values**2).sum(axis=1)
    inner = values @ values.T
    return np.sqrt(np.maximum(squares[:, None] + squares - 2.0 * inner, 0.0))


def _cost(cuts: IntArray, first: int, table: Float32Array, costs: Costs, n_groups: int) -> float:
    """Compute the cost of a segmentation of a part after grouping."""
    starts, ends = cuts[:-1] - first, cuts[1:] - first
    lengths = ends - starts
    distances = _table_distances(table, starts, ends)
    weights, prices = costs.weight * lengths, costs.price * lengths
    medoids, labels = group_by_medoids(
        distances, min(n_groups, len(starts)), weights=weights, prices=prices
    )
    error = float(weights @ distances[np.arange(len(starts)), medoids[labels]])
    return error + float(prices[medoids].sum()) + float(costs.rest[cuts[:-1]].sum()) + 1e-12


def _cross(mother: Bits, father: Bits, rng: np.random.Generator) -> Bits:
    """Return the mother's bits with the father's between two places."""
    child = mother.copy()
    a, b = np.sort(rng.integers(0, len(mother) + 1, 2))
    child[a:b] = father[a:b]
    return child


def _mutate(bits: Bits, flips: float, rng: np.random.Generator) -> Bits:
    """Flip some bits, and move a cut to a neighbouring candidate."""
    flipped = rng.random(len(bits)) < flips / max(len(bits), 1)
    bits = bits ^ flipped
    cuts = np.flatnonzero(bits)
    if len(cuts):
        at = int(rng.choice(cuts))
        to = at + (1 if rng.random() < 0.5 else -1)
        if 0 <= to < len(bits) and not bits[to]:
            bits[at], bits[to] = False, True
    return bits


def _repair(bits: Bits, cuts: IntArray, shortest: int) -> Bits:
    """Remove, from left to right, the cuts that would make a segment too short."""
    repaired = np.zeros(len(bits), dtype=bool)
    last = cuts[0]
    for n in np.flatnonzero(bits):
        if cuts[n + 1] - last >= shortest and cuts[-1] - cuts[n + 1] >= shortest:
            repaired[n] = True
            last = cuts[n + 1]
    return repaired


@njit(cache=True, fastmath=True)
def _table_distances(table: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Return D between segments from a table of pose distances; see :mod:`.segment_distance`."""
    n = len(starts)
    distances = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            a, b = (i, j) if ends[i] - starts[i] >= ends[j] - starts[j] else (j, i)
            length, shorter = ends[a] - starts[a], ends[b] - starts[b]
            total, behind, at = 0.0, 0, starts[b]
            for t in range(starts[a], ends[a]):
                total += table[t, at]
                behind += shorter
                if behind >= length:
                    behind -= length
                    at += 1
            distances[i, j] = distances[j, i] = total / length
    return distances
