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

STANDING = ("idle", "hold")
"""Actions that are waiting."""
ON_GUARD = "guard"
"""What those who guard do when they wait."""
_STILL = 0.12
"""Metres that a clip in place may move."""


def waits(
    library: ClipLibrary, entries: IntArray, lead: int, tail: int
) -> tuple[Wait | None, Wait | None]:
    """What is played ``lead`` frames before, ``tail`` behind a string; None where nothing fits."""
    own = {library.terminals[t] for t in np.asarray(library.terminal)[entries].tolist()}
    actions = (ON_GUARD,) if ON_GUARD in own else STANDING
    standing = _standing(library, actions)
    if len(standing) == 0:
        return None, None
    kinds = np.asarray(library.seam_class)
    first, last = kinds[entries[0]], kinds[entries[-1]]
    before = standing[int(np.argmin(library.seam[kinds[standing], first]))]
    behind = standing[int(np.argmin(library.seam[last, kinds[standing]]))]
    return Wait(library.source[before], lead), Wait(library.source[behind], tail)


def _standing(library: ClipLibrary, actions: tuple[str, ...]) -> IntArray:
    """Entries of actions, as they were captured, that stay where they are."""
    found = [
        entry
        for action in actions
        if action in library.terminals
        for entry in library.of(action)
        if library.source[entry].bend == 0.0
        and library.source[entry].stretch == 1.0
        and float(np.hypot(*library.step[entry, :2])) < _STILL
    ]
    return np.array(found, dtype=np.int64)
