"""Models of robots: MJCF and URDF tell the same, and what is not read is refused by name."""

from pathlib import Path

import numpy as np
import pytest

from motiondb.body import hinges, rotation
from motiondb.body.hinges import Robot
from motiondb.errors import CaptureError
from motiondb.files.formats import read_skeleton
from motiondb.files.limits import AS_USUAL
from motiondb.files.readers.robot_model import read_robot
from tests import small_robot


def _mjcf(inner: str, before: str = "") -> Robot:
    text = f"<mujoco>{before}<worldbody>{inner}</worldbody></mujoco>"
    return read_robot(text.encode(), "m.xml")


def test_mjcf_and_urdf_of_one_robot_have_links_in_the_same_places() -> None:
    first, second = (
        read_robot(text.encode(), "m") for text in (small_robot.mjcf(), small_robot.urdf())
    )
    assert {*first.joint_names} == {*second.joint_names} == {*small_robot.JOINTS}
    root, turns, values = small_robot.walk(5)
    places = []
    for robot in (first, second):
        order = [small_robot.JOINTS.index(name) for name in robot.joint_names]
        posed = hinges.pose(robot, root, turns, values[:, order])
        places.append({name: posed.places[:, n] for n, name in enumerate(robot.links)})
        limits = {joint.name: joint.limits for joint in robot.joints}
        low, high = np.rad2deg(limits["right_hip_roll_joint"])
        assert (low, high) == pytest.approx((-90.0, 30.0))
    for link, place in places[0].items():
        np.testing.assert_allclose(place, places[1][link], atol=1e-9)


@pytest.mark.parametrize(
    "attribute",
    [
        'quat="0.5 0.5 0.5 0.5"',
        'axisangle="1 1 1 120"',
        'euler="90 90 0"',
        'xyaxes="0 2 0 0 1 1"',
    ],
)
def test_orientations_may_be_written_in_any_form(attribute: str) -> None:
    inner = f'<body><body pos="1 0 0" {attribute}><joint/><body pos="0 0 1"/></body></body>'
    posed = hinges.at_zero(_mjcf(inner))
    np.testing.assert_allclose(posed.places[0, 2], [2.0, 0.0, 0.0], atol=1e-9)


def test_angles_are_degrees_unless_the_compiler_says_radians_and_euler_is_intrinsic() -> None:
    body = '<body><body euler="90 90 0"><joint range="0 1"/><body pos="0 0 1"/></body></body>'
    for compiler, place, high in (
        ("", [1.0, 0.0, 0.0], np.deg2rad(1.0)),
        ('<compiler eulerseq="XYZ"/>', [0.0, -1.0, 0.0], np.deg2rad(1.0)),
        ('<compiler angle="radian"/>', None, 1.0),
        ('<compiler autolimits="false"/>', [1.0, 0.0, 0.0], None),
    ):
        robot = _mjcf(body, compiler)
        limits = robot.joints[0].limits
        assert limits == (None if high is None else pytest.approx((0.0, high)))
        if place is not None:
            np.testing.assert_allclose(hinges.at_zero(robot).places[0, 2], place, atol=1e-9)


def test_frames_move_the_bodies_within_them() -> None:
    inner = (
        '<body><frame pos="0 0 1" axisangle="0 0 1 90"><body pos="1 0 0"><joint/></body></frame>'
        "</body>"
    )
    np.testing.assert_allclose(hinges.at_zero(_mjcf(inner)).places[0, 1], [0, 1, 1], atol=1e-12)


def test_default_classes_are_inherited_and_overridden() -> None:
    defaults = (
        '<default><joint axis="1 0 0"/><default class="a"><joint pos="0 0 2"/>'
        '<default class="b"><joint axis="0 1 0"/></default></default></default>'
    )
    inner = (
        '<body><body childclass="b"><joint name="one"/><body><joint name="two" class="a"/></body>'
        '</body><body><joint name="three" axis="0 0 3"/></body></body>'
    )
    one, two, three = _mjcf(inner, defaults).joints
    assert (one.axis, one.anchor) == ((0.0, 1.0, 0.0), (0.0, 0.0, 2.0))
    assert (two.axis, two.anchor) == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    assert (three.axis, three.anchor) == ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


