"""Decoding a capture into symbols, against all segmentations."""

from __future__ import annotations

import naive_hmm as naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols import hmm, network


def value_of(
    symbols: MotionSymbols, frames: FloatArray, way: list[tuple[int, int, int]], cost: float
) -> float:
    """What ``segment_by_symbols`` maximises, for a given segmentation."""
    total = -cost * (len(way) - 1)
    for start, end, s in way:
        total += max(p for _, p in naive.paths(symbols, s, frames[start:end], True))
    return total


@settings(deadline=None, max_examples=25)
@given(
    st.integers(0, 10**6),
    st.integers(3, 8),
    st.floats(-2, 4),
    st.integers(1, 4),
)
def test_best_of_all_segmentations(seed: int, n_frames: int, cost: float, shortest: int) -> None:
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [2, 1, 3], 2)
    frames = rng.normal(0, 1.5, (n_frames, 2))
    shortest = min(shortest, n_frames)
    way = hmm.segment_by_symbols(
        symbols,
        frames,
        switch_cost=cost,
        minimum_duration=shortest,
    )
    expected, _ = naive.best_segmentation(symbols, frames, cost, shortest)
    assert [a for a, _, _ in way] == [0, *(b for _, b, _ in way[:-1])]
    assert way[-1][1] == n_frames
    assert all(b - a >= max(shortest, symbols.n_states[s]) for a, b, s in way)
    assert value_of(symbols, frames, way, cost) == pytest.approx(expected, abs=1e-3)


def test_blocks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    symbols = naive.random_symbols(rng, [3, 2, 4, 3], 3)
    frames = rng.normal(0, 2, (90, 3))
    expected = hmm.segment_by_symbols(symbols, frames, switch_cost=3.0, minimum_duration=5)
    monkeypatch.setattr(network, "BLOCK_VALUES", 100)
    again = hmm.segment_by_symbols(symbols, frames, switch_cost=3.0, minimum_duration=5)
    assert again == expected
    assert len(expected) > 3


def test_samples_in_series_are_found_again() -> None:
    rng = np.random.default_rng(2)
    symbols = naive.random_symbols(rng, [4, 4, 4, 4], 6, spread=4.0)
    truth = [2, 0, 0, 3, 1, 2]
    parts = [hmm.sample(symbols, s, rng)[0] for s in truth]
    ends = np.cumsum([len(part) for part in parts])
    way = hmm.segment_by_symbols(symbols, np.concatenate(parts), switch_cost=5.0)
    assert [s for _, _, s in way] == truth
    assert [end for _, end, _ in way] == ends.tolist()


def test_too_short_for_any_symbol() -> None:
    symbols = naive.random_symbols(np.random.default_rng(3), [4, 3], 2)
    frames = symbols.means[1, :2]
    assert hmm.segment_by_symbols(symbols, frames) == [(0, 2, 1)]
    assert hmm.segment_by_symbols(symbols, symbols.means[0], minimum_duration=9) == [(0, 4, 0)]
    assert hmm.segment_by_symbols(symbols, np.zeros((0, 2))) == []


def test_error_texts() -> None:
    symbols = naive.random_symbols(np.random.default_rng(4), [2, 2], 2)
    with pytest.raises(MotionDBError) as caught:
        hmm.segment_by_symbols(symbols, np.zeros((5, 2)), minimum_duration=0)
    assert str(caught.value) == (
        "minimum_duration: expected at least 1 frame, found 0. Ask for more."
    )
