"""The bytes of C3D: every machine, long files, and headers that the parameters contradict."""

from __future__ import annotations

import numpy as np
import pytest
from c3d_writer import BLOCK, DEC, PC, SGI, c3d_bytes

from motiondb.errors import CaptureError
from motiondb.files.readers.c3d import C3DFile, read_c3d_file

LABELS = ("LASI", "RASI", "C7", "*110", "Müller:T10")


def places(n_frames: int = 40, n_points: int = 5) -> np.ndarray:
    """Places in millimetres that single precision holds, with one point lost in frame 3."""
    points = np.random.default_rng(n_points).integers(-3000, 3000, (n_frames, n_points, 3)) / 4.0
    points[3, 1] = np.nan
    return points


def read(data: bytes, **changes: bool) -> tuple[np.ndarray, C3DFile]:
    file = read_c3d_file(data, "a.c3d", **changes)
    return np.stack([file.track(point) for point in range(len(file.labels))], axis=1), file


@pytest.mark.parametrize("machine", [PC, DEC, SGI])
@pytest.mark.parametrize("scale", [-1.0, 0.25])
@pytest.mark.parametrize("analog", [0, 7])
def test_every_machine_writes_the_same_places(machine: int, scale: float, analog: int) -> None:
    points = places()
    found, file = read(c3d_bytes(points, LABELS, machine=machine, scale=scale, analog=analog))
    np.testing.assert_array_equal(found, points)
    assert (file.labels, file.fps, file.unit, file.notes) == (LABELS, 100.0, "mm", ())


def test_floats_by_hand() -> None:
    """1, -0.1 and 118.625 as the manuals of the machines write them."""
    numbers = {
        PC: "0000803f cdccccbd 0040ed42",
        DEC: "80400000 ccbecdcc ed430040",
        SGI: "3f800000 bdcccccd 42ed4000",
    }
    for machine, text in numbers.items():
        data = bytearray(c3d_bytes(places(1 + 3), LABELS, machine=machine))
        start = (data[17 if machine == SGI else 16] - 1) * BLOCK
        data[start : start + 12] = bytes.fromhex(text)
        np.testing.assert_allclose(read(bytes(data))[0][0, 0], [1.0, -0.1, 118.625], rtol=1e-7)


def test_names_and_places_of_more_points_than_a_byte_counts() -> None:
    names = [f"P{number:03}" for number in range(600)]
    points = places(5, 600)
    found, file = read(c3d_bytes(points, names))
    assert file.labels == tuple(names)
    np.testing.assert_array_equal(found, points)
    short, file = read(c3d_bytes(points, names, said={"POINT:LABELS3": ["Q"]}))
    assert file.labels[509:512] == ("P509", "Q", "")
    assert short.shape == (5, 600, 3)


