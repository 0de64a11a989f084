"""Vectors of words: parts of words, lengths, and the shipped table."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.language.word_vectors.word_vectors import (
    NEAREST,
    WordVectors,
    shares_by_meaning,
    word_vectors,
)


def test_a_word_is_the_mean_of_its_longest_parts() -> None:
    table = np.array([[100, 0], [0, 50], [60, 80]], dtype=np.int8)
    vectors = WordVectors({"moon": 0, "##walk": 1, "walk": 2}, table)
    assert vectors.of(["walk"]).tolist() == [[0.6, 0.8]]
    np.testing.assert_allclose(vectors.of(["Moonwalk"]), [[2 / 5**0.5, 1 / 5**0.5]])
    assert vectors.of(["moonwalker", ""]).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_words_of_like_meaning_are_near_in_the_shipped_table() -> None:
    """Words of one part and of several, against three words that mean something else."""
    for word, near in {
        "stroll": "walk", "jog": "run", "leap": "jump", "ballet": "dance", "somersault": "jump",
        "dancing": "dance",
    }.items():  # fmt: skip
        one, same, *others = word_vectors().of([word, near, "drink", "telephone", "wash"])
        assert one @ same > max(one @ other for other in others), word


def test_shares_are_those_of_the_nearest_words() -> None:
    known = word_vectors().of(["walk", "run", "drink", "jump", "climb"])
    shares = shares_by_meaning(known, word_vectors().of(["stroll"])[0])
    assert np.argmax(shares) == 0
    assert np.count_nonzero(shares) == NEAREST
    assert shares.sum() == pytest.approx(1.0)
    assert not shares_by_meaning(np.zeros((4, 128)), known[0]).any()
