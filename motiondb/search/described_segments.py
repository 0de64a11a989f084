"""The words of the segments of a capture, from its motion and from its own captions.

Three sources say what a segment shows:

- a caption of an interval, for its words, where the interval lies;
- the motion, as ``describe`` reads it;
- the alignment of the words of a caption with the segments of the whole take
  (:mod:`motiondb.meaning.place_fitting`), where it says more than the motion. A caption of
  a whole take does not say where in the take a word belongs, and how often the alignment is right
  at a single segment was never measured, so its probabilities order words but are not shown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.learn.learned import Learned
from motiondb.meaning.by_words import WINDOW_MARGIN
from motiondb.meaning.score_vectors import interval_vectors
from motiondb.records import FloatArray
from motiondb.search.described_motion import word_probabilities


@dataclass(frozen=True, eq=False)
class SegmentWords:
    """Words of the segments of one capture."""

    probabilities: FloatArray  # (segments, words): probability that a segment shows a word
    # (segments, words): whether a probability comes from aligning captions of the whole capture
    aligned: NDArray[np.bool_]


def segment_words(learned: Learned, capture: int) -> SegmentWords:
    """The words of every segment of a capture."""
    rows = learned.rows[capture]
    starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
    vectors = interval_vectors(
        learned.standardised[rows], starts, ends, starts - WINDOW_MARGIN, ends + WINDOW_MARGIN
    )
    is_known = learned.is_known()
    probabilities = word_probabilities(learned, vectors) * is_known
    aligned = np.zeros(probabilities.shape, dtype=bool)
    if learned.places is not None and capture in learned.places.words:
        listed = np.array(learned.places.words[capture])
        kept = is_known[listed]
        words, shown = listed[kept], learned.places.shown[capture][:, kept]
        aligned[:, words] = shown > probabilities[:, words]
        probabilities[:, words] = np.maximum(shown, probabilities[:, words])
    said = learned.said_places.get(capture)
    if said is not None:
        probabilities[said > 0.0] = 1.0
        aligned[said > 0.0] = False
    return SegmentWords(probabilities, aligned)
