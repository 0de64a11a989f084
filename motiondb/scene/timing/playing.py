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
from motiondb.scene.energy.scene_state import PlayerState


@dataclass(frozen=True)
class Part:
    """Frames of one source, or of a pause, which plays its source forwards and backwards."""

    source: ClipSource
    n_frames: int
    clip: int  # The action that it belongs to; for a pause the one before it, -1 before the first
    waits: bool = False  # Whether it is a pause


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
