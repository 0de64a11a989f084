"""Settings of the search for terminals, and their checks."""

from __future__ import annotations

from dataclasses import dataclass, field

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import tuning
from motiondb.grammar.terminals.objective import REPETITION_WEIGHT

COARSE_STEP = 2  # Frames per frame of the coarse search: 15 frames a second


FEWEST_TRIALS, MOST_TRIALS, TRIED_CELLS = 6_000, 16_000, 32_000_000
"""Bounds of the number of medoids that are tried, and of the number of cells computed for all of
them. Chosen so that a long take needs seconds; see ``docs/grammar.md``, Speed."""


@dataclass(frozen=True)
class TerminalSettings:
    """Settings of the search for terminals.

    Prices were chosen on one take of each sample grammar, the other values by hand.
    """

    shortest: int = 8  # Smallest number of frames of a segment
    longest: int = 75  # Largest number of frames of a segment
    grid: int = 10  # Largest number of frames between candidate cuts
    weight: float = REPETITION_WEIGHT  # w, the share of R
    # Price of a segment, in mean distances of a pose from the mean pose times frames
    segment_price: float = 2.0
    rest: float = 3.0  # Price of a cut at the mean speed of the takes, in the same unit
    most_segments: int | None = None  # N; no bound unless given
    n_starts: int = 16  # Number of starts of the exchange search
    # Number of trials of the exchange search; :func:`trials_for` unless given
    n_trials: int | None = None
    # Settings of the tuning of cuts
    tuning: tuning.TuningSettings = field(default_factory=tuning.TuningSettings)


def trials_for(n_cells: int) -> int:
    """Return the number of medoids to try; the time of a trial grows with the number of cells.

    >>> trials_for(1_000), trials_for(4_000), trials_for(20_000)
    (16000, 8000, 6000)
    """
    return min(MOST_TRIALS, max(FEWEST_TRIALS, TRIED_CELLS // n_cells))


def check_settings(n_terminals: int, settings: TerminalSettings) -> None:
    """Check settings; raise GrammarError with advice if they are not valid."""
    if n_terminals < 1:
        raise GrammarError(
            f"terminals: expected at least 1, found {n_terminals}. Ask for more terminals."
        )
    most = settings.most_segments
    if most is not None and most < n_terminals:
        raise GrammarError(
            f"terminals: expected room for {n_terminals} segments or more, found at most {most} "
            "allowed. Allow more segments, or ask for fewer terminals."
        )
    if not 0.0 <= settings.weight < 1.0:
        raise GrammarError(
            f"terminals: expected a weight of R from 0 to below 1, found {settings.weight}. "
            "Choose one such as 0.1."
        )
    if not 2 <= settings.shortest <= settings.longest or settings.grid < COARSE_STEP:
        raise GrammarError(
            "terminals: expected 2 <= shortest <= longest frames and a grid of 2 frames or more, "
            f"found {settings.shortest}, {settings.longest} and {settings.grid}. Change them."
        )
