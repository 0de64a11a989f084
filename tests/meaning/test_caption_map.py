"""Captions suggested by motion: the regression by hand, exact sums, the likeness of a question."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import made_captions

from motiondb.meaning.caption_map import (
    CAPTION_WEIGHT,
    MEANING_WEIGHT,
    CaptionMap,
    likeness_of,
    solve_caption_map,
)
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMoments, word_moments

MEANINGS = unit(np.random.default_rng(7).normal(size=(5, 3)))


def solved(moments: WordMoments, ridge: float = 0.1) -> CaptionMap:
    return solve_caption_map(moments, MEANINGS[: len(moments.words)], ridge)


def test_it_is_the_ridge_regression_of_captions_of_length_1() -> None:
    vectors, presence = made_captions(40)
    captions = solved(word_moments(vectors, presence), 0.3)
    t = presence / np.sqrt(presence.sum(axis=1, keepdims=True))
    v = vectors - vectors.mean(axis=0)
    weights = np.linalg.solve(v.T @ v + 0.3 * np.eye(6), v.T @ (t - t.mean(axis=0)))
    np.testing.assert_allclose(captions.weights, weights, atol=1e-3)
    np.testing.assert_allclose(
        captions.offsets, t.mean(axis=0) - vectors.mean(axis=0) @ weights, atol=1e-3
    )
    np.testing.assert_allclose(captions.rarity, np.log(41 / (1 + presence.sum(axis=0))))


@given(st.integers(1, 20), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_adding_and_removing_captures_is_exact(n: int, seed: int) -> None:
    first, second = made_captions(25, seed), made_captions(n, seed + 1)
    alone = word_moments(*first)
    back = alone + word_moments(*second) - word_moments(*second)
    np.testing.assert_array_equal(back.captions.cross, alone.captions.cross)
    np.testing.assert_array_equal(back.captions.words, alone.captions.words)
    np.testing.assert_array_equal(solved(back).weights, solved(alone).weights)


def test_likeness_by_hand() -> None:
    vectors, presence = made_captions(40)
    captions = solved(word_moments(vectors, presence))
    suggested = captions.suggest(vectors)
    shares = vectors @ captions.weights + captions.offsets
    for word in range(5):
        said = shares * captions.rarity
        alone = CAPTION_WEIGHT * said[:, word] / np.linalg.norm(said, axis=1)
        meant = shares @ MEANINGS
        by_vector = MEANING_WEIGHT * unit(meant) @ MEANINGS[word]
        both = alone - alone.mean() + by_vector - by_vector.mean()
        np.testing.assert_allclose(suggested.likeness()[:, word], both, atol=1e-9)
        other = likeness_of(suggested.meanings, MEANINGS[[word]])[:, 0]
        np.testing.assert_allclose(other, by_vector - by_vector.mean(), atol=1e-9)


def test_words_of_short_captions_have_larger_shares() -> None:
    """Two takes that move alike: what one says alone is told before what the other lists."""
    vectors = unit(np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    presence = np.array([[1, 0, 0, 0], [0, 1, 1, 1], [0, 0, 0, 1]], dtype=bool)
    shares = solved(word_moments(vectors, presence)).shares(vectors[:1])[0]
    assert shares[0] > shares[1] == pytest.approx(shares[2], abs=1e-6)
