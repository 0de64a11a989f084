"""Tables of Motive, Vicon and Qualisys are the same capture as a TRC with the same markers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from odd_c3d import MARKERS
from trc_writer import CENTRES, read_trc, trc

from motiondb.body.kinematics import clip_positions
from motiondb.errors import CaptureError, NoBodyError
from motiondb.files.folder import find_captures
from motiondb.files.formats import read_capture, read_marker_bytes, read_takes_bytes
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.first_bytes import is_marker_table
from motiondb.records import Clip

FRAMES = 20
Places = Mapping[str, tuple[float, ...]]
BONES = {
    {"Knee": "Shin", "Hip": "Thigh", "Ankle": "Foot", "Shoulder": "UArm", "Elbow": "FArm",
     "Wrist": "Hand", "BigToe": "Toe"}.get(name[1:], name[1:]).join((name[0], ""))
    if name[0] in "LR" else name: place
    for name, place in CENTRES.items() if name[1:] != "Heel"
}  # fmt: skip


def rows(places: Places, scale: float = 1.0, up: str = "y") -> list[list[str]]:
    """The cells of each frame; the points move ahead by 1 cm a frame; one is lost in one frame."""
    cells = []
    for frame in range(FRAMES):
        ahead = [(x, y, z + frame) for x, y, z in places.values()]
        turned = [(x, -z, y) if up == "z" else (x, y, z) for x, y, z in ahead]
        cells.append([f"{scale * value:.6f}" for place in turned for value in place])
    cells[1][:3] = ["", "", ""]
    return cells


def motive(
    places: Places,
    kind: str = "Marker",
    *,
    who: Sequence[str] = ("Ann",),
    unit: str = "Centimeters",
) -> str:
    """A take; bones have a quaternion before their places."""
    before = 4 if kind == "Bone" else 0
    names = [f"{one}:{name}" for one in who for name in places]
    each = [cell for name in names for cell in [name] * (before + 3)]
    what = (["Rotation"] * before + ["Position"] * 3) * len(names)
    axes = (list("XYZW")[:before] + list("XYZ")) * len(names)
    lines = [
        "Format Version,1.23,Take Name,a,Capture Frame Rate,120.000000,Export Frame Rate,60.000000,"
        f"Rotation Type,Quaternion,Length Units,{unit},Coordinate Space,Global",
        "",
        ",".join([",Type", *[kind] * len(each)]),
        ",".join([",Name", *each]),
        ",".join([",ID", *['"9A,1"'] * len(each)]),
        ",".join([",", *what]),
        ",".join(["Frame", "Time (Seconds)", *axes]),
    ]
    for frame, cells in enumerate(rows(places)):
        triples = [[*["0"] * before, *cells[n : n + 3]] for n in range(0, len(cells), 3)]
        numbers = [cell for _ in who for triple in triples for cell in triple]
        lines.append(",".join([str(frame), f"{frame / 60:.6f}", *numbers]))
    return "\n".join(lines) + "\n"


def vicon(places: Places, up: str = "z") -> str:
    names = "".join(f"Ann:{name},,," for name in places)
    lines = ["Model Outputs", "60", ",,a,,", "Frame,Sub Frame,X,Y,Z", ",,deg,deg,deg", "1,0,1,2,3"]
    lines += ["", "Trajectories", "60", f",,{names}", "Frame,Sub Frame" + ",X,Y,Z" * len(places)]
    lines += [",," + ",".join(["mm"] * 3 * len(places))]
    lines += [",".join([str(n), "0", *cells]) for n, cells in enumerate(rows(places, 10.0, up), 1)]
    return "\n".join([*lines, "", "Devices", "1000", ",,F", "Frame,Sub Frame,Fx", ",,N", "1,0,1"])


def qualisys(places: Places, is_numbered: bool = False, comma: str = ".") -> str:
    lines = [f"NO_OF_FRAMES\t{FRAMES}", f"NO_OF_MARKERS\t{len(places)}", f"FREQUENCY\t60{comma}0"]
    lines += ["EVENT\tstart\t1\t0.0", "DATA_INCLUDED\t3D", "\t".join(["MARKER_NAMES", *places])]
    if is_numbered:
        lines[:0] = ["FILE_VERSION\t2.0.0"]
        axes = [f"{name} {axis}" for name in places for axis in "XYZ"]
        lines += ["\t".join(["TRAJECTORY_TYPES", *["Measured"] * len(places)])]
        lines += ["\t".join(["Frame", "Time", *axes])]
    for frame, cells in enumerate(rows(places, 10.0, "z")):
        cells = [cell.replace(".", comma) or "0" for cell in cells]
        before = [str(frame + 1), f"{frame / 60:.5f}"] if is_numbered else []
        lines.append("\t".join([*before, *cells]))
    return "\n".join(lines) + "\n"


def height_and_way(clip: Clip) -> np.ndarray:
    """Heights of joints and how far they are from the first, whatever the heading; metres."""
    at = clip_positions(clip)[0]
    return np.stack([at[..., 1], np.linalg.norm(at - at[:1, :1], axis=2)])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", motive(MARKERS)),
        ("a.csv", vicon(MARKERS, "y")),
        ("a.csv", vicon(MARKERS)),
        ("a.tsv", qualisys(MARKERS)),
        ("a.tsv", qualisys(MARKERS, True)),
        ("a.tsv", qualisys(MARKERS, comma=",")),
    ],
    ids=["Motive", "Vicon, y up", "Vicon", "Qualisys", "Qualisys with times", "decimal commas"],
)
def test_markers_are_read_as_those_of_a_trc(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    assert find_captures(tmp_path) == [tmp_path / name]
    clip = read_capture(tmp_path / name)
    plain = read_trc(trc(MARKERS), "a.trc")
    assert (clip.format, clip.fps, clip.n_frames) == ("markers", 60.0, FRAMES)
    np.testing.assert_allclose(height_and_way(clip), height_and_way(plain), atol=1e-4)


AXES = ("_x", "_y", "_z"), (".x", ".y", ".z"), (" X", " Y", " Z"), ("_position_x", "_position_y",
"_position_z")  # fmt: skip


def joints_table(axes: Sequence[str], mark: str = ",", *, times: bool = True) -> str:
    """A column for each joint and axis, beside turns and a confidence."""
    heads = [f"{name}{axis}" for name in CENTRES for axis in axes]
    lines = [mark.join([*["Timestamp"] * times, *heads, "LHip_rotation_x", "LHip_visibility"])]
    for frame, cells in enumerate(rows(CENTRES)):
        numbers = [*[f"{frame / 60:.5f}"] * times, *cells, "3.5", "0.9"]
        lines.append(mark.join(n.replace(".", ",") if mark == ";" else n for n in numbers))
    return "\n".join(lines) + "\n"


def tidy_table() -> str:
    """A row a keypoint and frame, of two models, as FreeMoCap writes it."""
    lines = ["frame,timestamp,keypoint,x,y,z,model,reprojection_error"]
    for frame, cells in enumerate(rows(CENTRES)):
        for n, name in enumerate(CENTRES):
            places = ",".join(cells[3 * n : 3 * n + 3])
            lines += [f"{frame},{frame / 60:.5f},{name},{places},mediapipe.body,0.1"]
        lines += [f"{frame},{frame / 60:.5f},thumb,1,2,3,mediapipe.left_hand,0.1"]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "text",
    [*(joints_table(axes) for axes in AXES), joints_table(AXES[2], ";"), tidy_table()],
    ids=["_x", ".x", " X", "_position_x", "decimal commas", "a row a keypoint"],
)
def test_tables_of_joints_are_read_as_those_of_a_trc(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    assert find_captures(tmp_path) == [tmp_path / "a.csv"]
    clip, plain = read_capture(tmp_path / "a.csv", up="y"), read_trc(trc(CENTRES), "a.trc")
    assert (clip.fps, clip.n_frames) == (60.0, FRAMES)
    assert any("by the length of the legs it is 0.01 m" in note for note in clip.notes)
    limbs = [*range(1, 9), *range(14, 17), *range(18, 21)]
    both = [height_and_way(each)[..., limbs] for each in (clip, plain)]
    np.testing.assert_allclose(*both, atol=0.01)


def test_a_table_of_joints_without_times_has_its_rate_told() -> None:
    data = joints_table(AXES[0], times=False).encode()
    clip = read_takes_bytes(data, "markers")[""]
    assert clip.fps == 30.0
    assert "The table has no frame rate; 30 frames a second are taken" in " ".join(clip.notes)


SEGMENTS = {"Hip": "UpperLeg", "Knee": "LowerLeg", "Ankle": "Foot", "BigToe": "Toe"}
SEGMENTS |= {"Shoulder": "UpperArm", "Elbow": "ForeArm", "Wrist": "Hand"}


def mvnx(who: Sequence[str] = ("P1",), *, places: bool = True) -> str:
    """A take of MVN Animate; the first frames are poses, and z is up."""
    names = {n: {"L": "Left", "R": "Right"}[n[0]] + SEGMENTS[n[1:]] if n[1:] in SEGMENTS else n
             for n in CENTRES if n[1:] != "Heel"}  # fmt: skip
    text = '<?xml version="1.0" encoding="UTF-8"?><mvnx xmlns="http://www.xsens.com/mvn/mvnx">'
    for one in who:
        segments = "".join(
            f'<segment label="{name}"><points/></segment>' for name in names.values()
        )
        text += f'<subject label="{one}" frameRate="60"><segments>{segments}</segments><frames>'
        none = " ".join(["0"] * 3 * len(names))
        text += f'<frame type="tpose"><position>{none}</position></frame>'
        for frame in range(FRAMES):
            at = [(x, -z - frame, y) for x, y, z in (CENTRES[name] for name in names)]
            cells = " ".join(f"{value / 100:.6f}" for place in at for value in place)
            inner = f"<position>{cells}</position>" if places else "<orientation>1</orientation>"
            text += f'<frame time="{frame * 16}" type="normal">{inner}</frame>'
        text += "</frames></subject>"
    return text + "</mvnx>"


def test_segments_of_xsens_are_the_joints_of_each_performer() -> None:
    clips = read_takes_bytes(mvnx(("P1", "P2")).encode(), "markers", path="a.mvnx")
    plain = read_trc(trc(CENTRES), "a.trc")
    assert [*clips] == ["P1", "P2"]
    for clip in clips.values():
        assert (clip.fps, clip.n_frames, clip.unit, clip.up) == (60.0, FRAMES, 1.0, "y")
        legs = [height_and_way(each)[:, :, 1:9] for each in (clip, plain)]
        np.testing.assert_allclose(legs[0], legs[1], atol=0.01)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (mvnx(places=False), "expected places of segments (position), found none"),
        (mvnx().replace("</mvnx>", ""), "expected Xsens' MVNX with as many places as segments"),
        (mvnx().replace("<position>0.", "<position>x "), "expected Xsens' MVNX"),
        ("<?xml version='1.0'?><!DOCTYPE a []><mvnx/>", "expected XML without a DOCTYPE"),
    ],
    ids=["turns alone", "cut", "no numbers", "entities"],
)
def test_a_broken_mvnx_is_refused(text: str, said: str) -> None:
    with pytest.raises(CaptureError) as error:
        read_takes_bytes(text.encode(), "markers", path="a.mvnx")
    assert said in str(error.value)


def test_events_may_stand_before_the_trajectories(tmp_path: Path) -> None:
    events = "Events\n60\nSubject,Context,Name,Time (s),Description\nAnn,Left,Foot Off,0.1,x\n\n"
    (tmp_path / "a.csv").write_text(events + vicon(MARKERS))
    assert find_captures(tmp_path) == [tmp_path / "a.csv"]
    assert read_capture(tmp_path / "a.csv").n_frames == FRAMES


MISSING = "By their numbers 3 frames are missing; they are taken as not seen."


@pytest.mark.parametrize(
    ("name", "text", "first", "notes"),
    [
        ("a.csv", motive(MARKERS), 12, (MISSING,)),
        ("a.csv", motive(BONES, "Bone"), 12, (MISSING,)),
        ("a.csv", vicon(MARKERS), 19, (MISSING,)),
        (
            "a.tsv",
            qualisys(MARKERS, True),
            13,
            ("The header says 20 frames; there are 17.", MISSING),
        ),
    ],
    ids=["Motive", "bones", "Vicon", "Qualisys"],
)
def test_frames_that_the_rows_leave_out_keep_their_time(
    name: str, text: str, first: int, notes: tuple[str, ...], tmp_path: Path
) -> None:
    lines = text.splitlines(keepends=True)
    (tmp_path / name).write_text("".join(lines))
    whole = read_capture(tmp_path / name)
    (tmp_path / name).write_text("".join(lines[:first] + lines[first + 3 :]))
    clip = read_capture(tmp_path / name)
    assert clip.notes[: len(notes)] == notes
    np.testing.assert_allclose(clip.root_positions, whole.root_positions, atol=1e-4)


def test_frames_of_qualisys_without_the_first_marker_are_read() -> None:
    """Programs write a marker that was not seen as 0, or leave its cells empty."""
    lines = qualisys(MARKERS).splitlines()
    lines[6:9] = ["\t\t\t" + line.split("\t", 3)[3] for line in lines[6:9]]
    assert read_takes_bytes("\n".join(lines).encode(), "markers")[""].n_frames == FRAMES


def test_bones_of_motive_are_the_joints_of_each_performer() -> None:
    clips = read_takes_bytes(motive(BONES, "Bone", who=("Ann", "Ben")).encode(), "markers")
    assert [*clips] == ["Ann", "Ben"]
    plain = read_trc(trc(CENTRES), "a.trc")
    for clip in clips.values():
        assert clip.unit == 0.01
        assert not any("unit" in note for note in clip.notes)
        legs = [height_and_way(each)[:, :, 1:9] for each in (clip, plain)]
        np.testing.assert_allclose(legs[0], legs[1], atol=0.02)


def test_bones_that_fit_no_person_in_the_unit_of_the_file_are_in_another() -> None:
    true = read_takes_bytes(motive(BONES, "Bone").encode(), "markers")[""]
    for unit, length in (("Millimeters", 0.001), ("Meters", 1.0), ("", 0.001)):
        (clip,) = read_takes_bytes(motive(BONES, "Bone", unit=unit).encode(), "markers").values()
        assert clip.unit == 0.01
        assert clip.notes[0].startswith(f"The file says that its unit is {length:g} m; the body")
        np.testing.assert_allclose(clip.world_positions(), true.world_positions(), atol=1e-9)
    asked = ReadOptions(unit=0.02)
    (clip,) = read_takes_bytes(motive(BONES, "Bone").encode(), "markers", options=asked).values()
    assert clip.unit == 0.02


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (motive(MARKERS, "Rigid Body"), "expected markers, or bones in global coordinates, found"),
        (motive(BONES, "Bone").replace("Global", "Local"), "found Bone. Export them, too"),
        (motive(MARKERS).partition("\nFrame")[0], "found no row that begins with Frame"),
        (motive(MARKERS).replace("0.016667", "0.016667x"), "line 9: expected numbers, found"),
        (
            vicon(MARKERS).replace("Trajectories", "Segments"),
            "found the section Model Outputs alone",
        ),
        (vicon(MARKERS).replace("Frame,Sub", "Sub"), "expected rate, names, axes and units below"),
        (qualisys(MARKERS).replace("3D", "6D"), "expected places of markers in 3D with MARKER_NAM"),
        ("\n".join(qualisys(MARKERS).split("\n")[:6]), "expected at least 1 frame, found 0"),
        ("file\twords\na.bvh\twalks\n", "expected a table of markers .* found something else"),
    ],
)
def test_tables_without_markers_are_refused_with_the_reason(text: str, said: str) -> None:
    with pytest.raises(CaptureError, match=said):
        read_takes_bytes(text.encode(), "markers")


def test_markers_of_no_whole_body_are_kept() -> None:
    few = {name: MARKERS[name] for name in ("LASI", "RASI", "LKNE")}
    data = motive(few).encode()
    with pytest.raises(NoBodyError):
        read_takes_bytes(data, "markers")
    tracks = read_marker_bytes(data, "markers")
    assert (tracks.labels, tracks.fps) == (("Ann:LASI", "Ann:RASI", "Ann:LKNE"), 60.0)
    assert np.isnan(tracks.places[1, 0]).all()
    np.testing.assert_allclose(
        tracks.places[2, 1] * 100.0, np.add(few["RASI"], (0, 0, 2)), atol=1e-6
    )


def test_columns_called_as_sections_are_no_tables_of_markers() -> None:
    assert is_marker_table(vicon(MARKERS).encode())
    assert not is_marker_table(b"Joints\n29\n30\n31\n")
