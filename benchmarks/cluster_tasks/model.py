"""What a command takes with more hours and more workers, from what it took with a few.

    T(h, w) = own(h) + work(h) / w

`own` are processor seconds of the asking process and of the scheduler, of which there is one each,
`work` those of all workers, at h hours and w workers; nothing that one waits for meanwhile counts.
So T is no duration: the clock shows more. Every quantity is a line through the values at
two sizes, over the hours (the search for copies: over their square; the memory of a worker: over
the hours of its share). The memory of ``add``, which works in batches, is taken as that of the
larger size. So a third size shows what the lines are worth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Row = Mapping[str, Any]
COPIES = "likely_places, s"  # Work of the search for copies, which looks for all takes in all takes


@dataclass(frozen=True)
class Taken:
    """What a command takes."""

    own: float  # Processor seconds of the asking process and the scheduler
    work: float  # Processor seconds of all workers
    received: float  # Bytes that all workers receive
    own_peak: float  # Largest memory of the asking process, bytes
    worker_peak: float  # Largest memory of a worker, bytes

    def seconds(self, n_workers: float) -> float:
        """T for so many workers, processor seconds on the longest path."""
        return self.own + self.work / n_workers


def taken(row: Row) -> Taken:
    """What a measured command took."""
    return Taken(
        row["own, s"] + row["scheduler, s"],
        row["worked, s"],
        row["received, bytes"],
        row["own peak, bytes"],
        row["worker peak, bytes"],
    )


def predict(known: Sequence[Row], hours: float, n_workers: float) -> Taken:
    """What a command takes, from the rows of it at two sizes with equally many workers."""
    sizes = [row["hours"] for row in known]
    shares = [row["hours"] / row["workers"] for row in known]

    def over_hours(name: str) -> float:
        return line(sizes, [row[name] for row in known], hours)

    copies = [row.get(COPIES, 0.0) for row in known]
    others = [row["worked, s"] - part for row, part in zip(known, copies)]
    squares = [size**2 for size in sizes]
    first, last = map(taken, known)
    in_batches = known[-1]["command"] == "add"
    shared = line(shares, [row["worker peak, bytes"] for row in known], hours / n_workers)
    return Taken(
        line(sizes, [first.own, last.own], hours),
        line(sizes, others, hours) + line(squares, copies, hours**2),
        over_hours("received, bytes"),
        last.own_peak if in_batches else over_hours("own peak, bytes"),
        last.worker_peak if in_batches else shared,
    )


def line(places: Sequence[float], values: Sequence[float], place: float) -> float:
    """Value at a place of the line through two points.

    >>> line([1.0, 3.0], [10.0, 14.0], 10.0)
    28.0
    """
    (a, b), (low, high) = places, values
    return low + (high - low) * (place - a) / (b - a)
