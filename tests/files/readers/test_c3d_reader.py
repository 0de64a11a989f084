"""C3D as clips, on files that the tests write: a person in T-pose."""

from __future__ import annotations

import numpy as np
import pytest
from c3d_writer import BLOCK, SGI, c3d_bytes
from odd_c3d import MARKERS
from trc_writer import CENTRES, read_c3d, read_trc, trc

from motiondb.body import body, kinematics, retarget, rotation
from motiondb.errors import CaptureError
from motiondb.files.formats import read_takes_bytes
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.c3d import c3d_events
from motiondb.records import Event


def tracks(n_frames: int = 30) -> dict[str, np.ndarray]:
    """The markers of a person who slides ahead by 1 cm a frame, metres, y up."""
    ahead = np.arange(n_frames)[:, None] * [0.0, 0.0, 0.01]
    return {name: np.array(place) / 100.0 + ahead for name, place in MARKERS.items()}


SEGMENTS = {"Hip": "thigh", "Knee": "shank", "Ankle": "foot", "BigToe": "toes", "Shoulder": "uarm",
            "Elbow": "larm", "Wrist": "hand"}  # fmt: skip


def segments(n_frames: int = 20, cut: int = 0) -> bytes:
    """A file of Theia: matrices of segments, z up, millimetres, and no points."""
    named = {"head_4X4": CENTRES["Head"], "worldbody_4X4": (0, 0, 0)}
    named |= {
        f"{side.lower()}_{name}_4X4": CENTRES[side + joint]
        for side in "LR"
        for joint, name in SEGMENTS.items()
    }
    numbers = np.zeros((n_frames, len(named), 17), "f4")
    numbers[..., [0, 5, 10, 15]] = 1.0
    for n, (x, y, z) in enumerate(named.values()):
        ahead = z + np.arange(n_frames)
        numbers[:, n, 12:15] = 10.0 * np.stack([x + 0 * ahead, -ahead, y + 0 * ahead], axis=1)
    numbers[3, 1, 16] = -1.0
    said = {"ROTATION:USED": len(named), "ROTATION:DATA_START": 9, "ROTATION:LABELS": [*named]}
    said |= {"EVENT:USED": 1, "EVENT:LABELS": ["Foot Strike"], "EVENT:CONTEXTS": ["Left"]}
    said |= {"EVENT:TIMES": [0.0, 0.1]}
    head = c3d_bytes(np.zeros((n_frames, 0, 3)), [], said={**said, "ROTATION:RATIO": 1})
    return head.ljust(8 * BLOCK, b"\0") + numbers.tobytes()[: -cut or None]


def test_segments_of_theia_are_joints() -> None:
    clip, plain = read_c3d(segments(), "a.c3d"), read_trc(trc(CENTRES), "a.trc")
    assert (clip.fps, clip.n_frames, clip.up) == (100.0, 20, "y")
    mine, theirs = (retarget.clip_keypoints(each) for each in (clip, plain))
    limbs = [n for n, name in enumerate(body.JOINTS) if name[0] in "lr" and name[2:] != "collar"]
    np.testing.assert_allclose(mine[:, limbs], theirs[:, limbs], atol=0.01)
    (event,) = c3d_events(segments(), "a.c3d", 100.0)
    assert (event.name, event.joint) == ("foot_strike", "l_ankle")
    with pytest.raises(CaptureError, match="expected 20 frames of 16 segments, found 19: the file"):
        read_c3d(segments(cut=100), "a.c3d")


METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inch": 0.0254}


