"""Edges of actions at the resolution of frames, in made-up takes with known truth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.meaning import edge_map, score_vectors
from motiondb.meaning.edge_map import EdgeMap, FrameTake, fit_edge_map, frame_cues, refine_interval
from motiondb.records import Float32Array, FloatArray

N_DIMS = 3


def standing(n: int, rng: np.random.Generator) -> FloatArray:
    return rng.normal(scale=0.2, size=(n, N_DIMS))


def jumping(n: int, rng: np.random.Generator) -> FloatArray:
    return np.array([2.0, -2.0, 0.0]) + rng.normal(scale=0.2, size=(n, N_DIMS))


def walking(n: int, rng: np.random.Generator) -> FloatArray:
    return np.array([-2.0, 0.0, 2.0]) + rng.normal(scale=0.2, size=(n, N_DIMS))


def take(frames: list[FloatArray], word: int) -> FrameTake:
    joined: Float32Array = np.concatenate(frames).astype(np.float32)
    return FrameTake(joined, (word,), np.ones((len(joined), 1)))


@pytest.fixture(scope="module")
def fitted() -> EdgeMap:
    """Captions of whole takes: eight stand, jump (word 0) and stand; four stand (word 1); eight
    walk (word 2) throughout."""
    rng = np.random.default_rng(0)
    takes = [take([standing(20, rng), jumping(10, rng), standing(20, rng)], 0) for _ in range(8)]
    takes += [take([standing(40, rng)], 1) for _ in range(4)]
    takes += [take([walking(40, rng)], 2) for _ in range(8)]
    return fit_edge_map(takes, 3)


def test_standing_around_a_jump_is_cut_off(fitted: EdgeMap) -> None:
    rng = np.random.default_rng(1)
    frames = np.concatenate([standing(30, rng), jumping(12, rng), standing(25, rng)])
    start, end = refine_interval(fitted.evidence(frames, [0]), (0, 67), (0, 67))
    assert abs(start - 30) <= 4
    assert abs(end - 42) <= 4


def test_an_activity_that_fills_its_take_is_kept_whole(fitted: EdgeMap) -> None:
    frames = walking(60, np.random.default_rng(2))
    assert refine_interval(fitted.evidence(frames, [2]), (0, 60), (0, 60)) == (0, 60)


def test_repeats_of_an_action_stay_together(fitted: EdgeMap) -> None:
    rng = np.random.default_rng(3)
    frames = np.concatenate(
        [
            standing(30, rng),
            jumping(12, rng),
            standing(20, rng),
            jumping(12, rng),
            standing(30, rng),
        ]
    )
    start, end = refine_interval(fitted.evidence(frames, [0]), (0, 104), (0, 104))
    assert abs(start - 30) <= 4
    assert abs(end - 74) <= 4


def test_an_interval_is_extended_up_to_its_limits() -> None:
    evidence = np.concatenate([np.zeros(20), np.ones(40), np.zeros(20)])
    assert refine_interval(evidence, (30, 40), (0, 80)) == (20, 60)
    assert refine_interval(evidence, (30, 40), (25, 50)) == (25, 50)


def test_without_positive_evidence_an_interval_stays() -> None:
    assert refine_interval(-np.ones(30), (3, 17), (0, 30)) == (3, 17)


@given(st.integers(0, 2**31), st.integers(1, 60))
def test_refined_intervals_are_not_empty_and_keep_to_their_limits(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    evidence = rng.normal(size=n)
    first, low, high, last = np.sort(rng.integers(0, n + 1, size=4))
    if low == high:
        low, high, first, last = 0, n, 0, n
    start, end = refine_interval(evidence, (int(low), int(high)), (int(first), int(last)))
    assert first <= start < end <= last


def test_a_take_left_out_is_predicted_as_if_the_map_were_fitted_without_it() -> None:
    rng = np.random.default_rng(4)
    takes = [take([standing(9, rng), jumping(4 + n, rng)], 0) for n in range(3)]
    takes.append(take([standing(90, rng), jumping(40, rng)], 0))  # more frames than cues
    shown = [rng.uniform(size=one.shown.shape) for one in takes]
    regression = edge_map._Regression(takes, 1)
    mean, products = (
        regression.mean(shown, 1),
        [regression.products(n, regression.cues(n), y) for n, y in enumerate(shown)],
    )
    slopes = regression.inverse @ np.sum(products, axis=0)
    for n in range(len(takes)):
        others = [k for k in range(len(takes)) if k != n]
        rows = np.concatenate([regression.cues(k) for k in others])
        target = np.concatenate(
            [np.sqrt(regression.weights[k]) * (shown[k] - mean) for k in others]
        )
        gram = rows.T @ rows + edge_map.RIDGE * np.eye(rows.shape[1])
        naive = np.linalg.solve(gram, rows.T @ target)
        expected = regression.cues(n) @ naive / np.sqrt(regression.weights[n])
        actual = regression.left_out(n, regression.cues(n), shown[n] - mean, slopes)
        np.testing.assert_allclose(actual, expected, atol=1e-8)


def test_cues_of_a_still_take_have_no_change() -> None:
    cues = frame_cues(np.zeros((5, 1)))
    levels = 0.5 + 0.5 * np.tanh(-np.array(score_vectors.LEVELS) / (2 * score_vectors.SOFTNESS))
    np.testing.assert_allclose(cues, np.tile(np.concatenate([levels, levels]), (5, 1)))


def test_of_many_frames_the_takes_of_rare_words_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edge_map, "RARE", 2)
    rng = np.random.default_rng(4)
    takes = [take([standing(10, rng)], int(word)) for word in [1, *np.zeros(17, int), 1, 0]]
    assert edge_map._enough(takes) is takes
    monkeypatch.setattr(edge_map, "MOST_FRAMES", 80)
    places = [n for n, one in enumerate(takes) if one in edge_map._enough(takes)]
    assert len(places) == 8
    assert {0, 18} <= set(places)
    assert max(np.diff(places)) <= 4
