"""How a segment moves, apart from symbols: where it is, what moves together, how fast it swings.

Notation: x_t the whitened features of frame t (15 a second, D dimensions). Every column is a mean
over the segment's frames:

========  ==============  ===============================================================
block     columns         mean over frames of
========  ==============  ===============================================================
places    5 D             how surely x_t lies above -1.5, -0.75, 0, 0.75, 1.5 spreads
joint     D (D + 1) / 2   products of two dimensions: what moves together
rhythm    5 D             absolute change within 1/15 to 1 second: waving is not raising
========  ==============  ===============================================================

Means over frames add up over segments, so that whatever is linear in them can be taken apart
exactly. They stand beside the symbols' scores in an interval's vector
(:mod:`motiondb.search.score_vectors`), followed by posture and travel
(:mod:`motiondb.search.bearing`): symbols carry over to performers never seen, these columns
tell apart what symbols learned from other movements confuse.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import Float32Array, IntArray
from motiondb.search.bearing import N_POSTURE, N_TRAVEL

LEVELS = (-1.5, -0.75, 0.0, 0.75, 1.5)
SOFTNESS = 0.25
TRAVEL_WEIGHT = 1.5
LAGS = (1, 2, 4, 8, 15)
"""Feature frames between which change is measured: 1/15 to 1 second."""


def block_sizes(n_columns: int) -> tuple[int, ...]:
    """Columns of places, joint, rhythm, posture and travel, of all columns together; none of none.

    A database that learned before there were posture and travel has the first three alone.

    >>> block_sizes(627), block_sizes(540), block_sizes(0)
    ((120, 300, 120, 63, 24), (120, 300, 120), ())
    """
    if n_columns == 0:
        return ()
    bearing = (N_POSTURE, N_TRAVEL)
    whole = _sizes(n_columns - sum(bearing))
    return (*whole, *bearing) if sum(whole) + sum(bearing) == n_columns else _sizes(n_columns)


def count_bearing(n_columns: int) -> int:
    """How many of all columns of movement are posture and travel: the last ones.

    >>> count_bearing(627), count_bearing(540), count_bearing(0)
    (87, 0, 0)
    """
    return sum(block_sizes(n_columns)[3:])


def block_weight(block: int) -> float:
    """How much more than the symbols together a block of :func:`block_sizes` counts.

    >>> [block_weight(block) for block in range(5)]
    [1.0, 1.0, 1.0, 1.0, 1.5]
    """
    return TRAVEL_WEIGHT if block == 4 else 1.0


def _sizes(n_columns: int) -> tuple[int, int, int]:
    """Places, joint and rhythm of so many columns together."""
    per_dimension = 2 * (len(LEVELS) + len(LAGS)) + 1
    n_dims = (np.sqrt(per_dimension**2 + 8.0 * max(n_columns, 0)) - per_dimension) / 2.0
    n_dims = round(float(n_dims))
    return len(LEVELS) * n_dims, n_dims * (n_dims + 1) // 2, len(LAGS) * n_dims


def describe_movement(frames: Float32Array, starts: IntArray, ends: IntArray) -> Float32Array:
    """Places, joint and rhythm of the segments of one capture.

    Parameters
    ----------
    frames : array (frames, D)
        Whitened features of the capture.
    starts : array (segments,)
        Feature frames, each segment at least one frame long.
    ends : array (segments,)
        Feature frames, each segment at least one frame long.

    Returns
    -------
    array (segments, columns), means over the segments' frames; a change that would reach beyond
    the capture's end is measured up to its last frame.
    """
    n_frames, n_dims = frames.shape
    first, second = np.triu_indices(n_dims)
    now = np.arange(n_frames)
    places = [0.5 + 0.5 * np.tanh((frames - level) / (2.0 * SOFTNESS)) for level in LEVELS]
    rhythm = [np.abs(frames[np.minimum(now + lag, n_frames - 1)] - frames) for lag in LAGS]
    each = np.concatenate(places + rhythm, axis=1)
    n_places = len(LEVELS) * n_dims
    rows = np.empty((len(starts), each.shape[1] + len(first)), dtype=np.float32)
    for row, start, end in zip(rows, starts, ends):
        means = each[start:end].mean(axis=0)
        products = frames[start:end].T @ frames[start:end] / np.float32(end - start)
        row[:] = np.concatenate([means[:n_places], products[first, second], means[n_places:]])
    return rows
