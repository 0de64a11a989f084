"""What one file may cost, and that nothing but this project's errors leaves a reader."""

from __future__ import annotations

import io
import time
import tracemalloc
import warnings
import zipfile

import numpy as np
import pytest
from odd_captures import AMC, ASF, BVH, DEEPMIMIC

from motiondb.errors import CaptureError, QueryError
from motiondb.files.formats import read_capture_bytes
from motiondb.files.limits import NO_LIMITS, ReadLimits, ReadOptions, SkeletonFile, guarded


def refusal(data: bytes | str, kind: str, asf: str = ASF, **options: object) -> str:
    """The message with which a file is refused."""
    raw = data.encode() if isinstance(data, str) else data
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(
            raw, kind, path="f", skeleton=SkeletonFile(asf.encode(), "s.asf"),
            options=ReadOptions(**options),
        )  # fmt: skip
    return str(caught.value)


def npz(**arrays: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # odd values on purpose
    return buffer.getvalue()


POSES, TRANS = np.zeros((4, 66)), np.zeros((4, 3))
TOO_PLAIN = "f: expected an npz file of plain arrays, found something else. Save it again."


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BVH.replace("Frames: 8", "Frames: ²"), "expected a number of frames, found '²'."),
        (
            BVH.replace("Frames: 8", f"Frames: {'9' * 5000}"),
            f"expected a number of frames, found '{'9' * 40}...'.",
        ),
        (
            BVH.replace("Frames: 8", "Frames: 1000000000"),
            "f: expected 1000000000 frames as the header says, found 8. The file may be cut short",
        ),
        (BVH.replace("CHANNELS 3", "CHANNELS ٣"), "expected a number of channels, found ['٣']."),
        (BVH.replace("0 10 5", "0 1_0 5"), "expected numbers, found '1_0' as value 5. Correct"),
        (BVH.replace("0 10 5", "0 ١٠ 5"), "expected numbers, found '١٠' as value 5. Correct"),
        (BVH.replace("0 10 5", "0 infinity 5"), "expected numbers, found 'infinity' as value 5."),
        (BVH.replace("0 10 5", f"0 {'1' * 200} 5"), f"found '{'1' * 20}' as value 5."),
        (BVH.replace("0.0333333", "3_0e-3"), "expected a frame time from 0.0005 to 1 s, found no"),
        (BVH.replace("Frames: 8", "Frames: 8\nFrames: 8"), "expected one line 'Frames', found a"),
    ],
)
def test_odd_bvh(text: str, message: str) -> None:
    assert message in refusal(text, "bvh")


def test_numbers_of_an_amc_are_plain() -> None:
    assert "found '1_0'" in refusal(AMC.replace("2 3\n", "1_0 3\n"), "amc")
    assert "expected an axis order such as XYZ, found 'QQQ'." in refusal(
        AMC, "amc", ASF.replace("axis XYZ", "axis QQQ")
    )
    assert "expected each dof of 'lfemur' once" in refusal(
        AMC, "amc", ASF.replace("dof rx rz", "dof rx rx", 1)
    )


def test_frame_numbers_are_ascii() -> None:
    assert "expected at least 1 frame, found 0" in refusal(":DEGREES\n²\nroot 1 2 3 4 5 6\n", "amc")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '{"Frames": ' + "[" * 100_000 + "]" * 100_000 + "}",
            "at most 50 lists and objects within one another, found more.",
        ),
        (DEEPMIMIC.replace("0.03", "9" * 5000), "found 'inf' as value 1."),
        (DEEPMIMIC.replace("0.03", "1" + "0" * 400), "found 'inf' as value 1."),
        (DEEPMIMIC.replace("1.0, 0, 0, 0", "1e200, 0, 0, 0"), "found numbers that are too large."),
        (DEEPMIMIC.replace("0.03", "[]"), "found 'list' as value 1."),
        (DEEPMIMIC.replace("0.03", "true"), "found 'True' as value 1."),
    ],
)
def test_odd_json(text: str, message: str) -> None:
    assert message in refusal(text, "deepmimic")


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"fps": np.array([])}, "f: expected one number in fps, found 0."),
        ({"fps": np.array([30, 60])}, "f: expected one number in fps, found 2."),
        ({"fps": "fast"}, "f: expected numbers in 'fps', found other values."),
        ({"fps": np.nan}, "f: expected fps from 1 to 2000, found nan."),
        ({"fps": 1 + 2j}, "f: expected numbers in 'fps', found other values."),
        ({"fps": 30, "poses": POSES + 1j}, "f: expected numbers in 'poses', found other values."),
        (
            {"fps": 30, "poses": POSES.astype("i8").astype("M8[s]")},
            "f: expected numbers in 'poses', found other values.",
        ),
        ({"fps": 30, "poses": POSES + 1e308}, "f: expected lengths and angles of a body, found"),
    ],
)
def test_odd_arrays(arrays: dict[str, object], message: str) -> None:
    assert refusal(npz(**{"poses": POSES, "trans": TRANS, **arrays}), "amass").startswith(message)


