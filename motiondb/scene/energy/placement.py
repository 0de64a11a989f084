"""Strings of clips on the ground: where and when each begins, by products of ground transforms.

A clip takes its player from its entry to its exit by a ground transform S = (x, z, theta). With the
origin G and the delay t, clip k of a string c_1 .. c_n begins at

    placed[k] = G S_c1 .. S_c(k-1),       begin[k] = t + n_c1 + .. + n_c(k-1)  frames.

Exchanging clip k leaves everything up to placed[k] unchanged and moves everything after it by one
rigid motion, D = placed'[k + 1] placed[k + 1]^-1, and one number of frames. Multiplying the rest of
the string again from placed[k] gives the same motion at the same cost, and does not accumulate
rounding errors. Cosines and sines are carried along in the products, so that no trigonometry is
needed.

The axes, and compose() over whole arrays, are those of :mod:`motiondb.scene.clips.clip_cutting`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motiondb.grammar.kernels import inlined, kernel
from motiondb.records import FloatArray

if TYPE_CHECKING:
    from motiondb.scene.clips.clips import ClipLibrary


CLIP = np.dtype(
    [
        (name, np.int64)
        for name in ("n_frames", "event", "path_start", "seam", "first", "last", "most")
    ]
    + [(name, np.float64) for name in ("x", "z", "theta", "cos", "sin", "length")]
)
"""Fields of a clip for compiled code: its frames, the frame of its event (or its middle), the first
row of its path, its seam class, the clips [first, last) of its action, the frames of the longest of
them, its step with cosine and sine, and the length of its path in metres."""


class ClipArrays(NamedTuple):
    """A library of clips for compiled code."""

    clips: NDArray[np.void]
    # (frames of all clips, 3), m and rad: x, z, theta in the frame of the clip's entry
    path: FloatArray
    way: FloatArray  # (frames of all clips,), m: distance travelled since the clip's entry
    # (classes, classes): mismatch of the exit of one class and the entry of another
    seams: FloatArray
    fastest: FloatArray  # (1,), m: largest distance from one frame to the next


def clip_arrays(library: ClipLibrary) -> ClipArrays:
    """Return the library for compiled code; call it once, scenes share the result."""
    clips = np.zeros(len(library.n_frames), CLIP)
    step = np.asarray(library.step, dtype=float)
    clips["n_frames"], clips["path_start"] = library.n_frames, library.path_start
    clips["event"] = np.where(
        library.event_frame >= 0, library.event_frame, (np.asarray(library.n_frames) - 1) // 2
    )
    clips["seam"] = library.seam_class
    clips["first"] = np.asarray(library.first)[library.terminal]
    clips["last"] = np.asarray(library.first)[np.asarray(library.terminal) + 1]
    clips["most"] = _longest(library)[library.terminal]
    clips["x"], clips["z"], clips["theta"] = step.T
    clips["cos"], clips["sin"] = np.cos(step[:, 2]), np.sin(step[:, 2])
    path = np.ascontiguousarray(library.path, dtype=float)
    way, fastest = np.zeros(len(path)), 1e-6
    for number, (start, n) in enumerate(zip(clips["path_start"], clips["n_frames"], strict=True)):
        ends = np.concatenate([path[start : start + n, :2], step[number : number + 1, :2]])
        steps = np.linalg.norm(np.diff(ends, axis=0), axis=1)
        metres, fastest = np.cumsum(steps), max(fastest, float(steps.max()))
        way[start + 1 : start + n], clips["length"][number] = metres[:-1], metres[-1]
    seams = np.ascontiguousarray(library.seam, dtype=float)
    return ClipArrays(clips, path, way, seams, np.array([fastest]))


def _longest(library: ClipLibrary) -> NDArray[np.int64]:
    """Return the frames of every terminal's longest clip: array (terminals,)."""
    longest = np.zeros(len(library.terminals), np.int64)
    np.maximum.at(longest, np.asarray(library.terminal), np.asarray(library.n_frames))
    return longest


@inlined
def put_origin(placed: FloatArray, x: float, z: float, theta: float) -> None:
    """Set where a string begins: ``placed`` (clips + 1, 5) holds x, z, theta, cos, sin."""
    placed[0, 0], placed[0, 1], placed[0, 2] = x, z, theta
    placed[0, 3], placed[0, 4] = math.cos(theta), math.sin(theta)


@kernel
def chain(
    placed: FloatArray,
    begin: NDArray[np.int64],
    entry: NDArray[np.int64],
    clips: NDArray[np.void],
    since: int,
    count: int,
) -> None:
    """Place the clips of a string after number ``since``, whose own place is kept.

    Parameters
    ----------
    placed : array (at least count + 1, 5)
        x, z, theta, cos, sin of every clip's beginning; changed in place.
    begin : array of int (at least count + 1,)
        First frames of the clips; after the last the string's end; changed in place.
    entry : array of int (at least count,)
        The clips.
    clips : array of :data:`CLIP`
        The library.
    since : int
        The clip whose place is known.
    count : int
        Number of clips.
    """
    x, z, theta = placed[since, 0], placed[since, 1], placed[since, 2]
    c, s, frame = placed[since, 3], placed[since, 4], begin[since]
    for k in range(since, count):
        clip = clips[entry[k]]
        x, z = x + clip.x * c + clip.z * s, z - clip.x * s + clip.z * c
        c, s = c * clip.cos - s * clip.sin, s * clip.cos + c * clip.sin
        theta += clip.theta
        frame += clip.n_frames
        placed[k + 1, 0], placed[k + 1, 1], placed[k + 1, 2] = x, z, theta
        placed[k + 1, 3], placed[k + 1, 4] = c, s
        begin[k + 1] = frame


@inlined
def clip_at(begin: NDArray[np.int64], count: int, frame: int) -> int:
    """Return the clip that plays at a frame: the first before the string, the last after it."""
    k = count - 1
    while k > 0 and begin[k] > frame:
        k -= 1
    return k


@inlined
def place_in_clip(
    placed: FloatArray, path: FloatArray, row: int, k: int
) -> tuple[float, float, float]:
    """Return x, z, theta at row ``row`` of the library's paths, a frame of clip ``k``."""
    c, s, x, z = placed[k, 3], placed[k, 4], path[row, 0], path[row, 1]
    return placed[k, 0] + x * c + z * s, placed[k, 1] - x * s + z * c, placed[k, 2] + path[row, 2]
