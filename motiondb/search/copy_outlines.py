"""Where a copy may be: a filter that misses none, over small outlines of all captures.

Notation: k_1 ... k_n the key frames of a query (n = ``KEY_FRAMES``), q_k its pose there, x_t the
poses of a take, both vectors of 63 numbers. A copy at offset o satisfies

    sum over k of |q_k - x_{o + k}|^2 < most,                                           (1)

so that for one key at least |q_k - x_{o + k}|^2 < most / n. The outline of a pose has 12 numbers:
for each arm and each leg the sum of three joints divided by sqrt(3), which is an orthogonal
projection, so that distances of outlines are never larger than those of poses. The frames of all
takes are put into boxes, and these into larger boxes (a packed R-tree); around every key only the
boxes are opened that a frame with |q_k - x|^2 < s_k most / n can be in. There, (1) is tested on the
outlines. What is left is compared by whole poses (:mod:`motiondb.search.copies`).

The shares s_k >= 0, of which the sum is n, may be chosen: if no key is as near, (1) fails. They are
large where few frames are, c_k^(-5/2) with c_k the number of some evenly spread frames near the
key, so that almost nothing is opened around a key that stands as all do.

The work for a capture grows with the number of frames that are as near to one of its keys as a copy
would be, and not with all frames. Outlines are kept as integers of ``UNIT``; the bounds are wider
by the rounding.

Source: Guttman, R-trees: a dynamic index structure for spatial searching, 1984.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.workers import runs

Int16Array = NDArray[np.int16]
Int32Array = NDArray[np.int32]

UNIT = 0.0002  # Metres of a number of an outline: 16 bits reach 6.5 m
LIMBS = (
    ("l_elbow", "l_wrist", "l_shoulder"),
    ("r_elbow", "r_wrist", "r_shoulder"),
    ("l_knee", "l_ankle", "l_toe"),
    ("r_knee", "r_ankle", "r_toe"),
)
N_AXES = 3 * len(LIMBS)  # Numbers of an outline
_JOINTS = np.array([[body.INDEX[name] for name in limb] for limb in LIMBS])
_ROUNDING = 2.0 * UNIT * np.sqrt(N_AXES)  # By which rounding may change a distance, metres
RUN = 2  # Frames in a smallest box; affects only the time
FAN = 8  # Boxes in a box; affects only the time
_WIDER = 1.0 + 1e-5  # By which single precision and sums may be wrong
_SAMPLE = 256  # Frames by which it is guessed how many are near a key; affects only the time


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of takes, one after another."""

    limbs: Int16Array  # (frames, 12): outline of every frame, in ``UNIT``
    bounds: IntArray  # (takes + 1,): where each take begins and ends in ``limbs``
    first: int = 0  # Number of the first frame, among those of more takes


def outline(poses: Float32Array) -> Int16Array:
    """The outline of every frame: array (frames, 12), from `poses` (frames, 63), metres."""
    joints = poses.reshape(len(poses), len(body.JOINTS), 3)
    summed = joints[:, _JOINTS].sum(axis=2) / np.sqrt(_JOINTS.shape[1])
    rounded = np.rint(summed.reshape(len(poses), N_AXES) / UNIT)
    return np.clip(rounded, -32767, 32767).astype(np.int16)


def mirror_outline(limbs: Int16Array) -> Int16Array:
    """The outline of the mirror image: array (..., 12)."""
    swapped = limbs.reshape(*limbs.shape[:-1], len(LIMBS), 3)[..., [1, 0, 3, 2], :]
    return (swapped * np.array([-1, 1, 1], dtype=np.int16)).reshape(limbs.shape)


def join_outlines(parts: Sequence[Int16Array]) -> Outlines:
    """Outlines of several takes; `parts` each (frames, 12)."""
    bounds = np.concatenate([[0], np.cumsum([len(p) for p in parts])]).astype(np.int64)
    none = np.zeros((0, N_AXES), dtype=np.int16)
    return Outlines(np.concatenate(parts) if len(parts) else none, bounds)


@dataclass(frozen=True, eq=False)
class Boxes:
    """Frames of outlines in boxes, boxes in larger boxes, up to a few.

    The boxes of level 0 hold ``RUN`` frames that follow one another. A box of another level holds
    ``FAN`` boxes of the level below that are near one another.
    """

    outlines: Outlines
    order: Int32Array  # (boxes of level 0,): their numbers in time, as they are sorted in space
    low: Int16Array
    """(boxes of boxes, 12 * FAN): smallest numbers of the outlines in the boxes of each, axis after
    axis, level after level."""
    high: Int16Array  # The same with the largest
    levels: IntArray  # (levels + 1,): where each level begins in ``low`` and ``high``


