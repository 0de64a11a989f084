"""How clearly a segment shows the requested words and no others: two measures besides its place.

By neighbours. Each segment is compared with the segments of all other described captures:

    s_n     cosine of the segment's score vector and that of the most alike segment of capture n,
    g_nw    1/sqrt(actions) if the captions of capture n say word w among that many actions, else 0,
    p(w)    sum_n s_n g_nw / sum_n s_n over the ``NEIGHBOURS`` captures of largest s_n,
    q       1/|W| sum_{w in W} log (p(w) + SMALL) - log (max_v p(v) + SMALL),

with W the asked words, and v over the words that are neither in W nor related to it: words that
stand in half of the captures of a word of W, or of whose captures half say it. The steps towards a
stool, which resemble the beginning of many captures, therefore get a lower value than the sitting
down.

By a map of whole captions. b(w) is the evidence, in nats a second, of a ridge regression on all
other takes that takes every word of a take to be shown in all of it
(:meth:`motiondb.meaning.place_fitting.PlaceEvidence.unplaced`):

    r = 1/|W| sum_{w in W} b(w) - max(0, max_v b(v)), within +-``MOST_RIVALRY``,

with v over the words that stand in at least ``LEAST_CAPTURES`` captures, but neither in W nor
beside W in one action of the capture's captions: in "sit on stepstool", "stepstool" tells the same
action.

Neither needs the places that were learned from the order of captions, which in long takes are often
wrong. Neither shares a model with the judge (:mod:`motiondb.meaning.motion_judge`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from motiondb.learn.learned import DescribedSegments
from motiondb.meaning.motion_judge import RELATED
from motiondb.meaning.nearest_captures import NearestCaptures
from motiondb.meaning.score_vectors import unit
from motiondb.records import Float32Array, FloatArray

NEIGHBOURS = 10  # Number of neighbouring captures
SMALL = 0.03  # The share of one in about thirty neighbours; below it a word counts as absent
MOST_RIVALRY = 16.0
"""Nats a second beyond which r is no larger, so that it weighs no more than the evidence of the
place. On the best excerpts of 36 actions of CMU the judge finds the asked action before all others
in .64 with 16 and in .61 with 8 (.58 with 8 before words of the same action were left out)."""
LEAST_CAPTURES = 3  # Captures of a word that counts as another action: fewer say little of it


def neighbour_gains(
    others: DescribedSegments, takes: Mapping[int, FloatArray], asked: Collection[int]
) -> dict[int, FloatArray]:
    """Gain q of the segments of some captures: capture -> (segments,), each up to 3.5 nats.

    `takes`: Capture -> score vectors (segments, values).
    """
    words = sorted(asked)
    rivals = np.ones(others.says.shape[1], dtype=bool)
    rivals[sorted(related_words(others.says, words))] = False
    if not words or not len(others.captures):
        return {capture: np.zeros(len(vectors)) for capture, vectors in takes.items()}
    units = [unit(vectors) for vectors in takes.values()]
    bounds = others.segments.cosine_bounds(np.concatenate(units))
    nearest, gains, first = NearestCaptures(others.segments), {}, 0
    for capture, vectors in zip(takes, units):
        own = bounds[first : first + len(vectors)]
        first += len(vectors)
        own[:, others.captures == capture] = -np.inf
        if not np.isfinite(own).any():
            gains[capture] = np.zeros(len(vectors))
            continue
        found, cosines = nearest.find(vectors, own, NEIGHBOURS)
        weights = cosines / np.maximum(cosines.sum(axis=1, keepdims=True), 1e-12)
        said = np.einsum("sn,snw->sw", weights, others.says[found])
        best = said[:, rivals].max(axis=1) if rivals.any() else np.zeros(len(said))
        gains[capture] = np.log(said[:, words] + SMALL).mean(axis=1) - np.log(best + SMALL)
    return gains


def related_words(says: FloatArray | Float32Array, words: Collection[int]) -> set[int]:
    """Words that mostly occur in the same captures as one of some words, and these words.

    >>> sorted(related_words(np.array([[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]), [1]))
    [0, 1]
    """
    present = (says > 0.0).astype(float)
    counts = np.maximum(present.sum(axis=0), 1.0)
    related = set(words)
    for word in words:
        both = present[:, word] @ present
        near = (both > 0.0) & ((both >= RELATED * counts[word]) | (both >= RELATED * counts))
        related |= set(np.flatnonzero(near).tolist())
    return related


def rival_gain(evidence: FloatArray, asked: Collection[int], rivals: Collection[int]) -> FloatArray:
    """Gain r of every segment, nats a second: (segments,), from `evidence` (segments, words).

    >>> rival_gain(np.array([[3.0, 1.0, -2.0], [1.0, -1.0, -2.0]]), [0], [1, 2]).tolist()
    [2.0, 1.0]
    """
    best = evidence[:, sorted(rivals)].max(axis=1, initial=0.0)
    gain = evidence[:, sorted(asked)].mean(axis=1) - best
    return np.clip(gain, -MOST_RIVALRY, MOST_RIVALRY)
