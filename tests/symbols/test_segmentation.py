"""Segmentation: tiles (A1), against brute force over all cuts, true changes found."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_motions import SAMPLES, sample_motion

from motiondb.body import features
from motiondb.records import FloatArray, Segment
from motiondb.symbols import segmentation
from motiondb.symbols.feature_space import fit_feature_space
from motiondb.symbols.segmentation import SegmentationSettings


def cost_of(values: FloatArray, cut_costs: FloatArray, cuts: list[int]) -> float:
    """The module's formula, term by term."""
    total = 0.0
    for start, end in pairwise(cuts):
        part = values[start:end]
        total += float(np.sum((part - part.mean(axis=0)) ** 2)) + float(cut_costs[start])
    return total


def all_cuts(n_frames: int, shortest: int, longest: int, start: int = 0) -> list[list[int]]:
    if start == n_frames:
        return [[start]]
    return [
        [start, *rest]
        for end in range(start + shortest, min(start + longest, n_frames) + 1)
        for rest in all_cuts(n_frames, shortest, longest, end)
    ]


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(2, 11), st.integers(1, 3), st.integers(0, 3))
def test_cuts_equal_brute_force_over_all_cut_sets(
    seed: int, n_frames: int, shortest: int, more: int
) -> None:
    rng = np.random.default_rng(seed)
    values, cut_costs = rng.normal(size=(n_frames, 2)), rng.uniform(0, 3, n_frames)
    longest = 2 * shortest - 1 + more
    cuts = segmentation.optimal_cuts(values, cut_costs, shortest, longest).tolist()
    every = all_cuts(n_frames, shortest, longest)
    if not every:
        assert cuts == [0, n_frames]
        return
    assert cuts in every
    best = min(cost_of(values, cut_costs, c) for c in every)
    assert cost_of(values, cut_costs, cuts) == pytest.approx(best)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.integers(0, 200), st.integers(1, 10), st.integers(0, 20))
def test_segments_tile_and_keep_their_bounds(
    seed: int, n_frames: int, shortest: int, more: int
) -> None:
    walk = np.cumsum(np.random.default_rng(seed).normal(size=(n_frames, 3)), axis=0)
    chosen = SegmentationSettings(shortest=shortest, longest=2 * shortest - 1 + more)
    segments = segmentation.segment(walk, chosen)
    if n_frames == 0:
        assert segments == []
        return
    assert segments[0].start == 0
    assert segments[-1].end == n_frames
    assert all(a.end == b.start for a, b in pairwise(segments))
    lengths = [s.end - s.start for s in segments]
    if n_frames >= 2 * shortest:
        assert min(lengths) >= shortest
        assert max(lengths) <= chosen.longest
    else:
        assert segments == [Segment(0, n_frames)]


def test_context_equals_a_loop() -> None:
    values = np.random.default_rng(0).normal(size=(20, 3))
    actual = segmentation.context(values, 5)
    for frame in range(20):
        window = values[max(0, frame - 2) : frame + 3]
        expected = np.concatenate([window.mean(axis=0), window.std(axis=0)]) / np.sqrt(3)
        np.testing.assert_allclose(actual[frame], expected, atol=1e-9)


def test_pose_speed_by_hand() -> None:
    np.testing.assert_allclose(
        segmentation.pose_speed(np.array([[0.0], [0.0], [2.0], [6.0]])), np.array([0, 1, 3, 4]) / 2
    )
    assert segmentation.pose_speed(np.ones((1, 4))).tolist() == [0.0]
    assert segmentation.pose_speed(np.ones((5, 4))).tolist() == [0.0] * 5


def test_true_boundaries_draw_cuts() -> None:
    """A quarter of a second around the cuts holds far more true boundaries than by chance."""
    names = ("ana/long_1", "boris/long_2", "chidi/long_3", "boris/long_fight_1")
    motions = [sample_motion(name) for name in names]
    raw = [features.recognition_features(m) for m in motions]
    space = fit_feature_space(raw)
    rows = (SAMPLES / "segments.tsv").read_text(encoding="utf-8").splitlines()
    header = rows[0].split("\t")
    hits, covered = [], []
    for name, values in zip(names, raw):
        table = [dict(zip(header, row.split("\t"))) for row in rows[1:] if f"{name}.bvh" in row]
        truth = [int(row["start_frame"]) // 2 for row in table][1:]
        cuts = np.array([s.start for s in segmentation.segment(space.project(values))][1:])
        near = np.abs(np.arange(len(values))[:, None] - cuts).min(axis=1) <= 4
        hits += near[truth].tolist()
        covered += near.tolist()
    assert len(hits) >= 40
    assert np.mean(hits) > 1.4 * np.mean(covered)


def test_threads_cut_at_the_same_time() -> None:
    """Nothing that is compiled holds the interpreter."""
    for kernel in (segmentation.context, segmentation._cut):
        assert kernel.targetoptions["nogil"]
