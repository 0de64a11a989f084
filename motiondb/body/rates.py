"""Frame rates of frame times of few digits: 0.033 s is what 30 frames a second round to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from motiondb.records import FloatArray

_RATES = (24.0, 25.0, 30.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0)
"""Frames a second that cameras, games and optical systems have."""
_OTHER_RATES = (
    *(fps * 1000.0 / 1001.0 for fps in (24, 30, 60, 120, 240)),
    *(48.0, 72.0, 75.0, 80.0, 125.0, 144.0, 150.0, 180.0),
    *(250.0, 300.0, 360.0, 400.0, 480.0, 500.0, 1000.0),
)
"""Less usual ones; those of television are a thousandth below the whole number."""
_FEW_DIGITS = 5e-5
"""A written time that is within this share of a rate's says which rate it is: frame times are
written with five digits or more, and 29.97 lies ten times as far from 30."""


def find_rate(seconds: float, written: str = "") -> tuple[float, tuple[str, ...]]:
    """Find the frames per second that were written as a frame time, with notes.

    The most usual rate is taken that rounds to (or is cut to) the digits that are written, else a
    whole number, else what is written; the last two are told where the digits are few. `written`:
    the text of the time; "": all digits hold.

    >>> find_rate(0.0083333, "0.0083333")[0], find_rate(0.033, "0.033")[0]
    (120.0, 30.0)
    >>> round(find_rate(0.0333667)[0], 3)
    29.97
    >>> find_rate(0.01, "0.01"), find_rate(0.04, "0.04")
    ((100.0, ()), (25.0, ()))
    >>> find_rate(0.008, "0.008")[1][0][:61]
    'The frame time 0.008 fits 120 and 125 frames a second; 120 is'
    """
    mantissa, _, exponent = written.lower().partition("e")
    step = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])) if written else 0.0
    slack = max(step * 0.500001, _FEW_DIGITS * seconds)
    whole = float(round(1.0 / seconds))

    def fitting(rates: Sequence[float]) -> list[float]:
        over = {fps: 1.0 / fps - seconds for fps in rates if fps}
        near = [f for f, o in over.items() if abs(o) <= slack or 0 <= o < step * 0.999999]
        return sorted(near, key=lambda fps: abs(over[fps]))

    exact = [whole] if abs(whole * seconds - 1.0) < 1e-9 else []
    usual = fitting(_RATES) or fitting(_OTHER_RATES)
    if not usual:
        usual = fitting([whole]) or [1.0 / seconds]
        if exact or step < 1e-3 * seconds:
            return usual[0], ()
        near = sorted(_RATES, key=lambda fps: abs(math.log(fps * seconds)))[:2]
        return usual[0], (
            f"The frame time {written} is that of no usual rate: {usual[0]:.6g} frames a second "
            f"are taken; the nearest usual rates are {near[0]:g} and {near[1]:g}. Give the right "
            "one (--fps) if this is wrong.",
        )
    *others, last = (f"{fps:g}" for fps in sorted({*usual, *exact}))
    is_exact = usual[0] in exact and usual[0] in _RATES
    if not others or is_exact or slack > step:  # or written with five digits or more
        return usual[0], ()
    return usual[0], (
        f"The frame time {written} fits {', '.join(others)} and {last} frames a second; "
        f"{usual[0]:g} is taken. Give the right one (--fps) if this is wrong.",
    )


_SECONDS: Mapping[str, float] = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9})
_EVEN = 0.01  # Share by which steps of few digits differ from their mean
_LEAST: Mapping[str, float] = MappingProxyType({"ns": 1e6, "us": 1e3, "ms": 4.0})
"""Steps of times without a unit above which they are in this one: 1,000 to 1 frames a second."""


def rate_of_times(times: FloatArray, unit: str = "") -> float | None:
    """Return the frames per second of times; None for numbers of frames.

    Without a unit, steps are seconds up to 1, then milli-, micro- or nanoseconds.

    >>> [rate_of_times(np.arange(9) * step) for step in (0.02, 20, 20_000, 2e7)], 1e9
    ([50.0, 50.0, 50.0, 50.0], 1000000000.0)
    >>> rate_of_times(np.round(np.arange(99) / 60.0, 4))
    60.0
    """
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if len(times) > 2:  # rounded times are even over the whole
        whole = float(times[-1] - times[0]) / (len(times) - 1)
        step = whole if abs(whole - step) < _EVEN * step else step
    step *= _SECONDS[unit or next((u for u, least in _LEAST.items() if step >= least), "s")]
    return find_rate(step)[0] if 1e-4 < step < 1.0 else None
