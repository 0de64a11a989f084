"""Feet: contacts found, held and kept above ground, without jumps and without stretched legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sample_motions import sample_motion

from motiondb.body import body, contacts, kinematics, retarget, rotation
from motiondb.body.contacts import find_contacts, foot_slip
from motiondb.generate import contact
from motiondb.records import FloatArray, Motion

NAMES = ("ana/walk_1", "emil/dance_1", "boris/kick_1")
I = body.INDEX  # noqa: E741
STANDING = body.LEG_LENGTH + body.ANKLE_HEIGHT


def skating(motion: Motion, speed: float = 0.12) -> Motion:
    """The same steps while the ground slides away sideways, as blended clips do."""
    drift = np.arange(motion.n_frames) / 30.0 * speed
    root = motion.root_positions.copy()
    root[:, 0] += drift
    return replace(motion, root_positions=root)


def standing(n_frames: int, bend: float = 0.0, height: float = STANDING) -> Motion:
    """Feet together, knees bent by an angle in degrees."""
    local = np.tile(rotation.IDENTITY, (n_frames, 21, 1))
    for side in "lr":
        local[:, I[f"{side}_hip"]] = rotation.from_euler([-bend], "X")
        local[:, I[f"{side}_knee"]] = rotation.from_euler([2 * bend], "X")
        local[:, I[f"{side}_ankle"]] = rotation.from_euler([-bend], "X")
    root = np.tile([0.0, height, 0.0], (n_frames, 1))
    return Motion(local.astype(np.float32), root.astype(np.float32))


def lowest(positions: FloatArray) -> float:
    """The lowest sole over all frames, metres."""
    ankles = positions[:, [I["l_ankle"], I["r_ankle"]], 1] - body.ANKLE_HEIGHT
    toes = positions[:, [I["l_toe"], I["r_toe"]], 1] - 0.02
    return float(min(ankles.min(), toes.min()))


@pytest.mark.parametrize("name", NAMES)
def test_skating_feet_are_held(name: str) -> None:
    motion = skating(sample_motion(name))
    locked = contact.lock_feet(motion)
    assert foot_slip(motion) > 0.06
    assert foot_slip(locked) < min(0.06, 0.5 * foot_slip(motion))


@pytest.mark.parametrize("name", NAMES)
def test_no_foot_is_below_the_ground(name: str) -> None:
    motion = sample_motion(name)
    root = motion.root_positions - np.array([0, 0.02, 0], dtype=np.float32)
    positions, _ = retarget.motion_positions(
        contact.lock_feet(replace(motion, root_positions=root))
    )
    assert lowest(positions) > -1e-3


@pytest.mark.parametrize("name", NAMES)
def test_nothing_jumps(name: str) -> None:
    motion = skating(sample_motion(name))
    before, _ = retarget.motion_positions(motion)
    after, _ = retarget.motion_positions(contact.lock_feet(motion))
    jerk_before = np.linalg.norm(np.diff(before, 2, axis=0), axis=-1).max(axis=1)
    jerk_after = np.linalg.norm(np.diff(after, 2, axis=0), axis=-1).max(axis=1)
    assert (jerk_after - jerk_before).max() < 0.06
    assert np.linalg.norm(after - before, axis=-1).max() < 0.25


def test_only_legs_move_and_bones_keep_their_lengths() -> None:
    motion = skating(sample_motion("ana/walk_1"))
    locked = contact.lock_feet(motion)
    np.testing.assert_array_equal(locked.root_positions, motion.root_positions)
    legs = [I[f"{s}_{j}"] for s in "lr" for j in ("hip", "knee", "ankle")]
    others = [j for j in range(21) if j not in legs]
    dots = np.sum(locked.local_rotations * motion.local_rotations, axis=-1)
    np.testing.assert_allclose(np.abs(dots[:, others]), 1.0, atol=3e-5)  # multiples of 2^-17
    positions, world = retarget.motion_positions(locked)
    bones = np.linalg.norm(positions[:, 1:] - positions[:, body.PARENTS[1:]], axis=-1)
    lengths = np.linalg.norm(body.OFFSETS[1:], axis=-1)
    np.testing.assert_allclose(bones, np.broadcast_to(lengths, bones.shape), atol=3e-5)
    before = retarget.motion_positions(motion)[1][:, I["l_ankle"]]
    feet = np.abs(np.sum(world[:, I["l_ankle"]] * before, axis=-1))
    np.testing.assert_allclose(feet, 1.0, atol=1e-4)


def test_one_who_stands_still_stays() -> None:
    motion = standing(20, bend=20.0, height=STANDING - 0.05126)
    locked = contact.lock_feet(motion)
    before, _ = retarget.motion_positions(motion)
    after, _ = retarget.motion_positions(locked)
    np.testing.assert_allclose(after, before, atol=2e-3)
    assert find_contacts(before).all()
    assert foot_slip(motion) == pytest.approx(0.0, abs=1e-6)


def test_one_in_the_air_has_no_contact() -> None:
    motion = standing(12, height=STANDING + 0.4)
    positions, _ = retarget.motion_positions(motion)
    assert not find_contacts(positions).any()
    assert foot_slip(motion) == 0.0
    after, _ = retarget.motion_positions(contact.lock_feet(motion))
    np.testing.assert_allclose(after, positions, atol=1e-3)


def test_flicker_by_hand() -> None:
    on = [bool(int(c)) for c in "1111011100000111000011110"]
    expected = [bool(int(c)) for c in "1111111100000000000011110"]
    np.testing.assert_array_equal(contacts._without_flicker(np.array(on)), expected)


def test_corrections_fade_from_one_contact_to_the_next() -> None:
    moved = np.zeros((20, 2))
    moved[:4], moved[12:] = 1.0, -1.0
    fixed = np.zeros(20, dtype=bool)
    fixed[:4], fixed[12:] = True, True
    faded = contact._fade(moved, fixed)[:, 0]
    np.testing.assert_array_equal(faded[:4], 1.0)
    np.testing.assert_array_equal(faded[12:], -1.0)
    assert np.abs(np.diff(faded)).max() < 0.45
    assert np.all(np.diff(faded[3:13]) <= 0)
    np.testing.assert_allclose(faded[3:13], -faded[12:2:-1], atol=1e-12)


def test_a_nearly_straight_knee_does_not_snap() -> None:
    """One millimetre of reach would move this knee by two centimetres; it may move by one."""
    hip, ankle = np.array([[0.0, 0.85, 0.0]]), np.array([[0.0, 0.0023, 0.0]])
    along = (0.43**2 - 0.42**2 + 0.8477**2) / (2 * 0.8477)
    knee = hip + np.array([[0.0, -along, np.sqrt(0.43**2 - along**2)]])
    target = contact.without_pop(hip, knee, ankle, np.array([[0.0, -0.0022, 0.0]]))
    ahead = np.array([[0.0, 0.0, 1.0]])
    upper, _ = kinematics.two_bone(hip, knee, ankle, target, ahead)
    moved = np.linalg.norm(hip + rotation.rotate(upper, knee - hip) - knee)
    assert moved < 2 * 0.0022


@pytest.mark.parametrize("n_frames", [1, 2])
def test_a_frame_or_two_are_left_alone(n_frames: int) -> None:
    motion = standing(n_frames)
    assert contact.lock_feet(motion) is motion


def test_a_planted_foot_neither_slides_nor_turns() -> None:
    """The whole figure turns by 20 degrees while it stands, as at the seam of two headings."""
    motion = standing(30, bend=20.0, height=0.85)
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.linspace(0.0, 0.35, 30))
    local = motion.local_rotations.astype(np.float64)
    local[:, 0] = turn
    lifted = body.ANKLE_HEIGHT - retarget.motion_positions(motion)[0][0, I["l_ankle"], 1]
    root = motion.root_positions + np.array([0.0, lifted, 0.0], dtype=np.float32)
    turning = replace(motion, local_rotations=local.astype(np.float32), root_positions=root)
    stands = np.ones((30, 2), dtype=bool)
    before, _ = retarget.motion_positions(turning)
    after, _ = retarget.motion_positions(contact.lock_feet(turning, contacts=stands))
    for joint in ("l_ankle", "l_toe", "r_ankle", "r_toe"):
        assert np.ptp(before[:, I[joint]], axis=0).max() > 0.02
        assert np.ptp(after[:, I[joint]], axis=0).max() < 2e-3
