"""Candidate cuts of takes, and all segments between them.

Movements begin and end where the body rests or turns back. The candidate cuts are therefore the
moments of least change of the pose, with further cuts between them so that two neighbours are never
more than ``grid`` frames apart. A *cell* is a segment of allowed length between two candidate cuts
of one take. A segmentation is a path of cells from the first cut to the last; the cheapest path is
found exactly (:func:`cheapest_path`), with cuts as vertices in order of time and cells as edges.

Park, Lee and Lee (2011) place a candidate every 30 frames; the numbers of segments of their Table 1
cannot be reached in this way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motiondb.grammar.kernels import maker
from motiondb.grammar.terminals.distances import Poses
from motiondb.records import Float32Array, FloatArray, IntArray

_HALVINGS = 60  # Number of bisection steps for the price, more than the precision of a double


@dataclass(frozen=True, eq=False)
class Cells:
    """All segments between candidate cuts, ordered by their end, then start."""

    # (cuts,): frames of all takes in a row, ascending; begins and ends of takes are among them
    cuts: IntArray
    firsts: IntArray  # (cells,): number of the cut at which each cell begins
    lasts: IntArray  # (cells,): number of the cut at which each cell ends
    pointers: IntArray  # (cuts + 1,): cells ``pointers[j]`` to ``pointers[j + 1]`` end at cut j

    @cached_property
    def starts(self) -> IntArray:
        """First frame of every cell."""
        return self.cuts[self.firsts]

    @cached_property
    def ends(self) -> IntArray:
        """Frame after the last of every cell."""
        return self.cuts[self.lasts]


def thinned(poses: Poses, step: int) -> Poses:
    """Take every ``step``-th frame of every take, from its first."""
    pieces = [np.arange(a, b, step) for a, b in zip(poses.bounds, poses.bounds[1:])]
    kept = np.concatenate(pieces)
    bounds = np.cumsum([0, *(len(piece) for piece in pieces)])
    values = np.ascontiguousarray(poses.values[kept])
    return Poses(values, bounds, poses.largest, poses.speeds[kept])


def unthinned(cuts: IntArray, thin: Poses, poses: Poses, step: int) -> IntArray:
    """Convert cuts of :func:`thinned` takes to cuts of the takes."""
    takes = np.searchsorted(thin.bounds[:-1], cuts, side="right") - 1
    frames = poses.bounds[takes] + step * (cuts - thin.bounds[takes])
    return np.minimum(frames, poses.n_frames)


def rests(speeds: FloatArray) -> IntArray:
    """Return the inner frames at which the smoothed speed has a minimum.

    >>> rests(np.array([3.0, 2.0, 0.0, 2.0, 4.0, 1.0, 1.0, 3.0, 3.0]))
    array([2, 6])
    """
    if len(speeds) < 3:
        return np.zeros(0, dtype=np.int64)
    padded = np.concatenate([speeds[:1], speeds, speeds[-1:]])
    smooth = (padded[:-2] + 2.0 * padded[1:-1] + padded[2:]) / 4.0
    inside = smooth[1:-1]
    return np.flatnonzero((inside <= smooth[:-2]) & (inside < smooth[2:])) + 1


def candidate_cuts(poses: Poses, grid: int, shortest: int) -> IntArray:
    """Return rests, and cuts that fill the gaps between them.

    Rests nearer than half of ``shortest`` to an end of their take are left out.

    Shapes: result (cuts,).
    """
    cuts = [np.array([0])]
    for first, last in zip(poses.bounds, poses.bounds[1:]):
        n_frames = int(last - first)
        still = rests(poses.speeds[first:last])
        still = still[(still > shortest // 2) & (still < n_frames - shortest // 2)]
        fixed = np.concatenate([[0], still, [n_frames]])
        for a, b in pairwise(fixed):
            n_parts = -(-int(b - a) // grid)
            cuts.append(first + a + np.arange(1, n_parts + 1) * (b - a) // n_parts)
    return np.unique(np.concatenate(cuts))


def make_cells(
    cuts: IntArray, frames: IntArray, bounds: IntArray, shortest: int, longest: int
) -> Cells:
    """Return all cells that cross no end of a take.

    A take shorter than ``shortest`` is one cell. ``longest`` is raised to twice ``shortest`` and a
    gap of the cuts, so that there is always a path.

    Shapes: `cuts`, `frames` (cuts,); `bounds` (bounds,).
    """
    is_bound = np.isin(cuts, bounds)
    longest = max(longest, 2 * shortest + int(np.diff(frames).max()))
    firsts: list[IntArray] = []
    begin = 0
    for j in range(len(cuts)):
        earlier = np.arange(begin, j)
        lengths = frames[j] - frames[earlier]
        allowed = (lengths >= shortest) & (lengths <= longest)
        if is_bound[j]:
            if len(earlier) and not allowed.any():
                allowed = earlier == begin
            begin = j
        firsts.append(earlier[allowed])
    counts = np.array([len(some) for some in firsts])
    pointers = np.concatenate([[0], np.cumsum(counts)])
    return Cells(cuts, np.concatenate(firsts), np.repeat(np.arange(len(cuts)), counts), pointers)


@maker
def path_costs(
    firsts: IntArray,
    pointers: IntArray,
    costs: NDArray[np.floating],
    cut_costs: FloatArray,
    least: FloatArray,
    before: IntArray,
) -> float:
    """Fill the cost of the cheapest path to every cut, and its last cell.

    Returns the cost of the whole path.

    Parameters
    ----------
    firsts : array (cells,)
        Number of the cut at which each cell begins.
    pointers : array (cuts + 1,)
        Cells ``pointers[j]`` to ``pointers[j + 1]`` end at cut j.
    costs : array (cells,)
        Cost of every cell.
    cut_costs : array (cuts,)
        Cost of every cut.
    least : array (cuts,)
        Filled with the cost of the cheapest path to every cut.
    before : array (cuts,)
        Filled with the last cell of that path; the first cut has none and is left out.
    """
    least[0] = 0.0
    for j in range(1, len(least)):
        cheapest, cell = np.inf, -1
        for c in range(pointers[j], pointers[j + 1]):
            cost = least[firsts[c]] + costs[c]
            if cost < cheapest:
                cheapest, cell = cost, c
        least[j] = cheapest + cut_costs[j]
        before[j] = cell
    return float(least[-1])


def cheapest_path(
    cells: Cells, costs: FloatArray | Float32Array, cut_costs: FloatArray
) -> tuple[float, IntArray]:
    """Return the segmentation of least cost; `costs` (cells,); `cut_costs` (cuts,)."""
    least = np.empty(len(cells.cuts))
    before = np.empty(len(cells.cuts), dtype=np.int64)
    total = path_costs(cells.firsts, cells.pointers, costs, cut_costs, least, before)
    path, cut = [], len(cells.cuts) - 1
    while cut > 0:
        path.append(int(before[cut]))
        cut = int(cells.firsts[before[cut]])
    return float(total), np.array(path[::-1], dtype=np.int64)


def bounded_path(
    cells: Cells,
    costs: FloatArray | Float32Array,
    cut_costs: FloatArray,
    fewest: int,
    most: int | None,
) -> IntArray:
    """Return the cheapest path of ``fewest`` to ``most`` cells that a price per cell leads to.

    Shapes: `costs` (cells,); `cut_costs` (cuts,).
    """
    paid = np.asarray(costs, dtype=np.float64)
    size = float(np.abs(paid).sum() + np.abs(cut_costs).sum()) + 1.0
    low, high = -size, size
    _, path = cheapest_path(cells, paid + low, cut_costs)
    too_many = most is not None and len(path) > most
    answer = cheapest_path(cells, paid + (high if too_many else low), cut_costs)[1]
    for _ in range(_HALVINGS):
        price = (low + high) / 2.0
        _, path = cheapest_path(cells, paid + price, cut_costs)
        if len(path) < fewest:
            high = price
        elif most is not None and len(path) > most:
            low = price
        else:
            answer = path
            low, high = (price, high) if price < 0.0 else (low, price)
    return answer
