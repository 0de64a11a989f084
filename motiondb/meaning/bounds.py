"""Upper bounds of the log-odds of a question, for all captures at once.

``by_question.search_take`` places the parts of a question in one capture, which takes some 0.1 ms.
Most captures need not be looked at: the log-odds of a requested action are at most

    1/2 (mean over its words of the largest v at any segment) + 1/2 v of the whole capture,

those of an excluded action are at least the same with the smallest v, and the log-odds of all
statements together rise with those of requested and fall with those of excluded actions. Captures
are searched in the order of their bounds until no bound reaches the answers that there are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.question.readings import Reading
from motiondb.meaning.by_words import TakeScores, all_hold
from motiondb.records import FloatArray, IntArray

AT_ONCE = 4096
"""Captures whose log-odds are joined into one array at a time. Chosen by hand: some 10 MB."""
SLACK = 1e-6
"""Nats that a bound may be too low by rounding. Chosen by hand, far above the rounding of doubles
and far below what separates answers."""


@dataclass(frozen=True, eq=False)
class TakeExtremes:
    """The largest and smallest log-odds of every word in every capture."""

    captures: IntArray  # (captures,): numbers of the captures
    highest: FloatArray  # (captures, words): largest log-odds over the segments of the capture
    lowest: FloatArray  # (captures, words): smallest log-odds over its segments
    whole: FloatArray  # (captures, words): log-odds of the whole capture


def take_extremes(takes: Mapping[int, TakeScores]) -> TakeExtremes:
    """Return the extremes of captures, each of which has at least one segment."""
    highest, lowest, each = [], [], list(takes.values())
    for first in range(0, len(each), AT_ONCE):
        some = each[first : first + AT_ONCE]
        firsts = np.cumsum([0, *(len(take.starts) for take in some[:-1])])
        windows = np.concatenate([take.windows for take in some])
        highest.append(np.maximum.reduceat(windows, firsts, axis=0))
        lowest.append(np.minimum.reduceat(windows, firsts, axis=0))
    if not highest:
        none = np.zeros((0, 0))
        return TakeExtremes(np.zeros(0, dtype=np.int64), none, none, none)
    return TakeExtremes(
        np.fromiter(takes, dtype=np.int64),
        np.concatenate(highest),
        np.concatenate(lowest),
        np.stack([take.whole for take in each]),
    )


def upper_bounds(
    extremes: TakeExtremes, readings: Sequence[Reading], number: Mapping[str, int]
) -> FloatArray:
    """Return what the log-odds of a question are at most in each capture: array (captures,)."""
    bounds = np.full(len(extremes.captures), -np.inf)
    for reading in readings:
        np.maximum(bounds, _of_reading(extremes, reading, number), out=bounds)
    return bounds


def _of_reading(extremes: TakeExtremes, reading: Reading, number: Mapping[str, int]) -> FloatArray:
    asked = [
        _of_action(extremes.highest, extremes.whole, action, number, 0.5)
        for first in sorted({part.repeat_of for part in reading.parts})
        for action in reading.parts[first].actions
    ]
    elsewhere = {word for part in reading.parts for action in part.actions for word in action}
    excluded = [
        -all_hold(
            [
                _of_action(
                    extremes.lowest,
                    extremes.whole,
                    action,
                    number,
                    1.0 if elsewhere.issuperset(action) else 0.5,
                )
                for action in exclusion.actions
            ]
        )
        for exclusion in reading.exclusions
    ]
    return all_hold([*asked, *excluded])


def _of_action(
    near: FloatArray,
    whole: FloatArray,
    action: Sequence[str],
    number: Mapping[str, int],
    share: float,
) -> FloatArray:
    columns = [number[word] for word in action]
    inside, outside = near[:, columns].mean(axis=1), whole[:, columns].mean(axis=1)
    bound: FloatArray = share * inside + (1.0 - share) * outside
    return bound
