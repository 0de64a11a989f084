"""Files of knowledge: the same comes back, and nothing else than knowledge is read."""

from __future__ import annotations

import hashlib
import json
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_knowledge import ORIGIN, small_knowledge

from motiondb.errors import KnowledgeError
from motiondb.files import knowledge_file
from motiondb.files.knowledge_file import (
    HEADING,
    from_bytes,
    read_knowledge,
    read_summary,
    to_bytes,
    write_knowledge,
)
from motiondb.learn.codec import to_values
from motiondb.learn.knowledge import APART

GOOD = to_bytes(small_knowledge())


def parts(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Header and data of a file."""
    line, _, stream = content[len(HEADING) :].partition(b"\n")
    return json.loads(line), zlib.decompress(stream)


def build(header: dict[str, Any], data: bytes) -> bytes:
    """A file of a header and data; the digest and size fit the data."""
    header = {**header, "size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    return HEADING + json.dumps(header).encode() + b"\n" + zlib.compress(data)


def with_array(name: str, change: Any) -> bytes:
    """The good file with other numbers in one array."""
    header, data = parts(GOOD)
    place, made = 0, []
    for listed, shape in header["arrays"]:
        size = int(np.prod(shape))
        values = np.frombuffer(data, "<f4", size, 4 * place).reshape(shape).copy()
        if listed == name:
            values = np.asarray(change(values), dtype="<f4")
        made.append([listed, list(values.shape), values])
        place += size
    header["arrays"] = [[n, s] for n, s, _ in made]
    return build(header, b"".join(v.tobytes() for _, _, v in made))


def refusal(content: bytes) -> str:
    """Why a file is refused; "" where it is read."""
    try:
        from_bytes(content, "x")
    except KnowledgeError as error:
        return str(error)
    return ""


def test_what_was_written_comes_back(tmp_path: Path) -> None:
    made = small_knowledge()
    path = write_knowledge(made, tmp_path / "small.knowledge")
    actual = read_knowledge(path)
    assert actual.taught.words == made.taught.words
    assert replace(actual.origin, digest="") == ORIGIN
    assert actual.origin.digest == hashlib.sha256(path.read_bytes()).hexdigest()
    theirs = to_values(actual, without=APART)
    for name, values in to_values(made, without=APART).items():
        np.testing.assert_array_equal(theirs[name], values.astype(np.float32), err_msg=name)
    np.testing.assert_allclose(actual.taught.moments.gram, made.taught.moments.gram, atol=1e-6)
    assert actual.taught.shapes == made.taught.shapes
    assert actual.cutting == made.cutting
    assert [p.name for p in tmp_path.iterdir()] == ["small.knowledge"]


def test_the_same_knowledge_gives_the_same_bytes_and_what_was_read_is_written_so_again() -> None:
    assert to_bytes(small_knowledge()) == GOOD
    assert to_bytes(from_bytes(GOOD, "x")) == GOOD


def test_the_summary_is_read_without_the_numbers() -> None:
    origin, words = read_summary(GOOD[: GOOD.index(b"\n", len(HEADING)) + 1], "x")
    assert (origin.name, origin.captions, words) == ("small", 12, ("jump", "run", "walk"))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "expected the line 'motiondb knowledge 1', found ''"),
        (b"PK\x03\x04", "expected the line 'motiondb knowledge 1'"),
        (HEADING, "expected JSON, found a fault"),
        (HEADING + b"[" * 100_000 + b"\n", "at most 50 lists and objects within one another"),
        (HEADING + b"[]\n", "expected an object, found a list"),
        (HEADING + b" " * 2_000_000, "expected a second line of at most 1,000,000 bytes"),
        (GOOD[:-20], "bytes of data, found more or fewer"),
        (GOOD + b"more", "bytes of data, found more or fewer"),
        (GOOD.replace(b'"walk"', b'"wa k"'), "expected words of letters, found others"),
        (GOOD.replace(b'"walk"', b'"jump"'), "expected sorted words, each once"),
        (GOOD.replace(b'"seconds":60.5', b'"seconds":NaN'), "finite numbers, found NaN"),
        (GOOD.replace(b'"name":"small"', b'"name":"sm\\u001b[2J"'), "short texts and numbers"),
        (GOOD.replace(b'"name":"small"', b'"name":["sma"]'), "a text for origin.name"),
        (
            GOOD.replace(b'"kind":"learn"', b'"kind":' + b"[" * 500 + b"]" * 500),
            "at most 50 lists and objects within one another",
        ),
        (GOOD.replace(b'"learn"', b'"\\ud800"'), "half of a surrogate pair"),
        (GOOD.replace(b'"size":', b'"more":1,"size":'), "expected the fields origin, words"),
        (
            GOOD.replace(b'"feature_space.mean"', b'"__reduce__"'),
            "expected the array 'feature_space.mean'",
        ),
        (
            GOOD.replace(b'"taught.ridge",[]', b'"taught.ridge",[-1]'),
            "a name and a shape for every array",
        ),
        (GOOD.replace(b'"taught.ridge",[]', b'"taught.ridge",[9999999,9999999]'), "data for it"),
    ],
    ids=lambda value: value[:30] if isinstance(value, str) else "",
)
def test_a_damaged_file_is_refused_with_a_reason(content: bytes, said: str) -> None:
    with pytest.raises(KnowledgeError) as actual:
        from_bytes(content, "their.knowledge")
    assert str(actual.value).startswith("their.knowledge: expected ")
    assert said in str(actual.value)
    assert "get it again" in str(actual.value)


def test_a_bomb_is_not_unpacked() -> None:
    header, _ = parts(GOOD)
    bomb = zlib.compress(bytes(300_000_000), 9)
    for size, said in ((1_000, "expected 1,000 bytes"), (300_000_000, "expected 1 to 64,000,000")):
        line = json.dumps({**header, "size": size}).encode()
        with pytest.raises(KnowledgeError, match=said):
            from_bytes(HEADING + line + b"\n" + bomb, "bomb")


def test_a_file_that_is_too_large_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(knowledge_file, "MOST_BYTES", 1_000)
    (tmp_path / "large").write_bytes(GOOD)
    with pytest.raises(KnowledgeError, match=r"found: more than 0\.001 MB"):
        read_knowledge(tmp_path / "large")


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("symbols.covars", lambda v: v * 0, "variances of symbols above 0"),
        ("symbols.means", lambda v: v + np.nan, "finite numbers"),
        ("symbols.means", lambda v: v * 1e30, "finite numbers"),
        ("symbols.self_loops", lambda v: v + 1, "self-loops from 0 to below 1"),
        ("symbols.n_states", lambda v: v + 7, "numbers of states from 1 to 2"),
        ("symbols.n_states", lambda v: v[:2], "'symbols.n_states' of shape (3,), found (2,)"),
        (
            "feature_space.mean",
            lambda v: v[:-1],
            "mean' of shape (130,), found (129,)",
        ),
        ("feature_space.projection", lambda v: v.T, "'feature_space.projection' of shape (130, 2)"),
        ("score_space.spread", lambda v: v * 0, "spreads of scores above 0"),
        ("cutting.shortest", lambda v: v * 0, "a shortest length of at least 1"),
        ("space.clusters", lambda v: v + 5, "clusters that there are"),
        ("taught.said", lambda v: v * 0, "words that some caption holds"),
        ("taught.transitions", lambda v: -v, "counts of transitions of at least 0"),
        (
            "taught.expected.alignment.values",
            lambda v: v[:-1],
            "expected 11 numbers in 'taught.expected.alignment.values', found 10",
        ),
        (
            "taught.expected.alignment.keys",
            lambda v: v * 1000,
            "intervals of 1 to 400 symbols and words",
        ),
        ("taught.moments.gram", lambda v: -v, "a matrix that cannot be one"),
        ("taught.information", lambda v: -v, "a matrix that cannot be one"),
        ("taught.moments.words", lambda v: v + 50, "no word in more intervals than there are"),
        ("taught.calibration", lambda v: -v, "a calibration that rises"),
        (
            "taught.certainties.words.weights",
            lambda v: v[:-1],
            "of shape (1,), found (0,)",
        ),
    ],
)
def test_numbers_that_cannot_be_are_refused(name: str, change: Any, said: str) -> None:
    with pytest.raises(KnowledgeError) as actual:
        from_bytes(with_array(name, change), "x")
    assert said in str(actual.value)


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_no_change_of_the_bytes_gives_any_other_error(data: st.DataObject) -> None:
    content = bytearray(GOOD)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        how = data.draw(st.sampled_from(["set", "cut", "repeat"]))
        if how == "set":
            content[place] = data.draw(st.integers(0, 255))
        elif how == "cut":
            del content[place : place + data.draw(st.integers(1, 500))]
        else:
            content[place:place] = content[place : place + 40]
        if not content:
            break
    told = refusal(bytes(content))
    assert not told or told.startswith("x: expected")


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=8,
)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(["origin", "words", "arrays", "size", "sha256"]), _JSON)
def test_no_other_header_gives_any_other_error(field: str, value: Any) -> None:
    header, data = parts(GOOD)
    line = json.dumps({**header, field: value}).encode()
    with pytest.raises(KnowledgeError):
        from_bytes(HEADING + line + b"\n" + zlib.compress(data), "x")


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_no_other_numbers_give_any_other_error(data: st.DataObject) -> None:
    names = [name for name, _ in parts(GOOD)[0]["arrays"]]
    value = data.draw(st.floats(width=32))
    place = data.draw(st.integers(0, 10_000))

    def change(values: np.ndarray) -> np.ndarray:
        values.flat[place % max(values.size, 1)] = value
        return values

    told = refusal(with_array(data.draw(st.sampled_from(names)), change))
    assert not told or told.startswith("x: expected")


def test_a_missing_file_and_a_place_that_cannot_be_written_are_told(tmp_path: Path) -> None:
    with pytest.raises(KnowledgeError, match="expected a file of knowledge, found: No such file"):
        read_knowledge(tmp_path / "none")
    with pytest.raises(KnowledgeError, match="expected a file that can be written"):
        write_knowledge(small_knowledge(), tmp_path / "no" / "such" / "folder")
    with pytest.raises(KnowledgeError, match="Is a directory"):
        read_knowledge(tmp_path)
