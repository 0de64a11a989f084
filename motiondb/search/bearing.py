"""How a body bears itself during a segment: where its joints are, and how it travels.

Notation: p_t the joint positions of frame t in the frame of the heading, metres on the standard
body (``pose.features``); r_t = (velocity to the left, up, ahead, turning) in their usual spreads
0.3 m/s, 0.3 m/s, 0.6 m/s, 0.9 rad/s; r*_t the mean of r over two seconds around t. Every column is
a mean over the segment's frames:

========  =======  =============================================================================
block     columns  mean over frames of
========  =======  =============================================================================
posture   63       p_t: sitting, kneeling and hanging are postures, whoever takes them
travel    24       how surely r*_t lies above -1.5, -0.75, 0, 0.75, 1.5 spreads; the size of r_t
========  =======  =============================================================================

Neither depends on what a database has learned: no axes, no symbols. They say plainly what whitened
axes and symbols hold only mixed with everything else: a turn, a stop, a step to the side, a way
covered. They stand beside the columns of :mod:`motiondb.search.movement`; means over frames add up
over segments, so that whatever is linear in them can be taken apart exactly.
"""

from __future__ import annotations

import numpy as np

from motiondb.pose import body
from motiondb.pose.features import FEATURE_FPS, ROOT_WEIGHT, VELOCITY_SECONDS
from motiondb.records import Float32Array, FloatArray, IntArray

N_POSTURE = 3 * len(body.JOINTS)
N_TRAVEL = 24
LEVELS = (-1.5, -0.75, 0.0, 0.75, 1.5)
SOFTNESS = 0.25
SPREADS = (0.3, 0.3, 0.6, 0.9)
"""Of r: m/s to the left, up, ahead; rad/s. Measured on real captures, rounded."""
AVERAGED = 2.0
"""Seconds over which travelling is averaged: within a step the pelvis sways and speeds up."""


def describe_bearing(features: Float32Array, starts: IntArray, ends: IntArray) -> Float32Array:
    """Posture and travel of the segments of one capture.

    Parameters
    ----------
    features : array (frames, 130)
        Recognition features of the capture, 15 a second.
    starts : array (segments,)
        Feature frames, each segment at least one frame long.
    ends : array (segments,)
        Feature frames, each segment at least one frame long.

    Returns
    -------
    array (segments, 87), means over the segments' frames. Where the two seconds around a frame
    reach beyond the capture, those of its frames that there are count.
    """
    each = np.concatenate([features[:, :N_POSTURE], travel(features[:, -4:])], axis=1)
    rows = np.empty((len(starts), each.shape[1]), dtype=np.float32)
    for row, start, end in zip(rows, starts, ends):
        row[:] = each[start:end].mean(axis=0)
    return rows


def travel(root: Float32Array) -> FloatArray:
    """The 24 columns of travel frame by frame: array (frames, 24).

    root : array (frames, 4), the features' weighted velocity of the pelvis and turning.

    >>> still = travel(np.zeros((1, 4), dtype=np.float32))
    >>> still[0, 8:12].tolist(), still[0, 20:].tolist()  # on the level 0; sizes
    ([0.5, 0.5, 0.5, 0.5], [0.0, 0.0, 0.0, 0.0])
    """
    r = root.astype(np.float64) / (ROOT_WEIGHT * VELOCITY_SECONDS * np.array(SPREADS))
    smooth = _averaged(r, round(AVERAGED * FEATURE_FPS / 2.0))
    places = [0.5 + 0.5 * np.tanh((smooth - level) / (2.0 * SOFTNESS)) for level in LEVELS]
    return np.concatenate([*places, np.abs(r)], axis=1)


def _averaged(rows: FloatArray, reach: int) -> FloatArray:
    """Means of the rows at most ``reach`` before or after each."""
    sums = np.concatenate([np.zeros((1, rows.shape[1])), np.cumsum(rows, axis=0)])
    now = np.arange(len(rows))
    low, high = np.maximum(now - reach, 0), np.minimum(now + reach + 1, len(rows))
    return np.asarray((sums[high] - sums[low]) / (high - low)[:, None])
