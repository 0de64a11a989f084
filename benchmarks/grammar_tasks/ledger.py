"""Description length of terminals, sentences and rules together, in bits.

More terminals describe the motion more exactly, but give longer strings and more rules. The ledger
counts both in bits and has three parts: *motion*, the frames given the terminals; *string*, the
sentences given the rules; *grammar*, the rules.

The motion is encoded with a root mean square error of delta metres in the distance of poses. Delta
is measured in the motion itself (``performance_noise``): it is the median distance from half a
second of motion to the most similar half second elsewhere. Differences between two performances of
one action are mostly below delta and cost few bits. Differences between actions are above it.

Poses x_t are given on principal axes. Gaussian axes of variances v_a are encoded with mean square
error delta^2 in

    R(v) = sum_a max(0, 1/2 log2(v_a / theta)),    theta such that sum_a min(theta, v_a) = delta^2

bits a sample, and in 0 bits where sum_a v_a <= delta^2. The code has two parts:

* The frames of the K medoids are encoded as poses; v is the variance of poses.
* The frames of the other segments of a terminal are encoded as residuals: the difference from the
  medoid, uniformly warped to the length of the segment. All terminals share one distribution of the
  residual variance over the axes. Each terminal has its own total variance c_k, the maximum
  likelihood estimate. This parameter costs 1/2 log2 of the number of samples that it is estimated
  from.

Motion is smooth, so neighbouring frames are not independent. With correlation rho from frame to
frame there are (1 - rho) / (1 + rho) independent samples a frame. Each segment also costs log2 of
the greatest length of a segment, for its own length.

One more terminal lowers the total if it saves more bits of residuals than its medoid, its symbol
and the longer rules cost. The total therefore has a minimum between K = 1 and one terminal a
segment; ``terminal_number`` searches for it.

Sources: J. Rissanen, "Modeling by shortest data description", Automatica 14 (1978), for one total
of all parts and the cost of a parameter; T. M. Cover and J. A. Thomas, "Elements of Information
Theory" (2006), theorem 10.3.3, for the rate of Gaussian axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.sentences.partition import Sentences
from motiondb.grammar.terminals.distances import Poses, make_poses
from motiondb.grammar.terminals.terminals import Terminals
from motiondb.records import Float32Array, FloatArray, IntArray, Motion

COARSEST, FINEST = 0.2, 0.02
"""Bounds of delta, as shares of the root mean square distance of poses from the mean pose. Above
the upper bound, different actions would be taken as equal; below the lower bound is the noise of
capture."""

_WINDOW, _COMPARED = 15, 3
"""Frames of a window (half a second at 30 frames a second), and the step in frames: from window to
window, and between the frames of a window that are compared."""

_MOST_WINDOWS = 1500
"""Approximate number of evenly spaced windows whose nearest neighbour is searched; never twice as
many. It limits the time."""


@dataclass(frozen=True)
class Ledger:
    """Description length in its three parts, in bits."""

    motion: float  # Bits of the frames given the terminals
    string: float  # Bits of the sentences given the rules
    grammar: float  # Bits of the rules

    @property
    def total(self) -> float:
        """Sum of the three parts, in bits."""
        return self.motion + self.string + self.grammar


def motion_bits(
    values: Float32Array | FloatArray,
    starts: IntArray,
    ends: IntArray,
    labels: IntArray,
    medoids: IntArray,
    precision: float,
) -> float:
    """Return the bits of all frames given the string of terminals.

    Shapes: `values` (frames of all takes, axes); `starts`, `ends`, `labels` (segments,); `medoids`
    (K,).
    """
    if not precision > 0.0:
        raise GrammarError(
            f"precision: expected metres above 0, found {precision}."
            " Measure it (performance_noise), or give some, such as 0.02."
        )
    poses = np.asarray(values, dtype=np.float64)
    lengths = ends - starts
    bits = len(lengths) * float(np.log2(max(2, lengths.max())))
    samples = samples_a_frame(poses)
    if samples == 0.0:
        return bits
    squares = np.add.reduceat(_residuals(poses, starts, ends, labels, medoids) ** 2, starts)
    copied = np.ones(len(starts), dtype=np.bool_)
    copied[medoids] = False
    bits += samples * lengths[medoids].sum() * rate(poses.var(axis=0), precision)
    shape = squares[copied].sum(axis=0)
    shape /= shape.sum() or 1.0
    for label in np.unique(labels[copied]):
        members = copied & (labels == label)
        n_frames = int(lengths[members].sum())
        size = squares[members].sum() / n_frames
        bits += samples * n_frames * rate(size * shape, precision)
        bits += 0.5 * float(np.log2(max(1.0, samples * n_frames * len(shape))))
    return bits


def rate(variances: FloatArray, precision: float) -> float:
    """Return R(v), the bits of a sample of Gaussian axes at a given root mean square error.

    Shapes: `variances` (axes,).

    >>> rate(np.array([16.0, 0.0]), 1.0), rate(np.array([0.5, 0.25]), 1.0)
    (2.0, 0.0)
    """
    falling = np.sort(variances)[::-1]
    left = precision**2 - (falling.sum() - np.cumsum(falling))
    # If axes 0..m are encoded, each gets an equal share theta of the part of delta^2 that the other
    # axes do not use. The right m is the one where exactly the encoded axes have v > theta.
    levels = left / np.arange(1, len(falling) + 1)
    valid = np.flatnonzero((levels > 0.0) & (levels < falling))
    if not len(valid):
        return 0.0
    level = levels[valid[-1]]
    return float(0.5 * np.log2(np.maximum(falling / level, 1.0)).sum())


def performance_noise(values: Float32Array | FloatArray, bounds: IntArray) -> float:
    """Return delta, the median distance of half seconds of motion to their nearest neighbours.

    The nearest neighbour of a window is searched among the windows that begin at least a second
    away or in another take. The distance is the root mean square over the compared frames.

    Shapes: `values` (frames of all takes, axes); `bounds` (takes + 1,).
    """
    poses = np.asarray(values, dtype=np.float64)
    spread = float(np.sqrt(poses.var(axis=0).sum()))
    begins = np.concatenate([np.arange(a, b - _WINDOW + 1, _COMPARED) for a, b in pairwise(bounds)])
    takes = np.searchsorted(bounds, begins, side="right")
    rows = begins[:, None] + np.arange(0, _WINDOW, _COMPARED)
    windows = poses[rows].reshape(len(begins), rows.shape[1] * poses.shape[1])
    norms = (windows**2).sum(axis=1)
    nearest = []
    for asked in range(0, len(begins), max(1, len(begins) // _MOST_WINDOWS)):
        squares = norms + norms[asked] - 2.0 * windows @ windows[asked]
        near = np.abs(begins - begins[asked]) < 2 * _WINDOW
        squares = squares[~(near & (takes == takes[asked]))]
        if len(squares):
            nearest.append(max(0.0, squares.min()) / rows.shape[1])
    noise = float(np.sqrt(np.median(nearest))) if nearest else COARSEST * spread
    return min(max(noise, FINEST * spread), COARSEST * spread)


def samples_a_frame(poses: FloatArray) -> float:
    """Return the number of independent samples a frame, (1 - rho) / (1 + rho).

    Shapes: `poses` (frames, axes).

    >>> samples_a_frame(np.array([[0.0], [1.0]] * 8))
    1.0
    """
    spread = float(poses.var(axis=0).sum())
    if spread == 0.0 or len(poses) < 2:
        return 0.0
    steps = float((np.diff(poses, axis=0) ** 2).sum(axis=1).mean())
    rho = max(0.0, 1.0 - steps / (2.0 * spread))
    return (1.0 - rho) / (1.0 + rho)


def _residuals(
    poses: FloatArray, starts: IntArray, ends: IntArray, labels: IntArray, medoids: IntArray
) -> FloatArray:
    """Return the frames less their warped medoids (frames, axes); 0 in the medoids themselves."""
    residuals = np.zeros_like(poses)
    for start, end, label in zip(starts, ends, labels, strict=True):
        first, last = starts[medoids[label]], ends[medoids[label]]
        matched = first + np.arange(end - start) * (last - first) // (end - start)
        residuals[start:end] = poses[start:end] - poses[matched]
    return residuals


def make_ledger(
    takes: Sequence[Motion],
    terminals: Terminals,
    sentences: Sentences,
    precision: float | None = None,
) -> Ledger:
    """Return the ledger of the terminals of takes and of the grammar of their strings."""
    poses = make_poses(takes)
    if precision is None:
        precision = performance_noise(poses.values, poses.bounds)
    return ledger_of(poses, terminals, sentences, precision)


def ledger_of(poses: Poses, terminals: Terminals, sentences: Sentences, precision: float) -> Ledger:
    """Return the ledger of terminals whose poses are already on principal axes."""
    if precision == 0.0:
        return Ledger(0.0, sentences.bits.sentences, sentences.bits.grammar)
    offsets = poses.bounds[terminals.takes]
    motion = motion_bits(
        poses.values,
        terminals.starts + offsets,
        terminals.ends + offsets,
        terminals.labels,
        terminals.medoids,
        precision,
    )
    return Ledger(motion, sentences.bits.sentences, sentences.bits.grammar)
