"""Intervals, windows and why frames are left out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.curate import pieces
from motiondb.records import Finding, Quality

JUMP = Finding("jumps", "fault", 1.2, 1.3, 0.2, "m", 0.1, "l_wrist", "the left wrist jumps")
SEAT = Finding("sits", "needs", 2.5, 3.5, 0.5, "m", 0.1, "seat", "sits on something 50 cm high")


@given(
    st.lists(st.booleans(), min_size=1, max_size=40),
    st.lists(st.integers(0, 600), max_size=30),
    st.sampled_from([(1.0, 2.0), (2.0, 10.0)]),
)
def test_intervals_tile_what_is_kept_within_their_lengths(
    kept: list[bool], borders: list[int], lengths: tuple[float, float]
) -> None:
    mask = np.repeat(kept, 15)
    found, short = pieces.cut(3, sorted(borders), mask, *lengths)
    covered = np.zeros(len(mask), dtype=int)
    for each in found:
        assert each.capture == 3
        assert lengths[0] <= each.seconds <= lengths[1]
        covered[each.start : each.end] += 1
    assert np.array_equal(covered + short, mask.astype(int))


def test_intervals_end_at_borders() -> None:
    found, _ = pieces.cut(0, [10, 31, 40, 70, 95], np.ones(130, dtype=bool), 2.0, 10.0)
    assert [(each.start, each.end) for each in found] == [(0, 31), (31, 70), (70, 130)]


def test_windows_stand_for_all_seconds() -> None:
    intervals = [pieces.Interval(0, 10, 48), pieces.Interval(1, 0, 30)]
    found = pieces.windows_of(intervals)
    assert found.owner.tolist() == [0, 0, 0, 1, 1]
    assert found.first.tolist() == [10, 22, 33, 0, 15]
    assert found.seconds.sum() == pytest.approx(sum(each.seconds for each in intervals))


def test_distances_of_windows_are_those_of_their_poses() -> None:
    rng = np.random.default_rng(0)
    parts = [rng.normal(size=(40, 130)).astype(np.float32) for _ in range(2)]
    firsts = [np.array([0, 20]), np.array([5])]
    found, images = pieces.vectors(np.concatenate(list(map(pieces.poses, parts, firsts))))
    whole = [p[f : f + 15][list(pieces.POSES)].ravel() for p, s in zip(parts, firsts) for f in s]
    for a in range(3):
        for b in range(3):
            expected = np.linalg.norm(whole[a] - whole[b]) / np.sqrt(5 * 63)
            assert np.linalg.norm(found[a] - found[b]) == pytest.approx(
                expected, rel=1e-3, abs=1e-6
            )
    other = pieces.poses(pieces.mirrored(parts[0]), firsts[0])
    again = pieces.vectors(np.concatenate([other, pieces.poses(parts[0], firsts[0])]))
    for a in (0, 1):  # four points lie on three axes: what is kept of an image is its own
        assert np.linalg.norm(again[0][a] - again[1][a + 2]) < 1e-5
        assert np.linalg.norm(again[1][a] - again[0][a + 2]) < 1e-5
    assert images.shape == found.shape


def test_seconds_are_left_out_with_their_reason() -> None:
    quality = Quality((JUMP, SEAT), (), np.array([0.9, 0.3, 0.9, 0.5]), 0.0, ())
    found = pieces.runs_of(pieces.left_out(quality, 60, 0.8, False))
    assert found == [
        (0, 15, ""),
        (15, 30, "fault: jumps"),
        (30, 37, ""),
        (37, 45, "needs something: sits"),
        (45, 60, "fault: quality 0.50"),
    ]
    with_needs = pieces.runs_of(pieces.left_out(quality, 60, 0.4, True))
    assert [reason for *_, reason in with_needs] == ["", "fault: jumps", ""]


def test_where_nothing_is_learned_borders_are_where_the_body_rests() -> None:
    features = np.zeros((60, 130), dtype=np.float32)
    features[:, 0] = np.cumsum(1.0 + np.cos((np.arange(60) + 0.2) * 2.0 * np.pi / 20.0))
    found = [n for n in pieces.rests(features) if 0 < n < 59]
    assert found == [9, 29, 49]  # between frames 9 and 10, and so on
    assert pieces.rests(features[:1]) == []