def test_included_files_stand_in_their_place(tmp_path: Path) -> None:
    legs = "<mujocoinclude><body name='leg' pos='0 0 -1'><joint name='hip'/></body></mujocoinclude>"
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "legs.xml").write_text(legs)
    whole = '<mujoco><worldbody><body name="b"><include file="parts/legs.xml"/></body>'
    (tmp_path / "r.xml").write_text(whole + "</worldbody></mujoco>")
    robot = read_robot(read_skeleton(tmp_path / "r.xml", AS_USUAL), "r.xml")
    assert robot.links == ("b", "leg")
    assert robot.joint_names == ("hip",)
    for climbing in ("../legs.xml", "/etc/hostname", "parts/../../x.xml"):
        (tmp_path / "r.xml").write_text(f'<mujoco><include file="{climbing}"/></mujoco>')
        with pytest.raises(CaptureError, match="expected included files beside or below the model"):
            read_skeleton(tmp_path / "r.xml", AS_USUAL)
    (tmp_path / "r.xml").write_text('<mujoco><include file="r.xml"/></mujoco>')
    with pytest.raises(CaptureError, match="expected at most 20 included files, found more"):
        read_skeleton(tmp_path / "r.xml", AS_USUAL)


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ("<body><body><joint type='ball' name='hip'/></body></body>", "the 'ball' joint 'hip'"),
        ("<body><replicate count='2'><body><joint/></body></replicate></body>", "<replicate>"),
        ("<body/>", "expected a robot with hinges, found none"),
        ("", "expected a robot's body, found none"),
        ("<body><body pos='1 2'><joint/></body></body>", "expected 3 numbers as pos of body"),
        ("<body><body><joint axis='0 0 0'/></body></body>", "expected an axis with a direction"),
        ("<body><body><joint class='x'/></body></body>", "a default class of the model, found 'x'"),
        ("<body><body><joint ref='nan'/></body></body>", "expected finite numbers in the model"),
    ],
)
def test_mjcf_that_is_not_read_is_refused_with_its_reason(inner: str, said: str) -> None:
    with pytest.raises(CaptureError) as error:
        _mjcf(inner)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><robot/>", "expected XML without a DOCTYPE"),
        ("<robot>", "expected XML, found a fault"),
        ("<svg/>", "expected MJCF or URDF, found XML of 'svg'"),
        ("<robot><link name='a'/>" + "<link name='b'/>" * 3000 + "</robot>", "at most 2000 links"),
        (
            "<robot><link name='a'/><link name='b'/><joint name='j' type='planar'>"
            "<parent link='a'/><child link='b'/></joint></robot>",
            "the 'planar' joint 'j'",
        ),
        (
            "<robot><link name='a'/><joint name='j' type='revolute'><parent link='a'/>"
            "<child link='x'/></joint></robot>",
            "expected a tree of named links, found the joint 'j' from 'a' to 'x'",
        ),
    ],
)
def test_other_xml_is_refused_with_its_reason(text: str, said: str) -> None:
    with pytest.raises(CaptureError) as error:
        read_robot(text.encode(), "m")
    assert said in str(error.value)


def test_urdf_rpy_turns_about_fixed_axes_and_mimics_are_read() -> None:
    text = (
        "<robot><link name='a'/><link name='b'/><link name='c'/>"
        "<joint name='j' type='continuous'><parent link='a'/><child link='b'/>"
        f"<origin rpy='{np.pi / 2} 0 {np.pi / 2}'/></joint>"
        "<joint name='k' type='prismatic'><parent link='b'/><child link='c'/>"
        "<origin xyz='0 1 0'/><mimic joint='j' multiplier='2' offset='1'/></joint></robot>"
    )
    robot = read_robot(text.encode(), "m")
    assert robot.joints[1].mimics == (0, 2.0, 1.0)
    assert robot.free == (0,)
    still = hinges.pose(robot, np.zeros((1, 3)), rotation.IDENTITY[None], np.zeros((1, 2)))
    np.testing.assert_allclose(still.places[0, 2], [0.0, 0.0, 1.0], atol=1e-12)


def test_macros_are_named() -> None:
    """Read as it is, a robot would lack the limbs that macros make."""
    arm = '<arm xmlns="http://ros.org/wiki/xacro" side="left"/></robot>'
    data = small_robot.urdf().replace("</robot>", arm)
    with pytest.raises(CaptureError, match="found 1 elements of xacro"):
        read_robot(data.encode(), "a.urdf")