def write(
    markers: dict[str, np.ndarray],
    *,
    z_up: bool = True,
    prefix: str = "",
    units: str = "mm",
    metres: float | None = None,
    turn: np.ndarray | None = None,
    **how: object,
) -> bytes:
    """Write markers in metres, y up, with z up unless a turn is given; `metres` a file unit."""
    points = np.stack(list(markers.values()), axis=1)
    if turn is not None:
        points = rotation.rotate(turn, points)
    elif z_up:
        points = points[..., [0, 2, 1]] * [1.0, -1.0, 1.0]
    points = points / (metres or METRES[units])
    said = {"POINT:UNITS": units, **how.pop("said", {})}
    return c3d_bytes(points, [prefix + name for name in markers], said=said, **how)


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"z_up": False},
        {"prefix": "Anna:"},
        {"units": "m"},
        {"prefix": "lab:Anna:"},
        {"machine": SGI},
    ],
)
def test_joint_centres_by_hand(how: dict) -> None:
    clip = read_c3d(write(tracks(), **how), "a.c3d")
    assert (clip.fps, clip.format, clip.n_frames, clip.notes) == (100.0, "c3d", 30, clip.notes)
    if how.get("z_up", True):
        assert clip.notes == ()
    assert clip.skeleton.names == body.JOINTS
    positions, _ = kinematics.clip_positions(clip)
    places = dict(zip(body.JOINTS, positions[10]))
    # W = 0.24 m: hips 0.0864 m to the side, 0.0456 m back, 0.072 m down from the front markers.
    np.testing.assert_allclose(places["l_hip"], [0.0864, 0.928, 0.1 - 0.0456 + 0.1], atol=2e-3)
    np.testing.assert_allclose(places["r_hip"], [-0.0864, 0.928, 0.1 - 0.0456 + 0.1], atol=2e-3)
    np.testing.assert_allclose(places["l_knee"], [0.1, 0.5, 0.1], atol=1e-2)
    np.testing.assert_allclose(places["r_ankle"], [-0.1, 0.08, 0.1], atol=1e-2)
    np.testing.assert_allclose(places["r_toe"], [-0.1, 0.03, 0.24], atol=1e-2)
    np.testing.assert_allclose(places["l_wrist"], [0.7, 1.45, 0.1], atol=2e-2)
    np.testing.assert_allclose(places["head"], [0.0, 1.7, 0.1], atol=2e-2)
    np.testing.assert_allclose(np.diff(clip.root_positions, axis=0), [[0, 0, 0.01]] * 29, atol=1e-6)


def test_cmu_names_of_the_pelvis() -> None:
    names = {"LASI": "LFWT", "RASI": "RFWT", "LPSI": "LBWT", "RPSI": "RBWT"}
    markers = {names.get(name, name): track for name, track in tracks().items()}
    clip = read_c3d(write(markers), "a.c3d")
    plain = read_c3d(write(tracks()), "a.c3d")
    np.testing.assert_allclose(clip.local_rotations, plain.local_rotations, atol=1e-6)


def test_without_markers_that_can_be_spared() -> None:
    spared = ("TOE", "WRA", "WRB", "TRN", "LAV", "FHD", "BHD")  # of STRN, CLAV, or of each side
    markers = {name: track for name, track in tracks().items() if name[1:] not in spared}
    positions, _ = kinematics.clip_positions(read_c3d(write(markers), "a.c3d"))
    places = dict(zip(body.JOINTS, positions[0]))
    for side, sign in (("l", 1), ("r", -1)):
        foot = places[f"{side}_toe"] - places[f"{side}_ankle"]
        np.testing.assert_allclose(foot, [0, -0.06, 0.14], atol=0.03)
        assert sign * (places[f"{side}_wrist"] - places[f"{side}_elbow"])[0] > 0.2


def test_a_missing_toe_points_ahead_of_the_heel() -> None:
    markers = {name: track for name, track in tracks().items() if name not in ("LTOE", "RTOE")}
    markers["LHEE"] = markers["LANK"] + [-0.05, -0.03, -0.05]
    positions, _ = kinematics.clip_positions(read_c3d(write(markers), "a.c3d"))
    places = dict(zip(body.JOINTS, positions[0]))
    assert (places["l_toe"] - places["l_ankle"])[2] > 0.1


def moving(n_frames: int = 240) -> dict[str, np.ndarray]:
    """A person who slides ahead, turns, and leans over and back with all above the hips."""
    time = np.arange(n_frames) / 100.0
    markers = tracks(n_frames)
    for name, track in markers.items():
        place = track[0] - [0, 0.93, 0]
        lean = rotation.from_axis_angle((1.0, 0.0, 0.0), 0.3 * np.sin(3.0 * time))
        heading = rotation.from_axis_angle((0.0, 1.0, 0.0), 0.4 * time)
        if place[1] < 0:
            lean = np.broadcast_to(rotation.IDENTITY, lean.shape)
        turned = rotation.rotate(rotation.multiply(heading, lean), np.tile(place, (n_frames, 1)))
        markers[name] = turned + (np.outer(time, [0.2, 0.0, 1.0]) + np.array([0, 0.93, 0]))
    return markers


