"""Resemblance of captures to the best answers, and the weights of words in it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.meaning.resemblance import (
    FEEDBACK,
    FEWEST_OTHERS,
    PooledMap,
    fit_pooled_map,
    meaning_space,
    with_feedback,
)
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMap


def naive_feedback(alike: np.ndarray, rows: np.ndarray) -> list[float]:
    """The same, capture by capture."""
    n = max(1, min(FEEDBACK, len(alike) // FEWEST_OTHERS))
    if len(alike) <= n:
        return list(alike)
    best = sorted(range(len(alike)), key=lambda k: -alike[k])[:n]
    total = sum(max(alike[b], 0.0) for b in best)
    if total <= 0.0:
        return list(alike)
    return [
        0.5 * alike[k] + 0.5 * sum(max(alike[b], 0.0) * (rows[k] @ rows[b]) for b in best) / total
        for k in range(len(alike))
    ]


@given(st.integers(1, 80), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_feedback_is_the_mean_with_the_best_answers(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = unit(rng.normal(size=(n, 4)))
    alike = rows @ unit(rng.normal(size=4))
    np.testing.assert_allclose(with_feedback(alike, rows), naive_feedback(alike, rows), atol=1e-12)


def test_without_a_resemblance_nothing_changes() -> None:
    rows = np.eye(5)
    alike = -np.ones(5)
    assert with_feedback(alike, rows).tolist() == [-1.0] * 5


def naive_rows(
    vectors: np.ndarray,
    statistics: np.ndarray,
    words: WordMap,
    pooled: PooledMap,
    emphasis: np.ndarray,
    n_moving: int,
) -> np.ndarray:
    """The same in double precision, interval by interval, from the maps themselves."""
    rows = []
    for vector, numbers in zip(vectors, statistics):
        first = emphasis * words.evidence(vector)
        second = emphasis * pooled.evidence(numbers)
        moving = vector[:n_moving]
        rows.append(
            np.concatenate(
                [
                    np.sqrt(0.5) * first / np.linalg.norm(first),
                    np.sqrt(0.2) * moving / np.linalg.norm(moving),
                    np.sqrt(0.3) * second / np.linalg.norm(second),
                ]
            )
        )
    return np.array(rows)


@given(st.integers(12, 60), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_single_precision_ranks_as_double_precision_does(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    vectors = unit(rng.normal(size=(n, 20)))
    statistics = rng.normal(size=(n, 10))
    words = WordMap(rng.normal(size=(20, 6)), rng.normal(size=6), *np.ones((2, 6)), np.ones(3))
    pooled = fit_pooled_map(statistics, rng.random((n, 6)) < 0.4)
    emphasis = rng.choice([0.5, 1.0], size=6)
    space = meaning_space(words, n_posture_and_travel=5, emphasis=emphasis, pooled=pooled)
    rows = space.rows(vectors, statistics)
    exact = naive_rows(vectors, statistics, words, pooled, emphasis, 15)
    assert rows.dtype == np.float32
    np.testing.assert_allclose(rows, exact, atol=1e-5)
    np.testing.assert_array_equal(space.rows(vectors[3], statistics[3]).shape, rows[3].shape)
    alike, expected = rows[1:] @ rows[0], exact[1:] @ exact[0]
    np.testing.assert_allclose(alike, expected, atol=1e-5)
    # in the order of single precision, no value of double precision rises by more than rounding
    ranked = expected[np.argsort(-alike, kind="stable")]
    assert np.diff(ranked).max() < 2e-5


@given(st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_no_product_of_rows_is_larger_than_its_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    vectors, statistics = unit(rng.normal(size=(30, 9))), rng.normal(size=(30, 10))
    words = WordMap(rng.normal(size=(9, 6)), rng.normal(size=6), *np.ones((2, 6)), np.ones(3))
    pooled = fit_pooled_map(statistics, rng.random((30, 6)) < 0.4)
    space = meaning_space(words, 3, pooled=pooled)
    rows = space.rows(vectors, statistics)
    said, moving, example = rows[:, :6], rows[:, 6:12] @ rows[0, 6:12], rows[0]
    for asked in (example, rows[:4].mean(axis=0), rows[1]):
        bounds = space.most_alike(said, moving, example, asked)
        assert (rows @ asked <= bounds).all()
        # the bound is reached where the row itself is asked for
        assert bounds[0] <= rows[0] @ asked + 2e-3 or asked is not example
