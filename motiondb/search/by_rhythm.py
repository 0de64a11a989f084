"""Search by a rhythm: the intervals of captures whose steps fall at tapped times.

A part of a capture goes from a step to another one, on which the first and the last tap lie; so it
may begin anywhere, and be somewhat slower or faster than was tapped. Between these two, taps and
steps are paired in their order::

    for every step j and every later one k:        # s: times of steps, t: of the taps 1 to n, s
        r = (s_k - s_j) / (t_n - t_1)              # .8 to 1.25
        off = least sum, over all pairings, of
              |(s - s_j) / r - (t - t_1)|          # for each pair
              GAP                                  # for each tap without step, step without tap
        deviation = off / (n - 2) + PER_OCTAVE * |log2 r|
    best part of each capture; captures in the order of their deviations

The sum is the distance between two rows of instants of Victor and Purpura, "Nature and precision of
temporal coding in visual cortex: a metric-space analysis", Journal of Neurophysiology 76, 1996,
with 1/q = ``GAP``. For example, taps at 0, .5 and 1.2 s are .1 s off steps at 3, 3.6 and 4.2 s.

Which foot steps does not matter; steps are those of :func:`motiondb.body.gait.step_times`: who
lifts the feet in place makes none.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.search.nearest_parts import Part

GAP = 0.15
"""Seconds by which a tap without step, or a step without tap, is off. People who tap are some 30 ms
off, and a walk has a step every half second."""
SLOWEST = 1.25  # Times by which a part is slower than was tapped at most; and faster
PER_OCTAVE = 0.1  # Seconds that half or twice the tempo counts as
MOST_OFF = 0.06
"""Largest deviation of a part in a rhythm, s: even steps are .07 off a skip of .25 and .45 s."""
LEAST_APART, LONGEST, FEWEST, MOST = 0.1, 60.0, 3, 200  # s, s, taps, taps
AT_ONCE = 2_000_000  # Steps of parts that are compared at once: some 50 MB


def read_rhythm(taps: str | Sequence[float] | FloatArray) -> FloatArray:
    """The times of taps since the first one, s: array (taps,); as text "0 .5 1", or numbers.

    Raises
    ------
    QueryError
        If they are no 3 to 200 ascending numbers, at least .1 s apart, of at most 60 s.

    >>> read_rhythm("2 2.5 3.25").tolist()
    [0.0, 0.5, 1.25]
    """
    given = taps.replace(",", " ").replace("_", "?").split() if isinstance(taps, str) else taps
    try:
        times = np.asarray([float(each) for each in given])
    except (TypeError, ValueError):
        times = np.zeros(0)
    if not FEWEST <= len(times) <= MOST:
        raise QueryError(
            f"rhythm: expected the times of {FEWEST} to {MOST} taps in seconds, such as "
            f"'0 0.5 1 1.5', found something else: {str(taps)[:60]!r}."
        )
    apart = np.diff(times)
    if not np.isfinite(times).all() or not (apart >= LEAST_APART - 1e-9).all():
        raise QueryError(
            f"rhythm: expected times of taps in their order, {LEAST_APART:g} s apart or more, "
            f"found {str(taps)[:60]!r}. Times are in seconds."
        )
    if times[-1] - times[0] > LONGEST:
        raise QueryError(
            f"rhythm: expected taps of {LONGEST:g} s at most, found {times[-1] - times[0]:.3g} s. "
            "Times are in seconds."
        )
    return times - times[0]


def parts_in(
    steps: Mapping[int, FloatArray], taps: FloatArray, allowed: Collection[int]
) -> list[Part]:
    """The part of each capture whose steps fall at taps best; of those that step long enough.

    `steps`: Capture -> times of its steps, ascending, s. `taps`: As ``read_rhythm`` gives them.
    """
    numbers = sorted(set(allowed) & steps.keys())
    if not numbers:
        return []
    times = np.concatenate([steps[number] for number in numbers])
    owners = np.repeat(np.arange(len(numbers)), [len(steps[number]) for number in numbers])
    # captures one behind the other, so far apart that no part goes from one to the next
    line = times + owners * (times.max(initial=0.0) + SLOWEST * taps[-1] + 1.0)
    low = np.searchsorted(line, line + taps[-1] * (1.0 / SLOWEST - 1e-9))
    high = np.searchsorted(line, line + taps[-1] * (SLOWEST + 1e-9))
    first = np.repeat(np.arange(len(line)), high - low)
    nth = np.arange(len(first)) - np.repeat(np.cumsum(high - low) - (high - low), high - low)
    last = low[first] + nth
    off = np.concatenate([_off(line, taps, *part) for part in _batches(first, last)])
    size = (line[last] - line[first]) / taps[-1]
    deviation = off + PER_OCTAVE * np.abs(np.log2(size))
    order = np.lexsort((first, deviation, owners[first]))
    best = order[np.diff(owners[first][order], prepend=-1) > 0]
    return [
        Part(
            numbers[owners[first[n]]],
            round(MOTION_FPS * times[first[n]]),
            round(MOTION_FPS * times[last[n]]),
            float(deviation[n]),
            _say(off[n], size[n], int(last[n] - first[n]) + 1 - len(taps)),
        )
        for n in best.tolist()
    ]


def _batches(first: IntArray, last: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Parts from step to step, as many at once as memory has room for; at least one batch."""
    widest = int((last - first).max(initial=1))
    cuts = range(0, max(len(first), 1), max(AT_ONCE // widest, 1))
    return [(first[cut : cut + cuts.step], last[cut : cut + cuts.step]) for cut in cuts]


def _off(line: FloatArray, taps: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """How far taps are from the steps of parts, s: array (parts,); `line` (steps,): their times."""
    counts = last - first - 1  # steps between the first and the last one
    nth = np.arange(counts.max(initial=0))
    inside = first[:, None] + 1 + nth
    stretched = taps[-1] / (line[last] - line[first])
    at = (line[np.minimum(inside, len(line) - 1)] - line[first][:, None]) * stretched[:, None]
    # sums[p, m]: the least one of the taps so far and the first m steps of part p
    gaps = GAP * np.arange(len(nth) + 1)
    sums = np.broadcast_to(gaps, (len(first), len(gaps)))
    for tap in taps[1:-1]:
        paired = np.minimum(sums[:, :-1] + np.abs(at - tap), sums[:, 1:] + GAP)
        alone = np.concatenate([sums[:, :1] + GAP, paired], axis=1)
        # or the last step has no tap: sums[m] = min(alone[m], sums[m - 1] + GAP)
        sums = np.minimum.accumulate(alone - gaps, axis=1) + gaps
    found: NDArray[np.float64] = sums[np.arange(len(first)), counts]
    return found / (len(taps) - 2)


def _say(off: float, size: float, more: int) -> str:
    """What was measured of a part: how far off, at which tempo, how many steps more.

    >>> _say(0.021, 0.8, -1)
    '21 ms off the rhythm, 1.25 times as fast, 1 step fewer'
    """
    said = [f"{1000.0 * off:.0f} ms off the rhythm"]
    if abs(size - 1.0) > 0.005:
        said.append(f"{1.0 / size:.2f} times as fast")
    if more:
        steps = "step" if abs(more) == 1 else "steps"
        said.append(f"{abs(more)} {steps} {'more' if more > 0 else 'fewer'}")
    return ", ".join(said)