def joints(data: bytes, **how: object) -> tuple[np.ndarray, tuple[str, ...]]:
    """Places (frames, 21, 3), and the notes of the reader and of the canonical body."""
    clip = read_c3d(data, "a.c3d", ReadOptions(**how))
    return kinematics.clip_positions(clip)[0], clip.notes + retarget.to_motion(clip).notes


def test_short_gaps_are_filled_and_long_ones_refused() -> None:
    plain = read_c3d(write(tracks(200)), "a.c3d")
    markers = tracks(200)
    markers["LKNE"][20:40] = np.nan
    markers["RKNE"][:30] = 0.0
    clip = read_c3d(write(markers), "a.c3d")
    line = "Lost and filled along a straight line: RKNE (0.3 s)."
    assert clip.notes == (line,)
    np.testing.assert_allclose(
        clip.local_rotations[40:, 2], plain.local_rotations[40:, 2], atol=1e-5
    )
    markers["LKNE"][20:80] = np.nan
    data = write(markers)
    clip = read_c3d(data, "a.c3d", ReadOptions(skip_bad_frames=True))
    assert clip.n_frames == 140
    assert clip.notes == (line, "Left out 60 frames with lost markers.")
    clip = read_c3d(data, "a.c3d")
    assert clip.n_frames == 200
    assert clip.notes == (
        line,
        "Lost for long and drawn there beside the trunk; do not believe the motion of these "
        "limbs: LKNE (0.6 s).",
    )
    ends = plain.world_positions()[[20, 79]], clip.world_positions()[[20, 79]]
    np.testing.assert_allclose(ends[1][:, :2], ends[0][:, :2], atol=0.05)
    for name in ("LASI", "RASI", "LPSI", "RPSI"):
        markers[name][20:80] = np.nan
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(markers), "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected no gap above 0.5 s, found lost markers: "
        "LASI (0.6 s), LPSI and RPSI (0.6 s), RASI (0.6 s). Fill the gaps "
        "before the export, or pass --skip-bad-frames to leave those frames out."
    )


def test_a_performer_lost_for_long_does_not_refuse_the_other() -> None:
    whole, lost = tracks(200), tracks(200)
    for name in lost:
        lost[name] = lost[name] + [2.0, 0.0, 0.0]
        lost[name][20:120] = np.nan
    both = {f"Ann:{n}": t for n, t in whole.items()} | {f"Bob:{n}": t for n, t in lost.items()}
    clips = read_takes_bytes(write(both), "c3d", path="a.c3d")
    assert list(clips) == [""]
    assert any("Another performer is left out: a.c3d#Bob" in n for n in clips[""].notes)


def test_filtered_copies_of_all_markers_are_one_capture() -> None:
    markers = tracks()
    copies = {f"{name}_f": track + 0.001 for name, track in markers.items()}
    clip = read_c3d(write(markers | copies), "a.c3d")
    assert clip.notes == (
        "The markers with '_f' in their names stand where the others are, and are left out as a "
        "copy of them.",
    )
    plain = read_c3d(write(markers), "a.c3d")
    np.testing.assert_allclose(clip.root_positions, plain.root_positions)


def test_a_shoulder_lost_for_long_keeps_its_place_on_the_trunk() -> None:
    markers = tracks(200)
    whole = read_c3d(write(markers), "a.c3d")
    markers["LSHO"] = markers["LSHO"].copy()
    markers["LSHO"][30:150] = np.nan
    clip = read_c3d(write(markers), "a.c3d")
    assert "Lost for long and filled from the markers beside them: LSHO (1.2 s)." in clip.notes
    np.testing.assert_allclose(clip.local_rotations, whole.local_rotations, atol=1e-5)


