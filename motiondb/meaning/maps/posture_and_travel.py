"""Posture and travel of a segment: where the joints are, and how the body moves through space.

Notation: p_t the joint positions of frame t in the frame of the heading, metres on the standard
body (``pose.features``); r_t = (velocity to the left, up, ahead, turning) in their usual spreads
0.3 m/s, 0.3 m/s, 0.6 m/s, 0.9 rad/s; r*_t the mean of r over two seconds around t; s the logistic
function of (r* - level) / 0.25. Every column is a mean over the segment's frames:

========  =======  =============================================================================
block     columns  mean over frames of
========  =======  =============================================================================
posture 63 p_t, which distinguishes sitting, kneeling and hanging
travel    24       s for the levels -1.5, -0.75, 0, 0.75, 1.5, and the absolute value of r_t
========  =======  =============================================================================

Neither depends on what a database has learned. They describe directly a turn, a stop, a step to the
side and the distance covered, which whitened axes and symbols mix with other properties. They
follow the columns of :mod:`motiondb.meaning.maps.movement`. Means over frames are additive over
segments, so that functions linear in them can be decomposed exactly.

Levels, averaging and weights were chosen among about 270 settings by leaving performers out of the
CMU training parts (``docs/quality.md``, "Words to motion").
"""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.body.features import FEATURE_FPS, ROOT_WEIGHT, VELOCITY_SECONDS
from motiondb.records import Float32Array, FloatArray, IntArray

N_POSTURE = 3 * len(body.JOINTS)  # Columns of posture
N_TRAVEL = 24  # Columns of travel
LEVELS = (-1.5, -0.75, 0.0, 0.75, 1.5)  # Levels of r*, in spreads
SOFTNESS = 0.25  # Width of the logistic function, in spreads
SPREADS = (0.3, 0.3, 0.6, 0.9)
"""Spreads of r: m/s to the left, up, ahead; rad/s. Measured on real captures, rounded."""
AVERAGED = 2.0  # Seconds over which r is averaged, because the pelvis sways within every step


def describe_posture_and_travel(
    features: Float32Array, starts: IntArray, ends: IntArray
) -> Float32Array:
    """Compute posture and travel of the segments of one capture.

    Shapes: `features` (frames, 130); `starts`, `ends` (segments,); result (segments, 87).
    """
    each = np.concatenate([features[:, :N_POSTURE], travel(features[:, -4:])], axis=1)
    rows = np.empty((len(starts), each.shape[1]), dtype=np.float32)
    for row, start, end in zip(rows, starts, ends):
        row[:] = each[start:end].mean(axis=0)
    return rows


def travel(root: Float32Array) -> FloatArray:
    """Compute the 24 columns of travel for every frame: array (frames, 24).

    Shapes: `root` (frames, 4).

    >>> still = travel(np.zeros((1, 4), dtype=np.float32))
    >>> still[0, 8:12].tolist(), still[0, 20:].tolist()  # on the level 0; sizes
    ([0.5, 0.5, 0.5, 0.5], [0.0, 0.0, 0.0, 0.0])
    """
    r = root.astype(np.float64) / (ROOT_WEIGHT * VELOCITY_SECONDS * np.array(SPREADS))
    smooth = _averaged(r, round(AVERAGED * FEATURE_FPS / 2.0))
    places = [0.5 + 0.5 * np.tanh((smooth - level) / (2.0 * SOFTNESS)) for level in LEVELS]
    return np.concatenate([*places, np.abs(r)], axis=1)


def _averaged(rows: FloatArray, reach: int) -> FloatArray:
    """Mean of the rows within ``reach`` rows of each row."""
    sums = np.concatenate([np.zeros((1, rows.shape[1])), np.cumsum(rows, axis=0)])
    now = np.arange(len(rows))
    low, high = np.maximum(now - reach, 0), np.minimum(now + reach + 1, len(rows))
    return np.asarray((sums[high] - sums[low]) / (high - low)[:, None])
