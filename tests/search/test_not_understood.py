"""Questions of which a head is not understood, and words that are written otherwise."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb.answers.questions import search_answer
from motiondb.language.vocabulary import written_otherwise
from motiondb.search.takings import Sentence


@pytest.mark.parametrize(
    ("text", "known", "becomes"),
    [
        ("brake-dancing", "break dance", "break dancing"),
        ("breakdances", "break dance", "break dances"),
        ("a somersault", "forward roll", "a forward roll"),
        ("forward rolls", "forward somersault", "somersault"),
        ("idles", "stand still", "stand still"),
        ("karate, then idle", "martial art", "martial art, then idle"),
        ("handstands", "hand stand", "hand stand"),
        ("side-step", "sidestep", "sidestep"),
        ("side step", "side step sidestep", "side step"),
        ("understand", "under stand", "understand"),
    ],
)
def test_words_written_otherwise(text: str, known: str, becomes: str) -> None:
    assert written_otherwise(text, set(known.split()))[0] == becomes


def test_a_word_without_end_is_not_cut_at_every_letter() -> None:
    class Counted(frozenset[str]):
        asked = 0

        def __contains__(self, word: object) -> bool:
            self.asked += 1
            return super().__contains__(word)

    known = Counted({"hand", "stand"})
    assert written_otherwise("w" * 3000, known)[0] == "w" * 3000
    assert known.asked < 100


def test_a_compound_is_written_apart_only_where_captions_say_it_of_one_action() -> None:
    known = {"push", "up", "jump"}
    assert written_otherwise("push-ups", known)[0] == "push up"
    assert written_otherwise("push-ups", known, together=lambda words: False)[0] == "pushup"


def test_the_rest_of_a_question_carries_no_probability(db: motiondb.MotionDB) -> None:
    answer = db.search("crawling to a chair", limit=3)
    assert answer.missing == ("crawling",)
    assert answer.not_understood == (
        "not understood: 'crawling'; these are answers for 'chair' alone"
    )
    assert answer.matches_anything is None
    chances = [part for match in answer.matches for part in (match, *match.parts)]
    assert chances
    assert {one.probability for one in chances} == {None}
    assert {one.interval_probability for one in chances} == {None}
    told = search_answer(answer)
    assert (told.missing, told.sentences[0]) == (("crawling",), answer.not_understood)


@pytest.mark.parametrize("question", ["sewing on hands", "sew backward", "sew, both arms"])
def test_parts_of_the_body_and_directions_are_no_rest(db: motiondb.MotionDB, question: str) -> None:
    with pytest.raises(motiondb.UnknownWordsError, match="found 'sew'"):
        db.search(question)


def test_the_rest_of_a_question_is_answered_as_it_was_asked(
    db: motiondb.MotionDB, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing shows it; near words stand only in place of a question that is understood."""
    monkeypatch.setattr(
        "motiondb.search.asking.near_sentence", lambda asked, _: Sentence(asked.learned, "kick")
    )
    assert db.search("hold the chair up", limit=1).near == ("hold chair up", "kick")
    answer = db.search("hold the chair up, then sew", limit=1)
    assert (answer.missing, answer.near) == (("sew",), ())
    assert answer.question.understood == "hold chair up"


def test_a_word_that_names_no_action_may_be_missing(db: motiondb.MotionDB) -> None:
    answer = db.search("zombie walk", limit=1)
    assert (answer.missing, answer.unknown) == ((), {"zombie": ()})
    walking = db.search("walk", limit=1).matches[0]
    assert (answer.matches[0].capture, walking.probability is None) == (walking.capture, False)
    assert answer.matches[0].probability is None  # how probably a walk is a zombie's is not known


def test_what_is_missing_stands_first_and_without_scores(command: Any, learned_file: Path) -> None:
    told = command("search", "crawling to a chair", "--limit", 1, "--db", learned_file).out
    lines = told.split("\n")
    assert lines[0] == "not understood: 'crawling'; these are answers for 'chair' alone"
    assert "score" not in lines[2]
    assert lines[-2] == "(-: no reliable probability for this kind of question)"


@pytest.mark.parametrize(
    ("sentence", "why_not"),
    [
        ("crawl to a ball", "not understood: 'crawl'"),
        ("zombie walk", "not sure: zombie (not in the captions)"),
        (
            "stroll",
            "not sure: walk (for stroll) ('stroll' is not in the captions; replaced by walk (",
        ),
    ],
)
def test_a_motion_of_the_rest_is_not_called_shown(
    db: motiondb.MotionDB, sentence: str, why_not: str
) -> None:
    made = db.generate(sentence)
    assert made.why_not.startswith(why_not)
    assert not made.shows_all
    assert db.generate("walk").why_not == ""


def test_a_word_heard_by_its_meaning_ranks_without_a_probability(db: motiondb.MotionDB) -> None:
    answer = db.search("stretch", limit=3)
    (heard,) = answer.taken.values()
    assert heard.heard == ("bend", "jog", "sway")
    assert sum(heard.shares) == pytest.approx(1.0)
    assert heard.sentence() == (
        "'stretch' is not in the captions; ranked by meaning; nearest known words: bend, jog, sway"
    )
    assert (answer.missing, answer.matches_anything) == ((), None)
    assert answer.unchecked == "no probabilities: no caption of this database holds 'stretch'"
    chances = [part.probability for match in answer.matches for part in (match, *match.parts)]
    assert set(chances) == {None}
    assert db.search("stretch", limit=1, where="caption~bend").matches


def test_a_limb_that_is_not_the_verbs_is_left_out_and_told(db: motiondb.MotionDB) -> None:
    """The hand of a wave makes no kick."""
    answer = db.search("kicks with the hand", limit=5)
    assert answer.left == ("hand",)
    assert answer.remarks == ("neither said with its action nor measured: hand",)
    assert {match.probability for match in answer.matches} == {None}
