"""The candidates of an example are those that a full scan finds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from made_tables import Made, takes_of

from motiondb.meaning import alignment, by_motion
from motiondb.meaning.resemblance import (
    fit_pooled_map,
    meaning_space,
    statistics_of_intervals,
    with_feedback,
)
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_map import WordMap


def makes(rng: np.random.Generator, n_captures: int) -> list[Made]:
    takes: list[Made] = []
    for number in range(n_captures):
        n = int(rng.integers(1, 12))
        ends = np.cumsum(rng.integers(4, 30, n))
        starts = np.concatenate([[0], ends[:-1]])
        takes.append((3 * number, starts, ends, rng.integers(0, 6, n), rng.normal(size=(n, 9))))
    return takes


Window = tuple[float, int, int, np.ndarray]  # Rough score, first frame, end, vector


def scan(query: by_motion.Query, take: Made, distances: np.ndarray) -> list[Window]:
    """Every window of a capture, the best first."""
    _, starts, ends, symbols, rows = (np.asarray(column) for column in take)
    length, total = len(query.features), int(ends[-1])
    lows = {max(place, 0) for place in [*starts, *(ends - length)]}
    lows = {min(low, max(total - length, 0)) for low in lows}
    pairs = 1.0 - distances[np.ix_(query.symbols, symbols)] / alignment.distance_scale(distances)
    aligned, first, last = alignment._smith_waterman(
        pairs * query.weights[:, None], query.weights * alignment.GAP
    )
    windows = []
    for low in sorted(lows):
        high = min(low + length, total)
        inside = np.minimum(ends, high) - np.maximum(starts, low)
        vector = unit((np.maximum(inside, 0.0) @ rows)[None])[0]
        overlap = 0.0
        if last > first:
            a, b = starts[first], ends[last - 1]
            overlap = max(min(high, b) - max(low, a), 0) / max(min(high - low, b - a), 1)
        rough = 0.5 * float(vector @ query.vector) + 0.5 * aligned * overlap
        windows.append((rough, int(low), int(high), vector))
    return sorted(windows, key=lambda w: (-w[0], w[1]))


def all_candidates(
    query: by_motion.Query,
    takes: list[Made],
    distances: np.ndarray,
    n: int,
    frames: dict[int, np.ndarray] | None = None,
) -> list[tuple[int, int, int, float]]:
    """All windows of all captures, those that overlap a better one left out, the best first."""
    scans = [scan(query, take, distances) for take in takes]
    gains = np.zeros(len(takes))
    if query.meaning is not None and frames is not None:
        best = [(take[0], *windows[0]) for take, windows in zip(takes, scans)]
        parts = [query.features, *(frames[c][low:high] for c, _, low, high, _ in best)]
        vectors = np.stack([query.vector, *(vector for *_, vector in best)])
        rows = query.meaning.rows(vectors, statistics_of_intervals(parts))
        alike = with_feedback(rows[1:] @ rows[0], rows[1:])
        gains = alike - np.array([vector @ query.vector for *_, vector in best])
    found = []
    for take, windows, gain in zip(takes, scans, gains):
        kept: list[tuple[int, int, float]] = []
        for rough, low, high, _ in windows:
            shares = (min(high, b) - max(low, a) for a, b, _ in kept)
            if all(share < 0.5 * (high - low) for share in shares):
                kept.append((low, high, rough + 0.5 * gain))
        found += [(take[0], *window) for window in kept[:6]]
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
        found = by_motion.find_candidates(query, takes_of(*takes), distances, n_candidates)
        expected = all_candidates(query, takes, distances, n_candidates)
        assert [(c.capture, c.start, c.end) for c in found] == [c[:3] for c in expected]
        np.testing.assert_allclose([c.rough for c in found], [c[3] for c in expected], atol=1e-6)


def made_query(
    rng: np.random.Generator, frames: dict[int, np.ndarray], *, second: bool
) -> by_motion.Query:
    """An example that words are used for, by a second opinion too or not."""
    statistics = statistics_of_intervals(list(frames.values()))
    pooled = fit_pooled_map(statistics, rng.random((len(frames), 5)) < 0.3) if second else None
    words = WordMap(rng.normal(size=(9, 5)), np.zeros(5), np.ones(5), np.ones(5), np.ones(3))
    vector, symbols = unit(rng.normal(size=(1, 9)))[0], np.array([2, 0, 5])
    space = meaning_space(words, 2, pooled=pooled, dtype=np.float64)
    return by_motion.Query(frames[30][:30], symbols, np.full(3, 1 / 3), vector, space)


@pytest.mark.parametrize("second", [True, False])
@pytest.mark.parametrize("n_candidates", [3, 20, 1000])
def test_rows_that_cannot_matter_are_not_computed(n_candidates: int, second: bool) -> None:
    rng = np.random.default_rng(n_candidates)
    takes = makes(rng, 300)
    distances = np.ones((6, 6)) - np.eye(6)
    frames = {take[0]: rng.normal(size=(int(take[2][-1]), 2)).astype("f4") for take in takes}
    query = made_query(rng, frames, second=second)
    looked: list[int] = []

    def frames_of(intervals: list[tuple[int, int, int]]) -> list[np.ndarray]:
        looked.extend(capture for capture, *_ in intervals)
        return [frames[capture][low:high] for capture, low, high in intervals]

    table = takes_of(*takes, space=query.meaning)
    found = by_motion.find_candidates(query, table, distances, n_candidates, frames_of=frames_of)
    expected = all_candidates(query, takes, distances, n_candidates, frames)
    assert [(c.capture, c.start, c.end) for c in found] == [c[:3] for c in expected]
    np.testing.assert_allclose([c.rough for c in found], [c[3] for c in expected], atol=1e-6)
    assert len(looked) == len(set(looked))
    assert len(looked) < 300 or n_candidates == 1000
    assert second or not looked


@pytest.mark.parametrize("words", [True, False])
def test_a_copy_comes_after_its_original(words: bool) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        takes = [(*made[:4], rng.normal(size=(len(made[1]), 300))) for made in makes(rng, 30)]
        takes.append((999, *takes[0][1:]))  # the last row of a product is where BLAS differs
        vector, symbols = unit(rng.normal(size=300)), np.array([2, 0, 5])
        fit = WordMap(rng.normal(size=(300, 50)), np.ones(50), *np.ones((2, 50)), np.ones(3))
        space, features = meaning_space(fit, 20) if words else None, np.zeros((30, 2))
        query = by_motion.Query(features, symbols, np.full(3, 1 / 3), vector, space)
        table = takes_of(*takes, space=query.meaning)
        found = by_motion.find_candidates(query, table, np.ones((6, 6)) - np.eye(6), 1000)
        copies = [(c.rough, c.capture, c.start) for c in found if c.capture in (0, 999)]
        assert copies == sorted(copies, key=lambda c: (-c[0], c[1], c[2]))
        own, other = ([(c[0], c[2]) for c in copies if c[1] == n] for n in (0, 999))
        assert own == other


def test_candidates_are_those_of_a_full_scan_where_segments_cancel(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bounded = by_motion._largest

    def scanned(
        bounds: np.ndarray, _: int, values_of: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        values = values_of(np.arange(len(bounds)))
        assert (values <= bounds).all()
        return values

    def frames_of(intervals: list[tuple[int, int, int]]) -> list[np.ndarray]:
        return [frames[capture][low:high] for capture, low, high in intervals]

    for seed in range(8):
        rng = np.random.default_rng(seed)
        base, takes, frames = rng.normal(size=300), [], {}
        for number in range(150):
            row = rng.normal(size=300)
            rest = base * 10 ** rng.uniform(-7, -2)
            rows = np.clip(np.stack([row, rest - row]), -3, 3)
            takes.append((number, [0, 15], [15, 30], [0, 1], rows))
            frames[number] = rng.normal(size=(30, 4)).astype("f4")
        pooled = fit_pooled_map(
            statistics_of_intervals(list(frames.values())), rng.random((150, 50)) < 0.3
        )
        fit = WordMap(rng.normal(size=(300, 50)), np.ones(50), *np.ones((2, 50)), np.ones(3))
        space = meaning_space(fit, 20, pooled=pooled)
        query = by_motion.Query(frames[3], np.array([2, 0]), np.full(2, 0.5), unit(base), space)
        table, distances = takes_of(*takes, space=space), np.ones((6, 6)) - np.eye(6)
        found = []
        for largest in (bounded, scanned):
            monkeypatch.setattr(by_motion, "_largest", largest)
            found.append(by_motion.find_candidates(query, table, distances, 10, frames_of))
        assert [c.capture for c in found[0]] == [c.capture for c in found[1]]
