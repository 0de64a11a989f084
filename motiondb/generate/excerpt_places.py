"""The places that show an action about as clearly as the best one, in the order of the seeds.

An excerpt that shares more than half of the shorter one with the best excerpt of a place belongs to
it. A place is comparable with the best one if the value of its best excerpt is lower by at most
``COMPARABLE``, or at least ``CLEAR``, and if it does all that is measured, where the best one does.
The captures take turns: first the best place of each capture, then the second one of each, and so
on. Seed s takes place s modulo their number.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.generate.excerpts import Excerpt
from motiondb.records import FloatArray, IntArray

COMPARABLE = 2.0
"""Nats. On the best 24 excerpts of 36 actions of CMU, the judge's probability of excerpts within 2
nats of the best one is lower than that one's by .01 to .04, that of excerpts 2.5 to 3 nats below it
by .13; it finds shown .06 fewer at most within 2 nats, and .14 to .22 fewer at 2 to 3."""
CLEAR = 3.0
"""Nats. On the same excerpts the judge's mean probability from 3 nats on is .97 or more even where
the best one is better by more than 2 nats, and it finds them all shown; below 2 nats it is .83 or
less."""


def number_places(
    excerpts: Sequence[Excerpt], values: FloatArray, does: NDArray[np.bool_]
) -> IntArray:
    """Number the comparable places: array (excerpts,), from 0; -1 for excerpts of no such place.

    Shapes: `values` (excerpts,); `does` (excerpts,), bool.

    >>> where = [(7, 0, 90), (7, 20, 110), (7, 100, 190), (8, 0, 90), (9, 0, 90)]
    >>> excerpts = [Excerpt(c, a, b, 0.0, (a, b)) for c, a, b in where]
    >>> number_places(excerpts, np.array([5.0, 4.9, 4.5, 3.0, 2.9]), np.ones(5, dtype=bool))
    array([ 0,  0,  2,  1, -1])
    """
    numbers = np.full(len(excerpts), -1)
    order = np.argsort(-values, kind="stable").tolist()
    least = min(values[order[0]] - COMPARABLE, CLEAR) if order else 0.0
    firsts: list[int] = []
    of_capture: Counter[int] = Counter()
    turns: list[tuple[int, int]] = []
    for n in order:
        mates = [k for k, first in enumerate(firsts) if _is_same(excerpts[n], excerpts[first])]
        comparable = values[n] >= least
        if mates:
            numbers[n] = mates[0]
        elif comparable and (does[n] or not does[order[0]]):
            numbers[n] = len(firsts)
            firsts.append(n)
            turns.append((of_capture[excerpts[n].capture], len(turns)))
            of_capture[excerpts[n].capture] += 1
    in_turn = np.array([place for _, place in sorted(turns)])
    return np.where(numbers >= 0, np.argsort(in_turn)[numbers], -1)


def _is_same(one: Excerpt, other: Excerpt) -> bool:
    """Whether two excerpts share more than half of the shorter one."""
    shared = min(one.end, other.end) - max(one.start, other.start)
    shorter = min(one.end - one.start, other.end - other.start)
    return one.capture == other.capture and 2 * shared > shorter
