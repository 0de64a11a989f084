"""From captures to the canonical body: rotations that give positions back, and never flip."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_motions import sample_clip

from motiondb.body import body, kinematics, retarget, rotation
from motiondb.errors import SkeletonError
from motiondb.records import MOTION_FPS, Clip, FloatArray, Motion, Skeleton

MotionMaker = Callable[..., Motion]
few = settings(deadline=None, max_examples=10)
I = body.INDEX  # noqa: E741


def angles_between_frames(motion: Motion) -> FloatArray:
    """How far every joint turns from a frame to the next: array (frames - 1, 21), radians."""
    q = motion.local_rotations.astype(np.float64)
    dots = np.abs(np.sum(rotation.normalize(q[1:]) * rotation.normalize(q[:-1]), axis=-1))
    return 2.0 * np.arccos(np.clip(dots, 0.0, 1.0))


def posed(**turns: FloatArray) -> FloatArray:
    """Positions (frames, 21, 3) of the body with the Euler angles (frames, 3), XYZ, of joints."""
    n_frames = len(next(iter(turns.values())))
    local = np.tile(rotation.IDENTITY, (n_frames, 21, 1))
    for joint, angles in turns.items():
        local[:, I[joint]] = rotation.from_euler(angles, "XYZ")
    root = np.tile([0.0, 0.93, 0.0], (n_frames, 1))
    return kinematics.forward(body.PARENTS, body.OFFSETS, local, root)[0]


def sweep(*ends: tuple[float, float], n_frames: int = 60) -> FloatArray:
    """Angles (frames, 3) that go from one to another, degrees, with a soft start and end."""
    share = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, n_frames))
    return np.stack([low + (high - low) * share for low, high in ends], axis=1)


@few
@given(st.integers(0, 10**6))
def test_swings_come_back_as_positions(make_motion: MotionMaker, seed: int) -> None:
    motion = make_motion(30, seed, 0.8)
    positions, _ = retarget.motion_positions(motion)
    solved = retarget.solve_rotations(positions)
    again, _ = kinematics.forward(body.PARENTS, body.OFFSETS, solved, positions[:, 0])
    np.testing.assert_allclose(again, positions, atol=1e-5)


def test_a_solved_body_has_its_limbs_where_the_points_are(make_motion: MotionMaker) -> None:
    """Also one whose neck is not as far over its shoulders as the canonical body's."""
    points = make_motion(3, 40).joint_positions()
    trunk = [body.INDEX[name] for name in ("neck", "head")]
    points[:, trunk] -= 0.05 * (points[:, trunk[:1]] - points[:, :1])
    skeleton, turns = retarget.solved_body(points)
    places, _ = kinematics.forward(skeleton.parents, skeleton.offsets, turns, points[:, 0])
    limbs = [n for n, name in enumerate(body.JOINTS) if name[0] in "lr" and name[2:] != "collar"]
    apart = np.linalg.norm(places[:, limbs] - points[:, limbs], axis=-1)
    assert apart.mean() < 0.01


def test_a_t_pose_has_no_rotation() -> None:
    solved = retarget.solve_rotations(posed(pelvis=np.zeros((2, 3))))
    np.testing.assert_allclose(solved, np.tile(rotation.IDENTITY, (2, 21, 1)), atol=1e-9)


MOVES = {
    "arms overhead and down behind": {
        "l_shoulder": sweep((0, 0), (0, -30), (-80, 100)),
        "r_shoulder": sweep((0, 0), (0, 30), (80, -100)),
    },
    "a high kick ahead": {"l_hip": sweep((0, -150), (0, 0), (0, 15))},
    "a kick to the side": {"r_hip": sweep((0, -20), (0, 0), (0, -120))},
    "heel to seat": {"l_knee": sweep((0, 150), (0, 0), (0, 0))},
    "a full turn": {"pelvis": sweep((0, 0), (0, 360), (0, 0))},
    "a somersault": {
        "pelvis": sweep((0, 360), (0, 0), (0, 0)),
        "l_hip": sweep((0, -110), (0, 0), (0, 0)),
    },
    "a cartwheel": {
        "pelvis": sweep((0, 0), (0, 0), (0, 360)),
        "l_hip": sweep((0, 0), (0, 0), (0, 60)),
    },
    "a deep bow": {
        "spine": sweep((0, 60), (0, 0), (0, 0)),
        "chest": sweep((0, 60), (0, 0), (0, 0)),
    },
    "elbows folded": {
        "l_elbow": sweep((0, 0), (0, -150), (0, 0)),
        "r_elbow": sweep((0, 0), (0, 150), (0, 0)),
    },
}


