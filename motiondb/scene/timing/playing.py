"""What a player plays: parts of the clips that were sampled, and pauses between them.

Sampling puts clips end to end. Polishing may leave out the middle of one in which somebody only
stands (of the first its beginning, of the last its end), and may let a player stand between two.
Everything that looks at the frames of a string, be it for rules, for the ball or for provenance,
finds here which frame of which clip comes when.
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
    """``n_frames`` of one source, or of a pause, which plays its source to and fro.

    ``clip`` : the action that it belongs to; of a pause the one before it, -1 before the first.
    """

    source: ClipSource
    n_frames: int
    clip: int
    waits: bool = False


@dataclass(frozen=True, eq=False)
class Playing:
    """A player's string with its pauses; frames count from the first clip's first.

    Attributes
    ----------
    begins : array (clips + 1,), frames at which clips begin, and where the last one ends.
    ends : array (clips,), the frames behind the clips' last.
    instants : array (clips,), where rules look: the clip's event, else its middle.
    rows : array (frames,), the frame of the string as sampled; of a pause the one before it.
    """

    parts: tuple[Part, ...]
    begins: IntArray
    ends: IntArray
    instants: IntArray
    rows: IntArray

    @property
    def n_frames(self) -> int:
        """Frames of the string with its pauses."""
        return len(self.rows)

    @property
    def pauses(self) -> tuple[tuple[int, int], ...]:
        """The frames [start, end) of pauses."""
        found, at = [], 0
        for part in self.parts:
            if part.waits:
                found.append((at, at + part.n_frames))
            at += part.n_frames
        return tuple(found)

    @property
    def knots(self) -> IntArray:
        """Where clips and pauses begin and end, ascending."""
        return np.unique(np.concatenate([self.begins, self.ends]))


@dataclass(frozen=True)
class Pause:
    """Standing behind the clip ``behind``, in a clip in place, for ``n_frames``."""

    behind: int
    source: ClipSource
    n_frames: int


def play(
    player: PlayerState,
    library: ClipLibrary,
    lengths: Sequence[int] | None = None,
    pauses: Sequence[Pause] = (),
) -> Playing:
    """A player's clips, each ``lengths[k]`` frames of it, with pauses.

    Parameters
    ----------
    lengths : default all; one that is shorter than its clip must be of a clip without an event.
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
    """The frames [start, end) of a clip of ``whole`` that are kept where ``length`` are.

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
    """Frames [start, end) of a clip's source; the same share of its bend."""
    share = (end - start) / (source.end - source.start)
    return replace(
        source, start=source.start + start, end=source.start + end, bend=source.bend * share
    )
