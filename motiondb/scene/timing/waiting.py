"""Clips for waiting players: before the first action, between two actions, and after the last.

A string of clips begins when its delay is over, and may end before others do. Meanwhile the player
plays a clip in place: the entry of the grammar's standing actions whose poses are most like those
before and after it. A player who would begin or end in the middle of a run takes a first step from
rest before it, or a last one to rest after it.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import IntArray
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.timing.playing import Part

IDLE, HOLDING = "idle", "hold"  # Actions for waiting: without the ball, and with it
BALL_BEFORE = (
    "hold",
    "dribble",
    "pass",
    "shoot",
    "layup",
    "fake_shot",
    "pivot_left",
    "pivot_right",
)  # A player who begins with one of these actions has the ball
BALL_BEHIND = ("hold", "catch", "dribble", "fake_shot", "pivot_left", "pivot_right")
"""A player who ends with one of these actions still has it."""
ON_GUARD = "guard"  # Action of guarding; players who guard also wait in it
AT_REST = 0.35
"""Mean speed of the joints, m/s, up to which a body may pause. Chosen by hand on the sample
captures."""
_STILL = 0.12  # Largest displacement of a clip in place, m
_LEAST = {IDLE: 15, HOLDING: 15, ON_GUARD: 30}
"""Frames to which clips of standing may be cut: half a second, guarding a second."""


def least_lengths(library: ClipLibrary, entries: IntArray) -> IntArray:
    """Return to how many frames each of a string's clips may be cut.

    Only standing is cut. A clip with an event stays whole, because rules look at its instant.
    """
    whole = np.asarray(library.n_frames)[entries].astype(np.int64)
    for clip, entry in enumerate(np.asarray(entries).tolist()):
        standing = _LEAST.get(library.terminals[int(library.terminal[entry])], 0)
        standing = standing if int(library.event_frame[entry]) < 0 else 0
        if standing and float(np.hypot(*library.step[entry, :2])) < _STILL:
            whole[clip] = min(whole[clip], standing)
    return whole


def may_pause(library: ClipLibrary, entries: IntArray) -> IntArray:
    """Return 1 for clips after which the player may stand: this and the next are at rest there.

    It is 0 everywhere if the grammar has no clip to stand in.
    """
    allowed = np.zeros(len(entries), dtype=np.int64)
    if len(library.rest) and len(_standing(library, IDLE)):
        rest = np.asarray(library.rest)[np.asarray(library.seam_class)[entries]]
        allowed[:-1] = (rest[:-1, 1] <= AT_REST) & (rest[1:, 0] <= AT_REST)
    return allowed


def pause_entry(library: ClipLibrary, entries: IntArray, behind: int) -> int:
    """Return the entry that is played in a pause after a clip; -1 if the grammar has none."""
    played = _played(library, entries)
    action = HOLDING if played[behind] in BALL_BEHIND else IDLE
    standing = _standing(library, ON_GUARD if ON_GUARD in played else action)
    if len(standing) == 0:
        return -1
    kinds = np.asarray(library.seam_class)
    before, after = kinds[entries[behind]], kinds[entries[behind + 1]]
    costs = library.seam[before, kinds[standing]] + library.seam[kinds[standing], after]
    return int(standing[int(np.argmin(costs))])


def lead_in(library: ClipLibrary, entries: IntArray, n_frames: int) -> tuple[Part, ...]:
    """Return the clips for ``n_frames`` before a string; () if nothing fits."""
    played, kinds = _played(library, entries), np.asarray(library.seam_class)
    action = HOLDING if played[0] in BALL_BEFORE else IDLE
    standing = _standing(library, ON_GUARD if ON_GUARD in played else action)
    if len(standing) == 0:
        return ()
    step = _step(library, int(entries[0]), 0)
    first = kinds[entries[0] if step < 0 else step]
    stood = int(standing[int(np.argmin(library.seam[kinds[standing], first]))])
    parts = [Part(library.source[stood], n_frames, -1, waits=True)]
    if step >= 0:
        lasts = int(library.n_frames[step])
        parts[0] = Part(library.source[stood], max(n_frames - lasts, 1), -1, waits=True)
        parts.append(Part(library.source[step], lasts, -1))
    return tuple(parts)


def lead_out(library: ClipLibrary, entries: IntArray, n_frames: int) -> tuple[Part, ...]:
    """Return the clips after a string: a last step if it ends in motion, then ``n_frames``."""
    played, kinds = _played(library, entries), np.asarray(library.seam_class)
    action = HOLDING if played[-1] in BALL_BEHIND else IDLE
    standing = _standing(library, ON_GUARD if ON_GUARD in played else action)
    if len(standing) == 0:
        return ()
    behind, parts = len(entries), []
    step = _step(library, int(entries[-1]), 1)
    if step >= 0:
        parts.append(Part(library.source[step], int(library.n_frames[step]), behind))
    last = kinds[entries[-1] if step < 0 else step]
    stood = int(standing[int(np.argmin(library.seam[last, kinds[standing]]))])
    return (*parts, Part(library.source[stood], n_frames, behind, waits=True))


def _played(library: ClipLibrary, entries: IntArray) -> list[str]:
    return [library.terminals[t] for t in np.asarray(library.terminal)[entries].tolist()]


def _step(library: ClipLibrary, entry: int, side: int) -> int:
    """Return a step from rest before an entry (side 0) or to rest after it (1); -1 for none.

    It is of the same action, as captured, with the best seam, if that is better than to stop.
    """
    if not len(library.rest):
        return -1
    kinds = np.asarray(library.seam_class)
    stopping = float(library.rest[kinds[entry], side])
    if stopping <= AT_REST:
        return -1
    steps = np.array(
        [
            other
            for other in library.of(library.terminals[int(library.terminal[entry])])
            if library.source[other].bend == 0.0
            and library.source[other].stretch == 1.0
            and library.event_frame[other] < 0
            and library.rest[kinds[other], side] <= AT_REST
            and library.rest[kinds[other], 1 - side] > AT_REST
        ],
        dtype=np.int64,
    )
    if len(steps) == 0:
        return -1
    seams = (
        library.seam[kinds[steps], kinds[entry]]
        if side == 0
        else (library.seam[kinds[entry], kinds[steps]])
    )
    best = int(np.argmin(seams))
    return int(steps[best]) if seams[best] < stopping else -1


def _standing(library: ClipLibrary, action: str) -> IntArray:
    """Return entries of an action, as captured, that stay in place; else of the other action."""
    for name in (action, HOLDING if action == IDLE else IDLE):
        entries = [
            entry
            for entry in (library.of(name) if name in library.terminals else ())
            if library.source[entry].bend == 0.0
            and library.source[entry].stretch == 1.0
            and float(np.hypot(*library.step[entry, :2])) < _STILL
        ]
        if entries:
            return np.array(entries, dtype=np.int64)
    return np.zeros(0, dtype=np.int64)