@pytest.mark.parametrize("move", list(MOVES))
def test_nothing_flips(move: str) -> None:
    motion = retarget.motion_from_positions(posed(**MOVES[move]), MOTION_FPS)
    fastest = max(np.abs(np.diff(a, axis=0)).max() for a in MOVES[move].values())
    assert angles_between_frames(motion).max() < 3.0 * np.deg2rad(fastest)
    dots = np.sum(motion.local_rotations[1:] * motion.local_rotations[:-1], axis=-1)
    assert dots.min() > 0


@few
@given(st.integers(0, 10**6), st.floats(0.3, 2.5))
def test_bone_lengths_are_constant_whatever_the_source(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    points = posed(l_hip=sweep((0, -60), (0, 0), (0, 10))) * size
    motion = retarget.motion_from_positions(points + rng.normal(0, 0.01, points.shape), 30.0)
    positions, _ = retarget.motion_positions(motion)
    bones = np.linalg.norm(positions[:, 1:] - positions[:, body.PARENTS[1:]], axis=-1)
    lengths = np.linalg.norm(body.OFFSETS[1:], axis=-1)
    np.testing.assert_allclose(bones, np.broadcast_to(lengths, bones.shape), atol=1e-5)


def test_the_mirror_image_of_the_mirror_image(make_motion: MotionMaker) -> None:
    motion = make_motion(20, 4)
    mirrored = retarget.mirror(motion)
    here, _ = retarget.motion_positions(motion)
    there, _ = retarget.motion_positions(mirrored)
    np.testing.assert_allclose(there, here[:, body.MIRROR] * [-1, 1, 1], atol=1e-6)
    back = retarget.mirror(mirrored)
    np.testing.assert_array_equal(back.local_rotations, motion.local_rotations)
    np.testing.assert_array_equal(back.root_positions, motion.root_positions)


def test_resampling_by_hand() -> None:
    points = np.arange(8.0)[:, None, None] * np.ones((1, 21, 3))
    np.testing.assert_allclose(retarget.resample(points, 120.0)[:, 0, 0], [0.0, 4.0])
    np.testing.assert_allclose(retarget.resample(points[:3], 15.0)[:, 0, 0], [0, 0.5, 1, 1.5, 2, 2])
    np.testing.assert_array_equal(retarget.resample(points, 30.0), points)
    assert len(retarget.resample(points[:1], 120.0)) == 1


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 50), st.floats(5.0, 250.0))
def test_resampling_keeps_the_duration(n_frames: int, fps: float) -> None:
    resampled = retarget.resample(np.zeros((n_frames, 2, 3)), fps)
    assert abs(len(resampled) / 30.0 - n_frames / fps) <= max(
        1 / 60 + 1e-9, 1 / 30 - n_frames / fps
    )


def test_feet_stand_on_the_ground_and_the_start_is_the_origin() -> None:
    points = posed(l_shoulder=sweep((0, 0), (0, 0), (0, -70))) + np.array([3.0, 7.0, -2.0])
    motion = retarget.motion_from_positions(points, 30.0)
    positions, _ = retarget.motion_positions(motion)
    assert retarget.ground_height(positions) == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(motion.root_positions[0, [0, 2]], 0.0, atol=1e-7)


