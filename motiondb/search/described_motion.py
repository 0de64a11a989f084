"""The words of a motion over time, with their probabilities.

The probability of a word comes from a map of its own
(:mod:`motiondb.meaning.description_map`),
fitted to the captions that the database holds now. Where its calibration was not learned (with a
start, and in databases of versions that did not learn it), the probability is that of the word map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import recognise
from motiondb.meaning.description_map import score_probabilities
from motiondb.records import MOTION_FPS, FloatArray, Motion


@dataclass(frozen=True)
class Description:
    """The words of an interval of a motion."""

    start: float
    end: float
    # Words with their probabilities, most probable first; None where no own caption has checked the
    # probability (``learning.start.checking``)
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
                tuple((names[w], float(mean[w]) if learned.checked[w] else None) for w in order),
                tuple(int(s) for s in symbols[group]),
            )
        )
    return tuple(answers)


def word_probabilities(learned: Learned, vectors: FloatArray) -> FloatArray:
    """Probabilities of all words of the vocabulary in intervals: array (n, words).

    Shapes: `vectors` (n, columns).
    """
    words, told = learned.word_map, learned.description_map
    if told is None or learned.description_calibration is None:
        return words.probabilities(vectors)
    return learned.widened(
        score_probabilities(told.scores(vectors), learned.description_calibration)
    )
