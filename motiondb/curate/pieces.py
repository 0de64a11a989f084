"""Captures cut into intervals that can be trained on, and windows by which these are compared.

Interval: a run of frames of features (15 a second) of one capture. It begins and ends where a
segment does, lasts ``shortest`` to ``longest``, and holds no frame that is left out. Window: one
second of an interval, as five poses with their velocities, in the body's frame of reference
(:mod:`motiondb.body.features`), on the main axes of all windows. The distance of two windows is the
root mean square over the 63 numbers of a pose, so that it is metres of the standard body, to which
velocities add.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body import body
from motiondb.body.features import FEATURE_FPS, N_FEATURES
from motiondb.quality.assess import KEPT_WITH
from motiondb.records import NEEDS, BoolArray, Float32Array, FloatArray, IntArray, Quality

WINDOW = round(FEATURE_FPS)  # Frames of features in a window: a second
POSES = (0, 3, 7, 10, 14)  # Frames of a window that are compared
N_AXES = 48  # Main axes of windows; on CMU they hold .97 of the variance
_BLOCK = 4096  # Windows at a time; bounds memory
_POSE = 63  # Numbers of a pose without velocities


@dataclass(frozen=True)
class Interval:
    """A part of a capture, in frames of features."""

    capture: int
    start: int
    end: int

    @property
    def seconds(self) -> float:
        """Its length."""
        return (self.end - self.start) / FEATURE_FPS


def cut(
    capture: int, borders: Sequence[int], kept: BoolArray, shortest: float, longest: float
) -> tuple[list[Interval], BoolArray]:
    """Intervals of a capture, each as short as borders allow; which frames were too short for one.

    Shapes: `kept` (frames,): frames that are not left out.

    A part without a border for ``longest`` is cut there.

    >>> kept = np.array([True] * 60 + [False] * 15 + [True] * 20)
    >>> found, short = cut(7, [0, 20, 40, 95], kept, 2.0, 10.0)
    >>> [(each.start, each.end) for each in found], int(short.sum())
    ([(0, 60)], 20)
    """
    least, most = round(shortest * FEATURE_FPS), round(longest * FEATURE_FPS)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], kept.astype(np.int8), [0]])))
    out: list[Interval] = []
    short = kept.copy()
    for a, b in edges.reshape(-1, 2).tolist():
        start, first = a, len(out)
        while b - start >= least:
            fit = [x for x in borders if start + least <= x <= min(start + most, b - least)]
            end = fit[0] if fit else (b if b - start <= most else start + most)
            if 0 < b - end < least:  # the rest would be too short for an interval of its own
                end = b if b - start <= most else b - least
            out.append(Interval(capture, start, end))
            start = end
        for each in out[first:]:
            short[each.start : each.end] = False
    return out, short


NO_POSES = np.zeros((0, len(POSES) * N_FEATURES), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Windows:
    """The seconds of intervals, one after another."""

    owner: IntArray  # (windows,): number of the interval
    first: IntArray  # (windows,): first frame of features in the capture
    seconds: FloatArray  # (windows,): time that each stands for; they sum to that of the intervals


def windows_of(intervals: Sequence[Interval]) -> Windows:
    """Windows spread evenly over each interval, as many as it has seconds."""
    owner, first, seconds = [], [], []
    for number, each in enumerate(intervals):
        count = max(1, round(each.seconds))
        last = max(each.start, each.end - WINDOW)
        owner += [number] * count
        first += np.linspace(each.start, last, count).round().astype(int).tolist()
        seconds += [each.seconds / count] * count
    return Windows(
        np.array(owner, dtype=np.int64), np.array(first, dtype=np.int64), np.array(seconds)
    )


def poses(features: Float32Array, first: IntArray) -> Float32Array:
    """Features of the windows of a capture side by side: array (windows, values), float32.

    Shapes: `features` (frames, 130); `first` (windows,), where the windows begin.
    """
    frames = np.minimum(first[:, None] + np.array(POSES), len(features) - 1)
    return features[frames].reshape(len(first), len(POSES) * N_FEATURES)


def vectors(every: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Vectors of windows on their main axes, and of their mirror images: arrays (windows, axes).

    `every` (windows, values): those of :func:`poses`, which are centred in place.
    """
    mean = every.mean(axis=0, dtype=np.float64)
    every -= mean.astype(np.float32)
    moment = np.zeros((every.shape[1], every.shape[1]))
    for low in range(0, len(every), _BLOCK):
        block = every[low : low + _BLOCK].astype(np.float64)
        moment += block.T @ block
    axes = np.linalg.eigh(moment)[1][:, ::-1][:, :N_AXES].T
    other = mirrored(axes.reshape(-1, N_FEATURES)).reshape(axes.shape)
    scale = 1.0 / np.sqrt(len(POSES) * _POSE)
    found, image = (every @ (scale * each).astype(np.float32).T for each in (axes, other))
    return found, image + (scale * (other - axes) @ mean).astype(np.float32)


def mirrored(features: FloatArray) -> FloatArray:
    """Features (frames, 130) of the mirror image; of an axis, the axis on which images lie so."""
    out = features.copy()
    for part in (slice(0, _POSE), slice(_POSE, 2 * _POSE)):
        joints = features[:, part].reshape(len(features), -1, 3)[:, body.MIRROR]
        out[:, part] = (joints * (-1.0, 1.0, 1.0)).reshape(len(features), -1)
    out[:, [-4, -1]] *= -1.0  # to the side, and turning
    return out


def rests(features: Float32Array) -> list[int]:
    """Frames in which the body moves least within half a second: borders where nothing is learned.

    Shapes: `features` (frames, 130).
    """
    if len(features) < 2:
        return []
    speed = np.linalg.norm(np.gradient(features[:, :_POSE], axis=0), axis=1)
    half = WINDOW // 4
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(speed, half, constant_values=np.inf), 2 * half + 1
    )
    return [int(n) for n in np.flatnonzero(speed <= around.min(axis=1))]


def left_out(quality: Quality, frames: int, least: float, with_needs: bool) -> list[str]:
    """Why each frame of features is left out for what it lacks; "" where it is not.

    `least`: Smallest number of a second that is kept. `with_needs`: Whether motion is kept that
    needs something that was not captured.
    """
    why = [""] * frames

    def say(start: float, end: float, reason: str) -> None:
        low, high = math.floor(start * FEATURE_FPS), math.ceil(end * FEATURE_FPS)
        for frame in range(max(0, low), min(frames, high)):
            why[frame] = why[frame] or reason

    for second in np.flatnonzero(quality.seconds < least).tolist():
        there = [f for f in quality.findings if f.start < second + 1 and f.end > second]
        kinds = sorted({f.kind for f in there if f.family != NEEDS and f.kind in KEPT_WITH})
        said = ", ".join(kinds) or f"quality {quality.seconds[second]:.2f}"
        say(second, second + 1, f"fault: {said}")
    for each in quality.findings:
        if each.family == NEEDS and not with_needs:
            say(each.start, each.end, f"needs something: {each.kind}")
    return why


def runs_of(reasons: Sequence[str]) -> list[tuple[int, int, str]]:
    """Runs of equal reasons: start, end, reason.

    >>> runs_of(["", "a", "a", "b"])
    [(0, 1, ''), (1, 3, 'a'), (3, 4, 'b')]
    """
    out: list[tuple[int, int, str]] = []
    for frame, reason in enumerate(reasons):
        if out and out[-1][2] == reason:
            out[-1] = (out[-1][0], frame + 1, reason)
        else:
            out.append((frame, frame + 1, reason))
    return out
