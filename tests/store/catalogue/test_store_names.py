"""Names that users give: what no file could be called, or what leads elsewhere, is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb import store
from motiondb.errors import QueryError


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("", "nothing"),
        ("..", "an empty part, or one of dots alone"),
        ("../walk", "an empty part, or one of dots alone"),
        ("/etc/walk", "an empty part, or one of dots alone"),
        ("a\\walk", "a backslash"),
        ("walk\n", "a character that cannot be printed"),
        ("walk ", "a space at the beginning or the end of a part"),
        ("w" * 201, "more than 200 bytes"),
        ("\u00e4" * 101, "more than 200 bytes"),
    ],
)
def test_a_bad_name_is_refused(name: str, fault: str) -> None:
    with pytest.raises(QueryError) as error:
        store.check_new_name(name, "scene")
    assert str(error.value) == (
        f"{name[:60]!r}: expected a name for the scene, found {fault}. Choose another name, "
        "such as walk_2 or demo/walk_2."
    )


@pytest.mark.parametrize(
    "name", ["walk", "demo/walk_2", "walk.v2", ".hidden", "two words", "Gr\u00fc\u00dfe", "w" * 200]
)
def test_a_good_name_is_taken(name: str) -> None:
    store.check_new_name(name, "capture")


@given(st.text(max_size=300))
def test_what_is_taken_stays_below_its_folder(name: str) -> None:
    try:
        store.check_new_name(name, "capture")
    except QueryError:
        return
    assert 0 < len(name.encode()) <= 200
    assert not {"", ".", ".."} & set(name.split("/"))
    assert "\\" not in name
    assert "\0" not in name