def make_boxes(outlines: Outlines, *, in_space: bool = True) -> Boxes:
    """Put the frames of outlines into boxes.

    `in_space`: Whether boxes of a box are near in space, which takes longer to make and less to
    search; otherwise they follow one another in time.
    """
    limbs = outlines.limbs
    if not len(limbs):
        none = np.zeros((0, N_AXES * FAN), dtype=np.int16)
        return Boxes(outlines, np.zeros(0, np.int32), none, none, np.zeros(2, np.int64))
    low, high = _around(limbs, limbs, RUN)
    order = np.arange(len(low), dtype=np.int32)
    if in_space:
        from scipy.spatial import cKDTree

        order = cKDTree(low.astype(np.float64) + high, leafsize=FAN).indices.astype(np.int32)
        low, high = low[order], high[order]
    lows, highs = [low], [high]
    while len(lows[-1]) > FAN:
        low, high = _around(lows[-1], highs[-1], FAN)
        lows.append(low)
        highs.append(high)
    lows, highs = ([_by_axis(one) for one in rows] for rows in (lows, highs))
    levels = np.concatenate([[0], np.cumsum([len(one) for one in lows])]).astype(np.int64)
    return Boxes(outlines, order, np.concatenate(lows), np.concatenate(highs), levels)


def _by_axis(rows: Int16Array) -> Int16Array:
    """Rows (boxes, 12) of every ``FAN`` boxes, axis after axis; the last box fills up."""
    filled = np.pad(rows, ((0, -len(rows) % FAN), (0, 0)), mode="edge")
    return filled.reshape(-1, FAN, N_AXES).transpose(0, 2, 1).reshape(-1, N_AXES * FAN)


