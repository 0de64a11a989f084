"""Description length: prices and deaths, by hand and against writing L out."""

from __future__ import annotations

from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols import acquisition


def symbols_of(n_states: list[int], n_dims: int) -> MotionSymbols:
    shape = (len(n_states), max(n_states), n_dims)
    loops = np.full(shape[:2], 0.5)
    return MotionSymbols(np.array(n_states), loops, np.zeros(shape), np.ones(shape))


def length(scores: FloatArray, prices: FloatArray, alive: list[int]) -> float:
    """L of the symbols that live, a segment at a time."""
    total = sum(prices[s] for s in alive) + len(scores) * log(len(alive))
    return float(total - sum(max(row[s] for s in alive) for row in scores))


def test_prices_by_hand() -> None:
    """1 and 3 states in 2 dimensions: 2 means, 2 variances and a self-loop a state."""
    actual = acquisition.prices(symbols_of([1, 3], 2), 100)
    np.testing.assert_allclose(actual, [2.5 * 4.605170186, 7.5 * 4.605170186])


def test_prices_do_not_vanish_for_a_single_frame() -> None:
    assert acquisition.prices(symbols_of([1], 2), 1)[0] == pytest.approx(2.5 * log(2))


def test_deaths_by_hand() -> None:
    """Symbol 1 wins nothing and goes first; then 2, worth 79, before 0, worth 89."""
    scores = np.array([[-1.0, -2.0, -90.0], [-80.0, -9.0, -1.0]])
    order, gains = acquisition.deaths(scores, np.full(3, 5.0))
    np.testing.assert_array_equal(order, [1, 2])
    np.testing.assert_allclose(gains, [5 + 2 * log(3 / 2), 5 + 2 * log(2) - 79])


def test_deaths_go_on_to_the_least_number_and_one_symbol_stays() -> None:
    scores = 1e4 * np.eye(4)
    for least, expected in ((1, 1), (2, 2), (3, 3), (9, 3)):
        order, gains = acquisition.deaths(scores, np.ones(4), least)
        assert len(order) == len(set(order.tolist())) == expected
        assert np.all(gains < 0)
    assert [len(part) for part in acquisition.deaths(scores[:, :1], np.ones(1))] == [0, 0]


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 15), st.integers(2, 6), st.integers(1, 6))
def test_gains_are_differences_of_lengths_and_none_was_larger(
    seed: int, n_segments: int, n_symbols: int, least: int
) -> None:
    rng = np.random.default_rng(seed)
    scores = rng.normal(0, 20, (n_segments, n_symbols))
    prices = rng.uniform(1, 60, n_symbols)
    order, gains = acquisition.deaths(scores, prices, least)
    alive = list(range(n_symbols))
    for dead, gain in zip(order.tolist(), gains):
        before = length(scores, prices, alive)
        every = [before - length(scores, prices, [s for s in alive if s != d]) for d in alive]
        assert gain == pytest.approx(max(every))
        alive.remove(dead)
        assert gain == pytest.approx(before - length(scores, prices, alive))
