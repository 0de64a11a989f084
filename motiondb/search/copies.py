"""Copies of a motion: the same take in another file, a mirror image, a part of a longer take.

Notation: p_t the joint positions of frame t relative to the pelvis, in the frame of the heading, on
the standard body. The distance of a query of n frames to a take at offset o is

    distance(o) = sqrt(mean over frames and joints of |p_t - p'_{o + t}|^2), metres.

A few frames of the query, spread evenly, are compared with every frame of every take at once. At
the best offsets, and up to half a frame around them, the distance is computed over all frames. The
distance of a copy is below ``NEAR`` metres and below a quarter of the motion's own variation, so
that two people who stand still are not copies of each other. ``docs/measured/duplicates.md``
measures how many planted copies are found with these values.

A relation connects two captures of which one repeats the other. Groups are the connected components
of all relations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body import body, features, retarget, rotation
from motiondb.records import Float32Array, IntArray, Motion, Relation

NEAR = 0.01  # Largest distance of a copy, metres
RELATIVE = 0.25  # Largest distance of a copy, as a share of the motion's spread about its mean pose
KEY_FRAMES = 12  # Frames of the query that are compared first; affects only the time
FIRST_KEYS = (0, 5, 11)  # Key frames that are compared with every frame of every take
LEAST_FRAMES = 20  # Least length of a query, frames (2/3 s): shorter ones agree by chance
BLOCK = 32  # Queries compared with all takes in one matrix product; bounds memory
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


@dataclass(frozen=True, eq=False)
class Library:
    """Poses of takes, one after another."""

    # (frames, 63), float32: joint positions relative to the pelvis and the heading, metres
    poses: Float32Array
    bounds: IntArray  # (takes + 1,): where each take begins and ends in ``poses``


def copy_poses(motion: Motion) -> Float32Array:
    """Joint positions relative to the pelvis and the heading: array (frames, 63), metres."""
    positions, world = retarget.motion_positions(motion)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -features.headings(world))
    local = rotation.rotate(facing[:, None], positions - positions[:, :1])
    return local.reshape(len(local), -1).astype(np.float32)


def mirror_poses(poses: Float32Array) -> Float32Array:
    """Poses of the mirror image: array (frames, 63), metres, from `poses` (frames, 63)."""
    joints = poses.reshape(len(poses), -1, 3)[:, body.MIRROR]
    return (joints * np.array([-1.0, 1.0, 1.0], dtype=np.float32)).reshape(len(poses), -1)


def build_library(poses: Sequence[Float32Array]) -> Library:
    """Concatenate the poses of takes; `poses` each (frames, 63)."""
    bounds = np.concatenate([[0], np.cumsum([len(p) for p in poses])]).astype(np.int64)
    joined = np.concatenate(poses) if len(poses) else np.zeros((0, 63), dtype=np.float32)
    return Library(joined, bounds)


def find_copies(
    library: Library, queries: Sequence[int], takes: Sequence[int] | None = None
) -> list[Copy]:
    """Takes that contain the queries, for each query the nearest first.

    Of two takes of equal length the one of larger number is reported as the copy.
    """
    places = list(range(len(library.bounds) - 1) if takes is None else takes)
    held = library if takes is None else build_library([_take(library, p) for p in places])
    norms = np.einsum("td,td->t", held.poses, held.poses)
    long_enough = [q for q in queries if len(_take(library, q)) >= LEAST_FRAMES]
    copies: list[Copy] = []
    for block in range(0, len(long_enough), BLOCK):
        asked = [(q, mirrored) for q in long_enough[block : block + BLOCK] for mirrored in (0, 1)]
        shapes = [(mirror_poses if m else np.asarray)(_take(library, q)) for q, m in asked]
        first = np.concatenate([shape[_keys(shape)[list(FIRST_KEYS)]] for shape in shapes])
        products = (first @ held.poses.T).reshape(len(shapes), len(FIRST_KEYS), -1)
        for (query, mirrored), shape, product in zip(asked, shapes, products):
            for place, offset, distance in _find(held, norms, shape, product):
                take, length = places[place], int(held.bounds[place + 1] - held.bounds[place])
                same_length = abs(length - len(shape)) <= SLACK
                if take == query or (same_length and take > query):
                    continue
                kind = "mirror" if mirrored else ("same" if same_length else "cut")
                end = min(offset + len(shape), length)
                copies.append(Copy(query, take, kind, offset, end, distance))
    return copies


def _find(
    library: Library, norms: Float32Array, poses: Float32Array, products: Float32Array
) -> list[tuple[int, int, float]]:
    """(take, offset, distance) of every take that holds the poses, nearest first."""
    spread = float(np.sqrt(np.mean(np.sum((poses - poses.mean(axis=0)) ** 2, axis=1) / 21)))
    limit = min(NEAR, RELATIVE * spread)
    half_a_frame = 0.5 * float(np.sqrt(np.mean(np.diff(poses, axis=0) ** 2) * 3))
    best: dict[int, tuple[int, int, float]] = {}
    for offset in _likely_offsets(library, norms, poses, products, 1.5 * limit + half_a_frame):
        take = int(np.searchsorted(library.bounds, offset, side="right")) - 1
        if offset + len(poses) > library.bounds[take + 1] + SLACK:
            continue
        distance = _distance(_take(library, take), int(offset - library.bounds[take]), poses)
        if distance < limit and (take not in best or distance < best[take][2]):
            best[take] = (take, int(offset - library.bounds[take]), distance)
    return sorted(best.values(), key=lambda hit: hit[2])


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


def _likely_offsets(
    library: Library,
    norms: Float32Array,
    poses: Float32Array,
    products: Float32Array,
    limit: float,
) -> IntArray:
    """Rows of the library from which the key frames are nearer than a limit, metres.

    ``products`` is an array (first keys, rows), dot products of the first key frames with every
    row. The squared distances of the first key frames exceed the limit almost everywhere; the
    other key frames are compared only where they do not.
    """
    keys = _keys(poses)
    n = len(library.poses) - int(keys[-1])
    if n < 1:
        return np.zeros(0, dtype=np.int64)
    most = limit * limit * KEY_FRAMES * len(body.JOINTS)
    total = np.zeros(n, dtype=np.float32)
    for key, product in zip(keys[list(FIRST_KEYS)], products):
        total += norms[key : key + n] - 2.0 * product[key : key + n] + poses[key] @ poses[key]
    rows = np.flatnonzero(total < most + 1e-3)
    squares = np.zeros(len(rows), dtype=np.float32)
    for key in keys:
        squares += np.sum((library.poses[rows + key] - poses[key]) ** 2, axis=1)
    return rows[squares < most]


def _keys(poses: Float32Array) -> IntArray:
    return np.linspace(0, len(poses) - 1 - SLACK, KEY_FRAMES).round().astype(np.int64)


def _take(library: Library, number: int) -> Float32Array:
    return library.poses[library.bounds[number] : library.bounds[number + 1]]


@dataclass(frozen=True)
class DuplicateGroup:
    """Captures that repeat one another."""

    # Names: first the one to keep, then the others in the order in which they were added
    captures: tuple[str, ...]
    relations: tuple[Relation, ...]


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
