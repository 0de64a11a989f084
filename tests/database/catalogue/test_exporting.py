"""Motion as it leaves the database: its unit and its tempo."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sample_motions import sample_clip

from motiondb.database.catalogue.exporting import MotionChanges, changed, write_changed
from motiondb.errors import QueryError
from motiondb.files.formats import read_capture

CMU = 0.0254 / 0.45


def test_a_new_bvh_of_another_format_is_in_centimetres(tmp_path: Path) -> None:
    amc = replace(sample_clip("ana/bow_1"), format="amc", unit=CMU)
    path = tmp_path / "a.bvh"
    for asked, unit in (
        (MotionChanges(), 0.01),
        (MotionChanges(own_unit=True), CMU),
        (MotionChanges(unit=1.0), 1.0),
    ):
        assert write_changed(amc, path, asked).clip.unit == unit
        written = read_capture(path, unit=unit)
        np.testing.assert_allclose(written.root_positions, amc.root_positions, atol=1e-6)
    bvh = replace(amc, format="bvh")
    assert write_changed(bvh, path, MotionChanges()).clip.unit == CMU


def test_a_tempo_keeps_the_rate_and_the_way() -> None:
    clip = sample_clip("ana/walk_1")
    twice = changed(clip, MotionChanges(speed=2.0)).clip
    np.testing.assert_allclose(twice.root_positions, clip.root_positions[::2][: twice.n_frames])
    half = changed(clip, MotionChanges(speed=0.5)).clip
    assert (half.fps, half.n_frames) == (clip.fps, 2 * clip.n_frames)
    np.testing.assert_allclose(half.root_positions[1], clip.root_positions[:2].mean(axis=0))
    assert MotionChanges(speed=2.0).of_motion.are_any is False  # the file alone is faster


def test_a_tempo_of_no_use_is_refused(tmp_path: Path) -> None:
    with pytest.raises(QueryError, match=r"speed: expected 0\.1 to 10, found 0"):
        write_changed(sample_clip("ana/bow_1"), tmp_path / "a.bvh", MotionChanges(speed=0.0))
