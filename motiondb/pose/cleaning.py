"""Mending captures whose first frames or single frames are wild.

Three faults occur in the folders of users: a rest pose at the start that the capture software wrote
before the take (and that rings on for a few frames), frames in which joints leap faster than any
human moves, and values that are no numbers. Bad frames are replaced by linear interpolation between
their good neighbours (held at the ends), so times stay as they are; each repair leaves a note.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.pose import body
from motiondb.records import FloatArray

MAX_SPEED = 14.0
"""Metres a second on the standard body above which a joint is not believed."""
LEAD_SECONDS = 0.5
"""A run that begins within this time, ends within twice it and is cut off by a leap is a pose from
before the take."""
RINGING_SECONDS = 0.3
"""How long after a leap at the start a filter may ring."""
RINGING_SPEED = 4.0
"""Metres a second above which it does."""


def clean(points: FloatArray, fps: float, leg_length: float) -> tuple[FloatArray, tuple[str, ...]]:
    """Replace impossible frames.

    Parameters
    ----------
    points : array (frames, joints, 3), metres, world frame.
    fps : frames a second. leg_length : metres, for the speed limit.

    Returns
    -------
    points : the same shape, finite. notes : what was mended.
    """
    bad = wild_frames(points, fps, leg_length)
    if not bad.any():
        return points, ()
    if bad.all():
        return np.where(np.isfinite(points), points, 0.0), ("no frame moves like a human",)
    good = np.flatnonzero(~bad)
    times = np.arange(len(points))
    flat = points.reshape(len(points), -1)
    mended = flat.copy()
    for column in range(flat.shape[1]):
        mended[bad, column] = np.interp(times[bad], good, flat[good, column])
    lead = int(good[0])
    notes = []
    if lead:
        notes.append(f"the first {lead} frames leap; the first good frame is held in their place")
    if (count := int(bad.sum()) - lead) > 0:
        notes.append(f"{count} frames leap faster than {MAX_SPEED:g} m/s and were interpolated")
    return mended.reshape(points.shape), tuple(notes)


def wild_frames(points: FloatArray, fps: float, leg_length: float) -> NDArray[np.bool_]:
    """Frames not to be believed: array (frames,), bool.

    Leaps cut the take into runs of connected frames. The longest run is believed, and so are others
    of at least a tenth of a second; shorter runs between leaps and a pose before the take are not.
    """
    finite = np.asarray(np.isfinite(points).all(axis=(1, 2)))
    if len(points) < 2:
        return np.asarray(~finite)
    known = np.where(finite[:, None, None], points, 0.0) * (body.LEG_LENGTH / leg_length)
    speed = np.linalg.norm(np.diff(known, axis=0), axis=-1).max(axis=1) * fps
    leap = (speed > MAX_SPEED) | ~finite[1:] | ~finite[:-1]
    starts = np.concatenate([[0], np.flatnonzero(leap) + 1])
    ends = np.concatenate([starts[1:], [len(points)]])
    long_enough = max(3, round(0.1 * fps))
    longest = int(np.argmax(ends - starts))
    believed = ends - starts >= long_enough
    believed[longest] = True
    for run in range(longest - 1, -1, -1):
        leads = starts[run] < LEAD_SECONDS * fps and ends[run] <= 2 * LEAD_SECONDS * fps
        if believed[run] and leads:
            after = int(starts[run + 1 :][believed[run + 1 :]][0])
            believed[run] = _goes_on(known, finite, int(ends[run]), after, fps)
    bad = np.asarray(~finite)
    for start, end in zip(starts[~believed], ends[~believed]):
        bad[start:end] = True
    if bad[0] and not bad.all():
        _extend_over_ringing(bad, speed, fps)
    return bad


def _goes_on(
    known: FloatArray, finite: NDArray[np.bool_], end: int, after: int, fps: float
) -> bool:
    """Whether frame ``after`` goes on from frame ``end`` - 1 over a spike or missing numbers.

    A pose from before the take is elsewhere, and what follows it rings for longer than a spike.
    """
    if after - end >= max(3, round(0.1 * fps)) and finite[end:after].any():
        return False
    distance = float(np.linalg.norm(known[after] - known[end - 1], axis=-1).max())
    return after > end and distance * fps / (after - end + 1) < RINGING_SPEED


def _extend_over_ringing(bad: NDArray[np.bool_], speed: FloatArray, fps: float) -> None:
    """Mark the frames after a leap at the start in which the capture's filter still rings."""
    first = int(np.argmin(bad))
    limit = min(first + round(RINGING_SECONDS * fps), len(speed))
    ringing = np.flatnonzero(speed[first:limit] > RINGING_SPEED)
    if len(ringing):
        bad[first : first + int(ringing[-1]) + 1] = True
