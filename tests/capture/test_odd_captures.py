"""No file, however odd, makes a reader raise anything but this project's errors, or cost much."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from odd_captures import AMC, ASF, BVH, DEEPMIMIC, case, odd_c3d

from motiondb.capture import AsfFile, capture_format, guarded, read_capture_bytes
from motiondb.capture.input.limits import ReadLimits, ReadOptions
from motiondb.capture.sheets.event_sheet import read_event_sheet
from motiondb.capture.sheets.sheet import read_sheet
from motiondb.errors import CaptureError, MotionDBError
from motiondb.pose import retarget

UNEXPECTED = "expected a file that its reader knows"
"""How the safety net begins a message: a cause that a reader should have named itself."""


def read_case(seed: int, folder: Path) -> str:
    """Read a case as ``add`` does; the message of its refusal, or nothing."""
    suffix, data, companions = case(seed)
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


@pytest.mark.parametrize("seed", range(4))
def test_odd_c3d_files_are_refused(seed: int) -> None:
    pytest.importorskip("ezc3d")
    _, data, _ = odd_c3d(np.random.default_rng(seed))
    with pytest.raises(CaptureError):
        read_capture_bytes(data, "c3d", path="odd.c3d", options=ReadOptions(limits=ReadLimits(20)))
