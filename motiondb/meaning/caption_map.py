"""A linear map from score vectors to whole captions.

The word map (:mod:`motiondb.meaning.word_map`) predicts for each word separately whether
captions have it. For a question in the form of a caption, a comparison with the caption that the
motion suggests gives better answers. Notation: v the score vector of an interval, t = y /
|y| with y_w = 1 where word w was written about it. Ridge regression of t on v gives the suggested
caption c; r_w = log((1 + n) / (1 + n_w)) is the rarity of a word that n_w of n intervals hold. The
likeness of a question with words Q is the cosine of c * r and of the question's r:

    sum over w in Q of  c_w r_w / |c * r|  *  r_w / |r_Q|,

a sum over its words. t does not hold the rarity, so that the sums that the regression needs are
additive over captures and can be kept exactly (:mod:`motiondb.meaning.word_map`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.ridge import solve_sums
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMoments
from motiondb.records import FloatArray

RIDGE = 0.1
"""Ridge of the regression. Chosen among .1, .3 and 1 by leaving performers out of the CMU training
parts (``docs/measured/quality.md``, "Whole captions to motion", and "Motion to words")."""


@dataclass(frozen=True, eq=False)
class CaptionMap:
    """A linear map from score vectors to captions."""

    weights: FloatArray  # (columns, words): slopes
    offsets: FloatArray  # (words,): constants
    rarity: FloatArray  # (words,): r of the module's docstring

    def suggested(self, vectors: FloatArray) -> FloatArray:
        """Suggested captions of intervals, c * r / |c * r|: array (n, words).

        Shapes: `vectors` (n, columns).
        """
        return unit(self.shares(vectors) * self.rarity)

    def shares(self, vectors: FloatArray) -> FloatArray:
        """Predicted captions c of intervals: array (n, words), from `vectors` (n, columns)."""
        return np.asarray(vectors @ self.weights + self.offsets)

    def question(self, words: Sequence[int]) -> FloatArray:
        """r_w / |r_Q| of the words of a question: array (words of the question,)."""
        return unit(self.rarity[list(words)])


def solve_caption_map(moments: WordMoments, ridge: float = RIDGE) -> CaptionMap | None:
    """Caption map from sums; None if the sums for captions were not kept."""
    if moments.captions is None:
        return None
    n = max(moments.n, 1.0)
    mean_t: FloatArray = moments.captions.words / n
    sums = (moments.vectors, moments.gram, moments.captions.words, moments.captions.cross)
    weights, shift = solve_sums(n, *sums, ridge)
    return CaptionMap(weights, mean_t - shift, np.log((1.0 + n) / (1.0 + moments.words)))
