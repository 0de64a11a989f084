"""What a motion shows: words over time, and the words of the segments of a capture.

The probability of a word comes from a map of its own
(:mod:`motiondb.meaning.description_map`), fitted to the captions that the database holds now.
Where its calibration was not learned (with a start), the probability is that of the word map.

Three sources say what a segment of a stored capture shows:

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

from motiondb.body.features import FEATURE_STEP
from motiondb.language.vocabulary import as_said
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import recognise
from motiondb.meaning.description_map import score_probabilities
from motiondb.meaning.place_fitting import window_vectors
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.search.asked_words import AskedWords
from motiondb.tabled import Tupled


@dataclass(frozen=True)
class Description:
    """The words of an interval of a motion."""

    start: float
    end: float
    # Words with their probabilities, most probable first; None where no own caption has checked the
    # probability (``motiondb.learn.checking``)
    words: tuple[tuple[str, float | None], ...]
    symbols: tuple[int, ...] = ()  # Symbols of the interval's segments


def describe(learned: Learned, motion: Motion, n_words: int = 5) -> tuple[Description, ...]:
    """The words of a motion over time; neighbours with the same likeliest words become one."""
    seen = recognise(learned, motion)
    starts, ends, symbols = seen.starts, seen.ends, seen.symbols
    probabilities = word_probabilities(learned, seen.window_vectors()) * learned.is_known()
    groups: list[list[int]] = []
    for n, row in enumerate(probabilities):
        likeliest = set(np.argsort(-row)[:2])
        if groups and set(np.argsort(-probabilities[groups[-1]].mean(axis=0))[:2]) == likeliest:
            groups[-1].append(n)
        else:
            groups.append([n])
    seconds, names = FEATURE_STEP / MOTION_FPS, learned.association.words
    answers = []
    for group in groups:
        mean = np.average(probabilities[group], axis=0, weights=(ends - starts)[group])
        order = [w for w in np.argsort(-mean, kind="stable")[:n_words] if mean[w] > 0.0]
        answers.append(
            Description(
                round(float(starts[group[0]]) * seconds, 3),
                round(min(float(ends[group[-1]]) * seconds, motion.n_frames / MOTION_FPS), 3),
                tuple(
                    (as_said(names[w]), float(mean[w]) if learned.checked[w] else None)
                    for w in order
                ),
                tuple(int(s) for s in symbols[group]),
            )
        )
    return Tupled(answers)


def word_probabilities(learned: Learned, vectors: FloatArray) -> FloatArray:
    """Probabilities of the learned words in intervals (n, words), from `vectors` (n, columns)."""
    described = learned.description_map
    if described is None or learned.description_calibration is None:
        return learned.word_map.probabilities(vectors)
    return score_probabilities(described.scores(vectors), learned.description_calibration)


@dataclass(frozen=True, eq=False)
class SegmentWords:
    """Words of the segments of one capture."""

    probabilities: FloatArray  # (segments, words): probability that a segment shows a word
    # (segments, words): whether a probability comes from aligning captions of the whole capture
    aligned: NDArray[np.bool_]


def segment_words(asked: AskedWords, capture: int) -> SegmentWords:
    """The words of every segment of a capture."""
    learned = asked.learned
    rows = learned.rows[capture]

    def seen() -> FloatArray:
        vectors = window_vectors(learned.segments, learned.segment_rows, [rows])
        return word_probabilities(learned, vectors)

    is_known = asked.is_known()
    probabilities = asked.widened(learned.kept("words", capture, seen)) * is_known
    aligned = np.zeros(probabilities.shape, dtype=bool)
    if learned.places is not None and capture in learned.places.words:
        listed = np.array(learned.places.words[capture])
        kept = is_known[listed]
        words, shown = listed[kept], learned.places.shown[capture][:, kept]
        aligned[:, words] = shown > probabilities[:, words]
        probabilities[:, words] = np.maximum(shown, probabilities[:, words])
    said = asked.said_places.get(capture)
    if said is not None:
        probabilities[said > 0.0] = 1.0
        aligned[said > 0.0] = False
    return SegmentWords(probabilities, aligned)
