"""Terminals as Park, Lee and Lee (2011) find them: the baseline of motiondb's terminals.

As printed in their section 4: a candidate cut every 30 frames; solutions are bits, scored by F
after grouping (k-medoids by turns: every segment to its nearest medoid, every group to the member
with the least sum of distances, from the first K segments on); 100 solutions drawn in proportion to
F (roulette), crossed at one point and mutated, 500 generations; then 1,000 steps of Slide and
Resize, each taken only if F rises, d falling from large to 1, groups and medoids updated for what
changed. Distances between segments of the grid are kept once computed, which changes no result.
Not printed and chosen here: every bit starts with probability 1/2, crossing in 7 of 10 pairs, one
flip a solution on average, the best solution of all generations counts, d = 15, 8, 4, 2, 1 for 200
steps each, and all of it on the whole take with one table of distances between all pairs of frames.
The ends of captures are cuts here as in motiondb.

    PYTHONPATH=benchmarks python -m grammar_tasks.park_2011 DATA \
        [--generations 500] [--terminals 20] [--seeds 1]

DATA holds ``cmu`` and ``cmu-captions.tsv``. The take is all break-dance of performer 85, two boxing
captures and salsa, cut off at 8,677 frames, the length of the paper's break-dance.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from measured_run import machine
from numba import njit

from motiondb.grammar.terminals.distances import Poses, distances_to, make_poses
from motiondb.grammar.terminals.terminals import (
    REPETITION_WEIGHT,
    Terminals,
    TerminalSettings,
    find_terminals,
    score,
)
from motiondb.records import Float32Array, FloatArray, IntArray, Motion
from quality_protocol.captures import load_cmu

GRID = 30
"""Frames between candidate cuts, as in the paper."""
POPULATION, GENERATIONS, TUNING_STEPS = 100, 500, 1000
"""Solutions, generations and steps of tuning, as in the paper."""
CROSSED = 0.7
"""Probability that a pair is crossed. The paper gives none; chosen by hand."""
KEPT = 8  # places that a segment spans at most for its distances to be kept
STEPS = (15, 8, 4, 2, 1)
"""d in frames, from the first fifth of the steps to the last. The paper gives none."""
N_FRAMES = 8677
"""Length of the paper's break-dance in frames."""
NAMES = ("14/14_02", "17/17_10", "60/60_01", "60/60_02")


def long_take(data: Path) -> list[Motion]:
    """Captures in a row, 8,677 frames."""
    captures = load_cmu(data)
    chosen = [c.motion for c in captures if c.performer == "85"]
    chosen += [c.motion for name in NAMES for c in captures if c.name == name]
    takes, left = [], N_FRAMES
    for motion in chosen:
        kept = replace(
            motion,
            local_rotations=motion.local_rotations[:left],
            root_positions=motion.root_positions[:left],
        )
        left -= kept.n_frames
        if kept.n_frames:
            takes.append(kept)
    return takes


def pose_table(values: Float32Array) -> Float32Array:
    """d of all pairs of frames: array (frames, frames)."""
    squares = (values**2).sum(axis=1)
    table = values @ values.T
    table *= -2.0
    table += squares[:, None]
    table += squares
    return np.sqrt(np.maximum(table, 0.0, out=table), out=table)


def genetic_cuts(
    poses: Poses, table: Float32Array, k: int, weight: float, rng: np.random.Generator, rounds: int
) -> IntArray:
    """The best cuts of all generations."""
    grid = [np.arange(a + GRID, b - GRID + 1, GRID) for a, b in zip(poses.bounds, poses.bounds[1:])]
    free = np.concatenate(grid)
    places = np.unique(np.concatenate([poses.bounds, free]))
    known = np.full((len(places) * KEPT, len(places) * KEPT), np.nan, dtype=np.float32)

    def value(bits: np.ndarray) -> tuple[float, IntArray]:
        cuts = np.unique(np.concatenate([poses.bounds, free[bits]]))
        at = np.searchsorted(places, cuts)
        return paper_objective(table, cuts, k, (weight, poses.largest), at, known), cuts

    population = rng.random((POPULATION, len(free))) < 0.5
    best, cuts = 0.0, poses.bounds
    for _ in range(rounds + 1):
        scored = [value(bits) for bits in population]
        scores = np.array([f for f, _ in scored])
        if scores.max() > best:
            best, cuts = scored[int(np.argmax(scores))]
        parents = rng.choice(POPULATION, (POPULATION, 2), p=scores / scores.sum())
        population = np.stack([_child(population[a], population[b], rng) for a, b in parents])
    return cuts


