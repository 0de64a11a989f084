"""The BVH reader: numbers by hand, a slow twin, and the quirks that real files have."""

from __future__ import annotations

import naive_bvh
import numpy as np
import pytest

from motiondb.body import kinematics
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.bvh import read_bvh

TWO_BONES = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Leg
  {
    OFFSET 0 -45 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Foot
    {
      OFFSET 0 -40 5
      CHANNELS 3 Yrotation Xrotation Zrotation
      End Site
      {
        OFFSET 0 0 15
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0083333
1 90 2 90 0 0 0 0 0 0 0 0
1 91 2 10 20 30 -40 50 60 7 8 9
"""


def read(text: str | bytes, **options: object):
    data = text.encode() if isinstance(text, str) else text
    return read_bvh(data, "walk.bvh", ReadOptions(**{"unit": 0.01, **options}))


def test_numbers_by_hand() -> None:
    clip = read(TWO_BONES)
    assert clip.skeleton.names == ("Hips", "Leg", "Foot")
    assert clip.skeleton.parents.tolist() == [-1, 0, 1]
    assert clip.skeleton.offsets[1].tolist() == [0, -0.45, 0]
    assert clip.skeleton.end_sites == ((2, (0.0, 0.0, 0.15)),)
    assert clip.skeleton.channels[2] == ("Yrotation", "Xrotation", "Zrotation")
    assert clip.fps == 120.0
    assert clip.joint_positions is None
    assert clip.notes == ()
    # A quarter turn about z carries "down" (-y) to +x: the foot stands beside the hip.
    positions, _ = kinematics.clip_positions(clip)
    np.testing.assert_allclose(positions[0, 1], [0.01 + 0.45, 0.9, 0.02], atol=1e-12)
    np.testing.assert_allclose(positions[0, 2], [0.01 + 0.85, 0.9, 0.02 + 0.05], atol=1e-12)


def test_agrees_with_the_slow_twin() -> None:
    slow = naive_bvh.world_positions(TWO_BONES) * 0.01
    np.testing.assert_allclose(kinematics.clip_positions(read(TWO_BONES))[0], slow, atol=1e-12)


def test_position_channels_below_the_root_replace_the_offset() -> None:
    text = TWO_BONES.replace(
        "CHANNELS 3 Yrotation Xrotation Zrotation",
        "CHANNELS 4 Zposition Yrotation Xrotation Zrotation",
    )
    text = text.replace("0 0 0 0 0 0 0 0\n", "0 0 0 0 0 7 0 0 0\n")
    text = text.replace("50 60 7 8 9", "50 60 9 7 8 9")
    clip = read(text)
    assert clip.joint_positions is not None
    np.testing.assert_allclose(clip.joint_positions[:, 2], [[0, -0.4, 0.07], [0, -0.4, 0.09]])
    np.testing.assert_allclose(clip.joint_positions[:, 1], [[0, -0.45, 0]] * 2)
    np.testing.assert_allclose(clip.joint_positions[:, 0], clip.root_positions)
    slow = naive_bvh.world_positions(text) * 0.01
    np.testing.assert_allclose(kinematics.clip_positions(clip)[0], slow, atol=1e-12)


@pytest.mark.parametrize(
    "channels",
    [
        "6 Xrotation Yrotation Zrotation Xposition Yposition Zposition",
        "6 Xposition Zrotation Yposition Xrotation Zposition Yrotation",
        "6 xPOSITION yposition Zposition XROTATION yrotation zrotation",
    ],
)
def test_any_channel_order_of_the_root(channels: str) -> None:
    text = TWO_BONES.replace(
        "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation", channels
    )
    proper = " ".join(word[0].upper() + word[1:].lower() for word in channels.split())
    slow = naive_bvh.world_positions(text.replace(channels, proper)) * 0.01
    np.testing.assert_allclose(kinematics.clip_positions(read(text))[0], slow, atol=1e-12)


def test_root_without_position_channels_stays_at_its_offset() -> None:
    text = TWO_BONES.replace("OFFSET 0 0 0\n", "OFFSET 3 95 0\n", 1)
    text = text.replace("6 Xposition Yposition Zposition ", "3 ")
    text = text.replace("1 90 2 ", "").replace("1 91 2 ", "")
    np.testing.assert_allclose(read(text).root_positions, [[0.03, 0.95, 0.0]] * 2)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda t: t.replace("\n", "\r\n").encode(), "Leg"),
        (lambda t: t.replace("\n", "\r").encode(), "Leg"),
        (lambda t: t.replace("  ", "\t").replace(" ", "\t").encode(), "Leg"),
        (lambda t: b"\xef\xbb\xbf" + t.encode(), "Leg"),
        (lambda t: t.encode("utf-16"), "Leg"),
        (lambda t: t.replace("Leg", "Pied d'été").encode("latin-1"), "Pied d'été"),
        (lambda t: t.replace("Leg", "Pied d'été").encode(), "Pied d'été"),
        (lambda t: t.replace("Leg\n  {", "Leg {").encode(), "Leg"),
        (lambda t: t.replace("ROOT", "root").replace("JOINT", "Joint").encode(), "Leg"),
        (lambda t: t.replace("Frames: 2", "Frames:2").encode(), "Leg"),
        (lambda t: t.replace("Frames: 2", "Frames:\t2").encode(), "Leg"),
        (lambda t: t.replace("Frame Time: 0", "FRAME TIME:\t0").encode(), "Leg"),
        (lambda t: t.replace("0.0083333", ".0083333").encode(), "Leg"),
        (lambda t: t.replace("0.0083333", "8.3333e-3").encode(), "Leg"),
        (lambda t: t.replace("1 90 2", "1.0E0 +9e1 2.").encode(), "Leg"),
        (lambda t: t.replace("1 90 2 ", "1 90\n2 ").encode(), "Leg"),
        (lambda t: t.replace("MOTION\n", "\nMOTION\n\n").encode() + b"\n\n", "Leg"),
    ],
)
def test_layouts_that_say_the_same(change, name: str) -> None:
    clip, plain = read(change(TWO_BONES)), read(TWO_BONES)
    assert clip.skeleton.names == ("Hips", name, "Foot")
    assert clip.fps == plain.fps
    np.testing.assert_array_equal(clip.local_rotations, plain.local_rotations)
    np.testing.assert_array_equal(clip.root_positions, plain.root_positions)


def test_given_frame_rate_overrides_the_file() -> None:
    assert read(TWO_BONES.replace("0.0083333", "0"), fps=60.0).fps == 60.0
    assert read(TWO_BONES.replace("Frame Time: 0.0083333\n", ""), fps=24.0).fps == 24.0
    assert read(TWO_BONES.replace("0.0083333", "0.0333667")).fps == pytest.approx(29.97, abs=1e-3)


def test_names_with_spaces_and_joints_without_channels() -> None:
    text = TWO_BONES.replace("JOINT Leg", "JOINT Left  Upper Leg")
    text = text.replace("CHANNELS 3 Yrotation Xrotation Zrotation", "CHANNELS 0")
    text = text.replace("0 0 0 0 0 0 0 0\n", "0 0 0 0 0\n").replace("50 60 7 8 9", "50 60")
    clip = read(text)
    assert clip.skeleton.names[1] == "Left Upper Leg"
    assert clip.skeleton.channels[2] == ()
    np.testing.assert_array_equal(clip.local_rotations[:, 2], [[1, 0, 0, 0]] * 2)


def test_bad_frames_can_be_left_out() -> None:
    text = TWO_BONES.replace("7 8 9", "7 8")
    clip = read(text, skip_bad_frames=True)
    assert clip.n_frames == 1
    assert clip.notes == ("Left out 1 bad frames; the first is on line 25.",)
    clip = read(TWO_BONES.replace("Frames: 2", "Frames: 4"), skip_bad_frames=True)
    assert clip.notes == ("The header says 4 frames; the file holds 2.",)
