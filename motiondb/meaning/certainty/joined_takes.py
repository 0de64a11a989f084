"""Short captures of one action, joined to takes in which the place of every action is known.

No manual labels are needed: the true interval of an action is that of its short capture in the
joined take. Captures of one performer are joined, as in a real take, and captures of two
performers, which gives more combinations of actions than any one performer shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.counting import capture_rows
from motiondb.meaning.places.place_fitting import Written
from motiondb.records import MOTION_FPS, FloatArray, IntArray, SegmentTable

SHORTEST, LONGEST = 2.0, 20.0
"""Largest duration of a capture that is joined, seconds: longer ones often show other actions
too."""
FEWEST_PARTS, MOST_PARTS = 3, 6
"""Number of captures in a joined take, about the number of exercises in a real long take."""
MOST_OF_PAIR, MOST_PAIRS = 18, 30
"""Number of captures of two performers that are joined in one draw, and of pairs of performers in
one draw; bounds on the duration of learning."""


@dataclass(frozen=True, eq=False)
class ShortCapture:
    """A short capture of one action."""

    standardised: FloatArray  # (segments, columns): standardised scores and movement
    starts: IntArray  # (segments,): first frames
    ends: IntArray  # (segments,): last frames + 1
    words: tuple[int, ...]  # Numbers of the words of its action
    group: str


@dataclass(frozen=True)
class JoinedPart:
    """One capture of a joined take."""

    start: int
    end: int  # Last frame + 1
    words: tuple[int, ...]  # Numbers of the words of its action
    group: str


@dataclass(frozen=True, eq=False)
class JoinedTake:
    """Joined short captures, and the interval of each."""

    standardised: FloatArray  # (segments, columns): standardised scores and movement
    starts: IntArray  # (segments,): first frames
    ends: IntArray  # (segments,): last frames + 1
    parts: tuple[JoinedPart, ...]  # The captures, in order

    @property
    def groups(self) -> frozenset[str]:
        """The performer."""
        return frozenset(part.group for part in self.parts)


@dataclass(frozen=True)
class PlaceQuestion:
    """An action that is searched in a joined take."""

    words: tuple[int, ...]  # Numbers of its words
    group: str  # Performer of the first capture of the action
    true: tuple[tuple[int, int], ...]  # Frames [start, end) that show it, neighbours joined


def short_captures(
    table: SegmentTable,
    standardised: FloatArray,
    written: Written,
    performers: Mapping[int, str],
) -> list[ShortCapture]:
    """Captures whose shortest caption names one action, of a length that can be joined.

    Shapes: `standardised` (segments, columns).
    """
    chosen = []
    for capture, rows in capture_rows(table).items():
        starts, ends = table.starts[rows], table.ends[rows]
        seconds = float(ends[-1] - starts[0]) / MOTION_FPS
        wholes = written.of_whole(capture)
        if not wholes or not SHORTEST <= seconds <= LONGEST or written.of_intervals(capture):
            continue
        actions = min(wholes, key=len)
        if len(actions) == 1:
            words = tuple(dict.fromkeys(actions[0]))
            chosen.append(
                ShortCapture(standardised[rows], starts, ends, words, performers[capture])
            )
    return chosen


def join(captures: Sequence[ShortCapture]) -> JoinedTake:
    """Captures one after another as one take; one capture is a take of one part."""
    starts, ends, parts, at = [], [], [], 0
    for capture in captures:
        shift = at - int(capture.starts[0])
        starts.append(capture.starts + shift)
        ends.append(capture.ends + shift)
        behind = int(ends[-1][-1])
        parts.append(JoinedPart(at, behind, capture.words, capture.group))
        at = behind
    return JoinedTake(
        np.concatenate([capture.standardised for capture in captures]),
        np.concatenate(starts),
        np.concatenate(ends),
        tuple(parts),
    )


def join_captures(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Join captures of one performer in random order, each at most once."""
    takes = []
    for group in sorted({capture.group for capture in captures}):
        takes += _deal([capture for capture in captures if capture.group == group], rng)
    return takes


def join_pairs(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Join captures of two performers each, drawn at random, each capture at most once."""
    groups = sorted({capture.group for capture in captures})
    order = [groups[i] for i in rng.permutation(len(groups))]
    takes = []
    for pair in list(zip(order[::2], order[1::2]))[:MOST_PAIRS]:
        of_pair = [capture for capture in captures if capture.group in pair]
        some = [of_pair[i] for i in rng.permutation(len(of_pair))[:MOST_OF_PAIR]]
        takes += _deal(some, rng)
    return takes


def questions_of(take: JoinedTake) -> list[PlaceQuestion]:
    """Actions of a take with their true intervals, neighbours joined.

    An action that every part of a take shows is left out, because it has no place in it.
    """
    asked = []
    for words in dict.fromkeys(part.words for part in take.parts):
        true: list[tuple[int, int]] = []
        for part in take.parts:
            if set(words) <= set(part.words):
                low = part.start
                if true and true[-1][1] == low:
                    low = true.pop()[0]
                true.append((low, part.end))
        group = next(part.group for part in take.parts if part.words == words)
        if len(take.parts) == 1 or true[0] != (int(take.starts[0]), int(take.ends[-1])):
            asked.append(PlaceQuestion(words, group, tuple(true)))
    return asked


def union_share(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Intersection over union of two intervals.

    >>> union_share((0, 2), (1, 3))
    0.3333333333333333
    """
    shared = max(0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / (first[1] - first[0] + second[1] - second[0] - shared)


def _deal(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Takes of some captures in random order, each capture at most once."""
    left = [captures[i] for i in rng.permutation(len(captures))]
    takes = []
    while len(left) >= FEWEST_PARTS:
        n = min(int(rng.integers(FEWEST_PARTS, MOST_PARTS + 1)), len(left))
        takes.append(join(left[:n]))
        left = left[n:]
    return takes
