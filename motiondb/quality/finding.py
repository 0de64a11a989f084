"""What is said about a capture: findings with their measure, and what cannot be told."""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.records import FloatArray

NEEDS = "needs"  # Something that was not captured: furniture, a bar, a partner, a treadmill
FAULT = "fault"  # Not as a body moves
FILE = "file"  # Not the unit or the rate that the file says


@dataclass(frozen=True)
class Box:
    """Where something has to stand that was not captured: a box along the axes of the world."""

    centre: tuple[float, float, float]
    """x, y, z in metres, y up, in the world of the capture."""
    size: tuple[float, float, float]
    """Whole lengths along x, y and z, metres."""


@dataclass(frozen=True)
class Finding:
    """One thing that a capture lacks, from when to when, and how much of it."""

    kind: str
    """Such as "sits", "stands on", "hangs", "jumps", "frozen", "rate"."""
    group: str
    """"needs", "fault" or "file"."""
    start: float
    """Seconds from the beginning of the capture."""
    end: float
    """Seconds; the interval is half-open."""
    measure: float
    """What was measured, in `unit`."""
    unit: str
    """Such as "m", "m/s", "m/s2", "s" or "times"."""
    threshold: float
    """The value from which on it is said, in `unit`."""
    part: str
    """Of the body, such as "seat", "hands", "l_wrist"; "body": all of it."""
    sentence: str
    """The finding in words."""
    place: tuple[float, float, float] | None = None
    """Of the part, x, y, z in metres, y up; None: everywhere."""
    box: Box | None = None
    """What has to stand there, where a place is known."""


@dataclass(frozen=True, eq=False)
class Assessed:
    """All that is said about one capture."""

    findings: tuple[Finding, ...]
    untold: tuple[str, ...]
    """What cannot be told of this capture, such as "cannot say whether the rate is right: no
    jump"."""
    seconds: FloatArray
    """array (seconds,): a number from 0 to 1 for each second that was begun; those that need
    something are not lowered."""
    floor: float
    """Height of the floor in the world of the capture, metres."""
    flights: tuple[tuple[float, float], ...]
    """(gravity in m/s2, its standard error) of every flight that can be believed."""

    @property
    def mean(self) -> float:
        """Mean of the numbers of the seconds."""
        return float(self.seconds.mean())


def times(start: float, end: float) -> str:
    """When something is, in words.

    >>> times(2.94, 8.71), times(0.0, 0.008)
    ('2.9 to 8.7 s', '0.00 to 0.01 s')
    """
    places = 1 if end - start >= 0.1 else 2
    return f"{start:.{places}f} to {end:.{places}f} s"
