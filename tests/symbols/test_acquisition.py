"""Competitive learning: planted symbols are found again, and every update shortens L."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from typing import Any

import naive_acquisition as naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_hmm import random_symbols

from motiondb.errors import MotionDBError
from motiondb.symbols import acquisition, hmm, segmentation
from motiondb.symbols.acquisition import Acquired, AcquisitionSettings
from motiondb.symbols.spread import as_spread

Planted: Any = naive.Planted
plant, rand_index = naive.plant, naive.rand_index

SMALL = AcquisitionSettings(n_states=3, variance_floor=0.02)


def learn(planted: Planted, chosen: AcquisitionSettings = SMALL, seed: int = 0) -> Acquired:
    rng = np.random.default_rng(seed)
    cuts = (planted.bounds, planted.starts, planted.ends)
    return acquisition.acquire(planted.frames, *cuts, rng, chosen)


def frame_labels(acquired: Acquired) -> np.ndarray:
    cutting = acquired.cutting
    return np.repeat(cutting.winners, cutting.ends - cutting.starts)


def check_sound(acquired: Acquired, planted: Planted) -> None:
    """Segments tile the captures (A1), winners are arg-max (A2), symbols left-to-right (A4)."""
    cutting, symbols = acquired.cutting, acquired.symbols
    assert np.all(cutting.ends > cutting.starts)
    np.testing.assert_array_equal(cutting.starts[1:], cutting.ends[:-1])
    assert (cutting.starts[0], cutting.ends[-1]) == (0, len(planted.frames))
    assert set(planted.bounds) <= {0, *cutting.ends.tolist()}
    scores = hmm.score(symbols, planted.frames, cutting.starts, cutting.ends)
    np.testing.assert_array_equal(cutting.winners, scores.argmax(axis=1))
    assert acquired.scores is None or np.array_equal(acquired.scores, scores)
    assert symbols.means.shape == symbols.covars.shape
    assert symbols.self_loops.shape == symbols.means.shape[:2]
    real = np.arange(symbols.self_loops.shape[1]) < symbols.n_states[:, None]
    assert np.all((symbols.self_loops[real] > 0) & (symbols.self_loops[real] < 1))
    assert np.all(symbols.self_loops[~real] == 0)
    assert np.all(np.isfinite(symbols.means))
    assert np.all(symbols.covars > 0)


@pytest.mark.parametrize(("n_symbols", "n_states"), [(1, 3), (5, 3), (10, 3), (10, 6)])
def test_planted_symbols_are_found_again(n_symbols: int, n_states: int) -> None:
    for seed in range(3):
        planted = plant(seed, n_symbols, n_states=n_states)
        chosen = replace(SMALL, n_states=n_states)
        first = learn(planted, replace(chosen, recuts=0), seed)
        assert abs(first.symbols.n_symbols - n_symbols) <= 0.2 * n_symbols
        assert rand_index(planted.truth, first.cutting.winners) > 0.95
        learned = learn(planted, chosen, seed)
        assert abs(learned.symbols.n_symbols - n_symbols) <= 0.2 * n_symbols
        assert rand_index(planted.labels, frame_labels(learned)) > 0.95
        check_sound(learned, planted)


def test_symbols_are_found_in_captures_cut_in_the_wrong_places() -> None:
    """The first segmentation knows nothing of the symbols; recutting mends it."""
    planted = plant(3, 6, n_each=25)
    cuts = np.concatenate(
        [np.arange(low, high - 8, 11) for low, high in pairwise(planted.bounds)]
    )  # every 11 frames, the last segment of a capture up to 18
    wrong = replace(planted, starts=cuts, ends=np.append(cuts[1:], len(planted.frames)))
    uncut = learn(wrong, replace(SMALL, recuts=0))
    recut = learn(wrong, replace(SMALL, recuts=8))
    check_sound(recut, wrong)
    before, after = (rand_index(planted.labels, frame_labels(a)) for a in (uncut, recut))
    assert after > before + 0.1
    assert recut.description_lengths[-1] < uncut.description_lengths[-1]


def test_description_lengths_strictly_fall_and_end_at_what_the_twin_counts() -> None:
    planted = plant(1, 5, variance=1.5)
    learned = learn(planted)
    assert len(learned.description_lengths) > 1
    assert np.all(np.diff(learned.description_lengths) < 0)
    cutting = learned.cutting
    counted = naive.description_length(
        learned.symbols, planted.frames, cutting.starts, cutting.ends
    )
    assert learned.description_lengths[-1] == pytest.approx(counted, rel=1e-6)


def test_description_length_by_hand() -> None:
    """2 symbols of 1 and 2 states in 2 dimensions, 50 frames: 5 + 4 ln 2 + 3 * 5 / 2 ln 50."""
    symbols = random_symbols(np.random.default_rng(0), [1, 2], 2)
    bits = acquisition.description_length(-5.0, 4, symbols, 50)
    assert bits == pytest.approx(5 + 4 * 0.693147181 + 7.5 * 3.912023005)


def test_the_same_seed_gives_the_same_symbols_and_another_seed_sound_ones() -> None:
    planted = plant(2, 6, variance=0.5)
    first, again, other = learn(planted), learn(planted), learn(planted, seed=9)
    for part in ("n_states", "self_loops", "means", "covars"):
        np.testing.assert_array_equal(getattr(first.symbols, part), getattr(again.symbols, part))
    for part in ("starts", "ends", "winners"):
        np.testing.assert_array_equal(getattr(first.cutting, part), getattr(again.cutting, part))
    assert first.description_lengths == again.description_lengths
    check_sound(other, planted)


@pytest.mark.parametrize("n_symbols", [1, 2, 7, 30])
def test_a_given_number_of_symbols_is_kept_exactly(n_symbols: int) -> None:
    planted = plant(4, 5)
    learned = learn(planted, replace(SMALL, n_symbols=n_symbols))
    assert learned.symbols.n_symbols == n_symbols
    assert np.all(np.diff(learned.description_lengths) < 0)
    check_sound(learned, planted)


def test_no_more_symbols_than_allowed() -> None:
    planted = plant(6, 10)
    assert learn(planted, replace(SMALL, max_symbols=4)).symbols.n_symbols <= 4


def test_all_frames_equal() -> None:
    planted = plant(10, 2, n_each=5)
    still = replace(planted, frames=np.ones_like(planted.frames))
    learned = learn(still)
    assert learned.symbols.n_symbols == 1
    np.testing.assert_allclose(learned.symbols.means, 1.0)
    np.testing.assert_allclose(learned.symbols.covars, SMALL.variance_floor)
    check_sound(learned, still)


def test_error_texts() -> None:
    planted = plant(11, 2, n_each=3)
    nothing = np.zeros(0, dtype=np.int64)
    none = Planted(planted.frames[:0], np.array([0]), nothing, nothing, nothing)
    still = replace(planted, frames=np.ones_like(planted.frames))
    wrong = [
        (none, None, "learn: expected at least one segment, found none. Add captures first."),
        (
            planted,
            7,
            "expected a number of symbols from 1 to 6 (the segments that differ), found 7",
        ),
        (still, 2, "from 1 to 1 (the segments that differ), found 2. Ask for fewer symbols, or"),
        (planted, -1, "found -1"),
    ]
    for captures, n_symbols, text in wrong:
        with pytest.raises(MotionDBError, match=re.escape(text)):
            learn(captures, replace(SMALL, n_symbols=n_symbols))


def test_equal_symbols_tie_to_the_lowest_and_the_others_leave() -> None:
    one = random_symbols(np.random.default_rng(12), [3], 2)
    twins = acquisition.take(one, np.array([0, 0, 0]))
    frames = np.random.default_rng(13).normal(0, 1, (12, 2))
    scores = hmm.score(twins, frames, np.array([0, 6]), np.array([6, 12]))
    np.testing.assert_array_equal(scores.argmax(axis=1), [0, 0])
    left, winners = acquisition._drop_idle(twins, np.array([2, 0, 2]))
    assert left.n_symbols == 2
    np.testing.assert_array_equal(winners, [1, 0, 1])


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 6))
def test_symbols_die_as_in_the_twin(seed: int, n_segments: int, n_symbols: int) -> None:
    rng = np.random.default_rng(seed)
    scores = rng.normal(-500, rng.choice([1.0, 60.0]), (n_segments, n_symbols)).astype(np.float32)
    symbols = random_symbols(rng, rng.integers(1, 4, n_symbols).tolist(), 2)
    ends = 10 * np.arange(1, n_segments + 1)
    frames = np.zeros((10 * n_segments, 2), dtype=np.float32)
    arena = acquisition._Arena(as_spread(frames), ends - 10, ends, np.ones(2), SMALL, rng)
    state = acquisition._State(symbols, scores, scores.argmax(axis=1), 0.0)
    left = acquisition._kill(arena, state)
    prices = 0.5 * symbols.n_states * 5 * np.log(len(frames))
    alive = naive.symbols_that_pay(scores.astype(float), prices)
    expected = acquisition.take(symbols, np.array(alive))
    np.testing.assert_array_equal((left or state).symbols.means, expected.means)
    np.testing.assert_array_equal((left or state).scores, scores[:, alive])
    assert (left is None) == (len(alive) == n_symbols)


def test_two_symbols_that_share_one_movement_become_one() -> None:
    planted = plant(16, 1, n_each=12)
    starts, ends = planted.starts, planted.ends
    floor, rng = np.full(4, SMALL.variance_floor), np.random.default_rng(0)
    arena = acquisition._Arena(as_spread(planted.frames), starts, ends, floor, SMALL, rng)
    halves = np.arange(12) % 2
    two = acquisition._judge(arena, acquisition._fit_new(arena, starts, ends, halves))
    one = acquisition._thin(arena, two)
    assert one is not None
    assert one.symbols.n_symbols == 1
    assert one.length < two.length
    np.testing.assert_array_equal(one.scores, arena.score(one.symbols))
    assert acquisition._thin(arena, one) is None


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 20), st.integers(1, 8))
def test_seed_groups_are_numbered_without_gaps(seed: int, n: int, n_groups: int) -> None:
    rng = np.random.default_rng(seed)
    descriptors = rng.integers(0, 3, (n, 2)).astype(float)
    groups = acquisition.seed_groups(descriptors, n_groups, rng)
    expected = min(n_groups, len(np.unique(descriptors, axis=0)))
    np.testing.assert_array_equal(np.unique(groups), np.arange(expected))


def test_segments_are_described_by_their_thirds() -> None:
    frames = np.arange(12, dtype=np.float32)[:, None]
    actual = acquisition.describe_segments(frames, np.array([0, 6, 11]), np.array([6, 11, 12]))
    np.testing.assert_allclose(actual, [[0.5, 2.5, 4.5], [6, 7.5, 9.5], [11, 11, 11]])


def test_take_and_join_undo_each_other() -> None:
    symbols = random_symbols(np.random.default_rng(14), [3, 1, 2, 3], 2)
    low, high = (acquisition.take(symbols, np.array(which)) for which in ([0, 1], [2, 3]))
    joined = acquisition.join(low, high)
    for part in ("n_states", "self_loops", "means", "covars"):
        np.testing.assert_array_equal(getattr(joined, part), getattr(symbols, part))


def test_progress_is_told() -> None:
    planted = plant(15, 3)
    told: list[tuple[str, float]] = []
    cuts = (planted.bounds, planted.starts, planted.ends)
    rng = np.random.default_rng(0)
    acquisition.acquire(planted.frames, *cuts, rng, SMALL, lambda *at: told.append(at))
    assert told[0] == ("symbols compete", 0.0)
    assert {what for what, _ in told} == {"symbols compete", "cutting anew"}
    assert all(0 <= share < 1 for _, share in told)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.lists(st.integers(0, 60), min_size=1, max_size=5).filter(any))
def test_any_captures_give_sound_symbols(seed: int, lengths: list[int]) -> None:
    """From first segmentation to symbols, whatever the captures' lengths."""
    rng = np.random.default_rng(seed)
    bounds = np.concatenate([[0], np.cumsum(lengths)])
    frames = np.cumsum(rng.normal(0, 0.4, (bounds[-1], 4)), axis=0).astype(np.float32)
    cuts = [
        (low + part.start, low + part.end)
        for low, high in pairwise(bounds)
        for part in segmentation.segment(frames[low:high].astype(float))
    ]
    starts, ends = np.array(cuts).T
    captures = Planted(frames, bounds, starts, ends, np.zeros(len(cuts), dtype=np.int64))
    learned = learn(captures, AcquisitionSettings())
    check_sound(learned, captures)
    assert np.all(np.diff(learned.description_lengths) < 0)


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
        before = naive.total_length(scores, prices, alive)
        every = [
            before - naive.total_length(scores, prices, [s for s in alive if s != d]) for d in alive
        ]
        assert gain == pytest.approx(max(every))
        alive.remove(dead)
        assert gain == pytest.approx(before - naive.total_length(scores, prices, alive))