def test_to_clip_gives_the_performers_size_back() -> None:
    points = posed(l_hip=sweep((0, -60), (0, 0), (0, 0))) * 0.5
    motion = retarget.motion_from_positions(points, 30.0)
    positions, _ = kinematics.clip_positions(retarget.to_clip(motion))
    np.testing.assert_allclose(positions - positions[:1, :1], points - points[:1, :1], atol=1e-5)
    again = retarget.to_motion(retarget.to_clip(replace(motion, leg_length=1.7)))
    np.testing.assert_allclose(again.root_positions, motion.root_positions, atol=1e-5)
    assert again.leg_length == pytest.approx(1.7)


def clip_of(points: FloatArray, drop: tuple[str, ...] = ()) -> Clip:
    """A clip whose joints, all children of the first, stand at given points."""
    keep = [n for n, joint in enumerate(body.JOINTS) if joint not in drop]
    names = tuple(body.JOINTS[n] for n in keep)
    moved = points[:, keep] - points[:, :1]
    moved[:, 0] = points[:, 0]
    parents = np.zeros(len(keep), dtype=np.int64)
    parents[0] = -1
    turns = np.tile(rotation.IDENTITY, (len(points), len(keep), 1))
    skeleton = Skeleton(names, parents, np.zeros((len(keep), 3)))
    return Clip(skeleton, 30.0, turns, points[:, 0], joint_positions=moved)


def test_lacking_joints_are_placed_by_hand() -> None:
    points = posed(pelvis=np.zeros((3, 3)))
    lacking = ("spine", "chest", "head", "l_wrist", "r_wrist", "l_toe", "r_toe")
    actual = retarget.clip_keypoints(clip_of(points, lacking))
    neck, pelvis = points[:, I["neck"]], points[:, 0]
    np.testing.assert_allclose(actual[:, I["spine"]], pelvis + 0.24 * (neck - pelvis))
    np.testing.assert_allclose(actual[:, I["chest"]], pelvis + 0.62 * (neck - pelvis))
    np.testing.assert_allclose(actual[:, I["head"]], neck + 0.4 * 0.38 * (neck - pelvis))
    np.testing.assert_allclose(actual[:, I["l_wrist"], 0], 0.17 + 0.28 + 0.9 * 0.28)
    ankle = points[:, I["l_ankle"]]
    np.testing.assert_allclose(
        actual[:, I["l_toe"]] - ankle, np.tile([0, -0.14 * 0.42, 0.33 * 0.42], (3, 1)), atol=1e-9
    )


@pytest.mark.parametrize("drop", [(), ("l_toe", "r_toe")])
def test_a_world_with_z_up_is_turned(drop: tuple[str, ...]) -> None:
    points = posed(l_hip=sweep((0, -60), (0, 0), (0, 0)), r_shoulder=sweep((0, 0), (0, 50), (0, 0)))
    clip = clip_of(points, drop)
    turn = rotation.from_euler([90.0], "X")
    assert clip.joint_positions is not None
    turns = clip.local_rotations.copy()
    turns[:, 0] = turn
    moved = clip.joint_positions.copy()
    moved[:, 0] = rotation.rotate(turn, points[:, 0])
    z_up = Clip(clip.skeleton, 30.0, turns, moved[:, 0], joint_positions=moved)
    assert kinematics.clip_positions(z_up)[0][0, I["head"], 2] > 1.0
    np.testing.assert_allclose(
        retarget.to_motion(z_up).local_rotations,
        retarget.to_motion(clip).local_rotations,
        atol=1e-6,
    )


def test_a_toe_that_points_anywhere_is_replaced() -> None:
    """End sites of feet in some files point backwards."""
    points = posed(l_hip=sweep((0, -60), (0, 0), (0, 0)))
    clip = clip_of(points, ("l_toe", "r_toe"))
    names = clip.skeleton.names
    ends = tuple((names.index(f"{s}_ankle"), (0.0, 0.0, -0.2)) for s in "lr")
    skeleton = Skeleton(names, clip.skeleton.parents, clip.skeleton.offsets, ends)
    wrong = Clip(skeleton, 30.0, clip.local_rotations, points[:, 0], clip.joint_positions)
    actual = retarget.clip_keypoints(wrong, {"l_toe": "end:l_ankle", "r_toe": "end:r_ankle"})
    assert (actual[:, I["r_toe"], 2] - actual[:, I["r_ankle"], 2]).min() > 0.1


