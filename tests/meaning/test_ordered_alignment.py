"""Actions of a caption over the segments of a take: against all paths, and what order decides."""

from __future__ import annotations

import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from motiondb.meaning.place_map import MOST_COST, SKIP, SPREAD, align_in_order
from motiondb.records import FloatArray


def enumerated(log_ratios: FloatArray, seconds: FloatArray | None = None) -> FloatArray:
    """The same by all rising sequences of states."""
    n_segments, n_actions = log_ratios.shape
    total, posterior = 0.0, np.zeros_like(log_ratios)
    for path in itertools.product(range(2 * n_actions + 1), repeat=n_segments):
        if any(later < earlier for earlier, later in itertools.pairwise(path)):
            continue
        shown = {state // 2 for state in path if state % 2}
        weight = SKIP * (n_actions - len(shown))
        weight += sum(log_ratios[i, s // 2] for i, s in enumerate(path) if s % 2)
        for k in shown if seconds is not None else ():
            assert seconds is not None
            lasts = sum(seconds[i] for i, state in enumerate(path) if state == 2 * k + 1)
            apart = np.log(lasts * n_actions / seconds.sum()) / SPREAD
            weight -= min(0.5 * apart**2, MOST_COST)
        total += np.exp(weight)
        for i, state in enumerate(path):
            if state % 2:
                posterior[i, state // 2] += np.exp(weight)
    return posterior / total


@pytest.mark.parametrize("durations", [None, (0.5, 4.0), (0.1, 40.0)])  # the last beyond the bound
@pytest.mark.parametrize(("n_segments", "n_actions"), [(1, 1), (1, 3), (3, 1), (4, 2), (4, 3)])
def test_posteriors_are_those_of_all_paths(
    n_segments: int, n_actions: int, durations: tuple[float, float] | None
) -> None:
    rng = np.random.default_rng(n_segments * 10 + n_actions)
    ratios = rng.normal(0.0, 3.0, (n_segments, n_actions))
    seconds = None if durations is None else rng.uniform(*durations, n_segments)
    expected = enumerated(ratios, seconds)
    assert align_in_order(ratios, seconds) == pytest.approx(expected, abs=1e-12)


def test_leaving_an_action_out_weighs_as_many_sequences_as_divide_its_blanks() -> None:
    """One action in n segments, all paths with it impossible: n + 1 sequences without it."""
    n, weighs = 6, 5.0
    ratios = np.full((n, 1), -100.0)
    ratios[2] = weighs
    shown = np.exp(weighs)
    expected = shown / (shown + (n + 1) * np.exp(SKIP))
    assert align_in_order(ratios)[2, 0] == pytest.approx(expected, abs=1e-12)


def test_a_large_take_is_aligned_without_durations_in_linear_memory() -> None:
    """4,000 segments: one matrix of segments by segments would take 128 MB."""
    ratios = np.full((4000, 3), -1.0)
    for k in range(3):
        ratios[1000 * k + 200 : 1000 * k + 900, k] = 1.0
    tracemalloc.start()
    placed = align_in_order(ratios, np.full(4000, 2.0))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 5e6
    assert placed == pytest.approx(align_in_order(ratios), abs=0.0)
    for k in range(3):
        assert (placed[1000 * k + 210 : 1000 * k + 890, k] > 0.99).all()
    assert (placed.sum(axis=1) <= 1.0 + 1e-9).all()


@pytest.mark.parametrize("most", [4, 5])
def test_durations_count_up_to_the_largest_number_of_segments(
    monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    rng = np.random.default_rng(3)
    ratios, seconds = rng.normal(0.0, 3.0, (5, 2)), rng.uniform(0.5, 4.0, 5)
    monkeypatch.setattr("motiondb.meaning.place_map.MOST_SEGMENTS", most)
    expected = enumerated(ratios, seconds if most == 5 else None)
    assert align_in_order(ratios, seconds) == pytest.approx(expected, abs=1e-12)


def test_an_action_with_faint_evidence_everywhere_leaves_room_for_the_next() -> None:
    ratios = np.column_stack([np.full(8, 2.0), np.zeros(8)])
    even, by_duration = align_in_order(ratios), align_in_order(ratios, np.full(8, 2.0))
    assert even[6, 0] > 2.0 * even[6, 1]
    assert by_duration[6, 1] > 2.0 * by_duration[6, 0]
    assert (by_duration[1:4, 0] > 0.95).all()


@given(
    npst.arrays(
        np.float64, st.tuples(st.integers(1, 9), st.integers(1, 5)), elements=st.floats(-30, 30)
    )
)
def test_posteriors_are_probabilities(ratios: FloatArray) -> None:
    placed = align_in_order(ratios)
    assert np.isfinite(placed).all()
    assert (placed >= 0.0).all()
    assert (placed.sum(axis=1) <= 1.0 + 1e-9).all()
