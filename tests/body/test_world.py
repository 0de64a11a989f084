"""Axes, sides, units and rates that a file does not say, or says wrongly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from postures import FPS, POSTURES, in_world, positions, rotations, walk

from motiondb.body import body, kinematics, rates, retarget, rotation, world
from motiondb.records import Clip

HEADINGS = [0, 45, 90, 135, 180, 225, 270, 315]
PLACES = [(0.0, 0.0), (0.7, -1.3)]


@pytest.mark.parametrize("name", POSTURES)
def test_a_y_up_world_is_read_so_in_every_posture(name: str) -> None:
    for heading in HEADINGS:
        for place in PLACES:
            found = world.find_up(positions(name, heading, place), FPS, rest="y")
            assert found.up == "y", (heading, place)
            assert bool(found.notes) != found.is_sure
            if name == "stand" and place == PLACES[1]:
                assert found.is_sure, heading


@pytest.mark.parametrize("up", world.UPS[1:])
@pytest.mark.parametrize("name", POSTURES)
def test_another_axis_is_found_with_the_rest_pose_or_told(name: str, up: str) -> None:
    for heading in HEADINGS:
        for place in PLACES:
            points = in_world(positions(name, heading, place), up)
            with_rest = world.find_up(points, FPS, rest=up)
            assert (with_rest.up, len(with_rest.notes)) == (up, 1), (heading, place)
            without = world.find_up(points, FPS, rest="y")
            assert without.notes, (heading, place)


@pytest.mark.parametrize("usual", ["y", "z"])
def test_what_a_format_usually_has_makes_no_axis_certain(usual: str) -> None:
    """A body that lies straight looks as if it stood: its floor is elsewhere, or it is told."""
    for name in POSTURES:
        for up in world.UPS:
            points = in_world(positions(name, 90.0, PLACES[1]), up)
            found = world.find_up(points, FPS, usual=usual, rest=usual)
            assert found.notes or found.up == up, (name, up)
    starts_at_hips = in_world(positions("back", 180.0), "z")  # as many files: no floor at 0
    starts_at_hips = starts_at_hips - starts_at_hips[0, 0]
    assert not world.find_up(starts_at_hips, FPS, rest="y").is_sure


def test_what_stands_on_the_head_in_two_worlds_is_one_motion() -> None:
    """A handstand with -y up has the points of a standing person with y up: nobody can tell."""
    points = in_world(positions("handstand"), "-y")
    assert world.find_up(points, FPS, rest="y").up == "y"
    assert world.find_up(points, FPS, stated="-y").up == "-y"


def test_a_walk_shows_every_axis() -> None:
    for up in world.UPS:
        for stated in ("", up):
            found = world.find_up(in_world(walk(), up), FPS, stated=stated, rest="y")
            assert (found.up, found.is_sure) == (up, True)
    found = world.find_up(in_world(walk(), "z"), FPS, stated="y")
    assert found.up == "y"
    assert found.notes == ("y is up, as it was said; the body moves as if z were.",)


@pytest.mark.parametrize("up", world.UPS)
def test_places_relative_to_the_root_are_upright_and_told(up: str) -> None:
    """As poses from pictures: the head is stiller than any foot, and stood on the floor."""
    points = in_world(walk() - walk()[:, :1], up)
    found = world.find_up(points, FPS)
    assert found.up == up
    assert not found.is_sure


@pytest.mark.parametrize("up", world.UPS)
def test_hops_in_place_are_read_or_told(up: str) -> None:
    """Nothing carries a body that is mostly in the air, and another axis may be at 0 by chance."""
    times = np.arange(90) / FPS
    for heading in range(0, 360, 15):
        for place in PLACES:
            points = np.repeat(positions("stand", heading, place)[:1], 90, axis=0)
            points[..., 1] += 0.2 * np.abs(np.sin(2 * np.pi * times))[:, None]
            found = world.find_up(in_world(points, up), FPS, rest="y")
            assert found.notes or found.up == up == "y"


def test_captures_of_a_skeleton_decide_together() -> None:
    points = in_world(positions("back", 90.0, PLACES[1]), "z")
    lies = world.find_up(points, FPS, rest="y")
    walks = world.find_up(in_world(walk(), "z"), FPS, rest="y")
    assert not lies.is_sure
    assert world.pooled([lies, lies, walks]) == ("z", True)
    assert not world.pooled([lies, lies])[1]


def test_a_body_that_lies_as_if_it_stood_gives_way_to_one_that_walks() -> None:
    """On a mattress, with z up, its feet are lowest along y, at 0: alone it stands, with y up."""
    points = in_world(positions("back", 180.0), "z") + np.array([0.0, 0.0, 0.2])
    points[..., 1] -= points[..., 1].min() - 0.03
    lies = world.find_up(points, FPS, rest="y")
    walks = world.find_up(in_world(walk(), "z"), FPS, rest="y")
    assert (lies.up, lies.is_sure, lies.is_by_motion) == ("y", True, False)
    assert (walks.up, walks.is_by_motion) == ("z", True)
    assert world.pooled([lies, lies, walks]) == ("z", True)
    assert world.pooled([lies, lies]) == ("y", True)


@pytest.mark.parametrize("up", world.UPS)
def test_a_turn_brings_its_axis_up(up: str) -> None:
    turned = rotation.rotate(world.to_y_up(up), in_world(walk(), up))
    np.testing.assert_allclose(turned[..., 1], walk()[..., 1], atol=1e-9)
    assert np.linalg.det(rotation.to_matrix(world.to_y_up(up))) == pytest.approx(1.0)


def test_the_axis_along_which_a_rest_pose_stands() -> None:
    rest, _ = retarget.motion_positions(
        retarget.motion_from_positions(np.repeat(positions("stand")[:1], 2, axis=0), FPS)
    )
    assert [world.rest_up(in_world(rest[0], up)) for up in world.UPS] == list(world.UPS)
    collapsed = np.cumsum(np.ones((21, 3)) * [0.1, 0.0, 0.0], axis=0)
    assert world.rest_up(collapsed) == ""
    assert world.rest_up(np.zeros((21, 3))) == ""


def a_clip(name: str = "chair", points: np.ndarray | None = None) -> Clip:
    """A clip on the canonical body."""
    turns = rotations(name)
    root = positions(name)[:, 0] if points is None else points
    return Clip(body.standard_skeleton(), FPS, turns, root)


def walking_clip() -> Clip:
    return retarget.to_clip(retarget.motion_from_positions(walk(), FPS))


def test_a_mirror_image_and_exchanged_names_are_told_and_mended() -> None:
    clip = walking_clip()
    assert retarget.to_motion(clip).notes == ()
    partners = body.MIRROR
    for flipped in (
        kinematics.as_asked(clip, "", True, None),
        kinematics.as_asked(clip, "", False, partners),
    ):
        (note,) = retarget.to_motion(flipped).notes
        assert "--mirror-world" in note
        assert "--swap-sides" in note
    back = kinematics.as_asked(kinematics.as_asked(clip, "", True, None), "", True, None)
    np.testing.assert_allclose(back.world_positions(), clip.world_positions(), atol=1e-12)
    mended = kinematics.as_asked(
        kinematics.as_asked(clip, "", False, partners), "", False, partners
    )
    assert mended.joint_names == clip.joint_names
    mirrored = kinematics.as_asked(clip, "", True, None).world_positions()
    np.testing.assert_allclose(mirrored, clip.world_positions() * [-1.0, 1.0, 1.0], atol=1e-9)


def test_a_world_is_mirrored_along_the_ground() -> None:
    clip = walking_clip()
    mirrored = kinematics.as_asked(clip, "x", True, None)
    np.testing.assert_allclose(
        mirrored.world_positions(), clip.world_positions() * [1.0, 1.0, -1.0], atol=1e-9
    )
    assert mirrored.up == "x"


@pytest.mark.parametrize("part", ["knee", "ankle", "shoulder", "elbow", "wrist"])
def test_one_exchanged_pair_is_named(part: str) -> None:
    points = walk() * ([1.5, 1.0, 1.0] if part == "ankle" else [1.0] * 3)  # feet apart
    left, right = body.INDEX[f"l_{part}"], body.INDEX[f"r_{part}"]
    points[:, [left, right]] = points[:, [right, left]]
    (note,) = world.side_notes(points, True)
    assert f"The left {part} is right of the right one" in note


def test_exchanged_toes_are_told() -> None:
    points = walk()
    assert world.side_notes(points, True) == ()
    left, right = body.INDEX["l_toe"], body.INDEX["r_toe"]
    points[:, [left, right]] = points[:, [right, left]]
    (note,) = world.side_notes(points, True)
    assert note.startswith("Both toes are nearer to the other ankle for most of the take")
    assert world.side_notes(points, False) == ()


@pytest.mark.parametrize("degrees", [20.0, 60.0])
def test_knees_that_bend_backwards_are_told(degrees: float) -> None:
    """As where a model has the other sign; a knee that only swings so is not believed to."""
    turns = rotations("stand", 90)
    for side, sign in (("l", 1.0), ("r", -1.0)):
        angles = np.zeros((90, 3))
        angles[:, 0] = degrees * (1.0 + sign * np.sin(np.arange(90) / 5.0)) / 2.0
        turns[:, body.INDEX[f"{side}_knee"]] = rotation.from_euler(angles, "XYZ")
    back = turns.copy()
    for side in "lr":
        knee = body.INDEX[f"{side}_knee"]
        back[:, knee] = rotation.conjugate(turns[:, knee])
    root = np.tile([0.0, 0.9, 0.0], (90, 1))
    for rotated, is_told in ((turns, False), (back, True)):
        points, _ = kinematics.forward(body.PARENTS, body.OFFSETS, rotated, root)
        notes = world.side_notes(points, True)
        assert any("knees bend backwards though toes" in note for note in notes) == is_told
        assert is_told or notes == ()


def test_a_mirrored_world_is_told_where_legs_are_straight() -> None:
    points = walk()
    for side in "lr":
        hip, knee, ankle = (body.INDEX[f"{side}_{part}"] for part in ("hip", "knee", "ankle"))
        points[:, knee] = (points[:, hip] + points[:, ankle]) / 2.0
    assert world.side_notes(points, True) == ()
    mirrored = points * [-1.0, 1.0, 1.0]
    (note,) = world.side_notes(mirrored, True)
    assert "--mirror-world" in note
    assert world.side_notes(mirrored, False) == ()


@pytest.mark.parametrize(("one", "other"), [("shoulder", "elbow"), ("knee", "ankle")])
def test_names_exchanged_along_one_limb_are_told(one: str, other: str) -> None:
    points = walk()
    upper, lower = body.INDEX[f"l_{one}"], body.INDEX[f"l_{other}"]
    points[:, [upper, lower]] = points[:, [lower, upper]]
    notes = world.side_notes(points, True)
    assert any("times as long on the left as on the right" in note for note in notes)


@pytest.mark.parametrize(("above", "below"), [("elbow", "wrist"), ("hip", "knee")])
def test_a_bone_without_length_on_one_side_is_told(above: str, below: str) -> None:
    points = walk()
    points[:, body.INDEX[f"r_{below}"]] = points[:, body.INDEX[f"r_{above}"]]
    (note,) = world.side_notes(points, True)
    assert note.startswith(f"The way from {above} to {below} has no length on the right")


def test_names_exchanged_along_both_arms_are_told() -> None:
    points = walk()
    for side in "lr":
        upper, lower = body.INDEX[f"{side}_shoulder"], body.INDEX[f"{side}_elbow"]
        points[:, [upper, lower]] = points[:, [lower, upper]]
    (note, *_) = world.side_notes(points, True)
    assert "from elbow to wrist is much longer than the bone above it on both sides" in note


def test_feet_that_slide_are_told() -> None:
    points = walk()
    leg = retarget.legs_of(points)
    assert world.travel_notes(points, FPS, leg) == ()
    for factor in (0.01, 0.1, 0.3937, 0.5):
        slow = points.copy()
        slow[..., 2] -= (1.0 - factor) * points[:, :1, 2]
        (note,) = world.travel_notes(slow, FPS, leg)
        assert note.startswith(f"The root travels {factor:.1g}"[:24])
    for factor in (10.0, 100.0):
        (note,) = world.travel_notes(points + (factor - 1.0) * points[:, :1], FPS, leg)
        assert note.startswith("The root travels ")
    in_place = points.copy()
    in_place[..., 2] = positions("stand")[:1, :, 2]
    assert world.travel_notes(in_place, FPS, leg) == ()
    bob = 0.03 * np.sin(10.0 * np.arange(len(points)) / FPS)[:, None]
    treadmill, locked = points.copy(), points.copy()
    for moved, joints in ((treadmill, [0]), (locked, list(range(1, 21)))):
        moved[..., 2] -= points[:, :1, 2]
        moved[:, joints, 1] += bob * (1 if joints == [0] else -1)
    assert world.travel_notes(treadmill, FPS, leg) == ()
    assert len(world.travel_notes(locked, FPS, leg)) == 1


@pytest.mark.parametrize("factor", [0.01, 0.3937, 1.0, 2.54])
def test_hips_that_sink_otherwise_than_legs_bend_are_told(factor: float) -> None:
    """Knee bends in place."""
    bend = 0.5 - 0.5 * np.cos(np.arange(90) / 10.0)
    points = np.repeat(positions("stand")[:1], 90, axis=0)
    legs = [body.INDEX[f"{side}_{part}"] for side in "lr" for part in ("ankle", "toe")]
    points[..., 1] -= 0.4 * factor * bend[:, None]
    points[:, legs, 1] += 0.4 * bend[:, None]
    notes = world.travel_notes(points, FPS, retarget.legs_of(points[:1]))
    assert len(notes) == (factor != 1.0)
    assert all(f"travels {factor:.2g} times" in note for note in notes)


def test_hips_that_rest_while_feet_swing_are_told() -> None:
    """A walk whose root is in metres among centimetres; one who sits and swings the legs is not."""
    points = walk()
    bob = 0.02 * np.sin(10.0 * np.arange(len(points)) / FPS)
    points[:, :, 1] += bob[:, None]
    leg = retarget.legs_of(points)
    pinned = points - 0.99 * points[:, :1]
    (note,) = world.travel_notes(pinned, FPS, leg)
    assert note.endswith("another unit than the bones. Export the capture again with one unit.")
    (note,) = world.travel_notes(walk() - walk()[:, :1], FPS, leg)
    assert "stay where they are while both feet swing" in note
    turns = rotations("chair", 90)
    swing = 40.0 * np.sin(np.arange(90) / 5.0)
    for side, way in (("l", 1.0), ("r", -1.0)):
        angles = np.zeros((90, 3))
        angles[:, 0] = 60.0 + way * swing
        turns[:, body.INDEX[f"{side}_knee"]] = rotation.from_euler(angles, "XYZ")
    root = np.tile([0.0, 0.5, 0.0], (90, 1))
    sits, _ = kinematics.forward(body.PARENTS, body.OFFSETS, turns, root)
    assert world.travel_notes(sits, FPS, retarget.legs_of(sits)) == ()


def test_radians_read_as_degrees_are_told() -> None:
    turns = rotations("chair")
    radians = rotation.exp(rotation.log(turns) * np.pi / 180.0)
    root = np.linspace([0.0, 0.9, 0.0], [0.0, 0.9, 1.0], len(turns))
    (note,) = world.angle_notes(replace(a_clip(), local_rotations=radians, root_positions=root))
    assert note.startswith("No joint turns by more than ")
    assert world.angle_notes(replace(a_clip(), root_positions=root)) == ()
    assert world.angle_notes(replace(a_clip(), local_rotations=radians)) != ()  # it only stands
    still = replace(a_clip(), local_rotations=np.tile(rotation.IDENTITY, (len(turns), 21, 1)))
    still = replace(still, root_positions=0.0 * root)  # a T-pose
    assert world.angle_notes(still)[0].startswith("Nothing moves in the whole take.")
    one = replace(still, local_rotations=still.local_rotations[:1], root_positions=root[:1])
    assert world.angle_notes(one) == ()
    travels = replace(still, root_positions=root)
    (note,) = world.angle_notes(travels)
    assert note.startswith("No joint turns by more than 0 degrees in the whole take, and the root ")
    by_places = np.tile(still.skeleton.offsets, (len(turns), 1, 1))
    by_places[:, 1] += 0.1 * np.sin(np.arange(len(turns)))[:, None]
    assert world.angle_notes(replace(travels, joint_positions=by_places)) == ()


@pytest.mark.parametrize("said", [0.001, 0.01, 0.0254, 1.0])
@pytest.mark.parametrize("meant", [0.001, 0.01, 0.0254, 1.0])
def test_a_unit_that_makes_no_person_is_corrected(said: float, meant: float) -> None:
    unit, notes = world.checked_unit(said, 0.9 / meant, 0.85)
    assert (unit, bool(notes)) == (meant, said != meant)


def test_a_unit_that_no_other_fits_is_told() -> None:
    unit, (note,) = world.checked_unit(1.0, 0.085, 0.85)  # a mouse is as it says
    assert unit == 1.0 or "is taken" in note
    unit, (note,) = world.checked_unit(1.0, 1e-10, 0.85)
    assert unit == pytest.approx(0.85e10)
    assert note.endswith(
        "no other unit fits; the usual size is taken. Give the unit if it is wrong."
    )


RATES = [
    ("0.0083333", 120.0, False), ("0.0083", 120.0, False), (".0167", 60.0, False),
    ("0.0166", 60.0, False), ("0.016", 60.0, False), ("0.033", 30.0, False),
    ("0.0333", 30.0, False), ("0.042", 24.0, False), ("0.0416", 24.0, False),
    ("0.011", 90.0, False), ("0.0042", 240.0, False), ("3.33e-2", 30.0, False),
    ("0.0333667", 30000 / 1001, False), ("0.008342", 120000 / 1001, False),
    ("0.0417083", 24000 / 1001, False), ("0.0069", 144.0, False), ("0.005", 200.0, False),
    ("0.0625", 16.0, False), ("0.010000", 100.0, False), ("0.020000", 50.0, False),
    ("0.008", 120.0, True), ("0.004", 240.0, True), ("0.02", 50.0, False), ("0.04", 25.0, False),
    ("0.01", 100.0, False), ("0.0084", 119.0, True), ("0.009", 111.0, True), ("0.028", 36.0, True),
    ("0.0213", 47.0, True), ("0.0170648", 58.6, False), ("0.011765", 85.0, False),
]  # fmt: skip


@pytest.mark.parametrize(("written", "fps", "is_told"), RATES)
def test_the_rate_that_a_frame_time_means(written: str, fps: float, is_told: bool) -> None:
    found, notes = rates.find_rate(float(written), written)
    assert found == pytest.approx(fps, rel=1e-9 if fps != 58.6 else 1e-4)
    assert bool(notes) == is_told


def test_an_unusual_rate_of_few_digits_names_the_usual_ones_beside_it() -> None:
    assert rates.find_rate(0.0084, "0.0084")[1] == (
        "The frame time 0.0084 is that of no usual rate: 119 frames a second are taken; the "
        "nearest usual rates are 120 and 100. Give the right one (--fps) if this is wrong.",
    )


def test_whole_rates_come_back_from_every_number_of_digits() -> None:
    for fps in (24, 25, 30, 50, 60, 90, 100, 120, 240, 17, 85, 333):
        assert rates.find_rate(1.0 / fps)[0] == fps
        for digits in range(6, 12):
            assert (
                rates.find_rate(float(f"{1 / fps:.{digits}f}"), f"{1 / fps:.{digits}f}")[0] == fps
            )
