"""Does a made motion show what was asked for? Heard by motiondb itself, stretch by stretch.

The motion is recognised as a new capture would be, from its movement alone; what each stretch says
is compared with the words of its action (``generate.clarity``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.database.learn.learned import WINDOW_MARGIN, Learned, recognise
from motiondb.generate import clarity
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.search import score_vectors

LEAST = 1e-6
"""Probabilities are kept away from 0 and 1 by this much."""


def hear(learned: Learned, motion: Motion) -> tuple[FloatArray, IntArray]:
    """Probability of every word at every frame, array (frames, words), and the symbols found."""
    _, starts, ends, symbols, standardised = recognise(learned, motion)
    margin = WINDOW_MARGIN // FEATURE_STEP
    vectors = score_vectors.interval_vectors(
        standardised, starts, ends, starts - margin, ends + margin
    )
    probabilities = learned.word_map.probabilities(vectors)
    frames = np.repeat(np.repeat(probabilities, ends - starts, axis=0), FEATURE_STEP, axis=0)
    which = np.minimum(np.arange(motion.n_frames), len(frames) - 1)
    return np.clip(frames[which], LEAST, 1.0 - LEAST), symbols


def log_clarity(probabilities: FloatArray, asked: IntArray) -> float:
    """log c of a stretch, mean over its frames and the words asked for (see ``clarity``).

    probabilities : array (frames, words), strictly between 0 and 1.
    """
    said = np.log(probabilities[:, asked]).mean(axis=1)
    unasked = clarity.log_unasked(probabilities, asked)
    return float(np.mean(said + clarity.UNASKED_SHARE * unasked))


def is_heard(probabilities: FloatArray, asked: Sequence[int] | IntArray, least: float) -> bool:
    """Whether every word asked for has at least this mean probability over a stretch."""
    return bool((probabilities[:, asked].mean(axis=0) >= least).all())
