"""What a generated motion shows of what was asked, and where its frames come from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb import store
from motiondb.database.generate.generating import Generated
from motiondb.learning.learned import Learned
from motiondb.learning.making.action_symbols import word_numbers
from motiondb.learning.making.motion_making import RECOGNISED_FROM, frame_probabilities
from motiondb.records import MOTION_FPS

_LEFT_OUT = 2.0
"""Frames of a capture between two frames of a motion, above which some were left out."""


@dataclass(frozen=True)
class ShownAction:
    """An action of a generated motion, and whether the motion shows it.

    Attributes
    ----------
    words : tuple of str
        Its words.
    start : float
        Start of its part of the motion, seconds.
    end : float
        End of its part, seconds.
    probability : float
        Of its words the smallest mean probability over the part, as recognised in the motion alone.
    is_shown : bool
        Whether the motion counts as showing it: it is more probable than not.
    """

    words: tuple[str, ...]
    start: float
    end: float
    probability: float
    is_shown: bool


@dataclass(frozen=True)
class Stretch:
    """Frames of a motion that follow one another in one capture.

    Attributes
    ----------
    start : float
        Seconds of the motion.
    end : float
        Seconds of the motion.
    capture : str
        Name of the capture; "" where the frames were drawn from the model.
    source_start : float
        Seconds of the capture.
    licence : str
        Licence of the capture, "unknown" where none is given.
    edits : tuple of str
        What was done to the frames.
    """

    start: float
    end: float
    capture: str
    source_start: float
    licence: str
    edits: tuple[str, ...]


def shown_actions(learned: Learned, made: Generated) -> tuple[ShownAction, ...]:
    """Return what the motion shows of each asked action.

    Parameters
    ----------
    learned : Learned
        What was learned.
    made : Generated
        The generated motion.
    """
    probabilities, _ = frame_probabilities(learned, made.motion)
    found = []
    for words, (start, end) in zip(made.actions, made.spans):
        low = min(start, made.motion.n_frames - 1)
        part = probabilities[low : max(end, low + 1), word_numbers(learned, words)]
        least = float(part.mean(axis=0).min())
        found.append(
            ShownAction(
                words, start / MOTION_FPS, end / MOTION_FPS, least, least >= RECOGNISED_FROM
            )
        )
    return tuple(found)


def stretches(found: store.Provenance) -> tuple[Stretch, ...]:
    """Return the stretches of a motion, from the origin of its frames."""
    numbers, frames = found.source_numbers, found.source_frames
    if not len(numbers):
        return ()
    breaks = (np.diff(numbers) != 0) | (np.abs(np.diff(frames)) > _LEFT_OUT)
    bounds = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(numbers)]
    runs = []
    for start, end in pairwise(bounds):
        source = found.sources[number] if (number := int(numbers[start])) >= 0 else None
        said = (part for edit in found.edits[start:end] for part in edit.split(", "))
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