@pytest.mark.parametrize("name", ["ana/dance_1", "boris/kick_1", "fatou/layup_1"])
def test_sample_captures_keep_their_joints(name: str) -> None:
    """Bone by bone, the canonical body points where the capture's own body points."""
    clip = sample_clip(name)
    motion = retarget.to_motion(clip)
    points = retarget.clip_keypoints(clip) * (body.LEG_LENGTH / motion.leg_length)
    actual, _ = retarget.motion_positions(motion)
    for joint, parent in (("l_knee", "l_hip"), ("r_wrist", "r_elbow"), ("l_elbow", "l_shoulder")):
        source = rotation.normalize(points[:, I[joint]] - points[:, I[parent]])
        solved = rotation.normalize(actual[:, I[joint]] - actual[:, I[parent]])
        np.testing.assert_allclose(solved, source, atol=5e-5)  # poses are multiples of 2^-17
    assert angles_between_frames(motion).max() < 1.0
    assert (
        np.abs(actual[:, I["head"]] - points[:, I["head"]] + points[0, 0] * [1, 0, 1]).max() < 0.15
    )


def test_a_joint_of_the_solved_body_that_leaps_is_noted() -> None:
    rest, _ = kinematics.forward(
        body.PARENTS, body.OFFSETS, np.tile(rotation.IDENTITY, (3, 21, 1)), np.zeros((3, 3))
    )
    elbow, wrist = body.INDEX["l_elbow"], body.INDEX["l_wrist"]
    forearm = np.linalg.norm(body.OFFSETS[wrist])
    points = rest.copy()
    points[:, wrist] = points[:, elbow] + [[0.002, 0, 0], [-0.002, 0, 0], [0.002, 0, 0]]
    (note,) = retarget.motion_from_positions(points, 30.0).notes  # the points move at 0.12 m/s
    assert note.startswith(f"l_wrist moves at {2 * forearm * 30:.3g} m/s, 0.00 s after the start")
    assert retarget.motion_from_positions(rest, 30.0).notes == ()


def test_what_is_no_body_is_refused_and_a_few_broken_frames_are_mended() -> None:
    points = posed(pelvis=np.zeros((60, 3)))
    points[10:12] = np.nan
    motion = retarget.motion_from_positions(points, 30.0)
    assert np.isfinite(motion.local_rotations).all()
    assert motion.leg_length == pytest.approx(body.LEG_LENGTH)
    for wrong, text in (
        (0.0, "a leg between 1 mm and 1 km long, found 0 m. Give the length unit of the file (--u"),
        (np.nan, "positions: expected numbers, found none in any frame. Export the capture again."),
    ):
        with pytest.raises(SkeletonError, match=re.escape(text)):
            retarget.motion_from_positions(np.full((5, 21, 3), wrong), 30.0)


def test_an_axis_that_a_reader_turned_is_doubted_without_its_name() -> None:
    """In turned axes "z" is another axis than in the file."""
    clip = sample_clip("ana/walk_1")
    turn = rotation.from_euler([90.0], "X")
    local = clip.local_rotations.copy()
    local[:, 0] = rotation.multiply(np.broadcast_to(turn, local[:, 0].shape), local[:, 0])
    root = rotation.rotate(np.broadcast_to(turn, (clip.n_frames, 4)), clip.root_positions)
    wrong = replace(clip, local_rotations=local, root_positions=root, up="y", format="bvh")
    (note,) = retarget.solved(wrong)[1].notes
    assert note == "y is up, as it was said; the body moves as if z were."
    (note,) = retarget.solved(replace(wrong, format="c3d"))[1].notes
    assert note.startswith("The body moves as if another axis were up than the file")
