"""Frames in which arms and heads were edited after the clips were spliced.

Hands are moved to the ball and heads turned to it (:mod:`motiondb.scene.ball.hands`,
:mod:`motiondb.scene.ball.gaze`). A frame counts as edited if a joint differs from the spliced
motion's by more than one degree.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.records import Motion

LEAST = math.radians(1.0)
"""Smallest turn of a joint, rad, that counts as an edit. Chosen by hand: a smaller one cannot be
seen."""
_EDITS = {
    "hands brought to the ball": ("l_shoulder", "l_elbow", "r_shoulder", "r_elbow"),
    "head turned": ("neck", "head"),
}


def joint_edits(spliced: Motion, finished: Motion) -> dict[str, NDArray[np.bool_]]:
    """Return in which frames a finished motion was edited: arrays (frames,), by the edit.

    >>> from motiondb.body import rotation
    >>> local = np.tile(rotation.IDENTITY, (2, len(body.JOINTS), 1))
    >>> still = Motion(local.astype(np.float32), np.zeros((2, 3), np.float32), 0.9)
    >>> local[1, body.INDEX["neck"]] = rotation.from_axis_angle([0.0, 1.0, 0.0], 0.1)
    >>> looks = Motion(local.astype(np.float32), still.root_positions, 0.9)
    >>> {edit: frames.tolist() for edit, frames in joint_edits(still, looks).items()}
    {'hands brought to the ball': [False, False], 'head turned': [False, True]}
    """
    before, after = (m.local_rotations.astype(np.float64) for m in (spliced, finished))
    cosines = np.abs(np.sum(before * after, axis=2))  # of half the turn; q and -q are one rotation
    turned = cosines < math.cos(LEAST / 2.0)
    return {
        edit: turned[:, [body.INDEX[joint] for joint in joints]].any(axis=1)
        for edit, joints in _EDITS.items()
    }
