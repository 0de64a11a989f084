"""One ledger of bits for terminals, sentences and rules.

More terminals show the motion more exactly, and make the string harder to describe. Both are
counted in bits: *motion*, to send every frame once its terminal is known; *string*, the sentences
given the rules; *grammar*, the rules.

The motion is sent as exactly as it is worth telling: to delta metres, root mean square, in the
distance of poses. Delta is measured in the motion itself (``performance_noise``): half of all half
seconds have a like one elsewhere that is no farther off. What tells two performances of one action
apart is below delta and costs next to nothing; what tells two actions apart is above.

Poses x_t lie on principal axes. Gaussian axes of variances v_a are sent at mean square error
delta^2 in

    R(v) = sum_a max(0, 1/2 log2(v_a / theta)),    theta such that sum_a min(theta, v_a) = delta^2

bits a sample, and nothing where sum_a v_a <= delta^2. It is a code in two parts:

* the frames of the K medoids are sent as poses, v being the variances of poses;
* the frames of a terminal's other segments are sent as what is left when its medoid, uniformly
  warped, is taken from them. The left-overs of all terminals share the shares of their axes; each
  terminal has its own, most likely, size c_k. A size takes 1/2 log2 of the samples it is told from.

Motion is smooth, and a frame nearly told by the one before: with correlation rho from frame to
frame there are (1 - rho) / (1 + rho) independent samples a frame. Each segment also costs log2 of
the longest length, for its own.

A terminal more pays where the segments that it takes over are then better told by more bits than
its medoid, its name and the longer rules cost. So there is a smallest sum between K = 1 and a
terminal for every segment; ``terminal_number`` looks for it.

Sources: J. Rissanen, "Modeling by shortest data description", Automatica 14 (1978), for one ledger
of all parts and the price of a parameter; T. M. Cover and J. A. Thomas, "Elements of Information
Theory" (2006), theorem 10.3.3, for the bits of Gaussian axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.sentences.partition import Sentences
from motiondb.grammar.terminals.pose_distance import Poses, make_poses
from motiondb.grammar.terminals.terminals import Terminals
from motiondb.records import Float32Array, FloatArray, IntArray, Motion

COARSEST, FINEST = 0.2, 0.02
"""Bounds of delta, as shares of the root mean square distance of poses from the mean pose: above,
unlike actions would seem alike; below is the noise of capture itself."""

_WINDOW, _COMPARED = 15, 3
"""Frames of the half seconds that are compared, and from one to the next that is looked at."""

_MOST_WINDOWS = 1500
"""Windows whose like is looked for, evenly spaced."""


@dataclass(frozen=True)
class Ledger:
    """Bits of the motion given the terminals, the sentences given the rules, and the rules."""

    motion: float
    string: float
    grammar: float

    @property
    def total(self) -> float:
        """All bits."""
        return self.motion + self.string + self.grammar


def motion_bits(
    values: Float32Array | FloatArray,
    starts: IntArray,
    ends: IntArray,
    labels: IntArray,
    medoids: IntArray,
    precision: float,
) -> float:
    """Bits of all frames given the string.

    Parameters
    ----------
    values : array (frames of all takes, axes), poses on axes of their own.
    starts, ends : array (segments,), rows of ``values``, half-open.
    labels : array (segments,), terminals. medoids : array (K,), segments.
    precision : delta, in the unit of ``values``.

    Raises
    ------
    GrammarError where the precision is not positive.
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
        own = copied & (labels == label)
        n_frames = int(lengths[own].sum())
        size = squares[own].sum() / n_frames
        bits += samples * n_frames * rate(size * shape, precision)
        bits += 0.5 * float(np.log2(max(1.0, samples * n_frames * len(shape))))
    return bits


def rate(variances: FloatArray, precision: float) -> float:
    """R(v): bits of a sample of Gaussian axes at a root mean square error of ``precision``.

    >>> rate(np.array([16.0, 0.0]), 1.0), rate(np.array([0.5, 0.25]), 1.0)
    (2.0, 0.0)
    """
    falling = np.sort(variances)[::-1]
    left = precision**2 - (falling.sum() - np.cumsum(falling))
    # told axes 0..m: theta is what the untold leave of delta^2, shared; the right m tells v > theta
    levels = left / np.arange(1, len(falling) + 1)
    told = np.flatnonzero((levels > 0.0) & (levels < falling))
    if not len(told):
        return 0.0
    level = levels[told[-1]]
    return float(0.5 * np.log2(np.maximum(falling / level, 1.0)).sum())


def performance_noise(values: Float32Array | FloatArray, bounds: IntArray) -> float:
    """Delta in metres: how far the likes of half seconds are from them, root mean square; median.

    Parameters
    ----------
    values : array (frames of all takes, axes). bounds : array (takes + 1,), as in ``Poses``.

    A like one begins a second or more away, or in another take. Delta is kept within ``FINEST`` and
    ``COARSEST``; 0 where nothing moves, and ``COARSEST`` where the takes are too short to tell.
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
    found = float(np.sqrt(np.median(nearest))) if nearest else COARSEST * spread
    return min(max(found, FINEST * spread), COARSEST * spread)


def samples_a_frame(poses: FloatArray) -> float:
    """(1 - rho) / (1 + rho), rho the correlation of poses one frame apart.

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
    """Return what the warped medoids leave of the frames: 0 in the medoids themselves."""
    found = np.zeros_like(poses)
    for start, end, label in zip(starts, ends, labels, strict=True):
        first, last = starts[medoids[label]], ends[medoids[label]]
        matched = first + np.arange(end - start) * (last - first) // (end - start)
        found[start:end] = poses[start:end] - poses[matched]
    return found


def make_ledger(
    takes: Sequence[Motion],
    terminals: Terminals,
    sentences: Sentences,
    precision: float | None = None,
) -> Ledger:
    """Return the ledger of terminals of takes and of what was learned from their strings.

    precision : delta in metres; measured unless given.
    """
    poses = make_poses(takes)
    if precision is None:
        precision = performance_noise(poses.values, poses.bounds)
    return ledger_of(poses, terminals, sentences, precision)


def ledger_of(poses: Poses, terminals: Terminals, sentences: Sentences, precision: float) -> Ledger:
    """Return the ledger of terminals of poses.

    Precision : delta in metres, 0 where nothing moves.
    """
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