@pytest.mark.parametrize(
    ("frames", "lost"),
    [(slice(60, 90), 0.0), (slice(60, 190), 0.0), (slice(0, 120), np.nan), (slice(130, 240), 0.0)],
)
@pytest.mark.parametrize(
    ("names", "within"),
    [
        ("LWRA", 0.02), ("RWRB", 0.02), ("LFHD", 0.01), ("RBHD LBHD", 0.06), ("C7", 0.01),
        ("CLAV", 0.01), ("T10", 0.01), ("STRN T10", 0.05), ("LASI", 0.01), ("RPSI", 0.01),
        ("LTOE", 0.03), ("RTOE LTOE", 0.03), ("LFHD RFHD LBHD RBHD", 0.06), ("LWRA LWRB", 0.12),
    ],
)  # fmt: skip
def test_a_lost_marker_freezes_nothing(
    names: str, within: float, frames: slice, lost: float
) -> None:
    whole, no_notes = joints(write(moving()))
    assert no_notes == ()
    markers = moving()
    for name in names.split():
        markers[name][frames] = lost
    found, notes = joints(write(markers))
    assert np.linalg.norm(found - whole, axis=-1).max() < within
    if frames.stop - frames.start <= 50:
        assert notes == ()
    else:
        assert len(notes) == 1
        assert all(
            f"{name} ({(frames.stop - frames.start) / 100:.1f} s)" in notes[0]
            for name in names.split()
        )


@pytest.mark.parametrize("name", ["LANK", "LTOE"])
@pytest.mark.parametrize("frames", [slice(40, 80), slice(40, 170)])
def test_a_marker_of_a_foot_that_swings(name: str, frames: slice) -> None:
    """The shank swings about the knee by 50 degrees, the foot by 30 more."""
    markers, time = tracks(240), np.arange(240) / 100.0
    markers["LHEE"] = markers["LANK"] + np.array([-0.05, -0.04, -0.06])
    for centre, names, size in (("LKNE", "LANK LHEE LTOE", 0.45), ("LANK", "LHEE LTOE", 0.25)):
        swing = rotation.from_axis_angle((1.0, 0.0, 0.0), size * (1.0 - np.cos(6.0 * time)))
        for moved in names.split():
            way = markers[moved] - markers[centre]
            markers[moved] = markers[centre] + rotation.rotate(swing, way)
    whole, _ = joints(write(markers))
    markers[name][frames] = 0.0
    found, notes = joints(write(markers))
    assert np.linalg.norm(found - whole, axis=-1).max() < 0.05
    assert any(name in note for note in notes) == (frames.stop > 100)
    del markers["LHEE"]
    if name == "LANK" and frames.stop > 100:
        notes = read_c3d(write(markers), "a.c3d").notes
        assert any("beside the trunk" in note and "LANK (1.3 s)" in note for note in notes)


@pytest.mark.parametrize(
    "names", ["CLAV", "C7 T10", "LTOE RTOE", "LWRA RWRA", "LWRA LWRB", "LFHD RFHD LBHD RBHD"]
)
def test_markers_never_seen_are_as_absent(names: str) -> None:
    markers = moving()
    absent = {name: track for name, track in markers.items() if name not in names.split()}
    for name in names.split():
        markers[name][:] = 0.0
    found, notes = joints(write(markers))
    np.testing.assert_allclose(found, joints(write(absent))[0], atol=1e-6)
    assert notes == (f"Never seen, taken as absent: {', '.join(sorted(names.split()))}.",)
    markers["LKNE"][:] = 0.0
    with pytest.raises(CaptureError, match=r"found none for LKNE .*; never seen: .*LKNE"):
        read_c3d(write(markers), "a.c3d")


def test_two_lost_markers_of_the_pelvis_are_refused() -> None:
    markers = moving()
    markers["LASI"][60:190] = markers["RPSI"][60:190] = 0.0
    with pytest.raises(CaptureError, match=r"LASI \(1.3 s\), LPSI and RPSI \(1.3 s\)"):
        read_c3d(write(markers), "a.c3d")
    sacrum = (markers["LPSI"] + moving()["RPSI"]) / 2.0
    markers["LASI"] = moving()["LASI"]
    data = write({**markers, "SACR": sacrum})
    np.testing.assert_allclose(joints(data)[0], joints(write(moving()))[0], atol=1e-3)


