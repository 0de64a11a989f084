"""Answers as notebooks show them."""

from __future__ import annotations

from dataclasses import dataclass, field

from motiondb.tabled import Listed, Tabled, Tupled


@dataclass(frozen=True)
class Row:
    name: str
    seconds: float
    words: tuple[str, ...] = ("walk", "left")


@dataclass(frozen=True, repr=False)
class Facts(Tabled):
    capture: str
    shares: tuple[tuple[str, float], ...] = (("walk", 0.5), ("run", 0.25))
    tags: dict[str, str] = field(default_factory=lambda: {"performer": "ana"})
    nothing: str = ""


def test_a_long_list_is_a_table_of_twelve_lines_at_most() -> None:
    lines = repr(Listed([Row("x" * 100, n / 3) for n in range(1000)])).splitlines()
    assert lines[:2] == ["1000 rows", f"name{' ' * 36}  seconds  words"]
    assert lines[3] == f"{'x' * 39}…  0.33     walk left"
    assert (len(lines), lines[-1]) == (12, "... 991 more")


def test_a_list_shows_the_columns_that_were_chosen() -> None:
    assert repr(Listed([Row("a", 1.0)], "name")) == "1 row\nname\na"
    assert (repr(Tupled([])), Tupled([1]) == (1,)) == ("0 rows", True)


def test_a_record_shows_its_fields_and_nothing_that_is_empty() -> None:
    assert repr(Facts("a\x1b[2J")) == (
        "Facts\nfield    value\ncapture  a\\x1b[2J\nshares   walk 0.50, run 0.25\n"
        "tags     performer=ana"
    )


def test_a_notebook_shows_the_same_as_html_with_what_is_markup_as_text() -> None:
    shown = Listed([Row("<b>", 1.0)])._repr_html_()
    assert shown.startswith("<p>1 row</p><table><tr><td>name</td>")
    assert "<td>&lt;b&gt;</td><td>1.00</td>" in shown
