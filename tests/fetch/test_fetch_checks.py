"""Whole and damaged ASF and AMC bytes, each beside its exact sentence."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.fetch.checks import check_amc, check_asf

ASF = b"# by hand\n:version 1.10\n:root\n:bonedata\n  begin\n  end\n:hierarchy\n  begin\n  end\n"
AMC = b":FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3\nhead 4\n2\nroot 1 2 3\nhead 4\n"


def test_whole_files_pass_with_any_line_end() -> None:
    assert check_amc(AMC) is None
    assert check_amc(AMC.replace(b"\n", b"\r\n")) is None
    assert check_amc(b":DEGREES\n1\nroot 1\n") is None
    assert check_asf(ASF) is None
    assert check_asf(ASF.replace(b"\n", b"\r\n") + b"\r\n\r\n") is None


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"", "expected an AMC file, found an empty file"),
        (b" \n<!DOCTYPE html>", "expected an AMC file, found a web page"),
        (b"PK\x03\x04", "expected an AMC file, found something else"),
        (b":DEGREES\n", "expected frames after the header, found none"),
        (AMC.replace(b"\n2\n", b"\n4\n"), "expected frame 2 after frame 1, found frame 4"),
        (
            AMC.removesuffix(b"head 4\n"),
            "expected 2 bones with 4 values in the last frame (number 2), "
            "found 1 bones with 3 values",
        ),
        (AMC[:-1], "expected a line end at the end of the file, found a line cut short"),
    ],
)
def test_damaged_amc(data: bytes, fault: str) -> None:
    assert check_amc(data) == fault


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"<html>", "expected an ASF file, found a web page"),
        (ASF.replace(b":root\n", b""), "expected a section :root, found none"),
        (ASF[:-4], "expected an end for each of 2 begin, found 1 end"),
    ],
)
def test_damaged_asf(data: bytes, fault: str) -> None:
    assert check_asf(data) == fault


FIRST_FRAME_END = AMC.index(b"2\nroot", 30)


@given(st.integers(FIRST_FRAME_END + 1, len(AMC) - 1))
def test_every_cut_after_the_first_frame_is_found(length: int) -> None:
    assert check_amc(AMC[:FIRST_FRAME_END]) is None
    assert check_amc(AMC[:length]) is not None


@given(st.integers(0, len(ASF) - 2))
def test_every_cut_of_a_skeleton_is_found(length: int) -> None:
    assert check_asf(ASF[:length]) is not None
