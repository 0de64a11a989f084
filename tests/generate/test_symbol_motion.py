"""How clearly segments, symbols and parts of a motion show what was asked for, and nothing else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate.symbol_motion import log_clarity, log_unasked, symbol_clarity


def test_clarity_of_a_stretch_is_the_mean_over_its_frames() -> None:
    probabilities = np.array([[0.5, 0.75], [0.25, 0.75]])
    expected = (np.log(0.5) + np.log(0.25)) / 2 + 0.5 * np.log(0.25)
    assert log_clarity(probabilities, np.array([0])) == pytest.approx(expected)


def test_what_was_not_asked_for_takes_away() -> None:
    probabilities = np.array([[0.8, 0.5, 0.0], [0.8, 0.0, 0.0]])
    assert np.allclose(np.exp(log_unasked(probabilities, np.array([0]))), [0.5, 1.0])
    both = np.exp(log_unasked(probabilities, np.array([0, 1])))
    assert np.allclose(both, [1.0, 1.0])


def test_a_symbol_is_as_clear_as_its_segments() -> None:
    probabilities = np.array([[0.9], [0.9], [0.9], [0.1]])
    actual = symbol_clarity(probabilities, np.array([0]), np.zeros(4, dtype=int), 2)
    assert np.allclose(actual, [[np.sqrt(0.7 * 0.9)], [0.0]])  # all on average, the clearest three


def test_the_share_says_how_much_the_unasked_counts() -> None:
    probabilities = np.array([[0.8, 0.75]])
    symbols = np.zeros(1, dtype=int)
    actual = [
        symbol_clarity(probabilities, np.array([0]), symbols, 1, share)[0, 0]
        for share in (0.0, 0.5, 1.0)
    ]
    assert np.allclose(actual, [0.8, 0.4, 0.2])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 12), st.integers(1, 5))
def test_clarity_is_between_nothing_and_the_probability(
    seed: int, n_segments: int, n_words: int
) -> None:
    rng = np.random.default_rng(seed)
    probabilities = rng.uniform(0.0, 0.99, (n_segments, n_words))
    symbols = rng.integers(0, 3, n_segments)
    asked = rng.permutation(n_words)[: int(rng.integers(1, n_words + 1))]
    actual = symbol_clarity(probabilities, asked, symbols, 3)
    for symbol in range(3):
        of_symbol = probabilities[symbols == symbol][:, asked]
        most = of_symbol.max(axis=0) if len(of_symbol) else np.zeros(len(asked))
        assert (actual[symbol] >= 0.0).all()
        assert (actual[symbol] <= most + 1e-12).all()