@pytest.mark.parametrize(
    "said",
    [
        {"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [66_000 - 65_536, 1]},
        {"TRIAL:ACTUAL_START_FIELD": [11, 0], "TRIAL:ACTUAL_END_FIELD": [66_010 - 65_536, 1]},
        {"POINT:LONG_FRAMES": 66_000.0},
        {"POINT:FRAMES": 66_000.0},
        {"POINT:FRAMES": 66_000 - 65_536},
        {},
        {"POINT:FRAMES": None},
    ],
)
def test_more_frames_than_a_word_counts(said: dict) -> None:
    points = np.zeros((66_000, 1, 3))
    points[:, 0, 0] = np.arange(1.0, 66_001.0)
    header = {5: 464} if said.get("POINT:FRAMES") == 464 else {}
    for data in (
        c3d_bytes(points, ["A"], said=said, header=header),
        c3d_bytes(points, ["A"], said=said, header=header).rstrip(b"\0"),  # without the filling
    ):
        found, _ = read(data + bytes(-len(data) % 16))
        np.testing.assert_array_equal(found, points)


def test_what_follows_the_end_of_the_trial_is_cut() -> None:
    """Frames that hold nothing, as programs add that read up to the end of a file."""
    points = np.concatenate([places(40), np.full((300, 5, 3), np.nan)])
    said = {"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [40, 0]}
    found, _ = read(c3d_bytes(points, LABELS, said=said))
    np.testing.assert_array_equal(found, points[:40])
    points[60] = (1.0, 2.0, 3.0)  # the trial is longer than it says
    assert len(read(c3d_bytes(points, LABELS, said=said))[0]) == 61


@pytest.mark.parametrize(
    ("said", "header"),
    [
        ({"POINT:FRAMES": 40.0}, {5: 65535}),
        ({"POINT:FRAMES": None}, {}),
        ({"POINT:FRAMES": -1}, {}),
        ({"POINT:FRAMES": 41}, {}),
        ({"POINT:FRAMES": 0}, {}),
        ({"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [38, 0]}, {}),
        ({}, {4: 1001, 5: 2800}),  # the frames of the take from which these were cut
        ({}, {4: 0, 5: 0}),
        ({"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [900, 0]}, {}),
        ({"TRIAL:ACTUAL_START_FIELD": [861, 0], "TRIAL:ACTUAL_END_FIELD": [900, 0]}, {5: 900}),
        ({"POINT:USED": 6}, {}),
        ({}, {2: 0}),
        ({}, {2: 90, 3: 2}),
        ({}, {3: 0}),
        ({}, {3: 900}),
        ({"ANALOG:USED": 0}, {}),
        ({"ANALOG:USED": None, "ANALOG:RATE": None}, {10: 0}),
        ({}, {9: 1}),
        ({}, {9: 200}),
        ({"POINT:DATA_START": 1}, {}),
        ({"POINT:DATA_START": 3}, {9: 3}),
        ({"POINT:SCALE": 0.1}, {}),
        ({"POINT:SCALE": None}, {}),
        ({}, {7: 0, 8: 0}),
        ({}, {1: 0x5000}),
        ({}, {1: 0x5009}),
        ({"POINT:RATE": None}, {}),
        ({"POINT:RATE": 0.0}, {}),
        ({}, {11: 0, 12: 0}),
    ],
)
@pytest.mark.parametrize("machine", [PC, SGI])
def test_what_contradicts_the_bytes_is_not_believed(said: dict, header: dict, machine: int) -> None:
    points = places()
    if machine == SGI and 1 in header:
        header = {1: (header[1] & 255) << 8 | 0x50}
    data = c3d_bytes(points, LABELS, machine=machine, analog=6, said=said, header=header)
    found, file = read(data)
    np.testing.assert_array_equal(found, points)
    assert (file.labels, file.fps) == (LABELS, 100.0)


@pytest.mark.parametrize("said", [{}, {"POINT:FRAMES": -1, "ROTATION:DATA_START": 10}])
def test_what_follows_the_frames_is_passed_over(said: dict) -> None:
    points = places()
    data = c3d_bytes(points, LABELS, said=said, header={5: 65535} if said else {})
    assert len(data) == 9 * BLOCK  # so the next one is number 10
    found, _ = read(data + np.full(1000, 7.0, "<f4").tobytes())
    np.testing.assert_array_equal(found, points)


def test_the_header_has_the_scale_of_integers() -> None:
    points = places()
    data = c3d_bytes(points, LABELS, scale=0.25, said={"POINT:SCALE": 0.1})
    found, file = read(data)
    np.testing.assert_array_equal(found, points)
    assert file.notes == ("The scale of the header (0.25) was taken; POINT:SCALE says 0.1.",)
    found, file = read(c3d_bytes(points, LABELS, scale=0.25, header={7: 0, 8: 0}))
    np.testing.assert_array_equal(found, points)
    assert file.notes == ()


def test_parameters_of_every_form() -> None:
    said = {
        "POINT:X_SCREEN": "+X",
        "POINT:Y_SCREEN": "-Z",
        "POINT:ODD": "abc",
        "POINT:NONE": [],
        "SUBJECTS:NAMES": ["Ann", "Bartholomew"],
        "POINT:UNITS": None,
    }
    file = read(c3d_bytes(places(), LABELS, said=said))[1]
    assert (file.up, file.unit) == ("-z", "")
    for across, up, is_up in (
        ("+X", "y", "y"),
        ("", " +Z ", "z"),
        ("+Y", "-Y", ""),
        ("X", "up", ""),
    ):
        said |= {"POINT:X_SCREEN": across, "POINT:Y_SCREEN": up, "POINT:UNITS": ["cm\0\0"]}
        file = read(c3d_bytes(places(), LABELS, said=said))[1]
        assert (file.up, file.unit) == (is_up, "cm")


def test_lost_points() -> None:
    points = places()
    points[5, 0] = 0.0
    points[6, 0] = [0.0, 0.0, 1.0]
    points[7, 0] = [-3.7e28, -3.7e28, -3.7e28]
    found, _ = read(c3d_bytes(points, LABELS))
    assert np.isnan(found).all(axis=2).nonzero()[0].tolist() == [3, 5, 7]
    np.testing.assert_array_equal(found[6, 0], [0.0, 0.0, 1.0])


@pytest.mark.parametrize("machine", [PC, DEC, SGI])
def test_a_file_that_is_cut_short(machine: int) -> None:
    points = places(40)
    data = c3d_bytes(points, LABELS, machine=machine, analog=6, rate=50.0)
    frame = 4 * (5 * 4 + 6)
    start = (data[17 if machine == SGI else 16] - 1) * BLOCK
    whole, file = read(data[: start + 40 * frame - 12])
    np.testing.assert_array_equal(whole, points)
    assert file.notes == ("The file ends within the analog samples of its last frame.",)
    cut = data[: start + 31 * frame + 50]
    with pytest.raises(CaptureError) as caught:
        read(cut)
    big = " (big-endian, SGI)" if machine == SGI else ""
    assert str(caught.value) == (
        f"a.c3d: expected 40 frames as POINT:FRAMES says, found {len(cut)} bytes, which hold 31 of "
        f"5 points{big}. The file is cut short: export it again, or pass --skip-bad-frames to read "
        "what is there."
    )
    part, file = read(cut, skip_bad=True)
    np.testing.assert_array_equal(part, points[:31])
    assert file.notes == ("Left out 9 frames that the file is cut short of.",)


def test_files_without_points() -> None:
    for data, what in (
        (b"HIERARCHY" + bytes(600), "expected a C3D file, found something else. Export it again."),
        (
            c3d_bytes(places(40, 5)[:, :0], [], analog=4),
            "expected points, found none. Export the markers, too.",
        ),
        (
            c3d_bytes(places(40)[:0], LABELS, header={4: 0, 5: 0}),
            "expected at least 1 frame, found 0. Export the motion again.",
        ),
    ):
        with pytest.raises(CaptureError) as caught:
            read(data)
        assert str(caught.value) == f"a.c3d: {what}"
