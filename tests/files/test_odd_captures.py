"""No file, however odd, makes a reader raise anything but this project's errors, or cost much."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from odd_c3d import whole_c3d
from odd_captures import AMC, ASF, BVH, DEEPMIMIC, MAKERS, Companions, case, odd_c3d, strange_c3d
from odd_npz import as_member, good_arrays, mutated_npz, packed

from motiondb.body import retarget
from motiondb.errors import CaptureError, MotionDBError
from motiondb.files import AsfFile, capture_format, guarded, read_capture_bytes
from motiondb.files.limits import ReadLimits, ReadOptions
from motiondb.files.sheets import read_event_sheet, read_sheet

UNEXPECTED = "expected a file that its reader knows"
"""How the safety net begins a message: a cause that a reader should have named itself."""


def read_case(seed: int, folder: Path) -> str:
    """Read a case as ``add`` does; the message of its refusal, or nothing."""
    return read_file(*case(seed), folder)


def read_file(suffix: str, data: bytes, companions: Companions, folder: Path) -> str:
    """Read a file as ``add`` does; the message of its refusal, or nothing."""
    try:
        if suffix in (".tsv", ".csv"):
            path = folder / f"sheet{suffix}"
            path.write_bytes(data)
            (read_sheet if suffix == ".tsv" else read_event_sheet)(path)
            return ""
        asf = AsfFile(companions["skeleton.asf"]) if companions else None
        kind = capture_format(f"odd{suffix}")
        clip = read_capture_bytes(data, kind, path=f"odd{suffix}", skeleton=asf)
        with guarded("odd"):
            motion = retarget.to_motion(clip)
        assert np.isfinite(motion.root_positions).all()
        assert np.isfinite(motion.local_rotations).all()
    except MotionDBError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("start", range(0, 400, 50))
def test_odd_files_are_read_or_refused_by_name(tmp_path: Path, start: int) -> None:
    for seed in range(start, start + 50):
        message = read_case(seed, tmp_path)
        assert UNEXPECTED not in message, (seed, message)
        assert len(message) < 20_000, seed


def test_a_case_is_the_same_every_time() -> None:
    assert [case(seed) for seed in range(30)] == [case(seed) for seed in range(30)]


def test_the_whole_files_that_cases_damage_are_read() -> None:
    for text, kind in ((BVH, "bvh"), (AMC, "amc"), (DEEPMIMIC, "deepmimic")):
        clip = read_capture_bytes(text.encode(), kind, skeleton=AsfFile(ASF.encode()))
        motion = retarget.to_motion(clip, keep_implausible=False)
        assert clip.n_frames == 8
        assert motion.notes == ()


def test_the_whole_npz_that_cases_change_is_read() -> None:
    members = {f"{name}.npy": as_member(array) for name, array in good_arrays().items()}
    clip = read_capture_bytes(packed(members), "amass")
    motion = retarget.to_motion(clip, keep_implausible=False)
    assert (clip.n_frames, clip.fps, motion.notes) == (12, 60.0, ())


def test_changed_npz_files_are_read_and_refused(tmp_path: Path) -> None:
    messages = [
        read_file(*mutated_npz(np.random.default_rng([seed, 1])), tmp_path) for seed in range(120)
    ]
    assert not any(UNEXPECTED in message for message in messages)
    n_read = messages.count("")
    assert 30 <= n_read <= 90  # the cases are fixed by their seeds
    refused = " ".join(messages)
    for reason in (
        "expected an array 'poses'", "found NaN or infinity", "expected poses of shape",
        "expected trans of shape", "expected mocap_framerate from", "expected an npz file",
    ):  # fmt: skip
        assert reason in refused, reason


@pytest.mark.parametrize("kind", ["bvh", "amc", "deepmimic", "npz mutated", "sheet", "events"])
def test_every_kind_of_case_is_both_read_and_refused(tmp_path: Path, kind: str) -> None:
    answers = {
        read_file(*MAKERS[kind](np.random.default_rng([seed, 2])), tmp_path) == ""
        for seed in range(60)
    }
    assert answers == {True, False}


@pytest.mark.parametrize("seed", range(4))
def test_odd_c3d_files_are_refused(seed: int) -> None:
    pytest.importorskip("ezc3d")
    _, data, _ = strange_c3d(np.random.default_rng(seed))
    with pytest.raises(CaptureError):
        read_capture_bytes(data, "c3d", path="odd.c3d", options=ReadOptions(limits=ReadLimits(20)))


def test_damaged_c3d_files_are_read_or_refused(tmp_path: Path) -> None:
    pytest.importorskip("ezc3d")
    answers = [read_file(*odd_c3d(np.random.default_rng(seed)), tmp_path) for seed in range(8)]
    assert answers.count("") >= 1
    assert len(set(answers)) >= 3


def test_the_c3d_file_that_is_damaged_is_whole() -> None:
    pytest.importorskip("ezc3d")
    clip = read_capture_bytes(whole_c3d(5), "c3d", path="whole.c3d")
    assert (clip.n_frames, clip.fps, clip.notes) == (5, 100.0, ())
    np.testing.assert_allclose(np.diff(clip.root_positions, axis=0), [[0, 0, 0.01]] * 4, atol=1e-6)
