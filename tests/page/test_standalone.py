"""One file with the page, an answer and its motions."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb.errors import MotionDBError
from motiondb.page import standalone
from motiondb.page.motion import read_tracks
from motiondb.page.standalone import StandalonePage


class Parts(HTMLParser):
    """The scripts, styles and policy of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self.policy = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "meta" and given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"] or ""
        if tag in ("script", "style"):
            assert "src" not in given
            self.open.append((given.get("type") or tag, given))
        assert tag != "link"

    def handle_endtag(self, tag: str) -> None:
        if tag in ("script", "style"):
            self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open:
            kind = self.open[-1][0]
            self.texts[kind] = self.texts.get(kind, "") + data


@pytest.fixture
def bundle(bundle: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files of a page, in place of those of the build."""
    monkeypatch.setattr(standalone, "BUNDLE", bundle)
    return bundle


def parts_of(page: str) -> tuple[Parts, dict[str, Any]]:
    actual = Parts(page)
    return actual, json.loads(actual.texts["application/json"])


def hash_of(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_script_and_style_are_allowed_by_their_hashes_alone(bundle: Path) -> None:
    shown = StandalonePage("search", "</script><b>", "x.duckdb", {"a": "</script>"}, {})
    page = standalone.standalone_page(shown)
    actual, data = parts_of(page)
    assert hash_of(actual.texts["script"]) in actual.policy
    assert hash_of(actual.texts["style"]) in actual.policy
    assert "unsafe" not in actual.policy
    assert actual.policy.startswith("default-src 'none'")
    assert data["answer"] == {"a": "</script>"}
    assert page.count("</script>") == 2
    assert html.escape("<b>") not in page
    assert re.search(r"src=|href=|https?:", page) is None


def test_a_search_carries_the_motions_around_its_matches(learned_file: Path, bundle: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("kick", limit=3)
        page = standalone.standalone_page(StandalonePage.of_search(db, answer))
    _, data = parts_of(page)
    assert (data["kind"], data["title"], data["database"]) == ("search", "kick", "motions.duckdb")
    assert [m["capture"] for m in data["answer"]["matches"]] == [m.capture for m in answer.matches]
    for match in data["answer"]["matches"]:
        (track,) = read_tracks(base64.b64decode(data["motions"][match["ref"]]))
        seconds = len(track.points) / track.fps
        assert track.start <= match["start"]
        assert track.start + seconds >= min(match["end"], match["duration"] - 0.1)
        assert track.start >= match["start"] - 1.1


def test_every_command_writes_the_kind_that_it_shows(learned_file: Path, bundle: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        pages = [
            StandalonePage.of_like(db, db.like("ana/walk_1", 0, 1, limit=2), "ana/walk_1", 0, 1),
            StandalonePage.of_generated(db, db.generate("jump", 1)),
            StandalonePage.of_capture(db, "ana/walk_1"),
        ]
    kinds = []
    for shown in pages:
        _, data = parts_of(standalone.standalone_page(shown))
        kinds.append(data["kind"])
        for motion in data["motions"].values():
            assert len(read_tracks(base64.b64decode(motion))) == 1
    assert kinds == ["like", "generate", "capture"]
    assert "example" in pages[0].motions


def test_without_the_files_of_the_page_it_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(standalone, "BUNDLE", tmp_path)
    shown = StandalonePage("search", "x", "x", {}, {})
    with pytest.raises(MotionDBError, match=r"python build_backend\.py"):
        shown.write(tmp_path / "x.html")
    assert not (tmp_path / "x.html").exists()


def test_an_index_of_another_form_is_refused(tmp_path: Path, bundle: Path) -> None:
    (bundle / "index.html").write_text("<html><body></body></html>")
    shown = StandalonePage("search", "x", "x", {}, {})
    with pytest.raises(MotionDBError, match="expected one style and one script"):
        shown.write(tmp_path / "x.html")


def test_a_name_without_html_is_refused_before_anything_is_opened(command: Any) -> None:
    ended = command("search", "walk", "--html", "x.txt", "--db", "nothing.duckdb")
    assert ended.code == 2
    assert "expected a name that ends in .html" in ended.err


def test_the_option_writes_the_file(
    command: Any, learned_file: Path, bundle: Path, tmp_path: Path
) -> None:
    ended = command("search", "kick", "--html", "kick.html", "--db", learned_file)
    assert ended.code == 0, ended.err
    assert "page: kick.html" in ended.err
    _, data = parts_of((tmp_path / "kick.html").read_text())
    assert data["answer"]["matches"]
