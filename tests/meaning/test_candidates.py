"""The candidates of an example are those that a full scan finds."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.meaning import by_motion
from motiondb.meaning.score_vectors import unit


def makes(rng: np.random.Generator, n_captures: int) -> dict[int, by_motion.Take]:
    takes = {}
    for number in range(n_captures):
        n = int(rng.integers(1, 12))
        ends = np.cumsum(rng.integers(4, 30, n))
        starts = np.concatenate([[0], ends[:-1]])
        takes[3 * number] = by_motion.Take(
            starts, ends, rng.integers(0, 6, n), rng.normal(size=(n, 9))
        )
    return takes


def all_candidates(
    query: by_motion.Query, takes: dict[int, by_motion.Take], distances: np.ndarray, n: int
) -> list[tuple[int, int, int, float]]:
    """Every window of every capture, those that overlap a better one left out, the best first."""
    scale, found = by_motion.distance_scale(distances), []
    for capture, take in takes.items():
        length, total = len(query.features), int(take.ends[-1])
        lows = {max(place, 0) for place in [*take.starts, *(take.ends - length)]}
        lows = {min(low, max(total - length, 0)) for low in lows}
        pairs = 1.0 - distances[np.ix_(query.symbols, take.symbols)] / scale
        aligned, first, last = by_motion._smith_waterman(
            pairs * query.weights[:, None], query.weights * by_motion.GAP
        )
        windows = []
        for low in sorted(lows):
            high = min(low + length, total)
            inside = np.minimum(take.ends, high) - np.maximum(take.starts, low)
            vector = unit((np.maximum(inside, 0.0) @ take.standardised)[None])[0]
            overlap = 0.0
            if last > first:
                a, b = take.starts[first], take.ends[last - 1]
                shared = max(min(high, b) - max(low, a), 0)
                overlap = shared / max(min(high - low, b - a), 1)
            windows.append(
                (0.5 * float(vector @ query.vector) + 0.5 * aligned * overlap, low, high)
            )
        kept: list[tuple[float, int, int]] = []
        for window in sorted(windows, key=lambda w: (-w[0], w[1])):
            _, low, high = window
            shares = (min(high, b) - max(low, a) for _, a, b in kept)
            if all(share < 0.5 * (high - low) for share in shares):
                kept.append(window)
        found += [(capture, low, high, rough) for rough, low, high in kept[:6]]
    return sorted(found, key=lambda c: (-c[3], c[0], c[1]))[:n]


@pytest.mark.parametrize("n_candidates", [1, 7, 60, 1000])
def test_candidates_are_those_of_a_full_scan(n_candidates: int) -> None:
    rng = np.random.default_rng(n_candidates)
    takes = makes(rng, 40)
    distances = rng.random((6, 6))
    distances = distances + distances.T
    np.fill_diagonal(distances, 0.0)
    for length in (30, 45, 500):  # no window lies within one segment, so that none are equal
        vector = unit(rng.normal(size=(1, 9)))[0]
        symbols = np.array([2, 0, 5])
        query = by_motion.Query(np.zeros((length, 2)), symbols, np.full(3, 1 / 3), vector)
        found = by_motion.find_candidates(query, takes, distances, n_candidates)
        expected = all_candidates(query, takes, distances, n_candidates)
        assert [(c.capture, c.start, c.end) for c in found] == [c[:3] for c in expected]
        np.testing.assert_allclose([c.rough for c in found], [c[3] for c in expected], atol=1e-12)
