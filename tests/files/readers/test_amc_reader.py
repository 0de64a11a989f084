"""ASF and AMC: numbers by hand, a slow twin with matrices, and the choice of the skeleton."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motiondb.body import kinematics
from motiondb.errors import CaptureError
from motiondb.files.folder import skeleton_path
from motiondb.files.formats import read_capture
from motiondb.files.limits import ReadOptions, SkeletonFile
from motiondb.files.readers.amc import read_amc
from motiondb.files.readers.asf import read_asf

CMU = 0.0254 / 0.45

ASF = """# made for the tests
:version 1.10
:name TEST
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
  begin and end in this text mean nothing
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name hip
    direction 1 0 0
    length 2
    axis 0 0 0 XYZ
  end
  begin
    id 2
    name thigh
    direction 0 -1 0
    length 8
    axis 0 0 20 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
    id 3
    name shin
    direction 0 -2 0
    length 7
    axis 30 -40 50 XYZ
    dof rx rz
    limits (-10.0 170.0)
           (-10.0 170.0)
  end
:hierarchy
  begin
    root hip
    hip thigh
    thigh shin
  end
"""

AMC = """#!OML:ASF made for the tests
:FULLY-SPECIFIED
:DEGREES
1
root 1 17 2 0 0 0
thigh 0 0 0
shin 0 0
2
root 1 17 2 0 90 0
thigh 10 20 30
shin 40 50
"""


def read(amc: str = AMC, asf: str | None = ASF, **options):
    skeleton = None if asf is None else SkeletonFile(asf.encode(), "16.asf")
    return read_amc(amc.encode(), "16_01.amc", skeleton, ReadOptions(**options))


def test_rest_pose_by_hand() -> None:
    clip = read()
    assert clip.skeleton.names == ("root", "hip", "thigh", "shin")
    assert clip.skeleton.parents.tolist() == [-1, 0, 1, 2]
    assert clip.unit == pytest.approx(CMU)
    assert (clip.fps, clip.format, clip.n_frames, clip.notes) == (120.0, "amc", 2, ())
    expected = np.array([[1, 17, 2], [1, 17, 2], [3, 17, 2], [3, 9, 2]]) * CMU
    positions, _ = kinematics.clip_positions(clip)
    np.testing.assert_allclose(positions[0], expected, atol=1e-12)
    ((joint, end),) = clip.skeleton.end_sites
    assert joint == 3
    np.testing.assert_allclose(end, [0, -7 * CMU, 0])


def _turn(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    m = np.eye(3)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def test_agrees_with_matrices() -> None:
    c_thigh = _turn("z", 20)
    c_shin = _turn("z", 50) @ _turn("y", -40) @ _turn("x", 30)
    root = _turn("y", 90)
    thigh = c_thigh @ _turn("z", 30) @ _turn("y", 20) @ _turn("x", 10) @ c_thigh.T
    shin = c_shin @ _turn("z", 50) @ _turn("x", 40) @ c_shin.T
    at_thigh = np.array([1, 17, 2]) + root @ [2, 0, 0]
    at_shin = at_thigh + root @ thigh @ [0, -8, 0]
    end = at_shin + root @ thigh @ shin @ [0, -7, 0]
    clip = read()
    positions, rotations = kinematics.clip_positions(clip)
    np.testing.assert_allclose(positions[1, 3], at_shin * CMU, atol=1e-12)
    from motiondb.body.rotation import rotate

    actual = positions[1, 3] + rotate(rotations[1, 3], np.array(clip.skeleton.end_sites[0][1]))
    np.testing.assert_allclose(actual, end * CMU, atol=1e-12)


def test_degrees_of_freedom_in_another_order() -> None:
    asf = ASF.replace("dof rx ry rz", "dof rz rx ry")
    amc = AMC.replace("thigh 10 20 30", "thigh 30 10 20")
    np.testing.assert_allclose(read(amc, asf).local_rotations, read().local_rotations, atol=1e-12)


def test_root_order_and_position() -> None:
    asf = ASF.replace("order TX TY TZ RX RY RZ", "order RX RY RZ TX TY TZ")
    asf = asf.replace("position 0 0 0", "position 10 0 0")
    amc = AMC.replace("1 17 2 0 0 0", "0 0 0 1 17 2").replace("1 17 2 0 90 0", "0 90 0 1 17 2")
    clip = read(amc, asf)
    np.testing.assert_allclose(clip.root_positions, np.array([[11, 17, 2]] * 2) * CMU)
    np.testing.assert_allclose(clip.local_rotations, read().local_rotations, atol=1e-12)


def test_radians() -> None:
    rows = [line.split() for line in AMC.splitlines()[3:]]
    amc = "\n".join(
        " ".join([row[0], *(repr(float(np.deg2rad(float(v)))) for v in row[1:])]) for row in rows
    )
    amc = ":RADIANS\n" + amc.replace(repr(float(np.deg2rad(17.0))), "17")
    amc = amc.replace(repr(float(np.deg2rad(1.0))), "1").replace(repr(float(np.deg2rad(2.0))), "2")
    np.testing.assert_allclose(read(amc).local_rotations, read().local_rotations, atol=1e-12)
    np.testing.assert_allclose(read(amc).root_positions, read().root_positions, atol=1e-12)


def test_given_rate_and_unit() -> None:
    clip = read(fps=60.0, unit=0.5)
    assert clip.fps == 60.0
    assert clip.root_positions[0].tolist() == [0.5, 8.5, 1.0]


def test_other_length_is_found_from_the_size() -> None:
    body = read_asf(
        ASF.replace("length 0.45", "length 1.0").replace("length 8", "length 110").encode(), "a"
    )
    assert body.unit == 0.01


def test_incomplete_last_frame_is_left_out_with_a_note() -> None:
    clip = read(AMC.replace("shin 40 50\n", ""))
    assert clip.n_frames == 1
    assert clip.notes == ("The last frame (line 8) is incomplete and left out.",)


def test_bad_frames_can_be_left_out() -> None:
    clip = read(AMC.replace("shin 0 0", "shin 0 x"), skip_bad_frames=True)
    assert clip.n_frames == 1
    assert clip.notes == ("Left out 1 bad frames; the first is on line 7.",)


def test_frame_numbers_that_jump_are_noted() -> None:
    assert read(AMC.replace("\n2\n", "\n9\n")).notes == (
        "The frame numbers have gaps; the frames are taken in order.",
    )


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["16.asf", "17.asf"], "16.asf"),
        (["16.ASF"], "16.ASF"),
        (["my_body.asf"], "my_body.asf"),
        (["takes.asf"], "takes.asf"),  # the name of the folder
        (["16_01.asf", "16.asf"], "16_01.asf"),
    ],
)
def test_skeleton_beside_the_motion(tmp_path: Path, names: list[str], expected: str) -> None:
    folder = tmp_path / "takes"
    folder.mkdir()
    for name in names:
        (folder / name).write_text(ASF)
    (folder / "16_01.amc").write_text(AMC)
    skeleton = skeleton_path(folder / "16_01.amc")
    assert skeleton is not None
    assert skeleton.name == expected
    assert read_capture(folder / "16_01.amc").n_frames == 2
    assert read_capture(folder / "16_01.amc", skeleton=folder / names[-1]).n_frames == 2


def test_no_skeleton_and_too_many(tmp_path: Path) -> None:
    (tmp_path / "16_01.amc").write_text(AMC)
    with pytest.raises(CaptureError, match=r"expected its skeleton 16\.asf .* found no ASF file"):
        read_capture(tmp_path / "16_01.amc")
    (tmp_path / "a.asf").write_text(ASF)
    (tmp_path / "b.asf").write_text(ASF)
    with pytest.raises(CaptureError, match=r"found a\.asf, b\.asf\. Put the ASF"):
        read_capture(tmp_path / "16_01.amc")
    assert skeleton_path("a.bvh") is None


@pytest.mark.parametrize(
    ("line", "fps"),
    [
        (":SAMPLES-PER-SECOND 60", 60.0),
        (":samples-per-second 59.94", 59.94),
        ("  :Samples-Per-Second\t250", 250.0),
        (":SAMPLES_PER_SECOND=60", 60.0),
        (":Frame-Rate 60", 60.0),
    ],
)
def test_the_rate_of_the_header(line: str, fps: float) -> None:
    amc = AMC.replace(":DEGREES", f"{line}\n:DEGREES")
    assert read(amc).fps == fps
    assert read(amc, fps=30.0).fps == 30.0


@pytest.mark.parametrize(
    ("rate", "found"),
    [
        ("fast", "16_01.amc:3: expected a frame rate, found 'fast'. Give --fps."),
        (
            "9999",
            "16_01.amc: expected SAMPLES-PER-SECOND from 1 to 2000, found 9999. "
            "Give the right frame rate with --fps.",
        ),
    ],
)
def test_a_rate_that_is_none_is_refused(rate: str, found: str) -> None:
    with pytest.raises(CaptureError) as caught:
        read(AMC.replace(":DEGREES", f":SAMPLES-PER-SECOND {rate}\n:DEGREES"))
    assert str(caught.value) == found
