"""Frames in parts: workers of each part come to the same symbols as one array does."""

from __future__ import annotations

from typing import Any

import naive_acquisition as naive
import numpy as np
import pytest

from motiondb.records import IntArray
from motiondb.symbols import acquisition, hmm, spread
from motiondb.symbols.acquisition import AcquisitionSettings

plant: Any = naive.plant


@pytest.mark.parametrize(
    ("bounds", "firsts"),
    [
        ([0, 3, 5, 9], [0, 3]),  # near 3 and 6, where captures begin
        ([0, 9], [0]),  # a capture is never cut
        ([0, 1, 2, 3, 4, 5, 6, 7, 8, 9], [0, 3, 6]),
    ],
)
def test_parts_are_whole_captures(
    bounds: list[int], firsts: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spread, "PART_FRAMES", 4)
    frames = np.arange(9.0)[:, None]
    made = spread.spread(frames, np.array(bounds))
    assert [part.first for part in made.parts] == firsts
    np.testing.assert_array_equal(np.concatenate([part.frames for part in made.parts]), frames)


def test_no_frames_are_one_part() -> None:
    assert len(spread.spread(np.zeros((0, 2)), np.array([0])).parts) == 1


def test_parts_change_nothing_but_last_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    planted = plant(3, 4)
    args = (planted.bounds, planted.starts, planted.ends)
    settings = AcquisitionSettings(n_states=3, variance_floor=0.02)

    def learned(frames: spread.Frames) -> acquisition.Acquired:
        return acquisition.acquire(frames, *args, np.random.default_rng(0), settings)

    one = learned(planted.frames)
    monkeypatch.setattr(spread, "PART_FRAMES", 300)
    frames = spread.spread(planted.frames, planted.bounds)
    assert len(frames.parts) > 2
    several = learned(frames)
    for name, column in vars(one.cutting).items():
        np.testing.assert_array_equal(getattr(several.cutting, name), column)
    np.testing.assert_allclose(several.symbols.means, one.symbols.means, rtol=1e-9)
    scores = [hmm.score(one.symbols, f, *args[1:]) for f in (planted.frames, frames)]
    np.testing.assert_array_equal(*scores)


def test_intervals_lie_in_the_part_that_they_begin_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spread, "PART_FRAMES", 4)
    bounds: IntArray = np.array([0, 3, 3, 9])
    made = spread.spread(np.zeros((9, 1)), bounds)
    found = [(part.first, own.tolist()) for part, own in made.of_parts(np.array([4, 0, 2]))]
    assert found == [(0, [1, 2]), (3, [0])]
    spans = [
        (low, len(f)) for some in made.captures(bounds, 1.0) for low, f in spread.frames_of(some)
    ]
    assert spans == [(0, 3), (3, 0), (3, 6)]
