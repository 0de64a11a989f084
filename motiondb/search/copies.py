"""Copies of a motion: the same take in another file, a mirror image, a part of a longer take.

Notation: p_t the joint positions of frame t relative to the pelvis, in the frame of the heading, on
the standard body. The distance of a query of n frames to a take at offset o is

    distance(o) = sqrt(mean over frames and joints of |p_t - p'_{o + t}|^2), metres.

A few key frames of the query, spread evenly, are compared first. Where a copy may be, is found by
small outlines of the captures (:mod:`motiondb.search.copy_outlines`), which miss none. At the best
offsets, and up to half a frame around them, the distance is computed over all frames. The distance
of a copy is below ``NEAR`` metres and below a quarter of the motion's own variation, so that two
people who stand still are not copies of each other. ``docs/measured/duplicates.md`` measures how
many planted copies are found with these values.

A relation connects two captures of which one repeats the other. Groups are the connected components
of all relations.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np

from motiondb.body import body, features
from motiondb.records import DuplicateGroup, Float32Array, FloatArray, IntArray, Motion, Relation
from motiondb.search.copy_outlines import (
    N_AXES,
    Boxes,
    Int16Array,
    Keys,
    Outlines,
    join_outlines,
    likely_places,
    make_boxes,
    mirror_outline,
    outline,
)
from motiondb.workers import HERE, Workers, is_array, trusted

PosesOf = Callable[[int], Float32Array]

NEAR = 0.01  # Largest distance of a copy, metres
RELATIVE = 0.25  # Largest distance of a copy, as a share of the motion's spread about its mean pose
KEY_FRAMES = 12  # Frames of the query that are compared first
LEAST_FRAMES = 20  # Least length of a query, frames (2/3 s): shorter ones agree by chance
KEPT = 64  # Takes whose poses are kept while others are compared; bounds memory
AT_ONCE = 2**20  # Frames (10 hours) of takes in a group, unless one is longer; bounds memory
TOGETHER = 4  # Groups in memory at a time: each then goes to a quarter of the workers. By hand
MANY = 200  # Queries for which it is worth to sort boxes in space; affects only the time
SLACK = 2  # Largest difference in length of two files of one take, frames


@dataclass(frozen=True)
class Copy:
    """A query that occurs in a take."""

    query: int  # Number of the query
    take: int  # Number of the take
    kind: str  # "same", "cut" or "mirror"
    start: int  # First frame in the take
    end: int  # One past the last frame in the take
    distance: float


class Rows(Protocol):
    """Rows (rows, 12) of outlines."""

    def __getitem__(self, which: slice | IntArray, /) -> Int16Array:
        """Those between two numbers, or of an array of numbers."""


@dataclass(frozen=True, eq=False)
class Library:
    """Takes to look in and to look for."""

    sizes: IntArray  # (takes,): frames
    reaches: FloatArray  # (takes,): how far a copy may be at key frames (:func:`reach`), metres
    firsts: IntArray  # (takes,): where the rows of each begin in ``limbs``
    limbs: Rows  # Outlines of all frames, by which most are ruled out
    poses_of: PosesOf  # Poses of one take (frames, 63); called only for takes that may be copies


def copy_poses(motion: Motion) -> Float32Array:
    """Joint positions relative to the pelvis and the heading: array (frames, 63), metres."""
    return features.seen_from_pelvis(motion).reshape(motion.n_frames, -1).astype(np.float32)


def mirror_poses(poses: Float32Array) -> Float32Array:
    """Poses of the mirror image: array (frames, 63), metres, from `poses` (frames, 63)."""
    joints = poses.reshape(len(poses), -1, 3)[:, body.MIRROR]
    return (joints * np.array([-1.0, 1.0, 1.0], dtype=np.float32)).reshape(len(poses), -1)


def build_library(poses: Sequence[Float32Array]) -> Library:
    """A library of takes in memory; `poses` each (frames, 63)."""
    outlines = join_outlines([outline(p) for p in poses])
    sizes, firsts = np.diff(outlines.bounds), outlines.bounds[:-1]
    reaches = np.array([reach(p) for p in poses])
    return Library(sizes, reaches, firsts, outlines.limbs, poses.__getitem__)


def find_copies(
    library: Library,
    queries: Sequence[int],
    takes: Sequence[int] | None = None,
    workers: Workers = HERE,
) -> list[Copy]:
    """Takes that contain the queries, for each query the nearest first.

    Of two takes of equal length the one of larger number is reported as the copy.
    """
    sizes = library.sizes
    places = list(range(len(sizes)) if takes is None else takes)
    most = max((int(sizes[place]) + SLACK for place in places), default=0)
    fit = [q for q in queries if LEAST_FRAMES <= sizes[q] <= most]
    likely = _likely(library, places, _keys_of(library, np.array(fit, dtype=np.int64)), workers)
    bounds = np.concatenate([[0], np.cumsum(sizes[places])])
    number = np.searchsorted(bounds, likely[:, 1], side="right") - 1
    poses_of = lru_cache(maxsize=KEPT)(library.poses_of)
    copies: list[Copy] = []
    asked, firsts = np.unique(likely[:, 0], return_index=True)
    for n_asked, first, last in zip(asked.tolist(), firsts, [*firsts[1:], len(likely)]):
        query, mirrored = fit[n_asked // 2], n_asked % 2 == 1
        some = number[first:last]
        others = np.array([places[n] != query for n in some], dtype=bool)
        if not others.any():
            continue
        shape = mirror_poses(poses_of(query)) if mirrored else poses_of(query)
        starts = likely[first:last, 1] - bounds[some]
        hits = [
            (places[n], *best)
            for n in np.unique(some[others]).tolist()
            for best in _best(poses_of(places[n]), starts[some == n], shape)
        ]
        for take, offset, distance in sorted(hits, key=lambda hit: hit[2]):
            same_length = abs(int(sizes[take]) - len(shape)) <= SLACK
            if same_length and take > query:
                continue
            kind = "mirror" if mirrored else ("same" if same_length else "cut")
            end = min(offset + len(shape), int(sizes[take]))
            copies.append(Copy(query, take, kind, offset, end, distance))
    return copies


def _likely(library: Library, places: Sequence[int], keys: Keys, workers: Workers) -> IntArray:
    """Where copies may be, in order: array (places, 2), query and frame of the takes end to end."""
    groups = _groups(library, places)
    found, first = [np.zeros((0, 2), dtype=np.int64)], 0
    for some in (groups[n : n + TOGETHER] for n in range(0, len(groups), TOGETHER)):
        n_pieces = math.ceil(workers.n_pieces() / len(some))
        pieces = (
            (boxes, part)
            for boxes in _boxes_of(library, some, first, in_space=len(keys.queries) >= MANY)
            for part in keys.parts(n_pieces)
        )
        parts = trusted(workers, _are_places, likely_places, pieces, SLACK)
        found += [part for _, part in parts]
        first += sum(int(library.sizes[takes].sum()) for takes in some)
    likely = np.concatenate(found)
    return likely[np.lexsort((likely[:, 1], likely[:, 0]))]


def _are_places(found: IntArray, piece: tuple[Boxes, Keys], _: object) -> bool:
    """Whether places can be those of some queries in some boxes."""
    outlines, keys = piece[0].outlines, piece[1]
    frames = found[:, 1] - outlines.first
    return (
        is_array(found, (None, 2), "i")
        and bool(np.isin(found[:, 0], keys.queries).all())
        and bool(((frames >= 0) & (frames < len(outlines.limbs))).all())
    )


def _groups(library: Library, places: Sequence[int]) -> list[list[int]]:
    """Takes that are put into boxes together."""
    groups, n_held = list[list[int]](), 0
    for take in places:
        n_frames = int(library.sizes[take])
        if not groups or n_held + n_frames > AT_ONCE:
            groups.append([])
            n_held = 0
        groups[-1].append(take)
        n_held += n_frames
    return groups


def _boxes_of(
    library: Library, groups: Sequence[list[int]], first: int, in_space: bool
) -> Iterator[Boxes]:
    """Boxes of groups of takes, which stand end to end; `first`: number of their first frame."""
    for takes in groups:
        firsts, sizes = library.firsts[takes], library.sizes[takes]
        ends = firsts + sizes
        edges = [0, *(np.flatnonzero(firsts[1:] != ends[:-1]) + 1), len(takes)]
        parts = [library.limbs[firsts[a] : ends[b - 1]] for a, b in pairwise(edges)]
        bounds = np.concatenate([[0], np.cumsum(sizes)])
        yield make_boxes(Outlines(np.concatenate(parts), bounds, first), in_space=in_space)
        first += int(sizes.sum())


def _keys_of(library: Library, queries: IntArray) -> Keys:
    """The key frames of queries: of query n as number 2 n, of its mirror image as 2 n + 1."""
    frames = _keys(library.sizes[queries])
    limbs = library.limbs[library.firsts[queries][:, None] + frames]
    both = np.stack([limbs, mirror_outline(limbs)], axis=1).reshape(-1, KEY_FRAMES, N_AXES)
    twice = np.repeat(queries, 2)
    frames = np.repeat(frames, 2, axis=0)
    return Keys(np.arange(len(twice)), frames, both, library.sizes[twice], library.reaches[twice])


def _limit(poses: Float32Array) -> float:
    """Largest distance of a copy of poses, metres."""
    spread = float(np.sqrt(np.mean(np.sum((poses - poses.mean(axis=0)) ** 2, axis=1) / 21)))
    return min(NEAR, RELATIVE * spread)


def reach(poses: Float32Array) -> float:
    """Largest distance at the key frames alone, metres; `poses` (frames, 63).

    At up to half a frame beside the best offset, the key frames are further than the whole.
    """
    if len(poses) < LEAST_FRAMES:
        return 0.0
    half_a_frame = 0.5 * float(np.sqrt(np.mean(np.diff(poses, axis=0) ** 2) * 3))
    return 1.5 * _limit(poses) + half_a_frame


def _best(take: Float32Array, starts: IntArray, poses: Float32Array) -> Iterator[tuple[int, float]]:
    """Offset and distance of poses in a take at the best of some offsets, if they are a copy."""
    limit, keys = _limit(poses), _keys(len(poses))
    squares = np.zeros(len(starts), dtype=np.float32)
    for key in keys:
        squares += np.sum((take[starts + key] - poses[key]) ** 2, axis=1)
    near = starts[squares < reach(poses) ** 2 * KEY_FRAMES * len(body.JOINTS)]
    found = [(_distance(take, int(offset), poses), int(offset)) for offset in near]
    distance, offset = min(found, default=(limit, 0))
    if distance < limit:
        yield offset, distance


def _distance(take: Float32Array, offset: int, poses: Float32Array) -> float:
    """Distance of poses to a take at an offset, or up to half a frame before or after it.

    A part of a take seldom begins exactly at a frame, and half a frame of a fast movement exceeds
    the distance allowed for copies. Frames in between are interpolated at the best place,
    f = <q - p, n - p> / |n - p|^2 with n the frames before or after, kept within 0 and 1/2.
    """
    part = take[offset : offset + len(poses)]
    gap = poses[: len(part)] - part
    squares = [float(np.mean(gap**2))]
    for aside in (-1, 1):
        low, high = max(-aside - offset, 0), min(len(part), len(take) - offset - aside)
        step = take[offset + aside + low : offset + aside + high] - part[low:high]
        length = float(np.sum(step**2))
        f = float(np.clip(np.sum(gap[low:high] * step) / length, 0.0, 0.5)) if length else 0.0
        squares.append(float(np.mean((gap[low:high] - f * step) ** 2)))
    return float(np.sqrt(min(squares) * 3))


def _keys(n_frames: int | IntArray) -> IntArray:
    """Numbers of the key frames of queries of so many frames: array (..., keys)."""
    last = np.asarray(n_frames) - 1 - SLACK
    return np.linspace(0, last, KEY_FRAMES, axis=-1).round().astype(np.int64)


def group_duplicates(
    relations: Sequence[Relation], durations: Mapping[str, float]
) -> tuple[DuplicateGroup, ...]:
    """Connected components of relations, the largest first.

    The first capture of a group is the one to keep: the longest, and of equally long ones the one
    that was added first.

    >>> cut = Relation("b", "a", "cut", 1.0, 2.0, 0.0)
    >>> group_duplicates([cut], {"b": 1.0, "a": 5.0, "c": 5.0})[0].captures
    ('a', 'b')
    """
    parent: dict[str, str] = {}

    def root(name: str) -> str:
        parent.setdefault(name, name)
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    for relation in relations:
        parent[root(relation.capture)] = root(relation.other)
    order = {name: n for n, name in enumerate(durations)}
    members: dict[str, list[str]] = {}
    for name in sorted(parent, key=order.__getitem__):
        members.setdefault(root(name), []).append(name)
    groups = []
    for key, names in members.items():
        keep = max(names, key=lambda name: (round(durations[name], 1), -order[name]))
        inside = tuple(r for r in relations if root(r.capture) == key)
        groups.append(DuplicateGroup((keep, *(n for n in names if n != keep)), inside))
    return tuple(sorted(groups, key=lambda g: (-len(g.captures), order[g.captures[0]])))
