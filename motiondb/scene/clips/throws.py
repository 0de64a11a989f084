"""The frames in which a capture shows a throw, if its caption only says that there is one.

"dribble, shoot" names two actions and no times. More evidence comes from the hands: before a ball
leaves them at frame r (where a wrist is farthest ahead and up), they come together around it, and
afterwards they sink. Within frames [start, end) the throw is [a, b)::

    a   the first frame of the last interval before r in which the wrists are at most HELD apart
    b   the first frame after r + LANDED in which both wrists are below the chest

with at most AROUND frames on either side of r. The frames before a show the actions that the
caption names before the throw. The method fails if an earlier action looks like a throw, as a
feigned shot does.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.scene.clips.body_frames import WRISTS, BodyFrames
from motiondb.scene.clips.clip_cutting import AROUND, farthest_up

HELD = 0.3
"""Largest distance between the wrists with a ball in both hands, m. Chosen by hand: a ball is 0.24
m wide."""
LANDED = 25
"""Frames after which a jumping player is on the ground again. Chosen by hand on the sample
captures."""
_CHEST = body.INDEX["chest"]


def throw_frames(frames: BodyFrames, start: int, end: int) -> tuple[int, int]:
    """Return the frames [a, b) of a throw within [start, end); see the module."""
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