def _child(mother: np.ndarray, father: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    child = mother.copy()
    if rng.random() < CROSSED:
        at = int(rng.integers(1, len(child)))
        child[at:] = father[at:]
    return child ^ (rng.random(len(child)) < 1.0 / len(child))


@njit(cache=True)
def paper_objective(
    table: Float32Array,
    cuts: IntArray,
    k: int,
    scale: tuple[float, float],
    at: IntArray,
    known: Float32Array,
) -> float:
    """F after grouping; 0 if there are fewer segments than groups.

    scale : w, d_max. at : numbers of the cuts among all places. known : distances between segments
    of up to ``KEPT`` places, filled here.
    """
    n = len(cuts) - 1
    if n < k:
        return 0.0
    distances = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            spans = at[i + 1] - at[i], at[j + 1] - at[j]
            keep = spans[0] <= KEPT and spans[1] <= KEPT
            a, b = at[i] * KEPT + spans[0] - 1, at[j] * KEPT + spans[1] - 1
            if keep and not np.isnan(known[a, b]):
                gap = known[a, b]
            else:
                gap = np.float32(table_distance(table, cuts[i], cuts[i + 1], cuts[j], cuts[j + 1]))
                if keep:
                    known[a, b] = gap
            distances[i, j] = distances[j, i] = gap
    medoids, labels = alternating_medoids(distances, k)
    return objective_of(distances, cuts, medoids, labels, scale[0], scale[1])


@njit(cache=True)
def objective_of(
    distances: FloatArray,
    cuts: IntArray,
    medoids: IntArray,
    labels: IntArray,
    weight: float,
    largest: float,
) -> float:
    """F of given groups."""
    total = 0.0
    for m in medoids:
        total += weight * (cuts[m + 1] - cuts[m])
    for i in range(len(labels)):
        error = (cuts[i + 1] - cuts[i]) * distances[i, medoids[labels[i]]]
        total += (1.0 - weight) * error / largest
    return (cuts[-1] - cuts[0]) / total


@njit(cache=True)
def alternating_medoids(distances: FloatArray, k: int) -> tuple[IntArray, IntArray]:
    """Groups by turns from the first K segments, as section 4.1 describes them."""
    n = len(distances)
    medoids = np.arange(k)
    labels = np.zeros(n, np.int64)
    for _ in range(100):
        for i in range(n):
            for g in range(k):
                if distances[i, medoids[g]] < distances[i, medoids[labels[i]]]:
                    labels[i] = g
        labels[medoids] = np.arange(k)
        before = medoids.copy()
        for g in range(k):
            members = np.flatnonzero(labels == g)
            least = np.inf
            for c in members:
                total = 0.0
                for other in members:
                    total += distances[other, c]
                if total < least:
                    least, medoids[g] = total, c
        if (before == medoids).all():
            break
    return medoids, labels


@njit(cache=True)
def table_distance(table: Float32Array, a: int, b: int, a2: int, b2: int) -> float:
    """D of two segments."""
    if b - a < b2 - a2:
        a, b, a2, b2 = a2, b2, a, b
    total = 0.0
    for m in range(b - a):
        total += table[a + m, a2 + m * (b2 - a2) // (b - a)]
    return total / (b - a)


@njit(cache=True)
def table_distances(table: Float32Array, cuts: IntArray) -> FloatArray:
    """D of all pairs of segments."""
    n = len(cuts) - 1
    distances = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            distances[i, j] = table_distance(table, cuts[i], cuts[i + 1], cuts[j], cuts[j + 1])
            distances[j, i] = distances[i, j]
    return distances


def accept_if_better(
    poses: Poses,
    table: Float32Array,
    cuts: IntArray,
    k: int,
    weight: float,
    rng: np.random.Generator,
    n_steps: int,
) -> tuple[IntArray, IntArray, IntArray, float]:
    """Cuts, medoids, labels and F after Slide and Resize."""
    distances = table_distances(table, cuts)
    medoids, labels = alternating_medoids(distances, k)
    best = objective_of(distances, cuts, medoids, labels, weight, poses.largest)
    for number in range(n_steps):
        d = STEPS[number * len(STEPS) // n_steps] * (1 if rng.random() < 0.5 else -1)
        i = int(rng.integers(len(labels)))
        first = i if rng.random() < 0.5 else i + 1
        moved = cuts.copy()
        moved[first : i + 2] += d
        if np.isin(cuts[first : i + 2], poses.bounds).any() or (np.diff(moved) < 1).any():
            continue
        state = _moved(table, distances, moved, medoids, labels, (first - 1, i + 2))
        objective = objective_of(state[0], moved, state[1], state[2], weight, poses.largest)
        if objective > best:
            best, cuts, (distances, medoids, labels) = objective, moved, state
    return cuts, medoids, labels, best


def _moved(
    table: Float32Array,
    distances: FloatArray,
    cuts: IntArray,
    medoids: IntArray,
    labels: IntArray,
    changed: tuple[int, int],
) -> tuple[FloatArray, IntArray, IntArray]:
    """Distances, medoids and labels when the segments [low, high) have changed."""
    low, high = changed
    distances, medoids, labels = distances.copy(), medoids.copy(), labels.copy()
    for s in range(low, min(high, len(labels))):
        for j in range(len(labels)):
            distances[s, j] = table_distance(table, cuts[s], cuts[s + 1], cuts[j], cuts[j + 1])
            distances[j, s] = distances[s, j]
    some = np.arange(low, min(high, len(labels)))
    before = labels[some]
    labels[some] = np.argmin(distances[np.ix_(some, medoids)], axis=1)
    labels[medoids] = np.arange(len(medoids))
    for g in np.unique(np.concatenate([before, labels[some]])):
        members = np.flatnonzero(labels == g)
        medoids[g] = members[int(np.argmin(distances[np.ix_(members, members)].sum(axis=0)))]
    return distances, medoids, labels


def rescored(poses: Poses, terminals: Terminals, weight: float) -> float:
    """F of motiondb's terminals, from nothing."""
    offsets = poses.bounds[terminals.takes]
    starts, ends = offsets + terminals.starts, offsets + terminals.ends
    gaps = np.empty(len(starts))
    for label, m in enumerate(terminals.medoids):
        members = np.flatnonzero(terminals.labels == label)
        gaps[members] = distances_to(
            poses.values, starts[m], ends[m], starts[members], ends[members]
        )
    return score(ends - starts, terminals.medoids, gaps, poses.largest, weight).objective


def main(arguments: Sequence[str] | None = None) -> None:
    """Both procedures on the same take, F and seconds of each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--generations", type=int, default=GENERATIONS)
    parser.add_argument("--terminals", type=int, default=20)
    parser.add_argument("--weight", type=float, default=REPETITION_WEIGHT)
    parser.add_argument("--seeds", type=int, default=1)
    chosen = parser.parse_args(arguments)
    takes, k, weight = long_take(chosen.data), chosen.terminals, chosen.weight
    poses = make_poses(takes)
    find_terminals(takes[:2], 2, np.random.default_rng(0))  # compiled before the clock runs
    print(f"{machine()}; {poses.n_frames} frames, K = {k}, w = {weight}")
    for seed in range(chosen.seeds):
        rng = np.random.default_rng(seed)
        started = time.perf_counter(), time.process_time()
        terminals = find_terminals(takes, k, rng, settings=TerminalSettings(weight=weight))
        _tell("motiondb", rescored(poses, terminals, weight), len(terminals.starts), started)
        rng = np.random.default_rng(seed)
        started = time.perf_counter(), time.process_time()
        table = pose_table(poses.values)
        cuts = genetic_cuts(poses, table, k, weight, rng, chosen.generations)
        distances = table_distances(table, cuts)
        groups = alternating_medoids(distances, k)
        coarse = objective_of(distances, cuts, *groups, weight, poses.largest)
        _tell("paper, genetic", coarse, len(cuts) - 1, started)
        cuts, _, _, tuned = accept_if_better(poses, table, cuts, k, weight, rng, TUNING_STEPS)
        _tell("paper, tuned", tuned, len(cuts) - 1, started)


def _tell(name: str, objective: float, n_segments: int, started: tuple[float, float]) -> None:
    wall, processor = time.perf_counter() - started[0], time.process_time() - started[1]
    print(
        f"{name:16} F {objective:8.4f}  {n_segments:4} segments  {wall:7.1f} s "
        f"({processor:.1f} s of processors)",
        flush=True,
    )


if __name__ == "__main__":
    main()
