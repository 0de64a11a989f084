"""Files that users name are read up to a bound, also where the system tells no size."""

from __future__ import annotations

from pathlib import Path

import pytest

from motiondb.files.safe_files import read_bounded, read_bounded_text


def test_a_file_is_read_up_to_the_bound(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bounded(path, 5) == b"12345"
    with pytest.raises(OSError, match="more than 4e-06 MB"):
        read_bounded(path, 4)


def test_every_end_of_line_becomes_one(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_bounded_text(path) == "a\nb\nc\n"
    path.write_bytes(b"\xff")
    with pytest.raises(UnicodeDecodeError):
        read_bounded_text(path)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="a file without an end")
def test_a_file_without_an_end_is_refused() -> None:
    with pytest.raises(OSError, match="more than 1 MB"):
        read_bounded(Path("/dev/zero"), 1_000_000)