def test_an_npz_is_not_unpacked_before_its_size_is_known() -> None:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        with file.open("poses.npy", "w", force_zip64=True) as member:
            for _ in range(300):
                member.write(bytes(1_000_000))
        file.writestr("trans.npy", b"")
    tracemalloc.start()
    message = refusal(buffer.getvalue(), "amass")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert "f: expected arrays of at most 256 MB, found 300 MB packed into 0.29" in message
    assert peak < 10_000_000


def test_a_header_cannot_declare_what_is_not_there() -> None:
    for shape in ("(1000000000, 66)", "(-1, 66)", f"({'9' * 5000},)", "(((((", "(1e9, 66)"):
        header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as file:
            length = len(header).to_bytes(2, "little")
            file.writestr("poses.npy", b"\x93NUMPY\x01\x00" + length + header + bytes(800))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of NumPy, about odd headers
            assert refusal(buffer.getvalue(), "amass") == TOO_PLAIN


def nested(count: int, n_frames: int = 1) -> str:
    """A BVH of joints that hang below one another, all but the first without channels."""
    joints = "".join(f"JOINT j{n}\n{{\nOFFSET 0 1 0\nCHANNELS 0\n" for n in range(count))
    return (
        f"HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n{joints}{'}' * (count + 1)}\n"
        f"MOTION\nFrames: {n_frames}\nFrame Time: 0.01\n" + "0\n" * n_frames
    )


def test_deep_skeletons_take_linear_time() -> None:
    clip = read_capture_bytes(nested(10_000).encode(), "bvh")
    assert len(clip.skeleton.names) == 10_001
    assert clip.skeleton.offsets[1:].sum() / clip.unit == pytest.approx(10_000)


def test_a_small_file_cannot_fill_the_memory() -> None:
    text = nested(3_000, 5_000)
    assert refusal(text, "bvh").startswith(
        "f: expected a clip of at most 400 MB in memory, found 5000 frames of 3001 joints (1500 MB)"
    )
    text = nested(300, 300)
    message = refusal(text, "bvh", limits=ReadLimits(memory=10_000))
    assert "of at most 0.01 MB in memory, found 300 frames of 301 joints (9.03 MB)" in message
    options = ReadOptions(limits=NO_LIMITS)
    assert read_capture_bytes(text.encode(), "bvh", options=options).n_frames == 300


def test_what_the_file_really_holds_may_fill_more() -> None:
    limits = ReadLimits(memory=1_000)
    assert read_capture_bytes(BVH.encode(), "bvh", options=ReadOptions(limits=limits)).n_frames == 8


def test_limits_on_files_and_joints() -> None:
    message = refusal(BVH, "bvh", limits=ReadLimits(file_bytes=100))
    assert message.startswith("f: expected at most 0.0001 MB, found 0.00")
    message = refusal(nested(10), "bvh", limits=ReadLimits(joints=5))
    assert message == "f: expected at most 5 joints, found 11. Export fewer."


@pytest.mark.parametrize("fps", [0.5, 20_000.0])
def test_a_given_rate_has_a_range(fps: float) -> None:
    message = refusal(BVH, "bvh", fps=fps)
    assert message == f"f: expected a frame rate from 1 to 10000, found {fps:g}. Give another."


@pytest.mark.parametrize("unit", [0.0, -1.0, float("nan"), float("inf")])
def test_a_given_unit_is_positive(unit: float) -> None:
    assert "expected a length unit above 0 metres" in refusal(BVH, "bvh", unit=unit)


def test_a_slow_rate_cannot_fill_the_memory() -> None:
    frames = "0 0 0\n" * 4_000
    text = (
        "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n}\nMOTION\n"
    )
    text += f"Frames: 4000\nFrame Time: 1\n{frames}"
    assert refusal(text, "bvh").startswith(
        "f: expected a frame rate above 10 for 4000 frames, found 1 (1.11 hours)."
    )


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (ValueError("odd"), "f: expected a file that its reader knows, found one that it cannot "
         "read (ValueError: odd). Export it again."),
        (RecursionError(), "f: expected data that are not deeply nested, found deep nesting. "
         "Export it again."),
        (MemoryError(), "f: expected a file that fits into memory, found a larger one. "
         "Cut the capture."),
        (OverflowError("a\nb"), "f: expected a file that its reader knows, found one that it "
         "cannot read (OverflowError: a). Export it again."),
    ],
)  # fmt: skip
def test_unexpected_errors_name_the_file(error: Exception, message: str) -> None:
    with pytest.raises(CaptureError) as caught, guarded("f"):
        raise error
    assert str(caught.value) == message


def test_errors_of_the_project_and_interrupts_pass() -> None:
    with pytest.raises(QueryError, match="mine"), guarded("f"):
        raise QueryError("mine")
    with pytest.raises(KeyboardInterrupt), guarded("f"):
        raise KeyboardInterrupt


def wait() -> None:
    """Never end."""
    while True:
        time.sleep(0.01)


def test_a_slow_file_is_ended() -> None:
    with pytest.raises(CaptureError) as caught, guarded("f", 0.05), guarded("inner"):
        wait()
    assert str(caught.value) == (
        "f: expected to read the file within 0.05 s, found that it takes longer. Cut the capture, "
        "or allow more with --time-limit."
    )
