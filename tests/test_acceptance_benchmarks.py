"""X4: benchmarks split by performer, never by capture, and leave out copies and mirror images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import retarget
from motiondb.body.features import recognition_features
from motiondb.files.formats import read_capture
from motiondb.records import Motion
from quality_protocol import captures as quality

ROOT = Path(__file__).resolve().parents[1]


@given(st.lists(st.sampled_from("abcdefgh"), min_size=1, max_size=40), st.integers(1, 6))
def test_no_performer_is_on_both_sides(performers: list[str], n_folds: int) -> None:
    folds = quality.performer_folds(performers, n_folds)
    assert len(folds) == len(performers)
    assert ((folds >= 0) & (folds < n_folds)).all()
    for name in set(performers):
        assert len({int(f) for f, p in zip(folds, performers) if p == name}) == 1


def test_copies_and_mirror_images_are_left_out() -> None:
    walk, kick = (
        retarget.to_motion(read_capture(ROOT / f"sample_data/captures/{name}.bvh"))
        for name in ("ana/walk_1", "boris/kick_1")
    )

    def capture(name: str, motion: Motion) -> object:
        features = recognition_features(motion).astype(np.float32)
        return quality.Capture(name, name[0], ("said",), "", motion, features)

    captures = [
        capture("a/walk", walk),
        capture("b/kick", kick),
        capture("c/walk again", walk),
        capture("d/kick mirrored", retarget.mirror(kick)),
    ]
    kept = quality.without_copies(captures)
    assert [c.name for c in kept] == ["a/walk", "b/kick"]
