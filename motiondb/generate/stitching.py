"""Real segments that follow the trajectory: choice by dynamic programming, seams blended.

Notation: position k of the symbol sequence has candidates i, real segments of that symbol, with

    target cost  t_k(i)     how far the segment lies from the trajectory's part (and from the words)
    join cost    j(i, i')   |continuation of i - entry of i'|^2, between poses and velocities

where the continuation of i is what its own capture does next, so that a segment and its true
successor join at no cost. Viterbi finds the sequence of least total cost exactly. At a seam both
clips run on for some frames and are cross-faded by a cubic; path values are blended linearly,
rotations along the shortest arc.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.pose import rotation
from motiondb.records import FloatArray, IntArray

BLEND_FRAMES = 10


@dataclass(frozen=True, eq=False)
class Candidates:
    """Real segments for one position of the sequence.

    captures, starts, ends : arrays (n,), capture number and frames at 30 a second.
    entries, continuations : arrays (n, values), pose and velocity where the segment begins, and
        where its capture goes on after its end.
    targets : array (n,), target costs.
    """

    captures: IntArray
    starts: IntArray
    ends: IntArray
    entries: FloatArray
    continuations: FloatArray
    targets: FloatArray


def choose(candidates: Sequence[Candidates], join_weight: float = 1.0) -> list[int]:
    """One candidate per position, least sum of target and join costs (ties: the first)."""
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
    """j(i, i') for all pairs: array (n before, n after)."""
    a, b = before.continuations, after.entries
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    follows = (before.captures[:, None] == after.captures) & (before.ends[:, None] == after.starts)
    return np.where(follows, 0.0, np.maximum(squares, 0.0) + 1e-3)


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of one capture: frames [start, end) of its path values and local rotations."""

    capture: int
    start: int
    end: int


@dataclass(frozen=True, eq=False)
class Stitched:
    """The result: path (frames, 4), rotations (frames, 21, 4), and where each frame came from.

    captures, frames : arrays (frames,), the source that weighs most; shares : its weight, 1 away
    from seams.
    """

    path: FloatArray
    rotations: FloatArray
    captures: IntArray
    frames: IntArray
    shares: FloatArray


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
    """Put pieces one after another with cross-faded seams.

    Parameters
    ----------
    pieces : as chosen; consecutive ones of one capture are played through without a seam.
    sources : capture -> (path values (frames, 4), heading-relative rotations (frames, 21, 4)).
    """
    merged = merge_pieces(pieces)
    path, turned = _read(merged[0], sources, 0, 0)
    captures, frames, shares = _provenance(merged[0], len(path), 0)
    for before, after in pairwise(merged):
        half = min(
            BLEND_FRAMES // 2, (before.end - before.start) // 2, (after.end - after.start) // 2
        )
        old_path, old_turned = _read(
            Piece(before.capture, before.end - half, before.end), sources, 0, half
        )
        new_path, new_turned = _read(after, sources, half, 0)
        n = 2 * half
        share = (np.arange(n) + 0.5) / max(n, 1)
        share = share * share * (3.0 - 2.0 * share)
        mixed_path = old_path * (1.0 - share[:, None]) + new_path[:n] * share[:, None]
        mixed = rotation.slerp(old_turned, new_turned[:n], np.repeat(share[:, None], 21, axis=1))
        keep = len(path) - half
        path = np.concatenate([path[:keep], mixed_path, new_path[n:]])
        turned = np.concatenate([turned[:keep], mixed, new_turned[n:]])
        c, f, s = _provenance(after, len(new_path), half)
        new_wins = share > 0.5
        s[:n] = np.where(new_wins, share, s[:n])
        old_frames = np.arange(before.end - half, before.end + half)
        c[:n] = np.where(new_wins, c[:n], before.capture)
        limit = len(sources[before.capture][0]) - 1
        f[:n] = np.where(new_wins, f[:n], np.clip(old_frames, 0, limit))
        s[:n] = np.where(new_wins, share, 1.0 - share)
        captures = np.concatenate([captures[:keep], c])
        frames = np.concatenate([frames[:keep], f])
        shares = np.concatenate([shares[:keep], s])
    return Stitched(path, turned, captures, frames, shares)


def _read(
    piece: Piece, sources: dict[int, tuple[FloatArray, FloatArray]], before: int, after: int
) -> tuple[FloatArray, FloatArray]:
    """A piece with frames added before and after; the capture's ends are held."""
    path, turned = sources[piece.capture]
    which = np.arange(piece.start - before, piece.end + after)
    inside = np.clip(which, 0, len(path) - 1)
    values = path[inside].copy()
    values[which != inside, 1:] = 0.0
    return values, turned[inside]


def _provenance(piece: Piece, n_frames: int, before: int) -> tuple[IntArray, IntArray, FloatArray]:
    first = piece.start - before
    frames = np.maximum(np.arange(first, first + n_frames), 0)
    return np.full(n_frames, piece.capture), frames, np.ones(n_frames)
