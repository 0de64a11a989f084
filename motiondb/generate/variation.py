"""Long cyclic movements that vary: other excerpts in place of a cycle that is repeated.

An excerpt that is shorter than the duration asked for is lengthened by a loop
(:mod:`motiondb.generate.cycles`). Where the loop would be played more than twice, other excerpts of
the action take the place of the repetitions. They begin alike where the loop ends and end alike
where it begins, and are chosen by dynamic programming (:mod:`motiondb.generate.stitching`): their
scores, their seams, how much their speed over the ground differs from that of the loop (so that
nobody stops on the way), how much their length differs from an equal share of what is to be filled,
and a random cost, so that the same one is seldom played again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from motiondb.generate import stitching
from motiondb.generate.cuts import Take
from motiondb.generate.excerpts import TOLERANCE, Layout
from motiondb.records import FloatArray, IntArray

LONG = 120  # Frames (4 s) from which on a movement is varied
LONGEST_INSERTED, SHORTEST_INSERTED = 75, 30
"""Frames of excerpts that are inserted, on average; captures of runs are short."""
PER_FRAME = 0.15  # Cost of a frame by which an excerpt is longer or shorter than its share, nats
UNEVEN = 20.0  # Cost of a speed that differs by that of the loop, or by ``SLOW``, nats
SLOW, STEP = 0.5, 15  # Metres a second; frames over which the speed over the ground is averaged
RANDOM = 1.0  # Largest random cost of an excerpt, nats
AGAIN = 3.0  # Cost of an excerpt that shares frames with the first one, nats


def is_monotonous(layout: Layout) -> bool:
    """Whether a layout plays a loop more than twice, and long."""
    return len(layout.parts) > 2 and layout.n_frames > LONG and not layout.times


def vary(
    capture: int,
    layout: Layout,
    moved: tuple[stitching.Candidates, IntArray],
    takes: dict[int, Take],
    weights: tuple[float, float],
    is_last: bool,
    is_least: bool,
    rng: np.random.Generator,
) -> tuple[Layout, tuple[stitching.Piece, ...]]:
    """A layout without its repetitions, and the pieces between its two parts.

    `moved`: the excerpts with moved cuts that may be inserted, and the number of the excerpt of
    each; `weights`: of join costs, and their limit; `is_last`: whether no action follows, so that
    the end may be cut; `is_least`: whether the layout must not become shorter. If none fill the
    time, the layout as it is.
    """
    candidates, owner = moved
    first, last = layout.parts[0], layout.parts[-1]
    costs = candidates.targets + UNEVEN * _unevenness(candidates, takes, capture, layout.parts[1])
    shared = (candidates.starts < max(first[1], last[1])) & (candidates.ends > first[0])
    costs = costs + AGAIN * (shared & (candidates.captures == capture))
    costs = costs + rng.uniform(0.0, RANDOM, owner.max() + 1)[owner]
    candidates = replace(candidates, targets=costs)
    edges = takes[capture].edges
    ends = _only(capture, first, edges), _only(capture, last, edges)
    frames = sum(end - start for start, end in layout.parts[1:-1])
    fewest = max(round(frames / LONGEST_INSERTED), 1)
    for n in range(fewest, max(frames // SHORTEST_INSERTED, fewest) + 1):
        between = _insert(candidates, ends, frames, n, weights)
        missing = frames - sum(piece.end - piece.start for piece in between)
        end = max(last[1] + min(missing, 0), last[0] + 1) if is_last else last[1]
        short = last[1] + missing - end
        most = TOLERANCE * layout.n_frames
        if -most <= short <= (0.0 if is_least else most):
            return Layout((first, (last[0], end)), said_of(between)), between
    return layout, ()


def _insert(
    candidates: stitching.Candidates,
    ends: tuple[stitching.Candidates, stitching.Candidates],
    frames: int,
    n: int,
    weights: tuple[float, float],
) -> tuple[stitching.Piece, ...]:
    """The n excerpts of least cost between two ends that together have about `frames` frames."""
    lengths = candidates.ends - candidates.starts
    costs = candidates.targets + PER_FRAME * np.abs(lengths - frames / n)
    inner = [replace(candidates, targets=costs)] * n
    chosen = stitching.choose([ends[0], *inner, ends[1]], *weights)[1:-1]
    places = zip(candidates.captures[chosen], candidates.starts[chosen], candidates.ends[chosen])
    return tuple(stitching.Piece(int(c), int(a), int(b)) for c, a, b in places)


def _unevenness(
    candidates: stitching.Candidates, takes: dict[int, Take], capture: int, loop: tuple[int, int]
) -> FloatArray:
    """Mean difference of speed from a loop, as a share of its speed: array (candidates,)."""
    speed = float(takes[capture].speeds[loop[0] : loop[1]].mean())
    apart = {
        c: np.abs(uniform_filter1d(takes[c].speeds, STEP, mode="nearest") - speed)
        for c in {*candidates.captures.tolist()}
    }
    rows = zip(candidates.captures.tolist(), candidates.starts, candidates.ends)
    return np.array([apart[c][a:b].mean() for c, a, b in rows]) / max(speed, SLOW)


def said_of(between: Sequence[stitching.Piece]) -> str:
    """How an excerpt is lengthened by others.

    >>> said_of([stitching.Piece(3, 10, 85)])
    'its cycles vary: 1 other excerpt is inserted'
    """
    n = len(between)
    return "its cycles vary: " + (
        "1 other excerpt is inserted" if n == 1 else f"{n} other excerpts are inserted"
    )


def _only(capture: int, part: tuple[int, int], edges: FloatArray) -> stitching.Candidates:
    """A part as the only candidate."""
    start, end = part
    return stitching.Candidates(
        np.array([capture]),
        np.array([start]),
        np.array([end]),
        edges[[start]],
        edges[[end]],
        np.zeros(1),
    )
