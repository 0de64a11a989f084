"""The nearest captures are those that all cosines give."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.meaning import nearest_captures
from motiondb.meaning.nearest_captures import CaptureSegments, NearestCaptures
from motiondb.meaning.score_vectors import unit


def all_cosines(
    vectors: np.ndarray, rows: np.ndarray, bounds: np.ndarray, without: int
) -> list[list[tuple[float, int]]]:
    """Cosine and place of every capture but one, nearest first, for every vector."""
    found = []
    for vector in vectors:
        alike = [
            (max(float(r @ vector / np.linalg.norm(r)) for r in rows[low:high]), place)
            for place, (low, high) in enumerate(bounds)
            if place != without
        ]
        found.append(sorted(alike, key=lambda pair: (-pair[0], pair[1])))
    return found


@pytest.mark.parametrize("axes", [2, 8, 64])
def test_the_nearest_are_those_of_all_cosines(axes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nearest_captures, "AXES", axes)
    rng = np.random.default_rng(axes)
    ends = np.cumsum(rng.integers(1, 9, 200))
    bounds = np.stack([np.concatenate([[0], ends[:-1]]), ends], axis=1)
    rows = rng.normal(size=(40, 20))[rng.integers(0, 40, ends[-1])]  # some segments are alike
    rows += 0.3 * rng.normal(size=rows.shape)
    segments = CaptureSegments(rows, bounds)
    nearest = NearestCaptures(segments)
    for without in (0, 70):
        vectors = unit(rows[bounds[without, 0] : bounds[without, 1]])
        least = segments.cosine_bounds(vectors)
        least[:, without] = -np.inf
        places, cosines = nearest.find(vectors, least, 10)
        for found, given, expected in zip(
            places.tolist(), cosines, all_cosines(vectors, rows, bounds, without)
        ):
            assert found == [place for _, place in expected[:10]]
            np.testing.assert_allclose(given, [cosine for cosine, _ in expected[:10]], atol=1e-12)


def test_no_cosine_is_larger_than_its_bound() -> None:
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(60, 100)) * np.linspace(3.0, 0.1, 100)
    bounds = np.stack([np.arange(60), np.arange(1, 61)], axis=1)
    segments = CaptureSegments(rows, bounds)
    vectors = unit(rng.normal(size=(9, 100)))
    least = segments.cosine_bounds(vectors) + nearest_captures.ROUNDING
    assert (vectors @ unit(rows).T <= least).all()
