"""The site's page of descriptions, in its own markup."""

from __future__ import annotations

from motiondb.fetch.captions import caption_row
from motiondb.fetch.cmu_pages import Trial, read_trials

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


def test_a_row_has_no_quotes_tabs_or_line_ends() -> None:
    row = caption_row(Trial(114, 3, '"a"\tb\nc', None))
    assert row == "114/114_03.amc\t114/114.asf\t114\t\tCMU\t'a' b c"
