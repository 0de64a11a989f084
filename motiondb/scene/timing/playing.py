"""The sequence of a player: parts of the sampled clips, and pauses between them.

Sampling puts clips end to end. Polishing may leave out the middle of a clip in which a player only
stands (the beginning of the first clip, the end of the last), and may insert a pause between two
clips. All code that needs to know which frame of which clip is shown when (for rules, for the ball,
for provenance) gets it from here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.records import IntArray
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.scene_arrays import PlayerState
from motiondb.scene.language.activity import KEEPING, LOSING, TAKE, Activity


@dataclass(frozen=True)
class Part:
    """Frames of one source, or of a pause, which plays its source forwards and backwards."""

    source: ClipSource
    n_frames: int
    clip: int  # The action that it belongs to; for a pause the one before it, -1 before the first
    waits: bool = False  # Whether it is a pause
    action: str = ""  # What somebody does who follows another after their last action


@dataclass(frozen=True, eq=False)
class Playing:
    """A player's string with its pauses; frames count from the first frame of the first clip."""

    parts: tuple[Part, ...]
    begins: IntArray  # (clips + 1,), int: frames at which clips begin, and where the last one ends
    ends: IntArray  # (clips,), int: the frames after the clips' last
    instants: IntArray  # (clips,), int: where rules look: the clip's event, or its middle
    # (frames,), int: the frame of the string as sampled; for a pause the one before it
    rows: IntArray

    @property
    def n_frames(self) -> int:
        """Frames of the string with its pauses."""
        return len(self.rows)

    @property
    def pauses(self) -> tuple[tuple[int, int], ...]:
        """The frames [start, end) of pauses."""
        pauses, at = [], 0
        for part in self.parts:
            if part.waits:
                pauses.append((at, at + part.n_frames))
            at += part.n_frames
        return tuple(pauses)

    @property
    def knots(self) -> IntArray:
        """Where clips and pauses begin and end, ascending."""
        return np.unique(np.concatenate([self.begins, self.ends]))


@dataclass(frozen=True)
class Pause:
    """A pause after a clip."""

    behind: int  # Index of the clip before it
    source: ClipSource  # The clip in place that is played
    n_frames: int


