from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import QueryError
from motiondb.records import CaptureInfo
from motiondb.store.catalogue.where import (
    Condition,
    asks_captions,
    condition_text,
    matches,
    parse_where,
    with_columns,
)


def _info(**tags: str) -> CaptureInfo:
    return CaptureInfo(
        7, "14/14_01", "ab", "amc", "captured", 120.0, 480, 4.0, 120, 0.8, "/x", 1, tags
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ()),
        ("performer=14", (("performer", "=", "14"),)),
        ("duration>=2.5 and fps<100", (("duration", ">=", "2.5"), ("fps", "<", "100"))),
        ("a!=b AND c~d e", (("a", "!=", "b"), ("c", "~", "d e"))),
        ("take='sand and sea' and fps=60", (("take", "=", "sand and sea"), ("fps", "=", "60"))),
        ("licence=''", (("licence", "=", ""),)),
        ('a=\'it\'\'s "x"\' and "b""c"=1', (("a", "=", 'it\'s "x"'), ('b"c', "=", "1"))),
        ("name=band and kind=android", (("name", "=", "band"), ("kind", "=", "android"))),
    ],
)
def test_filters_are_read(text: str, expected: tuple) -> None:
    assert parse_where(text) == tuple(Condition(*parts) for parts in expected)


def test_unknown_name_gets_a_suggestion() -> None:
    with pytest.raises(QueryError) as error:
        with_columns(parse_where("preformer=14"), ["performer", "style"])
    assert str(error.value) == (
        "filter on 'preformer': expected one of capture_id, name, sha256, format, kind, fps, "
        "n_frames, duration, motion_frames, leg_length, path, run_id, caption, selection, "
        "performer, style, found no such column or tag. Did you mean performer?"
    )


def test_heads_of_the_table_name_its_columns() -> None:
    text = "not (Length>10 or words~walk) and capture in (a, b) and Frames<9"
    (none, one, frames) = with_columns(parse_where(text), ["performer"])
    expected = parse_where("not (duration>10 or caption~walk) and name in (a, b) and n_frames<9")
    assert (none, one, frames) == expected
    tagged = with_columns(parse_where("length=long"), ["length"])
    assert tagged == parse_where("length=long")


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("performer=6", True),  # the tag is "06": numbers are compared as numbers
        ("performer!=6", False),
        ("performer<14", True),  # as text "06" < "14" as well, but "6" < "14" is not
        ("performer>5.5", True),
        ("style=PROUD", True),
        ("style~rou", True),
        ("style>a", True),
        ("style<3", False),
        ("duration=4", True),
        ("fps>=120 and fps<=120", True),
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
    actual = [matches(info, (Condition("height", sign, repr(b)),)) for sign in ("<", "=", ">")]
    assert actual == [a < b, a == b, a > b]
    opposite = [matches(info, (Condition("height", s, repr(b)),)) for s in (">=", "!=", "<=")]
    assert opposite == [not holds for holds in actual]


@settings(max_examples=50, deadline=None)
@given(st.text(max_size=30), st.text(max_size=9))
def test_whatever_is_typed_gives_a_filter_or_a_sentence(text: str, value: str) -> None:
    with suppress(QueryError):
        matches(_info(tag=value), parse_where(text))


CAPTIONS = ("a person walks", "Walk, turn left")


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("performer=6 or style=shy", True),
        ("style=shy or performer=7", False),
        ("style=shy or style=proud and performer=7", False),  # and binds tighter
        ("(style=shy or style=proud) and performer=6", True),
        ("not style=shy", True),
        ("not (style=proud and performer=6)", False),
        ("not (style=proud and performer=7)", True),
        ("not mood=proud", True),
        ("NOT style=shy AND performer=6", True),
        ("performer in (5, 6, 7)", True),
        ("performer not in (5, 7)", True),
        ("style in ('shy', 'proud')", True),
        ("mood not in (proud)", True),
        ("style!~rou", False),
        ("mood!~x", True),
        ("caption~walk", True),
        ("caption~'TURN LEFT'", True),
        ("caption!~run", True),
        ("caption='a person walks'", True),
        ("caption~walk and not caption~run or style=shy", True),
        ("fps in (60) or (duration<2 or (duration>=4 and not kind=generated))", True),
    ],
)
def test_filters_with_alternatives_negations_and_captions(text: str, holds: bool) -> None:
    info = _info(performer="06", style="proud")
    assert matches(info, parse_where(text), CAPTIONS) is holds


