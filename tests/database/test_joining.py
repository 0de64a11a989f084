"""Joined parts: what is told is what is in the motion."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.records import MOTION_FPS


@pytest.mark.parametrize("parts", [("ana/walk_1", "ana/jump_1"), ("ana/bow_1:0-1", "ana/walk_1")])
def test_a_looped_join_tells_only_of_what_is_in_it(
    learned_file: Path, parts: tuple[str, str]
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        joined = db.join(parts, motiondb.MotionChanges(loop=True))
    frames = np.concatenate(
        [np.arange(*np.round(np.array([p.start, p.end]) * MOTION_FPS)) for p in joined.parts]
    )
    assert frames.tolist() == joined.provenance.source_frames.tolist()
    assert len(joined.seams) == len(joined.parts) - 1
    ends = np.cumsum([part.end - part.start for part in joined.parts])[:-1]
    assert [seam.seconds for seam in joined.seams] == pytest.approx(ends.tolist(), abs=1e-3)
    assert all(one.seconds < other.seconds for one, other in pairwise(joined.seams))
