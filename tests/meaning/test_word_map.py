"""The word map: additive to the last bit, calibrated, and not fooled by one performer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from motiondb.meaning import regression, word_map
from motiondb.meaning.score_vectors import unit
from motiondb.records import FloatArray, IntArray

Described = tuple[FloatArray, NDArray[np.bool_], IntArray]


def described(seed: int, n: int = 600, n_symbols: int = 12, n_words: int = 6) -> Described:
    """Intervals whose words follow from their symbols by a logistic law with noise."""
    rng = np.random.default_rng(seed)
    vectors = unit(rng.normal(size=(n, n_symbols)))
    weights = rng.normal(0, 6, size=(n_symbols, n_words))
    logits = vectors @ weights - rng.uniform(0.5, 2.5, n_words)
    presence = rng.uniform(size=logits.shape) < 1 / (1 + np.exp(-logits))
    return vectors, presence, rng.integers(0, 6, n)


def test_probabilities_are_calibrated_on_intervals_never_seen() -> None:
    vectors, presence, groups = described(0, 3000)
    fitted = word_map.fit_word_map(vectors[:1500], presence[:1500], groups[:1500])
    actual, truth = fitted.probabilities(vectors[1500:]).ravel(), presence[1500:].ravel()
    for low in np.arange(0.0, 1.0, 0.2):
        inside = (actual >= low) & (actual < low + 0.2)
        assert inside.sum() > 100
        assert actual[inside].mean() == pytest.approx(truth[inside].mean(), abs=0.07)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6))
def test_every_score_is_the_sum_of_its_symbols(seed: int) -> None:
    """z_w = sum over symbols of v_s u_sw + c_w, and the log-odds are a line in z."""
    vectors, presence, groups = described(seed, 80)
    fitted = word_map.fit_word_map(vectors, presence, groups)
    shares = vectors[:, :, None] * fitted.weights[None]
    evidence = fitted.evidence(vectors)
    np.testing.assert_allclose(shares.sum(axis=1) + fitted.offsets, evidence, atol=1e-12)
    a, b, c = fitted.calibration
    prior = np.log(fitted.priors) - np.log1p(-fitted.priors)
    expected = a * evidence / fitted.spreads + b * prior + c
    np.testing.assert_allclose(fitted.log_odds(vectors), expected, atol=1e-12)
    assert a > 0


def test_evidence_is_centred() -> None:
    """On the intervals it was fitted on, the mean evidence of every word is nothing."""
    vectors, presence, groups = described(2, 200)
    fitted = word_map.fit_word_map(vectors, presence, groups)
    np.testing.assert_allclose(fitted.evidence(vectors).mean(axis=0), 0.0, atol=1e-12)


def test_ridge_regression_by_normal_equations() -> None:
    vectors, presence, _ = described(3, 60, 4, 2)
    target = presence.astype(float)
    weights, offsets = regression.fit_ridge(vectors, target, 0.5)
    padded = np.hstack([vectors, np.ones((60, 1))])
    penalty = np.diag([0.5, 0.5, 0.5, 0.5, 0.0])
    expected = np.linalg.solve(padded.T @ padded + penalty, padded.T @ target)
    np.testing.assert_allclose(np.vstack([weights, offsets]), expected, atol=1e-9)


def test_what_is_left_out_does_not_take_part() -> None:
    vectors, presence, groups = described(4, 100, 5, 2)
    target = presence.astype(float)
    changed = target.copy()
    changed[groups == 3] = 9.0
    (before,) = regression.left_out(vectors, target, groups, [1.0])
    (after,) = regression.left_out(vectors, changed, groups, [1.0])
    np.testing.assert_allclose(after[groups == 3], before[groups == 3])


@pytest.mark.parametrize(
    "n", [40, 4]
)  # the other solution, where there are fewer rows than columns
def test_several_ridges_give_what_each_gives_alone(n: int) -> None:
    vectors, presence, groups = described(4, n, 5, 2)
    ridges = [0.1, 1.0]
    for ridge, predicted in zip(
        ridges, regression.left_out(vectors, presence.astype(float), groups, ridges)
    ):
        for group in np.unique(groups):
            rest = groups != group
            slopes, constants = regression.fit_ridge(
                vectors[rest], presence[rest].astype(float), ridge
            )
            np.testing.assert_array_equal(predicted[~rest], vectors[~rest] @ slopes + constants)


def test_calibration_finds_a_known_line() -> None:
    rng = np.random.default_rng(0)
    z, priors = rng.normal(size=(4000, 3)), np.array([0.1, 0.3, 0.6])
    logits = 1.7 * z + 0.8 * np.log(priors / (1 - priors)) - 0.3
    target = (rng.uniform(size=logits.shape) < 1 / (1 + np.exp(-logits))).astype(float)
    actual = regression.calibrate(z, np.broadcast_to(word_map.logit(priors), z.shape), target)
    np.testing.assert_allclose(actual, [1.7, 0.8, -0.3], atol=0.12)


def test_words_without_any_motion_in_them_get_their_prior() -> None:
    rng = np.random.default_rng(5)
    vectors, groups = unit(rng.normal(size=(800, 6))), rng.integers(0, 5, 800)
    presence = rng.uniform(size=(800, 3)) < np.array([0.1, 0.3, 0.5])
    actual = word_map.fit_word_map(vectors, presence, groups).probabilities(vectors)
    np.testing.assert_allclose(actual.mean(axis=0), presence.mean(axis=0), atol=0.05)
    assert actual.std(axis=0).max() < 0.1


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_few_described_intervals_are_enough(n: int) -> None:
    vectors = unit(np.random.default_rng(n).normal(size=(n, 4)))
    presence = np.zeros((n, 2), dtype=bool)
    presence[0, 0] = True
    fitted = word_map.fit_word_map(vectors, presence, np.zeros(n, dtype=np.int64))
    assert np.isfinite(fitted.log_odds(vectors)).all()


def test_words_that_are_always_or_never_said() -> None:
    vectors, presence, groups = described(6, 100, 4, 3)
    presence[:, 0], presence[:, 1] = True, False
    actual = word_map.fit_word_map(vectors, presence, groups).probabilities(vectors)
    assert actual[:, 0].min() > 0.9
    assert actual[:, 1].max() < 0.1
