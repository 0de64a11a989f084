"""Motion from recorded segments, one after the other: selection and blending.

Notation: position k of a sequence has candidates i, recorded segments, with

    target cost  t_k(i)     how badly the segment shows what the position asks for
    join cost    j(i, i')   |continuation of i - entry of i'|^2, between poses and velocities

where the continuation of i is the pose that follows in its own capture, so that the join cost of a
segment and its true successor is 0. Dynamic programming finds the sequence of least total cost. At
a seam both segments are extended by some frames of their captures and cross-faded by a cubic
weight; path values are interpolated linearly, rotations along the shortest arc.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.body import rotation
from motiondb.records import FloatArray, IntArray

BLEND_FRAMES = 10  # Frames (1/3 s) of a cross-fade of similar poses
MOST_BLEND_FRAMES = 30  # Frames (1 s) of a cross-fade of poses that are far apart
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


def choose(candidates: Sequence[Candidates], join_weight: float = 1.0) -> list[int]:
    """One candidate for each position, with least sum of target and join costs (ties: first)."""
    total = candidates[0].targets
    back: list[IntArray] = []
    for before, after in pairwise(candidates):
        costs = total[:, None] + join_weight * join_costs(before, after)
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


def stitch(pieces: Sequence[Piece], sources: dict[int, tuple[FloatArray, FloatArray]]) -> Stitched:
    """Concatenate pieces with cross-faded seams; `sources` (frames, 4), array (frames, 21, 4)."""
    merged = merge_pieces(pieces)
    result = _play(merged[0], sources, 0, 0)
    for before, after in pairwise(merged):
        longest = min(before.end - before.start, after.end - after.start)
        half = min(_blend_frames(before, after, sources) // 2, longest // 2)
        tail = Piece(before.capture, before.end - half, before.end)
        old, new = _play(tail, sources, 0, half), _play(after, sources, half, 0)
        keep = len(result.path) - half
        seam = _cross_fade(old, _part(new, 0, 2 * half))
        result = _join(_part(result, 0, keep), seam, _part(new, 2 * half, len(new.path)))
    return result


def _blend_frames(
    before: Piece, after: Piece, sources: dict[int, tuple[FloatArray, FloatArray]]
) -> int:
    """Number of frames of a cross-fade; it grows with the distance of the poses at the seam."""
    last = sources[before.capture][1][min(before.end, len(sources[before.capture][1])) - 1]
    first = sources[after.capture][1][after.start]
    apart = float(np.linalg.norm(rotation.log(rotation.relative(last, first)), axis=-1).mean())
    share = float(np.clip((apart - NEAR) / (FAR - NEAR), 0.0, 1.0))
    return round(BLEND_FRAMES + share * (MOST_BLEND_FRAMES - BLEND_FRAMES))


def _cross_fade(old: Stitched, new: Stitched) -> Stitched:
    """Cross-fade two stretches of equal length; a frame's source is the one of larger weight."""
    n_frames = len(old.path)
    share = (np.arange(n_frames) + 0.5) / max(n_frames, 1)
    share = share * share * (3.0 - 2.0 * share)
    n_joints = old.rotations.shape[1]
    wins = share > 0.5
    return Stitched(
        old.path * (1.0 - share[:, None]) + new.path * share[:, None],
        rotation.slerp(old.rotations, new.rotations, np.repeat(share[:, None], n_joints, axis=1)),
        np.where(wins, new.captures, old.captures),
        np.where(wins, new.frames, old.frames),
        np.where(wins, share, 1.0 - share),
    )


def _play(
    piece: Piece, sources: dict[int, tuple[FloatArray, FloatArray]], before: int, after: int
) -> Stitched:
    """A piece with frames added before and after; beyond its capture end frames are repeated."""
    path, turned = sources[piece.capture]
    which = np.arange(piece.start - before, piece.end + after)
    inside = np.clip(which, 0, len(path) - 1)
    values = path[inside].copy()
    values[which != inside, 1:] = 0.0
    captures = np.full(len(which), piece.capture)
    return Stitched(values, turned[inside], captures, inside, np.ones(len(which)))


def _part(whole: Stitched, start: int, end: int) -> Stitched:
    return Stitched(*(column[start:end] for column in vars(whole).values()))


def _join(*parts: Stitched) -> Stitched:
    columns = zip(*(vars(part).values() for part in parts))
    return Stitched(*map(np.concatenate, columns))
