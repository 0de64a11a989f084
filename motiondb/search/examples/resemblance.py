"""Resemblance of intervals: similarity of their motion, and of the words it suggests.

Notation: v the vector of an interval (:mod:`motiondb.search.vectors.score_vectors`), e(v) the
evidence for every word by the word map (:mod:`motiondb.words.maps.word_map`), v' the vector without
posture and travel. The resemblance of two intervals is

    MEANING_SHARE cos(e(v), e(w)) + (1 - MEANING_SHARE) cos(v', w')

where words were learned, and cos(v, w) otherwise.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray
from motiondb.search.vectors.score_vectors import unit
from motiondb.words.maps.word_map import WordMap

MEANING_SHARE = 0.8
"""Weight of the words in a resemblance, where words were learned.

Chosen among twelve settings by leaving performers out of the CMU training parts
(``docs/quality.md``, "Query by example").
"""


def resemblance(
    vector: FloatArray,
    vectors: FloatArray,
    words: WordMap | None = None,
    *,
    n_posture_and_travel: int = 0,
) -> FloatArray:
    """Similarity of intervals to one interval: array (n,), 1 for the same.

    See the module. Posture and travel depend on the place and the performer, so that with a word
    map they act through the words only. The cosines are sums over symbols and over columns of
    movement.

    Parameters
    ----------
    vector : array (columns,)
        Vector of the interval, of length 1.
    vectors : array (n, columns)
        Vectors of the others, rows of length 1.
    words : WordMap, optional
        The word map.
    n_posture_and_travel : int, optional
        Number of the last columns that are posture and travel.
    """
    if words is None:
        return np.asarray(vectors @ vector)
    rows = meaning_rows(words, vectors, n_posture_and_travel)
    return np.asarray(rows @ meaning_rows(words, vector, n_posture_and_travel))


def meaning_rows(words: WordMap, vectors: FloatArray, n_posture_and_travel: int = 0) -> FloatArray:
    """Rows whose dot products are the values of :func:`resemblance`: array (..., words + columns).

    They serve many comparisons of the same intervals.

    Parameters
    ----------
    words : WordMap
        The word map.
    vectors : array (..., columns)
        Vectors of length 1.
    n_posture_and_travel : int, optional
        Number of the last columns that are posture and travel.
    """
    said = unit(words.evidence(vectors))
    moving = unit(vectors[..., : vectors.shape[-1] - n_posture_and_travel])
    return np.concatenate(
        [np.sqrt(MEANING_SHARE) * said, np.sqrt(1.0 - MEANING_SHARE) * moving], axis=-1
    )
