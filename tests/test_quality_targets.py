"""The table of targets in docs/quality.md says what the sections below it say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from quality_protocol import targets as targets

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "quality.md"


def test_the_page_holds_the_table_of_its_sections() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert targets.section(text) in text
    assert text.index("<!-- task targets -->") == text.index("<!-- task ")


def test_every_figure_of_the_table_stands_in_a_section() -> None:
    text = PAGE.read_text(encoding="utf-8")
    table, rest = targets.section(text), targets._SECTION.sub("", text)
    rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| ")][2:]
    assert len(rows) > 20
    figures = [actual for row in rows for actual in re.findall(r"-?\d*\.\d{3}\b", row[1])]
    assert len(figures) > 60
    assert [figure for figure in figures if figure not in rest] == []


@pytest.mark.parametrize(
    ("ours", "best", "ahead", "met"),
    [
        (".500", ".400", ".100 (.050 to .150)", "yes, beyond the interval"),
        (".500", ".490", ".010 (-.050 to .060)", "yes"),
        (".500", ".520", "-.020 (-.050 to .010)", "no difference"),
        (".500", ".600", "-.100 (-.150 to -.050)", "no"),
    ],
)
def test_a_difference_is_judged_by_its_interval(ours: str, best: str, ahead: str, met: str) -> None:
    rows = (
        ("motiondb", ours, ""), ("motiondb, half of it", ".900", "-.400 (-.500 to -.300)"),
        ("other", best, ahead), ("worse", ".100", ".400 (.300 to .500)"),
        ("random", ".990", "-.490 (-.500 to -.480)"),
    )  # fmt: skip
    figure, actual = targets.beaten(targets.Table(("method", "x", "motiondb better by"), rows), "x")
    assert actual == met
    assert figure == f"{ours}; other {best}, motiondb better by {ahead}"