LYING = rotation.from_axis_angle((1.0, 0.0, 0.0), -np.pi / 2)
UPS = {  # Y_SCREEN -> a turn of a world with y up into one with this axis up
    "+Y": rotation.IDENTITY,
    "+Z": rotation.from_axis_angle((1.0, 0.0, 0.0), np.pi / 2),
    "-Y": rotation.from_axis_angle((1.0, 0.0, 0.0), np.pi),
    "-Z": rotation.from_axis_angle((1.0, 0.0, 0.0), -np.pi / 2),
    "+X": rotation.from_axis_angle((0.0, 0.0, 1.0), -np.pi / 2),
    "-X": rotation.from_axis_angle((0.0, 0.0, 1.0), np.pi / 2),
}


def neck_above_hips(data: bytes, **how: object) -> float:
    places = joints(data, **how)[0]
    return float(np.median(places[:, body.INDEX["neck"], 1] - places[:, 0, 1]))


@pytest.mark.parametrize("axis", UPS)
@pytest.mark.parametrize("heading", [0.0, 1.0, 2.0, 3.0, 4.5])
def test_the_axis_of_the_screen_is_up(axis: str, heading: float) -> None:
    across = "+Y" if "X" in axis else "+X"
    said = {"POINT:X_SCREEN": across, "POINT:Y_SCREEN": axis}
    about = rotation.from_axis_angle((0.0, 1.0, 0.0), heading)
    lying = rotation.multiply(UPS[axis], rotation.multiply(about, LYING))
    assert abs(neck_above_hips(write(moving(), turn=lying, said=said))) < 0.2
    standing = rotation.multiply(UPS[axis], about)
    assert neck_above_hips(write(moving(), turn=standing, said=said)) > 0.4
    asked = axis.lower().lstrip("+")
    assert neck_above_hips(write(moving(), turn=standing), up=asked) > 0.4


def test_a_body_that_stands_the_other_way_shows_a_wrong_sign() -> None:
    data = write(moving(), said={"POINT:X_SCREEN": "-X", "POINT:Y_SCREEN": "-Z"})
    assert neck_above_hips(data) > 0.4
    assert joints(data)[1] == (
        "POINT:Y_SCREEN says that -z is up, but the body stands along z, which is taken. "
        "Give the axis (--up) if this is wrong.",
    )


@pytest.mark.parametrize("said", ["mm", "cm", "m", "inches"])
@pytest.mark.parametrize("metres", [0.001, 0.01, 1.0, 0.0254])
def test_a_unit_that_no_person_has_is_corrected(said: str, metres: float) -> None:
    clip = read_c3d(write(moving(), units=said, metres=metres), "a.c3d")
    assert clip.unit == pytest.approx(metres, rel=0.02)
    stated = METRES.get(said, 0.0254)
    assert len(clip.notes) == (stated != metres)
    assert all(f"its unit is {stated:.4g} m" in note for note in clip.notes)
    assert (
        read_c3d(write(moving(), units=said, metres=metres), "a.c3d", ReadOptions(unit=1.0)).unit
        == 1.0
    )


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("", 1e-3),
        ("mete", 1.0),
        ("METRES", 1.0),
        ("millimetres", 1e-3),
        ("cent", 0.01),
        ("in", 0.0254),
    ],
)
def test_names_of_units(name: str, unit: float) -> None:
    assert read_c3d(write(moving(), units=name, metres=unit), "a.c3d").unit == unit
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(moving(), units="volt", metres=1.0), "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected the unit mm, cm, m or inch, found 'volt'. Give --unit."
    )


def test_sides_as_asked() -> None:
    plain, _ = joints(write(moving()))
    names = {name: {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:] for name in MARKERS}
    swapped = write({names[name]: track for name, track in moving().items()})
    np.testing.assert_allclose(joints(swapped, swap_sides=True)[0], plain, atol=1e-5)
    for mirror in ([-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]):
        mirrored = write({name: track * mirror for name, track in moving().items()})
        found = joints(mirrored, mirror_world=True)[0]
        turn = [-1.0, 1.0, -1.0] if mirror[2] < 0 else [1.0, 1.0, 1.0]
        np.testing.assert_allclose(found, plain * turn, atol=1e-5)


