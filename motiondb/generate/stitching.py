"""Motion from recorded segments, one after the other: selection and blending.

Notation: position k of a sequence has candidates i, recorded segments, with

    target cost  t_k(i)     how badly the segment shows what the position asks for
    join cost    j(i, i')   |continuation of i - entry of i'|^2, between poses and velocities

where the continuation of i is the pose that follows in its own capture, so that the join cost of a
segment and its true successor is 0. Dynamic programming finds the sequence of least total cost.

Seams are blended inertially (D. Bollo, "Inertialization: High-Performance Animation Transitions in
Gears of War", GDC 2018), and on both sides, so that no frames beyond the segments are needed: with
d the offset of the segment after the seam from where the segment before it would go on, v its
change a frame, and T the half length of the seam, the offset

    o(t) = d s(t / T) / 2 + v t_0 q(t / t_0) / 2,    t frames from the seam, t_0 = min(T, QUICK),

is added to the frames before it (with -v) and subtracted from those after it. s falls as the step
of least jerk does, and q is the quintic with slope 1 at 0; both end with their first and second
derivatives 0. So path values, rotations, and their velocities are continuous.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import convolve1d

from motiondb.body import rotation
from motiondb.records import MOTION_FPS, FloatArray, IntArray

BLEND_FRAMES = 10  # Frames (1/3 s) of a seam of similar poses
MOST_BLEND_FRAMES = 30  # Frames (1 s) of a seam of poses that are far apart
MOST_SPEEDING = 0.12
"""Most that a seam changes the speed over the ground in a frame, m/s; it grows longer instead."""
QUICK = 8  # Frames over which a difference of velocities fades
CALMED = 6.0
"""The speeds over the ground are smoothed over five frames where the other side of a seam has more
than a sixth of the weight, and less and less towards its ends."""
PEAK = 0.9375  # Steepest fall of s, at the seam
AGAIN_COST = 10.0
"""Cost of playing frames of the previous segment again: larger than that of poses that do not
fit."""
NEAR, FAR = 0.15, 0.6
"""Mean angles of the joints, radians, between poses that are similar and that are far apart:
standing and walking, standing and sitting."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Recorded segments for one position of the sequence."""

    captures: IntArray  # (n,): number of the capture
    starts: IntArray  # (n,): first frame, at 30 frames a second
    ends: IntArray  # (n,): one past the last frame
    entries: FloatArray  # (n, values): pose and velocity at the first frame
    continuations: FloatArray  # (n, values): pose and velocity that follow in the capture
    targets: FloatArray  # (n,): target costs


def choose(
    candidates: Sequence[Candidates],
    join_weight: float = 1.0,
    most_join: float = math.inf,
    continuing: float = 0.0,
) -> list[int]:
    """One candidate for each position, with least sum of target and join costs (ties: first).

    Join costs j count as j / (1 + j / `most_join`), a segment and its true successor `continuing`.
    """
    total = candidates[0].targets
    back: list[IntArray] = []
    for before, after in pairwise(candidates):
        joins = join_costs(before, after)
        joins[joins == 0.0] = continuing
        costs = total[:, None] + join_weight * joins / (1.0 + joins / most_join)
        best = np.argmin(costs, axis=0)
        back.append(best)
        total = costs[best, np.arange(len(best))] + after.targets
    path = [int(np.argmin(total))]
    for best in reversed(back):
        path.append(int(best[path[-1]]))
    return path[::-1]


