"""The canonical body: parents first, a mirror image of itself, feet on the ground."""

from __future__ import annotations

import numpy as np

from motiondb.body import body


def test_parents_stand_before_their_children() -> None:
    assert body.PARENTS[0] == -1
    assert all(parent < joint for joint, parent in enumerate(body.PARENTS))
    assert len(body.JOINTS) == len(set(body.JOINTS)) == 21


def test_the_body_is_its_own_mirror_image() -> None:
    np.testing.assert_array_equal(body.MIRROR[body.MIRROR], np.arange(21))
    np.testing.assert_allclose(body.OFFSETS[body.MIRROR] * [-1, 1, 1], body.OFFSETS)
    assert body.JOINTS[body.MIRROR[body.INDEX["l_toe"]]] == "r_toe"
    assert body.MIRROR[body.INDEX["chest"]] == body.INDEX["chest"]


def test_leg_length_is_thigh_and_shin() -> None:
    leg = -body.OFFSETS[body.INDEX["l_knee"]][1] - body.OFFSETS[body.INDEX["l_ankle"]][1]
    assert leg == body.LEG_LENGTH
    assert -body.OFFSETS[body.INDEX["l_toe"]][1] + 0.02 == body.ANKLE_HEIGHT


def test_the_standard_skeleton_scales_with_the_leg() -> None:
    skeleton = body.standard_skeleton(1.7)
    np.testing.assert_allclose(skeleton.offsets, 2 * body.OFFSETS)
    assert skeleton.end_sites[0] == (body.INDEX["head"], (0.0, 0.36, 0.0))
    assert skeleton.channels[0][:3] == ("Xposition", "Yposition", "Zposition")
    assert all(len(c) == 3 for c in skeleton.channels[1:])
