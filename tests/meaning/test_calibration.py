"""Probabilities of answers, and the threshold below which nothing matches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from motiondb.meaning import by_motion
from motiondb.meaning.regression import (
    fit_probability,
    probability,
    separate,
)
from motiondb.meaning.word_map import WordMap, clearest, usual
from motiondb.records import FloatArray

few = settings(deadline=None, max_examples=25)


def answers(seed: int, weights: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Cues of 300 answers, and which are right by a known law."""
    rng = np.random.default_rng(seed)
    cues = rng.normal(1.0, 2.0, (300, len(weights)))
    return cues, rng.random(300) < probability(cues @ np.array(weights) - 1.0)


@few
@given(st.integers(0, 10**6), st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_the_fit_is_the_optimum_found_by_a_general_method(
    seed: int, law: tuple[float, float]
) -> None:
    cues, right = answers(seed, law)
    weights, constant = fit_probability(cues, right)
    spread, centre = cues.std(axis=0), cues.mean(axis=0)
    x, y = (cues - centre) / spread, right.astype(float)

    def cost(b: FloatArray) -> float:
        z = x @ b[:-1] + b[-1]
        return float(
            np.logaddexp(0.0, z).sum() - y @ z + 0.5 * b[:-1] @ b[:-1] + 0.5e-3 * b[-1] ** 2
        )

    best = minimize(cost, np.zeros(3), bounds=[(0, None), (0, None), (None, None)], tol=1e-12)
    fitted = np.append(weights * spread, constant + weights @ centre)
    assert (weights >= 0.0).all()
    assert cost(fitted) <= best.fun + 1e-5


@few
@example([5e-324], [0.0])
@given(
    st.lists(st.floats(-3, 3), min_size=1, max_size=12),
    st.lists(st.floats(-3, 3), min_size=1, max_size=12),
)
def test_no_threshold_separates_better(present: list[float], absent: list[float]) -> None:
    there, gone = np.array(present), np.array(absent)

    def balanced(threshold: float) -> float:
        return float(np.mean(there >= threshold) + np.mean(gone < threshold))

    actual = balanced(separate(there, gone))
    assert actual >= max(balanced(t) for t in np.linspace(-3.5, 3.5, 141)) - 1e-12
    assert actual >= max(balanced(float(t)) for t in np.concatenate([there, gone])) - 1e-12


def test_without_questions_there_is_no_threshold() -> None:
    assert np.isnan(separate(np.array([1.0]), np.zeros(0)))
    assert np.isnan(separate(np.zeros(0), np.array([1.0])))


def test_what_is_usual_and_what_is_clear() -> None:
    priors = np.array([0.5, 0.2])
    words = WordMap(
        np.array([[2.0, 0.0]]), np.zeros(2), priors, np.ones(2), np.array([1.0, 1.0, 0])
    )
    np.testing.assert_allclose(usual(words), [0.0, np.log(0.25)])
    np.testing.assert_allclose(words.log_odds(np.zeros((1, 1)))[0], usual(words))
    assert clearest(words, np.array([1.0]), np.array([True, True])) == 2.0
    assert clearest(words, np.array([1.0]), np.array([False, True])) == pytest.approx(np.log(0.25))
    assert clearest(words, np.array([1.0]), np.array([False, False])) == 0.0


def test_one_motion_shows_one_thing() -> None:
    assert by_motion.same_motion(0.3, 0.0) == 1.0
    assert by_motion.same_motion(0.3, by_motion.NEAR) == pytest.approx(0.3)


def test_an_answer_that_counts_twice_is_two_answers() -> None:
    rng = np.random.default_rng(5)
    cues, right = rng.normal(size=(40, 2)), rng.random(40) < 0.5
    counts = rng.integers(1, 4, 40)
    weights, constant = fit_probability(cues, right, counts.astype(float))
    twice = np.repeat(np.arange(40), counts)
    expected, other = fit_probability(cues[twice], right[twice])
    np.testing.assert_allclose(weights, expected, atol=1e-9)
    assert constant == pytest.approx(other, abs=1e-9)
