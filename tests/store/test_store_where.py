from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import QueryError
from motiondb.records import CaptureInfo
from motiondb.store.catalogue.where import Condition, check_names, matches, parse_where


def _info(**tags: str) -> CaptureInfo:
    return CaptureInfo(
        7, "14/14_01", "ab", "amc", "captured", 120.0, 480, 4.0, 120, 0.8, "/x", 1, tags
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ()),
        ("  ", ()),
        ("performer=14", (("performer", "=", "14"),)),
        ("performer == 14", (("performer", "=", "14"),)),
        ("duration>=2.5 and fps<100", (("duration", ">=", "2.5"), ("fps", "<", "100"))),
        ("a!=b AND c~d e", (("a", "!=", "b"), ("c", "~", "d e"))),
        ("take='sand and sea' and fps=60", (("take", "=", "sand and sea"), ("fps", "=", "60"))),
        ('name="a=b"', (("name", "=", "a=b"),)),
        ("licence=''", (("licence", "=", ""),)),
        ("name=band and kind=android", (("name", "=", "band"), ("kind", "=", "android"))),
    ],
)
def test_filters_are_read(text: str, expected: tuple) -> None:
    assert parse_where(text) == tuple(Condition(*parts) for parts in expected)


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("performer", "performer"),
        ("=14", "=14"),
        ("performer=", "performer="),
        ("a=1 and", "nothing"),
        ("a=1 and b", "b"),
        ("a=b=c", "a=b=c"),
    ],
)
def test_what_is_no_filter_is_shown_one(text: str, rest: str) -> None:
    with pytest.raises(QueryError) as error:
        parse_where(text)
    assert str(error.value) == (
        f"filter {text!r}: expected NAME OPERATOR VALUE with one of = != < <= > >= ~, "
        f"found {rest!r}. Write for example: performer=14 and duration>2.5."
    )


def test_unknown_name_gets_a_suggestion() -> None:
    with pytest.raises(QueryError) as error:
        check_names(parse_where("preformer=14"), ["performer", "style"])
    assert str(error.value) == (
        "filter on 'preformer': expected one of capture_id, name, sha256, format, kind, fps, "
        "n_frames, duration, motion_frames, leg_length, path, run_id, performer, style, "
        "found no such column or tag. Did you mean performer?"
    )


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("performer=6", True),  # the tag is "06": numbers are compared as numbers
        ("performer=06", True),
        ("performer!=6", False),
        ("performer<14", True),  # as text "06" < "14" as well, but "6" < "14" is not
        ("performer>5.5", True),
        ("style=PROUD", True),
        ("style~rou", True),
        ("style~x", False),
        ("style>a", True),
        ("style>zebra", False),
        ("style<3", False),
        ("duration=4", True),
        ("fps>=120 and fps<=120", True),
        ("fps>120", False),
        ("name~14/", True),
        ("mood=proud", False),
        ("mood!=proud", True),
        ("mood~", None),
        ("performer=6 and style=shy", False),
    ],
)
def test_captures_are_compared(text: str, holds: bool | None) -> None:
    info = _info(performer="06", style="proud")
    if holds is None:
        with pytest.raises(QueryError):
            parse_where(text)
    else:
        assert matches(info, parse_where(text)) is holds


@settings(max_examples=50, deadline=None)
@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_each_operator_agrees_with_numbers(a: float, b: float) -> None:
    info = _info(height=repr(a))
    found = [matches(info, (Condition("height", sign, repr(b)),)) for sign in ("<", "=", ">")]
    assert found == [a < b, a == b, a > b]
    opposite = [matches(info, (Condition("height", s, repr(b)),)) for s in (">=", "!=", "<=")]
    assert opposite == [not holds for holds in found]


@settings(max_examples=50, deadline=None)
@given(st.text(max_size=30), st.text(max_size=9))
def test_whatever_is_typed_gives_a_filter_or_a_sentence(text: str, value: str) -> None:
    with suppress(QueryError):
        matches(_info(tag=value), parse_where(text))
