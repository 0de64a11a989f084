"""Questions in words that no caption holds, asked of the sample database."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.database.loading import nearby_table
from motiondb.errors import QueryError
from motiondb.search.asked_words import learned_words, with_replaced
from motiondb.search.takings import Sentence, Taking, unknown_words, with_likeliest

TAKING = Taking("strolls", (("walk", 0.8), ("step", 0.4)))


def test_the_log_odds_of_a_taken_word_are_the_mean_of_its_words(db: motiondb.MotionDB) -> None:
    learned = db.searchable
    view = with_replaced(learned_words(learned), {"stroll": TAKING})
    walk, step = learned.word_numbers["walk"], learned.word_numbers["step"]
    stroll = view.numbers["stroll"]
    assert stroll == len(learned.association.words)
    assert list(view.added) == ["stroll"]
    for capture, take in view.evidence.takes.items():
        before = learned.evidence.takes[capture]
        for had, has in ((before.windows, take.windows), (before.whole[None], take.whole[None])):
            np.testing.assert_array_equal(has[:, :-1], had)
        odds = learned.evidence.odds[capture]
        np.testing.assert_allclose(
            view.evidence.odds[capture][:, stroll], (2 * odds[:, walk] + odds[:, step]) / 3
        )


def test_a_replaced_word_ranks_as_the_known_one_without_a_probability(
    db: motiondb.MotionDB,
) -> None:
    """Who walks may not stroll."""
    learned = db.searchable
    view = with_replaced(learned_words(learned), {"zork": Taking("zork", (("kick", 0.6),))})
    np.testing.assert_allclose(
        [take.whole[-1] for take in view.evidence.takes.values()],
        [take.whole[learned.word_numbers["kick"]] for take in learned.evidence.takes.values()],
    )
    taken, known = db.search("stroll", limit=5), db.search("walk", limit=5)
    assert taken.taken["stroll"].is_other
    if taken.taken["stroll"].shares == (1.0,):
        assert [m.capture for m in taken.matches] == [m.capture for m in known.matches]
    assert {(m.probability, m.interval_probability) for m in taken.matches} == {(None, None)}
    assert (known.matches_anything, taken.matches_anything, taken.nothing) == (True, None, "")
    order = db.search("stroll, kick", limit=1)
    stroll, kick = order.matches[0].parts
    assert stroll.probability is None
    assert kick.probability is not None


def test_exact_leaves_words_out(db: motiondb.MotionDB) -> None:
    answer = db.search("stroll, kick", limit=3, exact=True)
    assert answer.taken == {}
    assert answer.actions == (("kick",),)
    assert "stroll" in answer.unknown
    with pytest.raises(QueryError, match="in the captions, found 'stroll'"):
        db.search("stroll", exact=True)


def test_what_is_not_taken_is_left_out_and_named(db: motiondb.MotionDB) -> None:
    answer = db.search("mortgage, wlak, kick", limit=1)
    assert answer.actions == (("kick",),)
    assert answer.unknown == {"mortgage": (), "wlak": ("walk",)}
    assert answer.taken == {}


def test_the_users_synonyms_win(learned_copy: Path, tmp_path: Path) -> None:
    (tmp_path / "synonyms.txt").write_text("stroll = kick\n")
    with motiondb.open(learned_copy) as opened:
        before = opened.search("stroll", limit=1)
        assert "stroll" in before.taken
        opened.set_synonyms(tmp_path / "synonyms.txt")
        after = opened.search("stroll", limit=3)
        assert after.taken == {}
        assert after.actions == (("kick",),)


def test_what_is_known_is_not_replaced(db: motiondb.MotionDB) -> None:
    takings = unknown_words(Sentence(db.searchable, "walk, kick"), nearby_table())
    assert takings == {}
    assert with_replaced(learned_words(db.searchable), takings).columns is None


def test_for_one_sequence_the_likeliest_word_is_read(db: motiondb.MotionDB) -> None:
    takings = unknown_words(Sentence(db.searchable, "strolling"), nearby_table())
    assert takings["stroll"].word == "strolling"
    assert with_likeliest(db.searchable, takings).synonyms["stroll"] == "walk"
    answer = db.search("stroll", limit=1, by_symbols=True)
    assert answer.actions == (("walk",),)
