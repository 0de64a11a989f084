"""Kinematics of robots: against 4x4 matrices, and by hand."""

import numpy as np
import pytest

from motiondb.body import hinges, rotation
from motiondb.body.hinges import Joint, Robot
from motiondb.body.joint_names import joint_map
from motiondb.files.readers.robot_model import read_robot
from motiondb.records import FloatArray
from tests import small_robot


def _turn(axis: FloatArray, angle: float) -> FloatArray:
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _matrix(turn: FloatArray | None = None, place: FloatArray | None = None) -> FloatArray:
    whole = np.eye(4)
    whole[:3, :3] = np.eye(3) if turn is None else turn
    whole[:3, 3] = 0.0 if place is None else place
    return whole


def _slow(robot: Robot, root: FloatArray, turn: FloatArray, values: FloatArray) -> FloatArray:
    """Places and turns of the links of one frame as matrices (links, 4, 4)."""
    found: list[FloatArray] = []
    for link, parent in enumerate(robot.parents):
        own = _matrix(rotation.to_matrix(robot.turns[link]), robot.places[link])
        whole = _matrix(rotation.to_matrix(turn), root) if parent < 0 else found[parent] @ own
        for number, joint in enumerate(robot.joints):
            if joint.link == link:
                value, axis = values[number] - joint.ref, np.array(joint.axis)
                anchor = np.array(joint.anchor)
                if joint.slides:
                    whole = whole @ _matrix(place=axis * value)
                else:
                    about = _matrix(_turn(axis, value))
                    whole = whole @ _matrix(place=anchor) @ about @ _matrix(place=-anchor)
        found.append(whole)
    return np.array(found)


def _random_robot(rng: np.random.Generator) -> Robot:
    links = 7
    joints = []
    for number in range(9):
        axis = rotation.normalize(rng.normal(size=3))
        joints.append(
            Joint(
                f"j{number}",
                int(rng.integers(1, links)),
                tuple(axis),
                tuple(rng.normal(size=3)),
                slides=number % 4 == 3,
                ref=float(rng.normal()),
            )
        )
    return Robot(
        "any",
        tuple(f"l{n}" for n in range(links)),
        np.array([-1, 0, 1, 1, 3, 0, 5]),
        rng.normal(size=(links, 3)),
        rotation.normalize(rng.normal(size=(links, 4))),
        tuple(joints),
    )


def test_poses_are_those_of_products_of_matrices() -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        robot = _random_robot(rng)
        values, root = rng.normal(size=(4, 9)), rng.normal(size=(4, 3))
        turns = rotation.normalize(rng.normal(size=(4, 4)))
        posed = hinges.pose(robot, root, turns, values)
        for frame in range(4):
            slow = _slow(robot, root[frame], turns[frame], values[frame])
            np.testing.assert_allclose(posed.places[frame], slow[:, :3, 3], atol=1e-12)
            fast = rotation.to_matrix(posed.turns[frame])
            np.testing.assert_allclose(fast, slow[:, :3, :3], atol=1e-12)


def test_clip_has_the_links_where_the_robot_has_them_with_y_up() -> None:
    rng = np.random.default_rng(4)
    robot = _random_robot(rng)
    posed = hinges.pose(
        robot,
        rng.normal(size=(3, 3)),
        rotation.normalize(rng.normal(size=(3, 4))),
        rng.normal(size=(3, 9)),
    )
    x, y, z = np.moveaxis(posed.places, -1, 0)
    actual = hinges.to_clip(robot, posed, 30.0).world_positions()
    np.testing.assert_allclose(actual, np.stack([x, z, -y], axis=-1), atol=1e-9)


def test_a_hinge_about_z_swings_a_hand_from_ahead_to_the_left() -> None:
    robot = Robot(
        "arm",
        ("base", "arm", "hand"),
        np.array([-1, 0, 1]),
        np.array([[0.0, 0, 0], [0, 0, 1.0], [0.5, 0, 0]]),
        np.tile(rotation.IDENTITY, (3, 1)),
        (Joint("turn", 1, (0.0, 0.0, 1.0)),),
    )
    posed = hinges.pose(robot, np.zeros((1, 3)), rotation.IDENTITY[None], np.array([[np.pi / 2.0]]))
    np.testing.assert_allclose(posed.places[0, 2], [0.0, 0.5, 1.0], atol=1e-12)


def test_mimics_follow_their_joint() -> None:
    axis = (1.0, 0.0, 0.0)
    joints = (Joint("a", 0, axis, mimics=(1, -2.0, 0.5)), Joint("b", 0, axis))
    still = np.zeros((1, 3))
    robot = Robot("m", ("l",), np.array([-1]), still, rotation.IDENTITY[None], joints)
    assert hinges.with_mimics(robot, np.array([[9.0, 0.25]])).tolist() == [[0.0, 0.25]]


@pytest.mark.parametrize("text", [small_robot.mjcf(), small_robot.urdf()])
def test_roles_of_a_robot_are_at_the_centres_of_its_joints(text: str) -> None:
    robot = read_robot(text.encode(), "small")
    clip = hinges.to_clip(robot, hinges.at_zero(robot), 30.0)
    names = {r: clip.joint_names[j] for r, j in joint_map(clip.skeleton).items()}
    assert names["l_hip"] == "left_hip_roll_joint"  # the thigh's yaw is 10 cm below it
    assert names["r_ankle"] == "right_ankle_roll_joint"
    assert names["r_shoulder"] == "right_shoulder_roll_joint"
    assert names["l_wrist"] == "left_hand"
    neck = clip.world_positions()[0, clip.joint_names.index("neck")]
    assert neck[1] == pytest.approx(0.4 + 0.07 * 0.62, abs=0.001)  # over the shoulders
