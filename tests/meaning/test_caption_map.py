"""Captions suggested by motion: the regression by hand, exact sums, the likeness of a question."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import made_captions

from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import CaptionMap, WordMoments, solve_caption_map, word_moments


def solved(moments: WordMoments, ridge: float = 0.1) -> CaptionMap:
    captions = solve_caption_map(moments, ridge)
    assert captions is not None
    return captions


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
    assert alone.captions is not None
    assert back.captions is not None
    np.testing.assert_array_equal(back.captions.cross, alone.captions.cross)
    np.testing.assert_array_equal(back.captions.words, alone.captions.words)
    np.testing.assert_array_equal(solved(back).weights, solved(alone).weights)


def test_the_likeness_is_the_cosine_with_the_question() -> None:
    vectors, presence = made_captions(40)
    captions = solved(word_moments(vectors, presence))
    suggested = (vectors @ captions.weights + captions.offsets) * captions.rarity
    asked = np.zeros(5)
    asked[[1, 3]] = captions.rarity[[1, 3]]
    cosine = unit(suggested) @ unit(asked)
    shares = captions.suggested(vectors)[:, [1, 3]] * captions.question([1, 3])
    np.testing.assert_allclose(shares.sum(axis=1), cosine)


def test_without_sums_for_captions_there_is_no_map() -> None:
    moments = word_moments(*made_captions(10))
    old = WordMoments(moments.n, moments.vectors, moments.words, moments.gram, moments.cross)
    assert solve_caption_map(old) is None
    assert (old + moments).captions is None
    assert (moments - old).captions is None
    assert (moments - moments).n == pytest.approx(0.0)


def test_words_of_short_captions_have_larger_shares() -> None:
    """Two takes that move alike: what one says alone is told before what the other lists."""
    vectors = unit(np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    presence = np.array([[1, 0, 0, 0], [0, 1, 1, 1], [0, 0, 0, 1]], dtype=bool)
    shares = solved(word_moments(vectors, presence)).shares(vectors[:1])[0]
    assert shares[0] > shares[1] == pytest.approx(shares[2], abs=1e-6)
