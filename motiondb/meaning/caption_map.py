"""A linear map from score vectors to whole captions, and how likely they make words.

The word map (:mod:`motiondb.meaning.word_map`) predicts each word by itself; both together rank
captures better than either. Notation: v the score vector of an interval, t = y / |y| with y_w = 1
where word w was written about it, e_w the vector of word w, which is like that of words of similar
meaning (:mod:`motiondb.language.word_vectors`). Ridge regression of t on v gives the suggested
caption c, and with it the suggested meaning s = sum over w of c_w e_w. With the rarity
r_w = log((1 + n) / (1 + n_w)) of a word that n_w of n intervals hold, the likeness of a word is

    CAPTION_WEIGHT c_w r_w / |c * r|  +  MEANING_WEIGHT cos(s, e_w)

less its mean over the captures, in nats. A word that no caption holds has the second term of its
own vector, and the first of the known words nearest to it. A question's words each add their
likeness, at the whole capture; order and place are left to the word map. t holds neither the rarity
nor the vectors, so that the sums of the regression are additive over captures, and exact.

Source: ridge regression to vectors of captions was compared with other maps in
``docs/measured/quality.md`` ("Whole captions to motion").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMoments
from motiondb.records import Float32Array, FloatArray
from motiondb.symbols.hmm_jobs import one_blas_thread

CAPTION_RIDGE = 0.1
"""Ridge of the regression. Chosen among .1, .3 and 1 by leaving performers out of the CMU training
parts (``docs/measured/quality.md``, "Whole captions to motion", and "Motion to words")."""
CAPTION_WEIGHT = 10.0
"""Nats for a cosine of 1. Chosen among 10, 20 and 40 by leaving performers out of the CMU training
parts (``docs/measured/quality.md``, "Whole captions to motion")."""
MEANING_WEIGHT = 10.0
"""The same as CAPTION_WEIGHT: weights that were fitted to both within the CMU training parts, with
performers left out, differed by less than a tenth."""


@dataclass(frozen=True, eq=False)
class CaptionMap:
    """A linear map from score vectors to captions."""

    weights: FloatArray  # (columns, words): slopes
    offsets: FloatArray  # (words,): constants
    rarity: FloatArray  # (words,): r of the module's docstring
    meanings: FloatArray  # (words, axes): vectors e of the words

    def shares(self, vectors: FloatArray) -> FloatArray:
        """Suggested captions c of intervals: array (n, words), from `vectors` (n, columns)."""
        return np.asarray(vectors @ self.weights + self.offsets)

    def suggest(self, vectors: FloatArray) -> Suggested:
        """What intervals suggest; `vectors` (n, columns)."""
        with one_blas_thread():  # sums of several threads differ in their last bits
            shares = self.shares(vectors)
            return Suggested(self, shares, unit(shares @ self.meanings))


@dataclass(frozen=True, eq=False)
class Suggested:
    """The captions that the motion of some intervals suggests."""

    of: CaptionMap
    shares: FloatArray  # (n, words): captions c
    meanings: FloatArray  # (n, axes): meanings s, of length 1

    def likeness(self) -> FloatArray:
        """Likeness of every word of the captions: array (n, words), nats."""
        said = CAPTION_WEIGHT * unit(self.shares * self.of.rarity)
        return said - said.mean(axis=0) + likeness_of(self.meanings, self.of.meanings)


def likeness_of(suggested: FloatArray | Float32Array, words: FloatArray) -> FloatArray:
    """Likeness of words to suggested meanings by their vectors alone: array (n, words), nats.

    Shapes: `suggested` (n, axes); `words` (words, axes).
    """
    with one_blas_thread():
        alike = MEANING_WEIGHT * (suggested @ words.T)
    return np.asarray(alike - alike.mean(axis=0))


def solve_caption_map(
    moments: WordMoments, meanings: FloatArray, ridge: float = CAPTION_RIDGE
) -> CaptionMap:
    """Caption map from sums, for words with the vectors `meanings` (words, axes)."""
    weights, shift = moments.solve(moments.captions, ridge)
    n = max(moments.n, 1.0)
    rarity = np.log((1.0 + n) / (1.0 + moments.words))
    return CaptionMap(weights, moments.captions.words / n - shift, rarity, meanings)