def test_missing_markers_are_named() -> None:
    markers = {
        name: track for name, track in tracks().items() if name not in ("LKNE", "RPSI", "T10")
    }
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(markers), "a.c3d")
    assert str(caught.value).startswith(
        "a.c3d: expected the markers of a whole body, as Plug-in Gait names them, found none for "
        "LKNE; LPSI and RPSI, or SACR (there are: C7, CLAV, LANK, LASI,"
    )
    assert str(caught.value).endswith(
        "). Rename the markers, or export the solved skeleton as BVH."
    )


@pytest.mark.parametrize("label", ["Ana_{}", "subject1_{}", "{}_1", "Bob{}", "Ben:{}_x"])
def test_what_labels_share_is_no_part_of_them(label: str) -> None:
    plain = read_c3d(write(tracks()), "a.c3d")
    named = {label.format(name): track for name, track in tracks().items()}
    named["Elsewhere"] = tracks()["C7"]
    clip = read_c3d(write(named), "a.c3d")
    np.testing.assert_array_equal(clip.root_positions, plain.root_positions)
    assert clip.notes == plain.notes


def test_numbers_behind_labels_are_no_part_of_them() -> None:
    plain = read_c3d(write(tracks()), "a.c3d")
    named = {f"{name}_{n}": track for n, (name, track) in enumerate(tracks().items())}
    clip = read_c3d(write(named), "a.c3d")
    np.testing.assert_array_equal(clip.local_rotations, plain.local_rotations)


def test_a_marker_that_occurs_twice_is_told() -> None:
    again = tracks() | {"Lasi": tracks()["RTOE"]}
    clip = read_c3d(write(again), "a.c3d")
    assert clip.notes[0] == (
        "Markers that occur more than once, of which the one seen most is taken: LASI."
    )
    plain = read_c3d(write(tracks()), "a.c3d")
    np.testing.assert_array_equal(clip.root_positions, plain.root_positions)


@pytest.mark.parametrize(("lost", "left"), [("C7", "CLAV"), ("CLAV", "C7")])
def test_a_neck_of_one_marker_is_told(lost: str, left: str) -> None:
    markers = {name: track for name, track in tracks().items() if name != lost}
    note = f"The neck is taken at {left}, as the other of C7 and CLAV is missing."
    assert note in read_c3d(write(markers), "a.c3d").notes


@pytest.mark.parametrize("names", ["LWRA RWRA", "CLAV STRN", "C7 T10"])
def test_markers_that_are_not_where_their_names_say_are_told(names: str) -> None:
    assert not any("where their" in note for note in read_c3d(write(moving()), "a.c3d").notes)
    one, other = names.split()
    markers = moving()
    markers[one], markers[other] = markers[other], markers[one]
    (note,) = [n for n in read_c3d(write(markers), "a.c3d").notes if "where their names say" in n]
    assert one in note


@pytest.mark.parametrize("names", ["LASI LPSI", "RASI RPSI", "CLAV C7", "LFHD LBHD"])
def test_front_and_back_exchanged_are_told(names: str) -> None:
    assert not any("Front" in note for note in read_c3d(write(moving()), "a.c3d").notes)
    front, back = names.split()
    markers = moving()
    markers[front], markers[back] = markers[back], markers[front]
    notes = [n for n in read_c3d(write(markers), "a.c3d").notes if n.startswith("Front is behind")]
    assert len(notes) == 1
    assert f"{front} and {back}" in notes[0]


def test_two_performers_are_two_takes() -> None:
    markers = {
        f"{who}:{name}": track for who in ("Ben", "Anna") for name, track in tracks().items()
    }
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(markers), "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected one performer, found 2: Anna, Ben. Name one: FILE#Anna."
    )
    clips = read_takes_bytes(write(markers), "c3d", path="a.c3d")
    alone = read_c3d(write(tracks()), "a.c3d")
    assert sorted(clips) == ["Anna", "Ben"]
    for clip in (clips["Ben"], read_c3d(write(markers), "a.c3d", ReadOptions(take="Ben"))):
        np.testing.assert_array_equal(clip.local_rotations, alone.local_rotations)


