"""Excerpts cut by what happens in the motion: measured words, and poses to begin and end with.

Where an action has a measured word that its captures can show ("stand up", "stop"), every excerpt
is cut to the part of its stretch that goes furthest that way, and what is missing of the full
amount is a cost. An excerpt that would begin or end in an unusual pose, such as upside down, is
extended to a more usual one near by.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motiondb.generate.direction import OCCURRING, furthest_part, gone
from motiondb.generate.excerpts import LONGEST, SHORTEST, Excerpt
from motiondb.generate.occurrences import find_occurrences
from motiondb.records import FloatArray

REACHED = 0.5
"""Share of the full amount of a direction that the best excerpt must reach for the direction to be
honoured."""
DIRECTION_WEIGHT = 3.0  # Cost of an excerpt that does not go in the direction at all, nats
NOT_DONE = 6.0
"""Further cost of an excerpt that does not reach ``REACHED``, nats: it would be told as not
shown."""
_AHEAD = {"stop": 1.0, "start": 0.0}
"""Share of the time that a short part is extended by which lies before it. A stop is not followed
by what comes after it, nor a start preceded by what came before."""
MARGIN = 12  # Frames (0.4 s) before and after the part that goes in the direction
WHOLE = 24
"""Frames (0.8 s) before and after hops, kicks and punches, so that these are whole and a cut may
still be moved inwards by half a second."""
FURTHER = 36  # Frames (1.2 s) by which an excerpt may be extended to a usual pose
UNUSUAL = 2.0
"""Mean squared distance from the mean pose, in variances, above which a pose is unusual."""


def direct(
    excerpts: Sequence[Excerpt],
    tracks: Mapping[int, FloatArray],
    directions: Sequence[str],
    longest: int = LONGEST,
) -> tuple[list[Excerpt], tuple[str, ...]]:
    """Cut excerpts to go in the directions of an action, and say which directions are honoured."""
    honoured: list[str] = []
    directed = list(excerpts)
    for direction in directions:
        cut = [_cut(e, tracks[e.capture], direction, longest) for e in directed]
        amounts = np.array([gone(tracks[e.capture][e.start : e.end], direction) for e in cut])
        if amounts.max(initial=0.0) < REACHED:
            continue
        costs = DIRECTION_WEIGHT * np.clip(1.0 - amounts, 0.0, 2.0) + NOT_DONE * (amounts < REACHED)
        directed = [replace(e, score=e.score - c) for e, c in zip(cut, costs)]
        honoured.append(direction)
    unique = {(e.capture, e.start, e.end): e for e in sorted(directed, key=lambda e: e.score)}
    return sorted(unique.values(), key=lambda e: -e.score), tuple(honoured)


def _cut(excerpt: Excerpt, path: FloatArray, direction: str, longest: int) -> Excerpt:
    """The part of the excerpt's stretch that goes furthest in a direction."""
    low, high = excerpt.stretch
    first, behind = furthest_part(path[low:high], direction, longest)
    margin = MARGIN
    if direction in OCCURRING:
        margin = WHOLE
        for begin, over in find_occurrences(path[low:high], direction):
            if begin < behind and first < over:
                first, behind = min(first, begin), max(behind, over)
    start, end = max(low + first - margin, 0), min(low + behind + margin, len(path))
    missing = max(SHORTEST - (end - start), 0)
    start = max(start - round(missing * _AHEAD.get(direction, 0.5)), 0)
    if direction != "stop":
        end = max(end, start + SHORTEST)
    return replace(excerpt, start=start, end=min(end, len(path)))


def complete(excerpt: Excerpt, unusual: FloatArray) -> Excerpt:
    """Extend an excerpt that begins or ends in an unusual pose; `unusual` (frames,)."""
    start, end = excerpt.start, min(excerpt.end, len(unusual))
    if unusual[end - 1] > UNUSUAL:
        end += int(np.argmin(unusual[end - 1 : end + FURTHER]))
    if unusual[start] > UNUSUAL:
        before = unusual[max(start - FURTHER, 0) : start + 1]
        start -= len(before) - 1 - int(np.argmin(before))
    return replace(excerpt, start=start, end=end)