def test_a_capture_without_captions_answers_only_to_negations() -> None:
    assert not matches(_info(), parse_where("caption~walk"))
    assert matches(_info(), parse_where("caption!~walk"))
    assert matches(_info(), parse_where("not caption~walk"))
    assert asks_captions(parse_where("fps=60 or not (caption~walk)"))
    assert not asks_captions(parse_where("action~caption"))


def test_values_may_hold_parentheses_and_commas() -> None:
    (bear,) = parse_where("action=bear (human subject), slow")
    assert bear == Condition("action", "=", "bear (human subject), slow")
    ((first,), (second,)) = parse_where("name in ('a,b)', c d)")[0].alternatives
    assert (first.value, second.value) == ("a,b)", "c d")


NO_CONDITION = (
    "expected NAME OPERATOR VALUE with one of = != < <= > >= ~, found {!r}. "
    "Write for example: performer=14 and duration>2.5."
)
TOO_DEEP = "expected at most 50 parentheses and negations within one another"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("performer", NO_CONDITION.format("performer")),
        ("=14", NO_CONDITION.format("=14")),
        ("a=1 and", NO_CONDITION.format("nothing")),
        ("a=b=c", NO_CONDITION.format("a=b=c")),
        ("a in ()", NO_CONDITION.format("a in ()")),
        ("not", NO_CONDITION.format("not")),
        ("a=1 or or b=2", NO_CONDITION.format("or b=2")),
        ("(a=1", "expected ')' for every '(', found 'the end'. Close the parentheses."),
        ("a=1)", "expected '(' before ')', found none. Leave out ')', or put the value into"),
        ("not " * 60 + "a=1", TOO_DEEP),
        ("(" * 60 + "a=1" + ")" * 60, TOO_DEEP),
    ],
)
def test_what_cannot_be_read_is_refused(text: str, message: str) -> None:
    with pytest.raises(QueryError) as error:
        parse_where(text)
    assert str(error.value).startswith("filter ")
    assert message in str(error.value)


def test_a_filter_has_a_longest_length() -> None:
    with pytest.raises(QueryError) as error:
        parse_where("a=1" + " or a=2" * 20_000)
    assert str(error.value) == (
        "filter: expected at most 100,000 characters, found 140,003. Ask for less at a time."
    )
    assert len(parse_where("name in (" + ", ".join(map(str, range(5_000))) + ")")) == 1


@given(st.text(min_size=1), st.text())
def test_any_name_and_value_are_a_condition(name: str, value: str) -> None:
    assert parse_where(condition_text(name, value)) == (Condition(name, "=", value),)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(
        st.sampled_from(
            ["a", "b", "caption", "=", "~", "(", ")", "not", "and", "or", "in", ",", "1", "'x y'",
             '"', "!~"]
        ),
        max_size=20,
    )
)  # fmt: skip
def test_any_words_of_the_language_give_a_filter_or_a_sentence(pieces: list[str]) -> None:
    with suppress(QueryError):
        matches(_info(a="1"), parse_where(" ".join(pieces)), CAPTIONS)


@given(st.integers(0, 63), st.integers(0, 7))
def test_filters_agree_with_logic(shape: int, tags: int) -> None:
    def wrap(text: str, negate: int) -> str:
        return f"not ({text})" if negate else text

    names = ["x", "y", "z"]
    truth = {name: bool(tags >> n & 1) for n, name in enumerate(names)}
    atoms = [wrap(f"{name}=1", shape >> n & 1) for n, name in enumerate(names)]
    values = [truth[name] != bool(shape >> n & 1) for n, name in enumerate(names)]
    joints = ["and" if shape >> n & 1 else "or" for n in (3, 4)]
    text = wrap(f"{atoms[0]} {joints[0]} {atoms[1]} {joints[1]} {atoms[2]}", shape >> 5 & 1)
    spelt = f"{values[0]} {joints[0]} {values[1]} {joints[1]} {values[2]}"
    info = _info(**{name: str(int(value)) for name, value in truth.items()})
    assert matches(info, parse_where(text)) is (eval(spelt) != bool(shape >> 5 & 1))
