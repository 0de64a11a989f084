"""Settings of the segmentation and of the acquisition of symbols.

Apart from what they set, because a search reads them and needs none of the compiled code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from motiondb.records import Within


@dataclass(frozen=True)
class SegmentationSettings:
    """Settings of the first segmentation; lengths in feature frames, 15 a second."""

    shortest: int = 8  # Least length of a segment: 8 frames, half a second. Chosen by hand
    longest: int = 36  # Largest length of a segment: 36 frames, 2.4 s. Chosen by hand
    # Length of the window of a context: 22 frames, 1.5 s. With it more true boundaries were found
    # than with the window used before
    window: int = 22
    # Cost of a boundary, in units of one whitened feature squared. Chosen by hand
    penalty: float = 6.0
    # Cost of a boundary where the pose moves at the capture's mean speed. Chosen by hand
    rest: float = 2.0


AT_LEAST_ONE = Within(1.0, 1e6, "a switch cost and a shortest length of at least 1")


@dataclass(frozen=True)
class RecutSettings:
    """How symbols cut a motion into segments."""

    # Nats that each further symbol costs. Not tuned
    switch_cost: Annotated[float, AT_LEAST_ONE] = 20.0
    # Least length of a segment: 8 feature frames, about half a second
    shortest: Annotated[int, AT_LEAST_ONE] = 8


@dataclass(frozen=True)
class AcquisitionSettings(RecutSettings):
    """Settings of the acquisition; lengths in feature frames, 15 a second.

    The defaults were chosen by hand on the sample data and on CMU captures; no table of
    ``docs/measured/quality.md`` compares other values, except as noted below.
    """

    n_symbols: int | None = None  # Number of symbols. None: the number of least description length
    n_states: int = 6  # States of a symbol. Not tuned
    # Least variance of a state; the variance of all whitened frames is 1. With 0.1 in place of 0.3,
    # and exact removal, planted symbols of synthetic data are recovered
    variance_floor: float = 0.1
    max_symbols: int = 240  # Largest number of symbols. It bounds time and memory
    # Rounds of removing, creating and refitting at most. The search usually ends earlier
    rounds: int = 12
    recuts: int = 3  # Times that the captures are segmented again at most
