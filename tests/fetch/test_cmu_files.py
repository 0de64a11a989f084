"""The site's page of descriptions, and whole and damaged files beside their exact sentences."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.fetch.cmu import Trial, caption_row, check_amc, check_asf, read_trials

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


PAGE = """<TABLE><TR><TD>Subject number (e.g. 41)<TABLE>
<TR><TD COLSPAN=3><CENTER>Subject #25 (nursery rhymes)
 <A HREF="http://mocap.cs.cmu.edu:80/subjects/25/25.asf">asf</A>
<TR BGCOLOR=#909090><TD>Image<TD>Trial #<TD>Motion Description</TR>
<TR BGCOLOR=#FF0000><TD></TD><TD>2</TD><TD>Simon &amp; Garfunkel,
   3 times</TD><TD><A HREF="http://mocap.cs.cmu.edu:80/subjects/25/25_02.amc">amc</A></TD>
   <TD></TD><TD>60</TD><TD><A HREF="badtrial.php?subjectnumber=25&motion=2">Feedback</A></TD></TR>
<TR><TD><TD>1<TD>"I'm a little teapot..."<TD><a href=/subjects/25/25_01.AMC>amc</a><TD>120
<TR><TD><TD>3<TD><TD><a href="/subjects/25/25_03.amc">amc</a><TD>
<TR><TD><TD>4<TD>only a film<TD><a href="/subjects/25/25_04.mpg">mpg</a><TD>120
<TR><TD><TD>5<TD>the partner<TD><a href="/subjects/26/26_05.amc">amc</a><TD>120
</TABLE></TABLE>"""


def test_rows_with_an_amc_of_the_subject_are_its_trials() -> None:
    assert read_trials(PAGE, 25) == (
        Trial(25, 1, '"I\'m a little teapot..."', 120),
        Trial(25, 2, "Simon & Garfunkel, 3 times", 60),
        Trial(25, 3, "", None),
    )


def test_a_page_without_trials_has_none() -> None:
    assert read_trials(PAGE, 99) == ()
    assert read_trials("", 25) == ()
    assert read_trials("<html><body>Not found", 25) == ()


def test_a_server_with_absurd_numbers_is_read() -> None:
    row = (
        "<TR><TD></TD><TD>{0}</TD><TD>walk</TD><TD><A HREF='/subjects/14/14_{0}.amc'>amc</A>"
        "</TD><TD>{1}</TD></TR>"
    )
    odd = ("9" * 5000, "\u00b2", "\u0661", "1" * 30)
    text = "".join(row.format(number, 60) for number in odd) + row.format("06", "9" * 5000)
    assert read_trials(text + row.format("07", "\u00b2"), 14) == (
        Trial(14, 6, "walk", None),
        Trial(14, 7, "walk", None),
    )
    assert check_amc(b":DEGREES\n" + b"9" * 5000 + b"\nroot 1\n") is not None


def test_a_row_has_no_quotes_tabs_line_ends_or_control_characters() -> None:
    row = caption_row(Trial(114, 3, '"a"\tb\nc\x1b[31m \x00and', None))
    assert row == "114/114_03.amc\t114/114.asf\t114\t\tCMU\t'a' b c[31m and"
