"""Where the frames of a generated motion come from, as stretches of captures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS

_LEFT_OUT = 2.0
"""Frames of a capture between two frames of a motion, above which some were left out."""


@dataclass(frozen=True)
class Stretch:
    """Frames of a motion that follow one another in one capture."""

    start: float  # Seconds of the motion
    end: float  # Seconds of the motion
    capture: str  # Name of the capture; "" where the frames were drawn from the model
    source_start: float  # Seconds of the capture
    licence: str  # Licence of the capture, "unknown" where none is given
    edits: tuple[str, ...]  # What was done to the frames


def stretches(provenance: store.Provenance) -> tuple[Stretch, ...]:
    """Return the stretches of a motion, from the origin of its frames."""
    numbers, frames = provenance.source_numbers, provenance.source_frames
    if not len(numbers):
        return ()
    breaks = (np.diff(numbers) != 0) | (np.abs(np.diff(frames)) > _LEFT_OUT)
    bounds = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(numbers)]
    runs = []
    for start, end in pairwise(bounds):
        source = provenance.sources[number] if (number := int(numbers[start])) >= 0 else None
        said = (part for edit in provenance.edits[start:end] for part in edit.split(", "))
        edits = sorted({"blend" if part.startswith("blend") else part for part in said if part})
        runs.append(
            Stretch(
                start / MOTION_FPS,
                end / MOTION_FPS,
                source.name if source else "",
                float(frames[start]) / MOTION_FPS if source else 0.0,
                (source.licence if source else "") or "unknown",
                tuple(edits),
            )
        )
    return tuple(runs)
