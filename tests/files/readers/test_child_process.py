"""Which end a process met that read one file."""

from __future__ import annotations

from pathlib import Path

import pytest

from motiondb.errors import CaptureError
from motiondb.files.limits import ReadLimits
from motiondb.files.readers.child_process import read_in_child

READER = """
import os, signal, time
from motiondb.files.readers.child_process import end_child_with_parent
source, target, (work,) = end_child_with_parent()
exec(work)
"""


@pytest.mark.parametrize(
    ("work", "limits", "said"),
    [
        (
            "raise ValueError('no header')",
            ReadLimits(),
            "expected a file that can be read, found that its reader fails (ValueError: no "
            "header). Export it again.",
        ),
        (
            "bytearray(10**9)",
            ReadLimits(memory=10**8),
            "expected a file that fits into memory, found a larger one. Cut the capture, or allow "
            "more with --memory-limit.",
        ),
        (
            "os.kill(os.getpid(), signal.SIGSEGV)",
            ReadLimits(),
            "expected a file that can be read, found that it ends the process that reads it "
            "(SIGSEGV). It is damaged, or needs more memory: export it again, or allow more with "
            "--memory-limit.",
        ),
        (
            "os.kill(os.getpid(), signal.SIGKILL)",
            ReadLimits(),
            "expected to read the file, found that the process was ended from outside (SIGKILL), "
            "as the system does where memory is short. The file may be whole: close other "
            "programs, or read fewer files at once (--jobs 1).",
        ),
        (
            "time.sleep(60)",
            ReadLimits(seconds=0.5),
            "expected to read the file within 0.5 s, found that it takes longer. Cut the capture, "
            "or allow more with --time-limit.",
        ),
        (
            "while True: pass",
            ReadLimits(seconds=120.0),
            "expected to read the file within 2 s of processor time, found that it takes longer. "
            "Cut the capture, or allow more with --time-limit.",
        ),
    ],
)
def test_every_end_of_a_child_is_told(
    work: str, limits: ReadLimits, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a_reader.py").write_text(READER)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(CaptureError) as caught:
        read_in_child("a_reader", b"bytes", limits, 1.0, [work], "a.fbx")
    assert str(caught.value) == f"a.fbx: {said}"
