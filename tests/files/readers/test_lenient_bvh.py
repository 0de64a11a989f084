"""BVH files with more than a body: read with a note where nothing is lost."""

from __future__ import annotations

import re

import numpy as np
import pytest

from motiondb.body import body
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import to_bvh
from motiondb.files.formats import read_capture_bytes
from motiondb.records import Clip

N = 5
TURNS = np.tile([1.0, 0.0, 0.0, 0.0], (N, 21, 1))
ROOT = np.linspace([0, 0.9, 0], [0, 0.9, 0.4], N) + np.linspace([0, 0, 0], [0.5, 0, 0], N) ** 2
TEXT = to_bvh(Clip(body.standard_skeleton(), 30.0, TURNS, ROOT, unit=0.01))
HEAD, ROWS = TEXT.split("MOTION\n")
COUNT, TIME, *LINES = ROWS.splitlines()
PROP = (
    "ROOT Ball\n{\n\tOFFSET 0 0 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
    "Yrotation\n\tEnd Site\n\t{\n\t\tOFFSET 0 0 0\n\t}\n}\n"
)


def read(
    head: str = HEAD, count: str = COUNT, time: str = TIME, rows=LINES, end: str = "\n"
) -> Clip:
    return read_capture_bytes(
        f"{head}MOTION\n{count}\n{time}\n".encode() + "\n".join(rows).encode() + end.encode(),
        "bvh",
        path="a.bvh",
    )


def check(clip: Clip, note: str, n_frames: int = N) -> None:
    np.testing.assert_allclose(clip.root_positions, ROOT[:n_frames], atol=1e-7)
    assert clip.joint_names == body.JOINTS
    assert clip.notes == (note,)


@pytest.mark.parametrize("count", [4, 2, 0, 6])
def test_a_header_with_another_number_of_frames(count: int) -> None:
    check(read(count=f"Frames: {count}"), f"The header says {count} frames; the file holds 5.")


def test_a_whole_number_of_frames_with_a_point() -> None:
    assert read(count="Frames: 5.0").notes == ()


@pytest.mark.parametrize(("count", "end"), [(7, "\n"), (6, "")])
def test_frames_that_are_missing_are_refused(count: int, end: str) -> None:
    with pytest.raises(CaptureError, match=f"expected {count} frames as the header says, found 5"):
        read(count=f"Frames: {count}", end=end)


def test_an_offset_with_a_rotation_that_the_channels_hold() -> None:
    head = re.sub(r"(OFFSET \S+ \S+ \S+)", r"\1 0.0 -1e-3 90.0", HEAD)
    check(
        read(head=head),
        "OFFSETs with six numbers: the last three, a rotation, are in the channels.",
    )
    one = re.sub(r"CHANNELS 3 \w+ \w+ (\w+)", r"CHANNELS 1 \1", head)
    with pytest.raises(CaptureError, match="expected 3 rotation channels for"):
        read(head=one)


@pytest.mark.parametrize("before", [True, False])
def test_a_second_root_that_is_a_prop(before: bool) -> None:
    hierarchy, body_text = HEAD.split("\n", 1)
    parts = [PROP, body_text] if before else [body_text, PROP]
    values = ["9 9 9 1 2 3 " + row if before else row + " 9 9 9 1 2 3" for row in LINES]
    clip = read(head="\n".join([hierarchy, *parts]), rows=values)
    check(clip, "Left out what hangs from other roots, which is no person: 'Ball'.")


def test_two_persons_are_refused() -> None:
    body_text = HEAD.split("\n", 1)[1]
    with pytest.raises(CaptureError) as caught:
        read(head=HEAD + body_text, rows=[f"{row} {row}" for row in LINES])
    assert str(caught.value) == (
        "a.bvh: expected one ROOT that is a person, found 2: 'pelvis' and 'pelvis'. "
        "Export one performer a file."
    )


def with_scales(scale: str) -> Clip:
    names = "Xscale Yscale Zscale"
    head = HEAD.replace("CHANNELS 6 ", f"CHANNELS 9 {names} ").replace(
        "CHANNELS 3 ", f"CHANNELS 6 {names} "
    )
    rows = []
    for line in LINES:
        values = line.split()
        groups = [values[:6], *(values[n : n + 3] for n in range(6, len(values), 3))]
        rows.append(" ".join(" ".join([scale] * 3 + group) for group in groups))
    return read(head=head, rows=rows)


def test_scales_of_1_are_left_out() -> None:
    clip = with_scales("1.0")
    check(clip, "Left out the scale channels: all are 1.")
    assert not any("scale" in name for names in clip.skeleton.channels for name in names)


def test_other_scales_are_refused() -> None:
    with pytest.raises(CaptureError, match=r"expected scale channels of 1, found 1\.5"):
        with_scales("1.5")


@pytest.mark.parametrize(
    ("rows", "side"),
    [
        ([f"{n} {row}" for n, row in enumerate(LINES)], "first"),
        ([f"{n + 1} {row}" for n, row in enumerate(LINES)], "first"),
        ([f"{row} 0" for row in LINES], "last"),
    ],
)
def test_one_number_more_in_each_frame(rows: list[str], side: str) -> None:
    check(read(rows=rows), f"Every frame has one number more; the {side} ones are left out.")


@pytest.mark.parametrize(
    "rows",
    [
        [f"{row} {n * n}" for n, row in enumerate(LINES)],
        [f"{100 + n} {row}" for n, row in enumerate(LINES)],
        [f"{n / 30:.4f} {row}" for n, row in enumerate(LINES)],
        [f"7 {row}" for row in LINES],
    ],
)
def test_a_number_more_that_may_mean_something_is_refused(rows: list[str]) -> None:
    with pytest.raises(CaptureError, match=r"expected 66 values .* found 67"):
        read(rows=rows)


def test_the_digits_of_the_frame_time_say_the_rate() -> None:
    assert read(time="Frame Time: 0.033").fps == 30.0
    clip = read(time="Frame Time: 0.008")
    assert clip.fps == 120.0
    assert clip.notes[0].startswith("The frame time 0.008 fits 120 and 125 frames a second")


def test_positions_of_0_do_not_collapse_a_body() -> None:
    """Some programs add the position channels to the OFFSET, and write zeros."""
    names = "Xposition Yposition Zposition"
    head = HEAD.replace("CHANNELS 3 ", f"CHANNELS 6 {names} ")
    rows = []
    for line in LINES:
        values = line.split()
        rest = (f"0 0 0 {' '.join(values[n : n + 3])}" for n in range(6, len(values), 3))
        rows.append(" ".join([*values[:6], *rest]))
    clip = read(head=head, rows=rows)
    np.testing.assert_allclose(clip.world_positions(), read().world_positions(), atol=1e-7)
    assert clip.notes[0].startswith("The positions of 20 joints ('l_hip', 'l_knee', ")


def test_decimal_commas_are_read() -> None:
    head, rows = HEAD.replace(".", ","), [row.replace(".", ",") for row in LINES]
    clip = read(head=head, time=TIME.replace(".", ","), rows=rows)
    check(clip, "Decimal commas are read as points.")


def test_a_decimal_comma_in_rows_alone_is_named() -> None:
    with pytest.raises(CaptureError, match="it has decimal commas"):
        read(rows=[row.replace(".", ",") for row in LINES])