def play(
    player: PlayerState,
    library: ClipLibrary,
    lengths: Sequence[int] | None = None,
    pauses: Sequence[Pause] = (),
) -> Playing:
    """Return a player's clips, cut to given lengths, with pauses.

    `lengths`: Frames of each clip, all by default. A clip that is cut must have no event.
    """
    entries = np.asarray(player.entries).tolist()
    whole = [int(library.n_frames[entry]) for entry in entries]
    lengths = whole if lengths is None else list(lengths)
    after = {pause.behind: pause for pause in pauses}
    firsts = np.cumsum([0, *whole])
    parts: list[Part] = []
    rows: list[IntArray] = []
    begins, ends, instants, at = [], [], [], 0
    for clip, (entry, length) in enumerate(zip(entries, lengths, strict=True)):
        kept = kept_frames(whole[clip], length, clip == 0, clip == len(entries) - 1)
        begins.append(at)
        for start, end in kept:
            parts.append(Part(part_of(library.source[entry], start, end), end - start, clip))
            rows.append(firsts[clip] + np.arange(start, end))
        cut = length < whole[clip]
        instants.append(at + ((length - 1) // 2 if cut else library.instant_of(entry)))
        at += length
        ends.append(at)
        if clip in after:
            pause = after[clip]
            parts.append(Part(pause.source, pause.n_frames, clip, waits=True))
            rows.append(np.full(pause.n_frames, rows[-1][-1]))
            at += pause.n_frames
    begins.append(at)
    return Playing(
        tuple(parts), np.array(begins), np.array(ends), np.array(instants), np.concatenate(rows)
    )


def kept_frames(whole: int, length: int, first: bool, last: bool) -> list[tuple[int, int]]:
    """Return the frames [start, end) of a clip of ``whole`` frames that are kept of it.

    >>> kept_frames(100, 20, True, False), kept_frames(100, 20, False, True)
    ([(80, 100)], [(0, 20)])
    >>> kept_frames(100, 21, False, False), kept_frames(100, 100, False, False)
    ([(0, 11), (90, 100)], [(0, 100)])
    """
    if length >= whole:
        return [(0, whole)]
    if first:
        return [(whole - length, whole)]
    if last:
        return [(0, length)]
    return [(0, length - length // 2), (whole - length // 2, whole)]


def part_of(source: ClipSource, start: int, end: int) -> ClipSource:
    """Return frames [start, end) of a clip's source, with the same fraction of its bend."""
    share = (end - start) / (source.end - source.start)
    return replace(
        source, start=source.start + start, end=source.start + end, bend=source.bend * share
    )


# Clips for waiting players: before the first action, between two actions, and after the last.

AT_REST = 0.35
"""Mean speed of the joints, m/s, up to which a body may pause. Chosen by hand on the sample
captures."""
_STILL = 0.12  # Largest displacement of a clip in place, m


def least_lengths(library: ClipLibrary, entries: IntArray, activity: Activity) -> IntArray:
    """Return to how many frames each of a string's clips may be cut.

    Only standing is cut. A clip with an event stays whole, because rules look at its instant.
    """
    whole = np.asarray(library.n_frames)[entries].astype(np.int64)
    for clip, entry in enumerate(np.asarray(entries).tolist()):
        standing = activity.shortest_rest(library.terminals[int(library.terminal[entry])])
        standing = standing if int(library.event_frame[entry]) < 0 else 0
        if standing and float(np.hypot(*library.step[entry, :2])) < _STILL:
            whole[clip] = min(whole[clip], standing)
    return whole


def may_pause(library: ClipLibrary, entries: IntArray, activity: Activity) -> IntArray:
    """Return 1 for clips after which the player may stand: this and the next are at rest there.

    It is 0 everywhere if the grammar has no clip to stand in.
    """
    allowed = np.zeros(len(entries), dtype=np.int64)
    if len(library.rest) and len(_standing(library, activity.rests_of((), False))):
        rest = np.asarray(library.rest)[np.asarray(library.seam_class)[entries]]
        allowed[:-1] = (rest[:-1, 1] <= AT_REST) & (rest[1:, 0] <= AT_REST)
    return allowed


def pause_entry(library: ClipLibrary, entries: IntArray, behind: int, activity: Activity) -> int:
    """Return the entry that is played in a pause after a clip; -1 if the grammar has none.

    It is the entry of the standing actions whose poses are most like those before and after it.
    """
    played = _played(library, entries)
    standing = _standing(library, _behind(activity, played, played[behind]))
    if len(standing) == 0:
        return -1
    kinds = np.asarray(library.seam_class)
    before, after = kinds[entries[behind]], kinds[entries[behind + 1]]
    costs = library.seam[before, kinds[standing]] + library.seam[kinds[standing], after]
    return int(standing[int(np.argmin(costs))])


def lead_in(
    library: ClipLibrary, entries: IntArray, n_frames: int, activity: Activity
) -> tuple[Part, ...]:
    """Return the clips for ``n_frames`` before a string; () if nothing fits.

    A string begins when its delay is over. A player who would begin in the middle of a run takes a
    first step from rest before it.
    """
    played, kinds = _played(library, entries), np.asarray(library.seam_class)
    holds = activity.deed(played[0]) in (*KEEPING, *LOSING)
    standing = _standing(library, activity.rests_of(played, holds))
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


def lead_out(
    library: ClipLibrary, entries: IntArray, n_frames: int, activity: Activity
) -> tuple[Part, ...]:
    """Return the clips after a string: a last step if it ends in motion, then ``n_frames``."""
    played, kinds = _played(library, entries), np.asarray(library.seam_class)
    standing = _standing(library, _behind(activity, played, played[-1]))
    if len(standing) == 0:
        return ()
    behind, parts = len(entries), []
    step = _step(library, int(entries[-1]), 1)
    if step >= 0:
        parts.append(Part(library.source[step], int(library.n_frames[step]), behind))
    last = kinds[entries[-1] if step < 0 else step]
    stood = int(standing[int(np.argmin(library.seam[last, kinds[standing]]))])
    return (*parts, Part(library.source[stood], n_frames, behind, waits=True))


def _behind(activity: Activity, played: Sequence[str], last: str) -> tuple[str, ...]:
    """Return how somebody rests after an action that they did."""
    return activity.rests_of(played, activity.deed(last) in (TAKE, *KEEPING), last)


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


def _standing(library: ClipLibrary, actions: Sequence[str]) -> IntArray:
    """Return entries, as captured, that stay in place, of the first of the actions that has any."""
    for name in actions:
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
