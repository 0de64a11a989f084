"""Words that were not learned but are written: in later captions, and in tags."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.meaning.word_evidence import UNWRITTEN, WRITTEN
from motiondb.search import reasons
from motiondb.search.asked_words import find_written, with_written

TIRED = ("ana/walk_1", "boris/walk_1")


@pytest.fixture
def db(learned_copy: Path, tmp_path: Path) -> Iterator[MotionDB]:
    """Two walks are tagged as exhausted and two others as active; one kick is a dropkick."""
    rows = [(name, "exhausted") for name in TIRED]
    rows += [("chidi/walk_1", "active"), ("fatou/kick_1", "active")]
    sheet = tmp_path / "styles.tsv"
    lines = ["file\tstyle", *(f"{name}.bvh\t{style}" for name, style in rows)]
    sheet.write_text("\n".join(lines) + "\n")
    with motiondb.open(learned_copy) as opened:
        assert opened.import_words(sheet).captures == 4
        opened.set_words("fatou/kick_1", "a person does a zwickel", keep=True)
        yield opened


def test_a_value_of_a_tag_answers(db: MotionDB) -> None:
    answer = db.search("an exhausted walk", limit=5)
    assert {m.capture for m in answer.matches[:2]} == set(TIRED)
    (word,) = answer.written
    assert (word.word, word.tags, len(word.captures)) == ("exhaust", ("style=exhausted",), 2)
    assert answer.unknown == {}
    assert [m.capture for m in db.search("walk but not exhausted", limit=90).matches][-2:] != []
    without = [m.capture for m in db.search("walk but not exhausted", limit=4).matches]
    assert not set(TIRED) & set(without)


def test_a_word_in_names_of_captures_answers(db: MotionDB) -> None:
    db.captures.rename("chidi/jump_1", "chidi/tennisServe_1")
    answer = db.search("a tennis serve", limit=3)
    assert answer.matches[0].capture == "chidi/tennisServe_1"
    assert [word.tags for word in answer.written] == [("names",), ("names",)]
    assert (answer.unknown, answer.missing) == ({}, ())
    written = find_written(db.learned)
    assert not {"long", "walk", "jump"} & written.keys()  # a size, and words that were learned


def test_a_word_that_was_written_after_learning_is_found_where_it_is_written(db: MotionDB) -> None:
    answer = db.search("zwickel", limit=3)
    assert answer.matches[0].capture == "fatou/kick_1"
    assert answer.written[0].in_captions == 1
    exact = db.search("zwickel", limit=3, exact=True)
    assert exact.matches == answer.matches


def test_reasons_of_written_words_add_up(db: MotionDB) -> None:
    answer = db.search("an exhausted walk", limit=6)
    words = answer.vocabulary
    for match, why in zip(answer.matches, answer.reasons):
        assert match.score == pytest.approx(1.0 / (1.0 + math.exp(-reasons.total(why))))
        by_word = {words[w.word]: w for w in why}
        said = match.capture in TIRED
        assert (by_word["exhaust"].written > 0.0) == said
        assert all(abs(s.share) < 1e-12 for s in by_word["exhaust"].shares)
    (both,) = db.search("an exhausted stroll", limit=1).explanations  # one written, one taken
    assert {word.word for word in both.words} == {"exhaust", "stroll"}


def test_evidence_is_that_of_written_words(db: MotionDB) -> None:
    learned = db.searchable
    actual = find_written(learned)
    view = with_written(learned, actual, ["exhaust", "zwickel", "walk", "nowhere"])
    assert view.names[-2:] == ("exhaust", "zwickel")
    assert view.added == {"exhaust": 2, "zwickel": 1}
    column = view.numbers["exhaust"]
    names = {info.name: number for number, info in learned.captures.items()}
    for name, value in (("ana/walk_1", WRITTEN), ("chidi/walk_1", UNWRITTEN)):
        written = view.evidence.written.get(names[name])
        assert written is not None
        np.testing.assert_array_equal(written[:, column], value)
    for capture, odds in learned.evidence.odds.items():
        np.testing.assert_array_equal(view.evidence.odds[capture][:, : odds.shape[1]], odds)
    assert with_written(learned, actual, ["walk", "nowhere"]).columns is None


def test_a_filter_takes_words_that_nothing_holds(db: MotionDB) -> None:
    assert db.captures("style=energetic", exact=True) == []
    taken = db.captures.taken_in_filter("style=fatigued or caption~stroll")
    assert taken["stroll"].words[0][0] == "walk"
    strolls = {i.name for i in db.captures("caption~stroll")}
    assert strolls == {i.name for i in db.captures("caption~walk")}
    assert strolls
    assert db.captures("caption~stroll", exact=True) == []
    everything = len(db.captures())
    assert len(db.captures("not caption~stroll")) == everything
    assert len(db.captures("caption!~stroll")) == everything
    assert db.captures.taken_in_filter("caption~walk and performer=ana") == {}
    assert db.captures.taken_in_filter("name~stroll") == {}
    both = {i.name for i in db.captures("caption~stroll and performer=ana")}
    assert both == {i.name for i in db.captures("caption~walk and performer=ana")}


def test_english_words_get_no_hints_of_spelling(db: MotionDB) -> None:
    with pytest.raises(QueryError) as exact:
        db.search("stroll", exact=True)
    assert "Perhaps" not in str(exact.value)
    with pytest.raises(QueryError, match=r"Perhaps walk\."):
        db.search("wakl", exact=True)
    answer = db.search("walk, stroll", limit=1, exact=True)
    assert answer.unknown == {"stroll": ()}
    assert [left.reason for left in answer.not_used] == ["not in the captions"]


def test_exact_generation_leaves_out_what_it_would_take(db: MotionDB) -> None:
    made = db.generate("a person strolls", seed=1)
    assert made.actions == (("walk",),)
    assert list(made.taken) == ["stroll"]
    with pytest.raises(QueryError, match="in the captions, found 'stroll'"):
        db.generate("a person strolls", seed=1, exact=True)
    with pytest.raises(QueryError, match="found 'stroll', which nothing in the database shows"):
        db.generate("a person strolls, then kicks", seed=1, exact=True)
    exact = db.generate("a person strolls, then kicks", seed=1, exact=True, anyway=True)
    assert ("kick",) in exact.actions
    assert exact.taken == {}
    assert list(exact.unknown) == ["stroll"]


def test_commands_say_where_words_are_written(db: MotionDB, command: Any) -> None:
    path = str(db.store.path)
    db.close()
    ended = command("search", "an exhausted walk", "--limit", 2, "--db", path)
    assert "'exhaust' was not learned; found where it is written: style=exhausted (2 captures)" in (
        ended.err
    )
    facts = json.loads(command("search", "exhausted walk", "--json", "--db", path).out)
    assert facts["written"][0]["tags"] == ["style=exhausted"]
    listed = command("list", "--where", "caption~stroll", "--db", path)
    assert "filter: 'stroll' is not there; replaced by walk (" in listed.err
    exact = command("list", "--where", "caption~stroll", "--exact", "--db", path)
    assert (exact.err, exact.out.splitlines()[-1]) == ("", "0 captures")
