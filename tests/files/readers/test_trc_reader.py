"""TRC as clips: markers of several sets, and centres of joints, of a person in T-pose."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from odd_c3d import MARKERS
from trc_writer import CENTRES, read_trc, trc

from motiondb.body import body, kinematics
from motiondb.errors import CaptureError
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.marker_names import name_markers


def joints(data: bytes) -> Mapping[str, np.ndarray]:
    """Return the joints in the first frame, centimetres."""
    clip = read_trc(data, "a.trc")
    positions, _ = kinematics.clip_positions(clip)
    return dict(zip(body.JOINTS, 100.0 * positions[0]))


@pytest.mark.parametrize(("unit", "scale"), [("mm", 10.0), ("m", 0.01), ("cm", 1.0)])
def test_markers_in_any_unit(unit: str, scale: float) -> None:
    clip = read_trc(trc(MARKERS, unit, scale), "a.trc")
    assert (clip.fps, clip.format, clip.n_frames, clip.up) == (60.0, "trc", 20, "y")
    assert joints(trc(MARKERS, unit, scale))["l_knee"] == pytest.approx([10, 50, 0], abs=1.0)


def test_an_inner_marker_gives_the_middle_of_the_joint() -> None:
    inner = {"LKneeMed": (3, 50, 0), "RKneeMed": (-3, 50, 0)}
    assert joints(trc({**MARKERS, **inner}))["l_knee"] == pytest.approx([9, 50, 0], abs=0.5)


OTHERS = {"ASI": "IAS", "PSI": "IPS", "KNE": "FLE", "ANK": "FAL", "SHO": "SAJ", "ELB": "HLE",
          "WRA": "RSP", "WRB": "USP", "TOE": "FM2", "FHD": "HDF", "BHD": "HDB"}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        lambda side, place: f"{side}_{OTHERS[place]}",
        lambda side, place: f"{side.lower()}.{place}_study",
        lambda side, place: f"Kim_{side}{place}",
    ],
    ids=["ISB", "study", "performer"],
)
def test_markers_of_other_sets_are_as_those_of_plug_in_gait(name) -> None:
    renamed = {
        name(label[0], label[1:]) if label[1:] in OTHERS else label: place
        for label, place in MARKERS.items()
    }
    plain, other = joints(trc(MARKERS)), joints(trc(renamed))
    np.testing.assert_allclose(list(other.values()), list(plain.values()), atol=1e-9)


def test_centres_of_joints_are_the_joints() -> None:
    found = joints(trc(CENTRES))
    for role, name in (("l_hip", "LHip"), ("r_knee", "RKnee"), ("l_ankle", "LAnkle"),
                       ("r_shoulder", "RShoulder"), ("l_elbow", "LElbow"), ("r_wrist", "RWrist"),
                       ("neck", "Neck"), ("l_toe", "LBigToe")):  # fmt: skip
        assert found[role] == pytest.approx(CENTRES[name], abs=1.0), role


@pytest.mark.parametrize("lost", [0.0, 9999.99, -9999.0, 1e10])
def test_one_number_three_times_is_no_place(lost: float) -> None:
    lines = trc(MARKERS).decode().split("\n")
    at = 2 + 3 * list(MARKERS).index("LKNE")
    for row in range(10, 13):
        cells = lines[row].split("\t")
        lines[row] = "\t".join([*cells[:at], *[f"{lost:g}"] * 3, *cells[at + 3 :]])
    clip, whole = read_trc("\n".join(lines).encode(), "a.trc"), read_trc(trc(MARKERS), "a.trc")
    np.testing.assert_allclose(clip.world_positions(), whole.world_positions(), atol=1e-5)


def test_wrists_and_toes_without_markers_are_told() -> None:
    told = "No markers are known for wrists and right toe: estimated from the rest of the body."
    less = {k: v for k, v in MARKERS.items() if k[1:3] != "WR" and k != "RTOE"}
    assert told in read_trc(trc(less), "a.trc").notes
    assert not any("estimated" in note for note in read_trc(trc(MARKERS), "a.trc").notes)
    other = {"RTOE": "RMT5", "LWRA": "LIWR", "RWRB": "RadialStyloidR"}
    renamed = {other.get(k, k): v for k, v in MARKERS.items() if k not in ("LWRB", "RWRA")}
    assert not any("estimated" in note for note in read_trc(trc(renamed), "a.trc").notes)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"hello", "expected a TRC file"),
        (trc(MARKERS).replace(b"0.017", b"0.017\tx"), "line 8: expected numbers, found 'x'"),
        (b"\n".join(trc(MARKERS).split(b"\n")[:6]), "expected at least 1 frame, found 0"),
        (trc(CENTRES).replace(b"LKnee", b"Other"), "found none for LKNE"),
        (trc(MARKERS).replace(b"\t", b" "), "expected cells between tabs"),
        (trc(MARKERS).rpartition(b"\t")[0], "line 26: expected [0-9]+ cells for .* cut short"),
        (
            trc(
                {k: v for k, v in MARKERS.items() if k != "RASI"}
                | {"LHip": (9, 92, 0), "RHip": (-9, 92, 0)}
            ),
            "found none for RASI",
        ),
    ],
)
def test_what_is_no_capture_is_refused_with_the_reason(data: bytes, told: str) -> None:
    with pytest.raises(CaptureError, match=told):
        read_trc(data, "a.trc")


def test_a_given_rate_holds() -> None:
    assert read_trc(trc(MARKERS), "a.trc", ReadOptions(fps=30.0)).fps == 30.0


@pytest.mark.parametrize("said", [b"120.00\t120.00", b"\t"])
def test_times_of_the_frames_hold_where_the_header_says_another_rate(said: bytes) -> None:
    clip = read_trc(trc(MARKERS).replace(b"60.00\t60.00", said), "a.trc")
    assert clip.fps == 60.0
    assert "the times of the frames say 60" in clip.notes[0]


def test_frames_that_are_left_out_are_not_seen() -> None:
    lines = trc(MARKERS).split(b"\n")
    clip = read_trc(b"\n".join(lines[:10] + lines[13:]), "a.trc")
    assert clip.n_frames == 20
    assert clip.notes[1] == "By their numbers 3 frames are missing; they are taken as not seen."
    np.testing.assert_allclose(np.diff(clip.root_positions[:, 2]), 0.01, atol=1e-6)


def test_frames_are_numbered_and_markers_named_as_other_programs_do() -> None:
    lines = trc(MARKERS).decode().split("\n")
    lines[3] = lines[3].replace("\t\t\t", "\t")
    rows = [f"{number - 5}.0\t{row.partition(chr(9))[2]}" for number, row in enumerate(lines[6:])]
    found = joints("\n".join(lines[:6] + rows).encode())
    plain = joints(trc(MARKERS))
    np.testing.assert_allclose(list(found.values()), list(plain.values()), atol=1e-9)


INNER = {"LKneeMed": (3, 50, 0), "RKneeMed": (-3, 50, 0)}
HIPS = {"LHJC": (9, 92, 0), "RHJC": (-9, 92, 0)}


def test_hips_beside_markers_of_both_sides_of_the_knee() -> None:
    rest = {name: place for name, place in MARKERS.items() if name[1:] not in ("ASI", "PSI")}
    data = trc({**rest, **HIPS, **INNER})
    assert joints(data)["l_knee"] == pytest.approx([9, 50, 0], abs=0.5)
    assert "centres of the hips." in read_trc(data, "a.trc").notes[-1]


def test_centres_as_their_short_names() -> None:
    short = {"Hip": "HJC", "Knee": "KJC", "Ankle": "AJC", "Shoulder": "SJC", "Elbow": "EJC"}
    renamed = {label[0] + short.get(label[1:], label[1:]): v for label, v in CENTRES.items()}
    plain = joints(trc(CENTRES))
    found = joints(trc(renamed))
    np.testing.assert_allclose(list(found.values()), list(plain.values()), atol=1e-9)


def test_the_number_of_a_performer_is_no_part_of_a_name() -> None:
    found = joints(trc({f"{name}_7": place for name, place in MARKERS.items()}))
    plain = joints(trc(MARKERS))
    np.testing.assert_allclose(list(found.values()), list(plain.values()), atol=1e-9)


@pytest.mark.parametrize("time", [b"", b"0:00:01", b"0.000"])
def test_times_that_are_none_say_nothing(time: bytes) -> None:
    lines = trc(MARKERS).replace(b"DataRate", b"DATARATE").split(b"\n")
    rows = [row.split(b"\t") for row in lines[6:]]
    rows = [b"\t".join([row[0], time, *row[2:]]) for row in rows]
    clip = read_trc(b"\n".join([*lines[:6], *rows]), "a.trc")
    assert (clip.fps, clip.notes) == (60.0, ())


@pytest.mark.parametrize(
    ("label", "marker"),
    [
        ("R_SAE", "RSHO"),
        ("R.Acromium", "RSHO"),
        ("L.Toe.Tip", "LTOE"),
        ("Left Knee Inner", "LKNM"),
        ("L_Lower", ""),
        ("Lateral", ""),
        ("RRib", ""),
        ("RHead", ""),
        ("R1", ""),
        ("LTHI", ""),
        ("RBAK", ""),
        ("RacketHead", ""),
    ],
)
def test_what_a_label_names(label: str, marker: str) -> None:
    named = name_markers([label, "C7", "LASI"])[""]
    assert set(named) - {"C7", "LASI"} == ({marker} if marker else set())


_SPELT = {
    "classic Helen Hayes": "R.ASIS V.Sacral R.Knee R.Ankle R.Toe R.Shoulder R.Elbow R.Wrist",
    "Helen Hayes of OpenSim": "R.ASIS V.Sacral R.Knee.Lat R.Ankle.Lat R.Toe.Tip R.Acromium "
    "R.Elbow R.Wrist",
    "Qualisys animation": "WaistRFront WaistRBack RKneeOut RAnkleOut RToeTip RShoulderTop "
    "RElbowOut RWristOut",
    "Rajagopal": "RASI RPSI RLFC RLMAL RTOE RACR RLEL RFAradius",
    "in words": "right_asis right_psis right_lateral_knee right_lateral_malleolus right_toe "
    "right_acromion right_lateral_elbow right_radial_wrist",
    "CODA": "Right ASIS;Right PSIS;Right Knee;Right Ankle;Right Toe;Right Shoulder;"
    "Right Elbow;Right Wrist",
}
_LIKE = ("RASI", "RPSI", "RKNE", "RANK", "RTOE", "RSHO", "RELB", "RWRA")


@pytest.mark.parametrize("spelt", _SPELT)
def test_sets_of_laboratories_without_a_marker_of_the_neck(spelt: str) -> None:
    """They give the joints of Plug-in Gait; the neck lies over the shoulders."""
    labels = _SPELT[spelt].split(";" if ";" in _SPELT[spelt] else None)
    places = {}
    for label, name in zip(labels, _LIKE):
        for side in "RL":
            own = label.replace("Right", "Left") if side == "L" else label
            own = own.replace("right", "left") if side == "L" else own
            if own == label and side == "L" and label != "V.Sacral":
                own = label.replace("WaistR", "WaistL") if "WaistR" in label else "L" + label[1:]
            place = MARKERS[side + name[1:]]
            places[own] = (0.0, *place[1:]) if label == "V.Sacral" else place
    clip = read_trc(trc(places), "a.trc")
    assert clip.notes[0].startswith("There is no marker of the neck")
    found = dict(zip(body.JOINTS, kinematics.clip_positions(clip)[0][0]))
    middle = (np.array(MARKERS["LSHO"]) + np.array(MARKERS["RSHO"])) / 2.0
    np.testing.assert_allclose(found["neck"], middle * 0.01, atol=0.02)
    assert found["l_knee"][0] * np.sign(MARKERS["LKNE"][0]) > 0
