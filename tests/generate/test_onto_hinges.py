"""Motion on the hinges of a robot, and in its files."""

import json
from pathlib import Path

import numpy as np
import pytest

from motiondb.body import hinges, retarget
from motiondb.files.arrays import write_robot
from motiondb.files.formats import read_capture
from motiondb.files.readers.robot_model import read_robot
from motiondb.generate import onto_hinges
from motiondb.generate.onto_hinges import FittedRobot, onto_robot
from motiondb.records import Clip
from tests import small_robot

ROBOT = read_robot(small_robot.mjcf().encode(), "small.xml")


def _own_walk() -> Clip:
    """The arms and the trunk of the walk over legs that stand, so that no foot slides."""
    root, turns, values = small_robot.walk(60)
    legs = [n for n, name in enumerate(small_robot.JOINTS) if "hip" in name or "knee" in name]
    values[:, legs] = values[0, legs]
    root, turns = np.tile(root[0], (60, 1)), np.tile(turns[0], (60, 1))
    order = [small_robot.JOINTS.index(name) for name in ROBOT.joint_names]
    return hinges.to_clip(ROBOT, hinges.pose(ROBOT, root, turns, values[:, order]), 30.0)


@pytest.fixture(scope="module")
def fitted() -> FittedRobot:
    return onto_robot(retarget.to_motion(_own_walk()), ROBOT)


def test_a_walk_of_the_robot_is_found_again_on_its_hinges(fitted: FittedRobot) -> None:
    assert fitted.joint_error < 0.015
    assert fitted.fit.foot_error < 0.01
    assert fitted.fit.driven == 21
    expected, actual = (
        retarget.to_motion(clip).joint_positions() for clip in (_own_walk(), fitted.motion.clip())
    )
    away = np.linalg.norm(actual - expected, axis=-1)
    assert away[:, [1, 2, 3, 5, 6, 7]].mean() < 0.03
    assert away.mean() < 0.05  # the canonical body has narrower shoulders


def test_hinges_stay_within_their_limits_and_move_smoothly(fitted: FittedRobot) -> None:
    for number, joint in enumerate(ROBOT.joints):
        assert joint.limits is not None
        low, high = joint.limits
        value = fitted.motion.values[:, number]
        assert low <= value.min() <= value.max() <= high
    assert np.abs(np.diff(fitted.motion.values, axis=0)).max() < 0.3


def test_slopes_are_those_of_small_steps() -> None:
    rng = np.random.default_rng(5)
    root, turns, values = small_robot.walk(2)
    values = values + rng.normal(scale=0.1, size=values.shape)
    links = np.array([ROBOT.links.index(n) for n in ("left_hand", "right_ankle_roll")])
    points = onto_hinges._Points(
        ("a", "b"), links, rng.normal(size=(2, 3)), np.zeros((2, 2, 3)), np.ones(2)
    )

    def at(values: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return onto_hinges._places(hinges.pose(ROBOT, root, turns, values), points)

    posed = hinges.pose(ROBOT, root, turns, values)
    moves = onto_hinges._moves(ROBOT, points)
    slopes = onto_hinges._slopes(ROBOT, posed, at(values), root, moves)
    for number in range(values.shape[1]):
        step = np.zeros_like(values)
        step[:, number] = 1e-6
        slow = (at(values + step) - at(values - step)) / 2e-6
        np.testing.assert_allclose(slopes[..., 6 + number], slow, atol=1e-7)


def test_written_files_are_read_back_as_the_same_motion(
    fitted: FittedRobot, tmp_path: Path
) -> None:
    (tmp_path / "small.xml").write_text(small_robot.mjcf())
    motion = fitted.motion
    expected = motion.clip().world_positions()
    for name in ("w.csv", "w.npz"):
        path = tmp_path / name
        beside = write_robot(path, ROBOT, 30.0, motion.root, motion.turns, motion.values)
        np.testing.assert_allclose(read_capture(path).world_positions(), expected, atol=1e-5)
        assert (beside is not None) == (name == "w.csv")
    said = json.loads((tmp_path / "w.json").read_text())
    assert said["quaternion_order"] == "x, y, z, w"
    assert said["columns"][7:] == list(ROBOT.joint_names)
    with np.load(tmp_path / "w.npz") as arrays:
        assert str(arrays["quaternion_order"]) == "w, x, y, z"
        turned = np.diff(np.unwrap(2.0 * np.arctan2(motion.turns[:, 3], motion.turns[:, 0])))
        spins = arrays["body_ang_vel_w"][1:-1, 0, 2]
        np.testing.assert_allclose(spins, (turned[1:] + turned[:-1]) * 15.0, atol=0.05)


def test_other_rates_and_tempos_keep_the_way(fitted: FittedRobot) -> None:
    fast = fitted.motion.resampled(50.0, 2.0)
    assert len(fast.root) == 50
    assert fast.fps == 50.0
    np.testing.assert_allclose(fast.root[25], fitted.motion.root[30], atol=1e-9)
    np.testing.assert_allclose(fast.values[5], fitted.motion.values[6], atol=1e-9)
