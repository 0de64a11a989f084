"""No file, however odd, makes a reader raise anything but this project's errors, or cost much."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from odd_captures import Companions, case, odd_c3d, strange_c3d
from odd_npz import mutated_npz

from motiondb.body import retarget
from motiondb.errors import CaptureError, MotionDBError
from motiondb.files.formats import capture_format, read_capture_bytes
from motiondb.files.limits import ReadLimits, ReadOptions, SkeletonFile, guarded
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
        asf = SkeletonFile(companions["skeleton.asf"]) if companions else None
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


def test_changed_npz_files_are_read_and_refused(tmp_path: Path) -> None:
    messages = [
        read_file(*mutated_npz(np.random.default_rng([seed, 1])), tmp_path) for seed in range(120)
    ]
    assert not any(UNEXPECTED in message for message in messages)
    n_read = messages.count("")
    assert 30 <= n_read <= 90  # the cases are fixed by their seeds
    refused = " ".join(messages)
    for reason in (
        "expected arrays of SMPL", "found NaN or infinity", "expected poses with 3, 4,",
        "expected trans of shape", "expected mocap_framerate from", "expected an npz file",
    ):  # fmt: skip
        assert reason in refused, reason


@pytest.mark.parametrize("seed", range(4))
def test_odd_c3d_files_are_refused(seed: int) -> None:
    _, data, _ = strange_c3d(np.random.default_rng(seed))
    with pytest.raises(CaptureError):
        read_capture_bytes(data, "c3d", path="odd.c3d", options=ReadOptions(limits=ReadLimits(20)))


def test_damaged_c3d_files_are_read_or_refused(tmp_path: Path) -> None:
    answers = [read_file(*odd_c3d(np.random.default_rng(seed)), tmp_path) for seed in range(60)]
    assert not any(UNEXPECTED in answer for answer in answers)
    assert 10 <= answers.count("") <= 50
    assert len(set(answers)) >= 5