@njit(cache=True, nogil=True)
def _around(low: Int16Array, high: Int16Array, size: int) -> tuple[Int16Array, Int16Array]:
    """Smallest and largest numbers of every ``size`` rows: two arrays (boxes, 12)."""
    n_boxes = -(-len(low) // size)
    lows, highs = low[: n_boxes * size : size].copy(), high[: n_boxes * size : size].copy()
    for row in range(len(low)):
        box = row // size
        for axis in range(low.shape[1]):
            lows[box, axis] = min(lows[box, axis], low[row, axis])
            highs[box, axis] = max(highs[box, axis], high[row, axis])
    return lows, highs


@dataclass(frozen=True, eq=False)
class Keys:
    """The key frames of some queries."""

    queries: IntArray  # (queries,): their numbers
    frames: IntArray  # (queries, keys): numbers of the key frames within the query
    limbs: Int16Array  # (queries, keys, 12): their outlines
    n_frames: IntArray  # (queries,): frames of each query
    reaches: FloatArray  # (queries,): root mean square distance of (1), metres

    def parts(self, n_parts: int) -> Iterator[Keys]:
        """The queries in at most so many parts of nearly equal length, none of them empty."""
        for part in runs(range(len(self.queries)), n_parts):
            which = slice(part[0], part[-1] + 1)
            yield Keys(*(array[which] for array in vars(self).values()))


def likely_places(piece: tuple[Boxes, Keys], slack: int) -> IntArray:
    """Places where the outlines satisfy (1): array (places, 2), query and number of the frame.

    A query may end up to ``slack`` frames behind its take. The places are in order of query and
    frame, each once.

    `piece`: Boxes, and queries.
    """
    boxes, keys = piece
    far = len(body.JOINTS) ** 0.5 * keys.reaches + _ROUNDING  # sqrt(most / n)
    counts, starts = _search_all(
        boxes.outlines.limbs,
        boxes.outlines.bounds,
        boxes.order,
        boxes.low,
        boxes.high,
        boxes.levels,
        keys.limbs.astype(np.int32),
        keys.frames,
        (far / UNIT) ** 2,
        keys.n_frames - slack,
    )
    return np.column_stack([np.repeat(keys.queries, counts), boxes.outlines.first + starts])


@njit(cache=True, nogil=True)
def _search_all(  # noqa: PLR0913  as below, query by query
    limbs: Int16Array,
    bounds: IntArray,
    order: Int32Array,
    low: Int16Array,
    high: Int16Array,
    levels: IntArray,
    keys: Int32Array,
    frames: IntArray,
    nearest: FloatArray,
    lengths: IntArray,
) -> tuple[IntArray, IntArray]:
    """Number of starts of every query, and the starts in order, query after query.

    Shapes: `keys` (queries, keys, 12); `frames` (queries, keys); `nearest`, `lengths` (queries,).
    """
    counts, parts = np.zeros(len(keys), np.int64), [np.zeros(0, np.int64)]
    for n in range(len(keys)):
        starts = _search(
            limbs, bounds, order, low, high, levels, keys[n], frames[n], nearest[n], lengths[n]
        )
        counts[n] = len(starts)
        if len(starts):
            parts.append(np.sort(starts))
    ends = np.cumsum(np.array([len(part) for part in parts]))
    every = np.empty(ends[-1], np.int64)
    for n in range(len(parts)):
        every[ends[n] - len(parts[n]) : ends[n]] = parts[n]
    return counts, every


@njit(cache=True, nogil=True)
def _search(  # noqa: PLR0913  one compiled search, box by box
    limbs: Int16Array,
    bounds: IntArray,
    order: Int32Array,
    low: Int16Array,
    high: Int16Array,
    levels: IntArray,
    keys: Int32Array,
    frames: IntArray,
    one: float,
    length: int,
) -> IntArray:
    """Starts of a query, each once: frames (places,) of all outlines.

    Shapes: `keys` (keys, 12); `frames` (keys,).

    `one`: Squared distance of the nearest key; the sum over all is at most as many times this.

    `length`: Frames of the query that must lie in the take.
    """
    found = [np.int64(0) for _ in range(0)]
    stack = np.empty((FAN * len(levels) + FAN, 2), np.int64)
    near = _shares(limbs, keys, one)
    gaps = np.empty(FAN * keys.shape[1], np.float32)
    for k in range(len(frames)):
        key, n_open = np.repeat(keys[k].astype(np.float32), FAN), 1
        stack[0] = len(levels) - 2, 0
        while n_open:
            n_open -= 1
            level, boxes = stack[n_open]
            _far(low[levels[level] + boxes], high[levels[level] + boxes], key, gaps)
            for inner in range(FAN):
                box = FAN * boxes + inner
                if gaps[inner] >= near[k] * _WIDER:
                    continue
                if level:
                    if box < levels[level] - levels[level - 1]:
                        stack[n_open] = level - 1, box
                        n_open += 1
                    continue
                first = int(order[box]) * RUN if box < len(order) else len(limbs)
                for frame in range(first, min(first + RUN, len(limbs))):
                    start = frame - frames[k]
                    if start < 0 or _distance(limbs, frame, keys, k, near[k]) >= near[k]:
                        continue
                    take = np.searchsorted(bounds, start, side="right") - 1
                    fits = start + length <= bounds[take + 1]
                    if fits and _fits(limbs, start, keys, frames, k, near, one):
                        found.append(np.int64(start))
    return np.array(found, dtype=np.int64)


@njit(cache=True)
def _far(low: Int16Array, high: Int16Array, key: Float32Array, gaps: Float32Array) -> None:
    """Squared distances of a key from ``FAN`` boxes, which become the first of the gaps.

    Shapes: all (12 * FAN,): axis after axis, the key ``FAN`` times.
    """
    for n in range(len(low)):  # a loop that is compiled for vectors
        gap = max(np.float32(low[n]) - key[n], key[n] - np.float32(high[n]), np.float32(0.0))
        gaps[n] = gap * gap
    for n in range(FAN, len(low)):
        gaps[n % FAN] += gaps[n]


@njit(cache=True)
def _shares(limbs: Int16Array, keys: Int32Array, one: float) -> FloatArray:
    """Squared distance (keys,) within which frames are looked at: in the mean ``one``."""
    near, step = np.zeros(len(keys)), max(1, len(limbs) // _SAMPLE)
    for k in range(len(keys)):
        n_near = 0.01
        for frame in range(0, len(limbs), step):
            far = _distance(limbs, frame, keys, k, np.inf) / (2.0 * one)
            n_near += 1.0 / (1.0 + far * far)
        near[k] = n_near**-2.5
    return near * (one * len(keys) * _WIDER / near.sum())


@njit(cache=True)
def _distance(limbs: Int16Array, frame: int, keys: Int32Array, k: int, most: float) -> float:
    """Squared distance of a frame and a key; not less than ``most`` if it is cut short."""
    total = 0.0
    for axis in range(keys.shape[1]):
        gap = float(np.int32(limbs[frame, axis]) - keys[k, axis])
        total += gap * gap
        if total >= most:
            return total
    return total


@njit(cache=True)
def _fits(
    limbs: Int16Array,
    start: int,
    keys: Int32Array,
    frames: IntArray,
    k: int,
    near: FloatArray,
    one: float,
) -> bool:
    """Whether all keys together are near, and no key before ``k`` alone was near enough."""
    total, every = 0.0, one * len(frames)
    for other in range(len(frames)):
        distance = _distance(limbs, start + frames[other], keys, other, every)
        if other < k and distance < near[other]:
            return False
        total += distance
        if total >= every:
            return False
    return True
