"""Bootstrap 95 % intervals, plain and paired.

The unit that is drawn again is what the caller gives one value per: a capture, a word's query, a
take. A paired interval is that of the difference of two methods on the same units; a difference
whose interval contains 0 does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from motiondb.records import FloatArray, IntArray
from quality_protocol.report import Measure

N_DRAWS = 2000
"""Bootstrap samples of an interval. Chosen by hand; not tuned."""


def mean_of(values: Sequence[float] | FloatArray, seed: int = 0) -> Measure:
    """Mean of one value per unit, with its interval."""
    array = np.asarray(values, dtype=float)
    if not len(array):
        return Measure(float("nan"))
    means = array[_draws(len(array), seed)].mean(axis=1)
    return Measure(float(array.mean()), *np.quantile(means, [0.025, 0.975]).tolist())


def statistic_of(statistic: Callable[[IntArray], float], n_units: int, seed: int = 0) -> Measure:
    """A statistic of drawn units (their numbers, with repeats), with its interval.

    >>> str(statistic_of(lambda units: float(np.mean(units > -1)), 10))
    '1.000 (1.000 to 1.000)'
    """
    values = [statistic(units) for units in _draws(n_units, seed)[:500]]
    low, high = np.nanquantile(values, [0.025, 0.975])
    return Measure(statistic(np.arange(n_units)), float(low), float(high))


def weighted_draws(n_units: int, seed: int = 0, n_draws: int = 1000) -> FloatArray:
    """How often each unit is drawn: array (draws, units); row 0 is every unit once."""
    rng = np.random.default_rng(seed)
    drawn = rng.multinomial(n_units, np.full(n_units, 1.0 / n_units), n_draws).astype(float)
    return np.concatenate([np.ones((1, n_units)), drawn])


def weighted_measure(values: FloatArray) -> Measure:
    """A statistic of every draw of :func:`weighted_draws`: its value and interval.

    Captures drawn twice are adjacent in a ranking, which raises every precision; the
    interval is therefore moved to where the draws' mean is the value.
    """
    low, high = np.nanquantile(values[1:] - np.nanmean(values[1:]), [0.025, 0.975])
    return Measure(float(values[0]), float(values[0] + low), float(values[0] + high))


def _draws(n_units: int, seed: int) -> IntArray:
    return np.random.default_rng(seed).integers(0, n_units, (N_DRAWS, n_units))
