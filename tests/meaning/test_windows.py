"""Cosines and evidence of windows are those of their vectors, also where segments cancel."""

from __future__ import annotations

import numpy as np
import pytest
from made_tables import Made, takes_of

from motiondb.meaning.alignment import Aligned
from motiondb.meaning.resemblance import meaning_space
from motiondb.meaning.score_vectors import interval_vectors, unit
from motiondb.meaning.windows import row_products, score_windows
from motiondb.meaning.word_map import WordMap


def opposed(rng: np.random.Generator, n: int, rest: float) -> np.ndarray:
    """Rows in single precision, of which each second one is nearly opposite to the one before."""
    rows = rng.normal(size=(n, 40))
    rows[1::2] = rest * rng.normal(size=(n // 2, 40)) - rows[: n - n % 2 : 2]
    return rows.astype(np.float32).astype(np.float64)


@pytest.mark.parametrize("length", [30, 257, 600])
@pytest.mark.parametrize("rest", [1.0, 1e-2, 1e-4, 1e-6, 0.0])
def test_scores_are_those_of_vectors(length: int, rest: float) -> None:
    rng = np.random.default_rng(0)
    words = WordMap(rng.normal(size=(40, 5)), np.zeros(5), *np.ones((2, 5)), np.ones(3))
    space, vector = meaning_space(words, 10), unit(rng.normal(size=40))
    captures: list[Made] = []
    for number, n in enumerate((1, 2, 7, 80)):
        ends = 15 * np.arange(1, n + 1)
        captures.append((number, ends - 15, ends, [0] * n, opposed(rng, n, rest)))
    captures[-1][-1][30:] = 0.0  # rows of zeros have the cosine 0 wherever they stand
    takes = takes_of(*captures, space=space)
    plain = Aligned(*np.zeros((3, 4), dtype=int))
    windows = score_windows(takes.segments, takes.bounds, vector, plain, length)
    for n, (_, starts, ends, _, rows) in enumerate(captures):
        own = slice(windows.edges[n], windows.edges[n + 1])
        places = windows.places[own]
        exact = interval_vectors(
            rows, np.asarray(starts), np.asarray(ends), places[:, 0], places[:, 1]
        )
        np.testing.assert_allclose(2.0 * windows.rough[own], exact @ vector, atol=5e-7)
        best = exact[windows.best[n] - own.start]
        moving = unit(best[:30]) @ unit(vector[:30])
        np.testing.assert_allclose(windows.moving[n], moving, atol=1e-6)
        np.testing.assert_allclose(windows.evidence[n], best @ space.weights, atol=2e-5)


def test_products_of_neighbours_are_kept_for_one_length() -> None:
    rows = np.random.default_rng(0).normal(size=(9, 3))
    ends = 10 * np.arange(1, 10)
    segments = takes_of((1, ends - 10, ends, [0] * 9, rows)).segments
    short = segments.neighbours(30)
    assert segments.neighbours(60) is short
    segments.neighbours(100)
    assert segments.neighbours(30) is not short


def test_equal_rows_have_equal_products() -> None:
    rng = np.random.default_rng(0)
    row, vector = rng.normal(size=900).astype(np.float32), rng.normal(size=900)
    for n in range(1, 40):
        products = row_products(np.tile(row, (n, 1)), vector)
        assert len(set(products.tolist())) == 1
        np.testing.assert_allclose(products[0], row.astype(np.float64) @ vector, rtol=1e-12)
        single = row_products(np.tile(row, (n, 1))[:, :701], vector.astype(np.float32)[:701])
        assert len(set(single.tolist())) == 1
