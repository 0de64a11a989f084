"""Repair of captures whose first frames or single frames are impossible.

Three faults occur in the folders of users: a rest pose at the start that the capture software wrote
before the take (after which a filter rings for a few frames), frames in which joints jump faster
than any person moves, and values that are not numbers. Bad frames are replaced by linear
interpolation between their good neighbours (held at the ends), so times stay as they are; each
repair leaves a note. A capture that is impossible as a whole is not repaired: :func:`implausible`
describes it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.records import MOTION_FPS, FloatArray

MAX_SPEED = 14.0
"""Metres per second on the standard body above which a joint is taken to leap. Sprinters run at 12,
and the joints of 540 real captures stay below 12.4 but for single frames."""
MAX_BAD_SHARE = 0.5
"""A capture of which more than this share would be replaced is implausible, because too much of it
would be interpolated. Of 540 real captures, none has a share above 0.11."""
MAX_LEAP_SECONDS = 0.5
"""A capture that moves faster than ``MAX_SPEED`` for longer than this without interruption is
implausible; errors of a marker are shorter. Of 540 real captures, none does so for longer than 0.11
s."""
LEAD_SECONDS = 0.5
"""A run that begins within this time, ends within twice it and is cut off by a leap is a pose from
before the take. Chosen by hand on the CMU captures that begin so; not tuned."""
RINGING_SECONDS = 0.3
"""How long after a leap at the start a filter may ring. Chosen by hand on the same captures."""
RINGING_SPEED = 4.0  # Metres per second above which it does. Chosen by hand on the same captures
SHORT_SECONDS = 0.1
"""Frames between two jumps that last less are not believed: human movements last longer."""


def clean(points: FloatArray, fps: float, leg_length: float) -> tuple[FloatArray, tuple[str, ...]]:
    """Replace impossible frames of (frames, joints, 3); legs of ``leg_length``, metres."""
    bad = wild_frames(points, fps, leg_length)
    if not bad.any():
        return points, ()
    if bad.all():
        return np.where(np.isfinite(points), points, 0.0), ("no frame moves like a human",)
    good = np.flatnonzero(~bad)
    times = np.arange(len(points))
    flat = points.reshape(len(points), -1)
    repaired = flat.copy()
    for column in range(flat.shape[1]):
        repaired[bad, column] = np.interp(times[bad], good, flat[good, column])
    lead = int(good[0])
    notes = []
    if lead:
        notes.append(f"the first {lead} frames jump; they were replaced by the first good frame")
    if (count := int(bad.sum()) - lead) > 0:
        notes.append(f"{count} frames jump faster than {MAX_SPEED:g} m/s and were interpolated")
    return repaired.reshape(points.shape), tuple(notes)


def implausible(points: FloatArray, fps: float, leg_length: float) -> str:
    """Why points (frames, joints, 3) as a whole cannot be the motion of a person, or ""."""
    if len(points) < 2:
        return ""
    _, speed, finite = _standard_speeds(points, fps, leg_length)
    leap = (speed > MAX_SPEED) & finite[1:] & finite[:-1]
    if finite.all() and not leap.any():
        return ""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], leap.astype(int), [0]])))
    leaps = edges.reshape(-1, 2)
    longest = float(np.diff(leaps, axis=1).max(initial=0)) / fps
    share = float(wild_frames(points, fps, leg_length).mean())
    if longest <= MAX_LEAP_SECONDS and share <= MAX_BAD_SHARE:
        return ""
    usual = f" (in the median at {np.median(speed[leap]):.4g} m/s)" if leap.any() else ""
    if longest > MAX_LEAP_SECONDS:
        span = f"{longest:.2g} s without interruption"
        return f"a motion faster than {MAX_SPEED:g} m/s for {span}{usual}"
    return f"{share:.0%} of the frames jumping or without numbers{usual}"


def fastest_note(positions: FloatArray) -> tuple[str, ...]:
    """Note a joint of the solved body that moves faster than any person.

    Of 540 real captures 9 have such frames. In 7 the measured joint is as fast; in 2 it is slow:
    there only the solved body leaps.

    Shapes: `positions` (frames, 21, 3), metres on the standard body.
    """
    if len(positions) < 2:
        return ()
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * MOTION_FPS
    frame, joint = np.unravel_index(int(speed.argmax()), speed.shape)
    if speed[frame, joint] <= MAX_SPEED:
        return ()
    return (
        f"{body.JOINTS[joint]} moves at {speed[frame, joint]:.3g} m/s, {frame / MOTION_FPS:.2f} s "
        "after the start: faster than any person. Either the capture jumps there, or only "
        "the body that is solved for it.",
    )


def wild_frames(points: FloatArray, fps: float, leg_length: float) -> NDArray[np.bool_]:
    """Find the frames that are not believed.

    Leaps cut the take into runs of connected frames. The longest run is believed, and so are others
    of at least a tenth of a second; shorter runs between leaps and a pose before the take are not.

    Shapes: `points` (frames, joints, 3); result (frames,), bool.
    """
    known, speed, finite = _standard_speeds(points, fps, leg_length)
    if len(points) < 2:
        return np.asarray(~finite)
    leap = (speed > MAX_SPEED) | ~finite[1:] | ~finite[:-1]
    starts = np.concatenate([[0], np.flatnonzero(leap) + 1])
    ends = np.concatenate([starts[1:], [len(points)]])
    long_enough = max(3, round(SHORT_SECONDS * fps))
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


def _standard_speeds(
    points: FloatArray, fps: float, leg_length: float
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Scale positions to the standard body and measure their speeds; result (frames, joints, 3)."""
    finite = np.asarray(np.isfinite(points).all(axis=(1, 2)))
    known = np.where(finite[:, None, None], points, 0.0) * (body.LEG_LENGTH / leg_length)
    speed = np.linalg.norm(np.diff(known, axis=0), axis=-1).max(axis=1) * fps
    return known, speed, finite


def _goes_on(
    known: FloatArray, finite: NDArray[np.bool_], end: int, after: int, fps: float
) -> bool:
    """Say whether frame ``after`` continues frame ``end`` - 1 over a spike or missing numbers."""
    if after - end >= max(3, round(SHORT_SECONDS * fps)) and finite[end:after].any():
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
