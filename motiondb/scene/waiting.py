"""What players do while they wait: before their first action, and behind their last.

A string of clips begins when its delay is over and ends before others do. Meanwhile a clip in place
is played, of the entries of the grammar's own standing actions the one whose pose is most like that
with which the string begins, or ends.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import IntArray
from motiondb.scene.clips import ClipLibrary
from motiondb.scene.splicing import Wait

IDLE, HOLDING = "idle", "hold"
"""Actions that are waiting: without the ball, and with it."""
BALL_BEFORE = (
    "hold",
    "dribble",
    "pass",
    "shoot",
    "layup",
    "fake_shot",
    "pivot_left",
    "pivot_right",
)
"""Who begins with one of these has the ball."""
BALL_BEHIND = ("hold", "catch", "dribble", "fake_shot", "pivot_left", "pivot_right")
"""Who ends with one of these has it still."""
ON_GUARD = "guard"
"""What those who guard do when they wait."""
_STILL = 0.12
"""Metres that a clip in place may move."""


def waits(
    library: ClipLibrary, entries: IntArray, lead: int, tail: int
) -> tuple[Wait | None, Wait | None]:
    """What is played ``lead`` frames before, ``tail`` behind a string; None where nothing fits."""
    played = [library.terminals[t] for t in np.asarray(library.terminal)[entries].tolist()]
    action = HOLDING if played[0] in BALL_BEFORE else IDLE
    leads = _standing(library, ON_GUARD if ON_GUARD in played else action)
    action = HOLDING if played[-1] in BALL_BEHIND else IDLE
    tails = _standing(library, ON_GUARD if ON_GUARD in played else action)
    if len(leads) == 0 or len(tails) == 0:
        return None, None
    kinds = np.asarray(library.seam_class)
    first, last = kinds[entries[0]], kinds[entries[-1]]
    before = leads[int(np.argmin(library.seam[kinds[leads], first]))]
    behind = tails[int(np.argmin(library.seam[last, kinds[tails]]))]
    return Wait(library.source[before], lead), Wait(library.source[behind], tail)


def _standing(library: ClipLibrary, action: str) -> IntArray:
    """Entries of an action, as captured, that stay in place; of the other one where it has none."""
    for name in (action, HOLDING if action == IDLE else IDLE):
        found = [
            entry
            for entry in (library.of(name) if name in library.terminals else ())
            if library.source[entry].bend == 0.0
            and library.source[entry].stretch == 1.0
            and float(np.hypot(*library.step[entry, :2])) < _STILL
        ]
        if found:
            return np.array(found, dtype=np.int64)
    return np.zeros(0, dtype=np.int64)