def join_costs(before: Candidates, after: Candidates) -> FloatArray:
    """j(i, i') for all pairs: array (n before, n after); overlapping pairs cost AGAIN_COST more."""
    a, b = before.continuations, after.entries
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    same = before.captures[:, None] == after.captures
    follows = same & (before.ends[:, None] == after.starts)
    again = same & (before.starts[:, None] < after.ends) & (before.ends[:, None] > after.starts)
    costs = np.maximum(squares, 0.0) + 1e-3 + AGAIN_COST * again
    return np.where(follows, 0.0, costs)


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of one capture: frames [start, end) of its path values and local rotations."""

    capture: int
    start: int
    end: int


@dataclass(frozen=True, eq=False)
class Stitched:
    """A stitched motion and the source of every frame."""

    path: FloatArray  # (frames, 4): path values
    rotations: FloatArray  # (frames, 21, 4): heading-relative rotations, w, x, y, z
    captures: IntArray  # (frames,): number of the capture of largest weight
    frames: IntArray  # (frames,): frame of that capture
    shares: FloatArray  # (frames,): its weight, 1 outside of seams


def merge_pieces(pieces: Sequence[Piece]) -> list[Piece]:
    """Join pieces that follow one another in the same capture.

    >>> [(p.start, p.end) for p in merge_pieces([Piece(1, 0, 5), Piece(1, 5, 9), Piece(2, 9, 12)])]
    [(0, 9), (9, 12)]
    """
    merged: list[Piece] = []
    for piece in pieces:
        if merged and merged[-1].capture == piece.capture and merged[-1].end == piece.start:
            merged[-1] = Piece(piece.capture, merged[-1].start, piece.end)
        else:
            merged.append(piece)
    return merged


def stitch(
    pieces: Sequence[Piece],
    sources: dict[int, tuple[FloatArray, FloatArray]],
    fps: float = MOTION_FPS,
) -> Stitched:
    """Concatenate pieces with blended seams; `sources` (frames, 4), array (frames, joints, 4)."""
    merged = merge_pieces(pieces)
    played = [_play(piece, sources) for piece in merged]
    for k, (before, after) in enumerate(pairwise(merged)):
        longest = min(before.end - before.start, after.end - after.start) // 2
        seam = _seam(before, after, sources, fps / MOTION_FPS)
        _bend(played[k], played[k + 1], seam, min(seam.half, longest))
    columns = zip(*(vars(one).values() for one in played))
    whole = Stitched(*map(np.concatenate, columns))
    # the speeds of both sides must not add up to a jump
    smooth_speeds(whole.path, np.clip(CALMED * (1.0 - whole.shares), 0.0, 1.0))
    return whole


def smooth_speeds(path: FloatArray, share: FloatArray) -> None:
    """Replace a share (frames,) of the speeds of a path (frames, 4) by means of five frames."""
    weights = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
    smooth = convolve1d(path[:, 1:], weights, axis=0, mode="nearest")
    path[:, 1:] += share[:, None] * (smooth - path[:, 1:])


@dataclass(frozen=True, eq=False)
class _Seam:
    """How far the piece after a seam is from where the piece before it would go on."""

    path: FloatArray  # (4,): offset d of the path values
    path_rates: FloatArray  # (4,): its change v a frame
    turns: FloatArray  # (21, 3): offset of the rotations, as rotation vectors
    turn_rates: FloatArray  # (21, 3): its change a frame
    half: int  # T, frames
    quick: int = QUICK  # Frames over which a difference of velocities fades


def _seam(
    before: Piece,
    after: Piece,
    sources: dict[int, tuple[FloatArray, FloatArray]],
    rate: float,
) -> _Seam:
    """Offsets at a seam; a capture that ends there is continued at its last velocity.

    `rate`: Frames in 1/30 s.
    """
    (old, turned), (new, turned_new) = sources[before.capture], sources[after.capture]
    last, first = before.end - 1, after.start
    previous, following = max(last - 1, 0), min(first + 1, len(new) - 1)
    old_turning = rotation.log(rotation.relative(turned[previous], turned[last]))
    new_turning = rotation.log(rotation.relative(turned_new[first], turned_new[following]))
    going = turned[last + 1] if last + 1 < len(turned) else None
    if going is None:
        going = rotation.multiply(turned[last], rotation.exp(old_turning))
    rates = np.zeros(4)  # those of speeds are accelerations: mostly noise
    rates[0] = new[following, 0] - new[first, 0] - (old[last, 0] - old[previous, 0])
    height = old[last + 1, 0] if last + 1 < len(old) else 2.0 * old[last, 0] - old[previous, 0]
    path = new[first] - np.array([height, *old[last, 1:]])
    turns = rotation.log(rotation.relative(going, turned_new[first]))
    apart = float(np.linalg.norm(turns, axis=-1).mean())
    share = float(np.clip((apart - NEAR) / (FAR - NEAR), 0.0, 1.0))
    frames = BLEND_FRAMES + share * (MOST_BLEND_FRAMES - BLEND_FRAMES)
    speed = float(np.hypot(*path[1:3]))
    half = max(round(rate * frames / 2.0), math.ceil(rate * PEAK * speed / MOST_SPEEDING))
    return _Seam(path, rates, turns, new_turning - old_turning, half, round(rate * QUICK))


def _bend(old: Stitched, new: Stitched, seam: _Seam, half: int) -> None:
    """Bend the end of a stretch and the beginning of the next one towards each other."""
    if half < 1:
        return
    before = np.arange(min(half, len(old.path)), 0, -1)  # frames to the seam
    after = np.arange(min(half, len(new.path)))
    early, late = slice(len(old.path) - len(before), None), slice(0, len(after))
    old.path[early] += _offset(seam.path, -seam.path_rates, before, half, seam.quick)
    new.path[late] -= _offset(seam.path, seam.path_rates, after, half, seam.quick)
    old.rotations[early] = rotation.multiply(
        old.rotations[early],
        rotation.exp(_offset(seam.turns, -seam.turn_rates, before, half, seam.quick)),
    )
    new.rotations[late] = rotation.multiply(
        new.rotations[late],
        rotation.exp(-_offset(seam.turns, seam.turn_rates, after, half, seam.quick)),
    )
    old.shares[early] = 1.0 - _offset(np.ones(()), np.zeros(()), before, half)
    new.shares[late] = 1.0 - _offset(np.ones(()), np.zeros(()), after, half)


def _offset(
    offset: FloatArray, rate: FloatArray, frames: IntArray, half: int, quick: int = QUICK
) -> FloatArray:
    """o of the module's docstring at a number of frames from the seam: array (frames, ...)."""
    shape = (-1, *(1,) * offset.ndim)
    x = (frames / half).reshape(shape)
    quick = min(half, quick)
    y = np.minimum(frames / quick, 1.0).reshape(shape)
    decay = 1.0 - x**3 * (10.0 - x * (15.0 - 6.0 * x))
    slope = x - x**3 * (6.0 - x * (8.0 - 3.0 * x))
    swing = y - y**3 * (6.0 - y * (8.0 - 3.0 * y))
    return offset * (0.5 * decay - PEAK * slope) + 0.5 * rate * quick * swing


def _play(piece: Piece, sources: dict[int, tuple[FloatArray, FloatArray]]) -> Stitched:
    path, turned = sources[piece.capture]
    which = np.arange(piece.start, piece.end)
    captures = np.full(len(which), piece.capture)
    return Stitched(path[which], turned[which], captures, which, np.ones(len(which)))
