"""Where in a capture somebody throws, where its caption tells only that they do.

"dribble, shoot" tells of two actions and of no times. Hands tell more: before a ball leaves them at
frame r (where a wrist is farthest ahead and up), they come together about it, and after it they
sink. So of frames [start, end) the throw is [a, b)::

    a   the first frame of the last stretch before r in which the wrists are at most HELD apart
    b   the first frame after r + LANDED in which both wrists are below the chest

and at most AROUND frames lie on either side of r. What comes before a is what the caption tells of
before. It holds where nothing that is told before looks like a throw (a feigned shot does).
"""

from __future__ import annotations

import numpy as np

from motiondb.pose import body
from motiondb.scene.clips.body_frames import WRISTS, BodyFrames
from motiondb.scene.clips.clip_cutting import AROUND, farthest_up

HELD = 0.3
"""Metres between the wrists of who has a ball in both hands, at most."""
LANDED = 25
"""Frames after which who jumped is on the ground again."""
_CHEST = body.INDEX["chest"]


def throw_frames(frames: BodyFrames, start: int, end: int) -> tuple[int, int]:
    """The frames [a, b) of a throw somewhere in [start, end); see the module."""
    release = farthest_up(frames, start, end)
    wrists = frames.joints[start:end, WRISTS]
    together = np.linalg.norm(wrists[:, 0] - wrists[:, 1], axis=1) <= HELD
    held = np.flatnonzero(together[: release - start + 1])
    first = release - AROUND
    if len(held):
        apart = np.flatnonzero(~together[: held[-1]])
        first = max(first, start + (int(apart[-1]) + 1 if len(apart) else 0))
    landed = min(release + LANDED, end)
    chest = frames.joints[landed:end, _CHEST, 1]
    down = np.flatnonzero(frames.joints[landed:end, WRISTS, 1].max(axis=1) < chest)
    last = landed + int(down[0]) if len(down) else end
    return max(first, start), min(last, release + AROUND, end)
