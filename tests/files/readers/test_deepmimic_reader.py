"""DeepMimic's text: the rest pose, single joints, and the frame rate."""

from __future__ import annotations

import json

import numpy as np
import pytest

from motiondb.body import kinematics
from motiondb.body.joint_names import joint_map
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.deepmimic import read_deepmimic

REST = [0.033333, 0.0, 0.9, 0.0] + [1.0, 0, 0, 0] * 4 + [0.0] + [1.0, 0, 0, 0] * 2 + [0.0]
REST += [1.0, 0, 0, 0] + [0.0] + [1.0, 0, 0, 0] * 2 + [0.0]


def read(frames: object, **options):
    text = json.dumps({"Loop": "none", "Frames": frames})
    return read_deepmimic(text.encode(), "flip.txt", ReadOptions(**options))


def test_rest_pose_by_hand() -> None:
    clip = read([REST])
    positions, _ = kinematics.clip_positions(clip)
    places = dict(zip(clip.skeleton.names, positions[0]))
    np.testing.assert_allclose(places["right_ankle"], [0, 0.9 - 0.831416, 0.084887], atol=1e-9)
    np.testing.assert_allclose(places["left_hip"], [0, 0.9, -0.084887], atol=1e-9)
    np.testing.assert_allclose(
        places["left_elbow"], [-0.02405, 0.9 + 0.236151 + 0.2435 - 0.274788, -0.18311], atol=1e-9
    )
    assert clip.fps == 30.0
    assert (clip.format, clip.unit, clip.notes) == ("deepmimic", 1.0, ())
    assert len(joint_map(clip.skeleton)) >= 17


@pytest.mark.parametrize(("column", "joint"), [(20, "right_knee"), (34, "left_knee")])
def test_a_negative_knee_bends_backwards(column: int, joint: str) -> None:
    frame = list(REST)
    frame[column] = -np.pi / 2
    clip = read([frame])
    positions, _ = kinematics.clip_positions(clip)
    knee = clip.skeleton.names.index(joint)
    np.testing.assert_allclose(
        positions[0, knee + 1] - positions[0, knee], [-0.40987, 0, 0], atol=1e-9
    )


def test_quaternions_need_not_be_normal() -> None:
    frame = list(REST)
    frame[4:8] = [2.0, 0, 2.0, 0]
    np.testing.assert_allclose(read([frame]).local_rotations[0, 0], [0.5**0.5, 0, 0.5**0.5, 0])


def test_frame_rate() -> None:
    slow = [0.05, *REST[1:]]
    still = [0.0, *REST[1:]]
    assert read([slow, slow, still]).fps == 20.0
    assert read([slow], fps=60.0).fps == 60.0
    assert read([still]).notes == ("The frames last 0 s; 30 frames a second are taken.",)
    assert read([slow, slow, REST]).notes == (
        "The durations of frames differ; their median is taken.",
    )


def test_unit_and_bad_frames() -> None:
    clip = read([REST, REST[:40]], skip_bad_frames=True, unit=0.5)
    assert clip.notes == ("Left out 1 bad frames.",)
    assert clip.root_positions[0, 1] == 0.45
    assert clip.skeleton.offsets[1, 1] == pytest.approx(0.236151 / 2)
