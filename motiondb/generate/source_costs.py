"""A source of an action, and the costs and gains of its motion relative to the other sources.

The notation is that of :mod:`motiondb.generate.action_sources`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.generate.competing_words import (
    LEAST_CAPTURES,
    describe_segments,
    neighbour_gain,
    rival_gain,
)
from motiondb.learn.learned import Learned
from motiondb.records import FloatArray, IntArray

NEIGHBOUR_WEIGHT = 1.0  # N
RIVAL_WEIGHT = 0.5
"""R. Of 0, .25, .5 and 1, on the best excerpts of 36 actions of CMU: the judge finds the asked
action before all others in .35, .37, .42, .42 (at N = 1; with R = .5 and N = 0 in .37)."""
MOST_COMPARED = 100
"""Number of sources, the best without q and r, for which q and r are computed. Chosen by hand:
more take longer."""
UNLIKE_WEIGHT = 0.4  # D
RARE_WEIGHT = 0.12
"""A. Chosen by hand, so that a plain kick and plain twists win against those of an acrobat; .08 to
.16 make little difference to how many excerpts the judge finds right (.61 to .64 of 36 actions of
CMU)."""
RARE = 60.0
"""Nats a frame. On CMU the median over the captures of a performer is 30 to 60 in walking,
exercises and karate, 64 in ballet, 132 in acrobatics."""


@dataclass(frozen=True, eq=False)
class Source:
    """A capture that can show an action."""

    capture: int
    rows: slice  # Its rows of the segment table
    starts: IntArray  # (segments,): first frames, at 30 frames a second
    ends: IntArray  # (segments,): last frames + 1
    values: FloatArray  # (segments,): v
    cost: float  # Cost of the module's docstring, and further costs
    is_placed: bool = True  # Whether the motion says where in the capture the action is
    # Words that its captions say in one action with those of the action
    beside: frozenset[int] = frozenset()


def with_rarity(learned: Learned, sources: Sequence[Source]) -> list[Source]:
    """Add the cost of motion that is rarer than another performer's motion for the action."""
    rare = {s.capture: float(-learned.segments.backgrounds[s.rows].min()) for s in sources}
    of: dict[str, list[float]] = {}
    for capture, value in rare.items():
        of.setdefault(learned.performers[capture], []).append(value)
    usual = max(RARE, min((float(np.median(v)) for v in of.values()), default=RARE))
    return [
        replace(s, cost=s.cost + RARE_WEIGHT * max(rare[s.capture] - usual, 0.0)) for s in sources
    ]


def against_rivals(
    learned: Learned, sources: Sequence[Source], words: frozenset[int]
) -> list[Source]:
    """Add N q + R r; sources that are not compared get the least that another one got."""
    order = sorted(range(len(sources)), key=lambda n: sources[n].cost - _peak(sources[n]))
    if not order:
        return []
    others = describe_segments(learned)
    known = {int(w) for w in np.flatnonzero((others.says > 0.0).sum(axis=0) >= LEAST_CAPTURES)}
    gains = {}
    for n in order[:MOST_COMPARED]:
        capture, vectors = sources[n].capture, learned.standardised[sources[n].rows]
        gains[n] = NEIGHBOUR_WEIGHT * neighbour_gain(others, capture, vectors, words)
        evidence = learned.unplaced.get(capture)
        if evidence is not None and words:
            rivals = known - words - sources[n].beside
            gains[n] = gains[n] + RIVAL_WEIGHT * rival_gain(evidence, words, rivals)
    least = np.float64(min(float(gain.min()) for gain in gains.values()))
    return [replace(s, values=s.values + gains.get(n, least)) for n, s in enumerate(sources)]


def with_distance(learned: Learned, sources: Sequence[Source]) -> list[Source]:
    """Add the cost of posture and travel that are unlike those of the other sources."""
    n = learned.n_posture_and_travel
    if n == 0 or len(sources) < 3:
        return list(sources)
    columns = learned.standardised[:, -n:]
    spread = columns.std(axis=0) + 1e-9
    peaks = np.stack(
        [_weighted(columns[s.rows] / spread, s.values, s.ends - s.starts) for s in sources]
    )
    gain = np.array([_peak(s) - s.cost for s in sources])
    weight = np.exp(np.maximum(gain - gain.max(), -20.0))
    total = weight.sum() - weight  # of the others
    centre = (weight @ peaks - weight[:, None] * peaks) / np.maximum(total, 1e-9)[:, None]
    centre[total < 1e-6] = peaks[total < 1e-6]
    distance = np.mean((peaks - centre) ** 2, axis=1)
    return [replace(s, cost=s.cost + UNLIKE_WEIGHT * float(d)) for s, d in zip(sources, distance)]


def _weighted(columns: FloatArray, values: FloatArray, frames: IntArray) -> FloatArray:
    """Mean of columns over the segments of largest value: array (columns,)."""
    weight = frames * np.exp(values - values.max())
    return np.asarray(weight @ columns / weight.sum())


def _peak(source: Source) -> float:
    return float(source.values.max())
