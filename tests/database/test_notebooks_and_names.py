"""What a notebook needs of a database: pictures, parts, texts, lists of names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import Motion


def test_answers_are_short_and_pictures_show_themselves(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("kick")
        shown = [answer, db.like("goran/kick_1"), db.describe("ana/long_1"), db.captures()]
        shown += [db.generate("walk"), db.join(["ana/bow_1", "ana/run_1"]), db.symbols.rows()]
        assert max(len(repr(each).splitlines()) for each in shown) <= 12
        drawn = [db.captures.draw("ana/bow_1"), db.captures.draw_matches(answer)]
        drawn += [db.captures.draw_reasons(answer), db.symbols.draw()]
    assert {each._repr_png_()[1:4] for each in drawn} == {b"PNG"}


def test_frames_and_seconds_of_motions_and_clips(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        whole, part = db.clip("ana/bow_1"), db.clip("ana/bow_1", 0.5, 1.0)
        motion = db.motion("ana/bow_1")
    np.testing.assert_array_equal(part.local_rotations, whole[15:30].local_rotations)
    assert (motion[10:20].n_frames, motion[-3:].n_frames) == (10, 3)
    for wrong in (3, slice(0, 9, 2)):
        with pytest.raises(TypeError, match="expected consecutive frames"):
            motion[wrong]  # type: ignore[index]
    with pytest.raises(motiondb.QueryError, match=r"found none in 90:80"):
        motion[90:80]
    assert isinstance(motion[5:], Motion)


def test_texts_are_questions_too(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        found = list(db.ask_many(["kick", motiondb.Question("kick", limit=1)]))
        assert found[0].matches[:1] == found[1].matches
        with pytest.raises(motiondb.QueryError, match="questions: expected several texts"):
            list(db.ask_many("walk"))


def test_names_are_a_filter_wherever_one_goes(learned_copy: Path) -> None:
    names = ["goran/kick_1", "ana/bow_1"]
    with motiondb.open(learned_copy) as db:
        full = ["ana/bow_1", "goran/kick_1"]
        assert [info.name for info in db.captures(names)] == full
        assert db.captures([]) == []
        assert {m.capture for m in db.search("kick", names).matches} <= set(full)
        assert {m.capture for m in db.like("ana/run_1", where=names)} == set(full)
        (asked,) = db.ask_many([motiondb.Question("kick", where=names)])
        assert asked.matches == db.search("kick", names).matches
        assert db.captures.browse(names).total == 2
        assert db.tables.captures(names).num_rows == 2
        assert sorted(db.captures.set_tags({"room": "2"}, where=names)) == full
        with pytest.raises(motiondb.QueryError, match="learned from, found 2 that it has"):
            db.evaluate(names)
        with pytest.raises(motiondb.QueryError, match="expected the name of a capture"):
            db.captures(["nobody"])