@pytest.mark.parametrize(
    ("first", "second", "takes"),
    [
        ("Ann_{}", "Bob_{}", ["Ann", "Bob"]),
        ("{}_1", "{}_2", ["1", "2"]),
        ("Ann:Body:{}", "Bob:Body:{}", ["Ann:Body", "Bob:Body"]),
        ("{}", "Bob:{}", ["unnamed", "Bob"]),
        ("P#1:{}", "a/b:{}", ["P-1", "a-b"]),
    ],
)
def test_performers_are_named_in_any_way(first: str, second: str, takes: list[str]) -> None:
    markers = {how.format(name): t for how in (first, second) for name, t in tracks().items()}
    data = write(markers)
    assert list(read_takes_bytes(data, "c3d", path="a.c3d")) == takes
    assert read_c3d(data, "a.c3d", ReadOptions(take=takes[1])).n_frames == 30


@pytest.mark.parametrize("is_never_seen", [False, True])
def test_a_performer_without_a_whole_body_is_told(is_never_seen: bool) -> None:
    other = {f"Bob:{name}": track * np.nan for name, track in tracks().items()}
    if not is_never_seen:
        other = {f"Bob:{name}": t for name, t in tracks().items() if name != "LKNE"}
    markers = {f"Ann:{name}": track for name, track in tracks().items()}
    clip = read_c3d(write({**markers, **other, "Bat:Head": markers["Ann:C7"]}), "a.c3d")
    told = "all" if is_never_seen else "LKNE"
    assert clip.notes == (
        f"'Bob' has no whole body and is left out; missing or never seen: {told}.",
    )


def test_a_performer_that_is_not_there_is_told() -> None:
    one = write(tracks(), prefix="Ann:")
    with pytest.raises(CaptureError, match=r"one alone, found 'Ann'\. Leave it out"):
        read_c3d(one, "a.c3d", ReadOptions(take="Ann"))
    two = write({f"{who}:{name}": t for who in ("Ann", "Bob") for name, t in tracks().items()})
    with pytest.raises(CaptureError, match="expected a performer 'Eve', found 2: Ann, Bob"):
        read_c3d(two, "a.c3d", ReadOptions(take="Eve"))


def test_rates_that_contradict_each_other_are_told() -> None:
    data = write(tracks(), said={"POINT:RATE": 50.0})
    clip = read_c3d(data, "a.c3d")
    assert clip.fps == 50.0
    assert clip.notes[0].startswith("The file has the rates 50, 100; 50 is taken.")
    assert read_c3d(data, "a.c3d", ReadOptions(fps=100.0)).notes == ()


def test_events_of_a_file_that_holds_a_part_of_its_trial() -> None:
    """Times count from frame 1 of the trial, and the file begins at frame 101, at 1 s."""
    said = {
        "TRIAL:ACTUAL_START_FIELD": [101, 0],
        "TRIAL:ACTUAL_END_FIELD": [130, 0],
        "EVENT:USED": 6,
        "EVENT:TIMES": [0.0, 1.1, 0.0, 1.2, 0.0, 1.0, 0.0, 0.99, 0.0, 1.29, 0.0, 5.0],
        "EVENT:LABELS": ["Foot Strike", "Foot Off", "RHS", "Foot Strike", "Ball hit", "Toe Off"],
        "EVENT:CONTEXTS": ["Left", "Right", "", "Left", "General", "Left"],
    }
    points = np.stack(list(tracks().values()), axis=1) * 1000.0
    data = c3d_bytes(points, list(MARKERS), said=said, header={4: 101, 5: 130})
    assert c3d_events(data, "a.c3d", 100.0) == [
        Event(0, "foot_strike", "r_ankle", "ground"),
        Event(3, "foot_strike", "l_ankle", "ground"),
        Event(6, "foot_off", "r_ankle", "ground"),
        Event(9, "ball_hit"),
    ]
    assert c3d_events(c3d_bytes(points, list(MARKERS)), "a.c3d", 100.0) == []
