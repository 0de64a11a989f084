"""Changes of a clip on its own skeleton."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motiondb.body import body, changes, kinematics, retarget, rotation
from motiondb.body.joint_names import mirror_joints
from motiondb.errors import SkeletonError
from motiondb.records import Clip, Skeleton


def a_clip(n_frames: int = 31, fps: float = 30.0) -> Clip:
    """A canonical body that walks along z at 1 m/s with sway, bending joints at random."""
    rng = np.random.default_rng(3)
    waves = rng.normal(size=(len(body.JOINTS), 3)) * 0.3
    times = np.arange(n_frames) / fps
    local = rotation.exp(np.sin(2.0 * times)[:, None, None] * waves)
    root = np.stack([0.03 * np.sin(2 * np.pi * 2 * times), 0.9 + 0 * times, times], axis=1)
    return Clip(body.standard_skeleton(), fps, local, root)


def under_a_static_root(clip: Clip) -> Clip:
    """The same body below a joint that stays on the ground, turned about the vertical."""
    skeleton = clip.skeleton
    local = np.concatenate([clip.local_rotations[:, :1] * 0, clip.local_rotations], axis=1)
    turn = rotation.from_euler([90.0], "Y")
    local[:, 0] = turn
    local[:, 1] = rotation.multiply(rotation.conjugate(turn), local[:, 1])
    places = np.repeat(np.concatenate([np.zeros((1, 3)), skeleton.offsets])[None], len(local), 0)
    places[:, 1] = rotation.rotate(rotation.conjugate(turn), clip.root_positions)
    below = Skeleton(
        ("ground", *skeleton.names),
        np.concatenate([[-1], skeleton.parents + 1]),
        np.concatenate([np.zeros((1, 3)), skeleton.offsets]),
        tuple((joint + 1, end) for joint, end in skeleton.end_sites),
    )
    return Clip(below, clip.fps, local, places[:, 0].copy(), places)


def places(clip: Clip) -> np.ndarray:
    return kinematics.clip_positions(clip)[0]


def test_a_rate_twice_as_high_keeps_every_frame_and_halves_turns() -> None:
    clip = a_clip()
    double = changes.resampled(clip, 60.0)
    assert (double.n_frames, double.fps) == (62, 60.0)
    np.testing.assert_allclose(places(double)[::2], places(clip), atol=1e-12)
    first = rotation.relative(clip.local_rotations[3], clip.local_rotations[4])
    half = rotation.relative(double.local_rotations[6], double.local_rotations[7])
    np.testing.assert_allclose(2.0 * rotation.log(half), rotation.log(first), atol=1e-9)
    slow = changes.resampled(clip, 10.0)
    np.testing.assert_allclose(places(slow), places(clip)[::3][: slow.n_frames], atol=1e-12)


def test_in_place_keeps_the_sway() -> None:
    clip = a_clip(n_frames=91)
    still, length = changes.in_place(clip, clip.root_positions)
    assert 2.9 < length < 3.1  # metres in 3 s
    assert np.ptp(still.root_positions[:, 2]) < 0.01
    middle = still.root_positions[30:60, 0]
    assert np.ptp(middle) == pytest.approx(0.06, abs=0.01)
    np.testing.assert_array_equal(still.root_positions[:, 1], clip.root_positions[:, 1])


def test_hips_below_a_root_on_the_ground_come_back() -> None:
    clip = a_clip()
    whole = under_a_static_root(clip)
    hips = changes.from_hips(whole)
    np.testing.assert_allclose(places(hips.clip), places(clip), atol=1e-12)
    aside = np.array([1.0, 0.0, 0.0])
    back = hips.restored(changes.moved_root(hips.clip, hips.clip.root_positions + aside))
    np.testing.assert_allclose(places(back)[:, 1:], places(clip) + aside, atol=1e-12)
    assert changes.from_hips(clip).restored(clip) is clip


@pytest.mark.parametrize("make", [a_clip, lambda: under_a_static_root(a_clip())])
def test_mirrored_joints_are_the_mirror_images_of_their_partners(make) -> None:
    clip = make()
    partners = mirror_joints(clip.skeleton)
    mirrored = changes.mirrored(clip)
    expected = places(clip)[:, partners] * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(places(mirrored), expected, atol=1e-9)
    np.testing.assert_allclose(places(changes.mirrored(mirrored)), places(clip), atol=1e-9)


def test_mirrored_as_the_canonical_mirror() -> None:
    clip = a_clip()
    ours = retarget.to_motion(changes.mirrored(clip)).joint_positions()
    theirs = retarget.mirror(retarget.to_motion(clip)).joint_positions()
    np.testing.assert_allclose(ours, theirs, atol=1e-4)


def test_a_skeleton_without_sides_is_refused() -> None:
    clip = a_clip()
    names = tuple(f"joint{number}" for number in range(len(body.JOINTS)))
    bare = replace(clip, skeleton=replace(clip.skeleton, names=names))
    with pytest.raises(SkeletonError, match="expected joints in pairs of left and right"):
        changes.check_pairs(bare)


def test_z_up_becomes_y_up() -> None:
    clip = a_clip()
    turn = rotation.from_euler([90.0], "X")
    local = clip.local_rotations.copy()
    local[:, 0] = rotation.multiply(turn, local[:, 0])
    z_up = changes.moved_root(
        replace(clip, local_rotations=local), rotation.rotate(turn, clip.root_positions)
    )
    np.testing.assert_allclose(places(changes.upright(z_up)), places(clip), atol=1e-9)
    assert changes.upright(clip) is clip
