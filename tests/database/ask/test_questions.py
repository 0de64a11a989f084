"""Questions with not, or, counts and lengths, asked of the sample data."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextvars import copy_context
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import motiondb
from motiondb.cli.main import make_app
from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.language.question.heads import verbs_in
from motiondb.language.question.readings import is_order, readings, say
from motiondb.meaning import by_question
from motiondb.meaning.occurrences import find_occurrences, measured_track
from motiondb.search import reasons
from motiondb.search.asked_words import learned_words, without_words_apart

QUESTIONS = (
    "walk but not turn", "not walking", "kick or punch", "walk and kick", "walk twice",
    "walk for 4 s, not sit", "wave while walking", "walk slowly", "walk, then not (turn and sit)",
    "not walk, not turn", "walk, turn left, sit down", "walk, ?, wave",
)  # fmt: skip


@pytest.mark.parametrize("question", QUESTIONS)
def test_reasons_of_any_question_sum_to_what_ranks(db: MotionDB, question: str) -> None:
    answer = db.search(question, limit=30)
    learned = db.learned
    number = {word: n for n, word in enumerate(learned.association.words)}
    read, _ = readings(answer.question.tree)
    verbs = verbs_in(question)
    evidence = without_words_apart(learned_words(learned), read, verbs).evidence
    ids = {info.name: capture for capture, info in learned.captures.items()}
    assert answer.matches
    for match, why in zip(answer.matches, answer.reasons):
        take = evidence.takes[ids[match.capture]]
        hit = by_question.search_take(take, read, number)
        assert hit is not None
        assert math.isclose(reasons.total(why), hit.log_odds, rel_tol=1e-9, abs_tol=1e-9)
    is_plain = len(read) > 1 or not is_order(read[0])
    ranks = [  # of an order, probable answers come first; what the motion contradicts comes last
        (bool(m.contradicted), not (is_plain or (m.probability or 0.0) >= 0.5))
        for m in answer.matches
    ]
    totals = [reasons.total(why) for why in answer.reasons]
    placed = [(*rank, -total) for rank, total in zip(ranks, totals)]
    assert answer.measured or placed == sorted(placed)  # "slowly" orders answers by their speed


@pytest.mark.parametrize("question", ["kick", "walk, sit"])
def test_answers_by_symbols_have_the_probability_of_their_words(
    db: MotionDB, question: str
) -> None:
    in_words = {m.capture: m.probability for m in db.search(question, limit=200).matches}
    matches = db.search(question, by_symbols=True, limit=200).matches
    assert {m.capture: m.probability for m in matches}.items() <= in_words.items()
    known = [p for p in in_words.values() if p is not None]
    scores = [match.score for match in matches]
    assert scores == sorted(scores, reverse=True)
    for match in matches:
        similarity = float(match.reason.partition("similarity ")[2].partition(";")[0])
        chance = min(known) if match.probability is None else match.probability
        assert match.score == pytest.approx(similarity * chance, abs=0.006)


def test_answers_to_an_example_fall_and_tell_the_example_itself(db: MotionDB) -> None:
    name = db.captures()[0].name
    answer = db.like(name, limit=8)
    assert [bool(match.reason) for match in answer] == [match.capture == name for match in answer]
    assert answer[0].reason == "the same motion"
    chances = [match.probability or 0.0 for match in answer]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] > chances[-1]


def test_excluded_actions_are_not_in_the_first_answers(db: MotionDB) -> None:
    said = {info.name: caption for info in db.captures() for caption in
            [" ".join(c.words for c in db.captions(info.name))]}  # fmt: skip
    walks = {name for name, text in said.items() if "walk" in text}
    turns = {name for name, text in said.items() if "turn" in text}
    assert walks & turns
    first = [m.capture for m in db.search("walk but not turn", limit=5).matches]
    assert set(first) <= walks - turns
    assert not walks & {m.capture for m in db.search("not walking", limit=20).matches}
    lowest = db.search("walk but not turn", limit=200)
    plain = {m.capture: m.score for m in db.search("walk", limit=200).matches}
    assert all(match.score <= plain[match.capture] + 1e-12 for match in lowest.matches)


def test_only_measured_kinds_of_questions_have_a_probability(db: MotionDB) -> None:
    assert [left.text for left in db.search("walk twice").not_used] == ["at most 2 times"]
    longest = db.search("walk for at least 4 s")
    assert all(match.end - match.start >= 4.0 - 1e-6 for match in longest.matches)
    assert db.search("walk for at least 10 minutes").matches == ()
    for text in (
        "walk, then (kick or punch)", "walk then run, but not turn", "walk twice", "walk for 2 s"
    ):  # fmt: skip
        for match in db.search(text).matches:
            assert match.probability is match.interval_probability is None
            assert {part.probability for part in match.parts} == {None}
    for text in ("walk", "not walking", "kick or punch"):
        assert None not in {match.probability for match in db.search(text).matches}
    for match in db.search("walk, then sit").matches:
        assert (match.probability is None) == match.reason.endswith("; not seen in this order")


def test_a_posture_that_no_caption_says_is_seen_in_the_motion(db: MotionDB) -> None:
    answer = db.search("both arms above the head", limit=3)
    assert answer.measured == ("hold both hands overhead",)
    shown = [match for match in answer.matches if not match.contradicted]
    assert shown
    for match in shown:
        track = measured_track(db.motion(match.capture))
        assert match.probability is None
        assert (round(match.start * 30), round(match.end * 30)) in find_occurrences(
            track, "overhead both"
        )
    lying = db.search("lying on the floor", limit=3)
    assert lying.nothing == "probably nothing in this database matches"
    assert all(match.contradicted == ("does not lie",) for match in lying.matches)


def test_counts_and_durations_do_not_decide_whether_anything_matches(db: MotionDB) -> None:
    """How often an action is shown was never measured; whether it is was."""
    once = db.search("kick")
    for text in ("kick 7 times", "kick for at least 3 s"):
        counted = db.search(text)
        assert (counted.strength, counted.matches_anything) == (once.strength, True)


def test_nothing_matches_where_what_is_asked_is_excluded(db: MotionDB) -> None:
    assert db.search("kick").matches_anything
    assert db.search("kick, not kick").matches_anything is False
    assert db.search("not kick").matches_anything


def test_question_stands_in_json_and_above_the_answers(learned_file: Path, tmp_path: Path) -> None:
    asked = ["search", "wlak or walk for 2 s but not turning", "--limit", "2", "--explain"]
    command = [*asked, "--png", str(tmp_path / "why.png"), "--db", str(learned_file)]
    ended = copy_context().run(CliRunner().invoke, make_app(), [*command, "--json"])
    assert ended.exit_code == 0
    facts = json.loads(ended.stdout)
    assert facts["question"]["understood"] == "(walk for 2 s), not turn"
    assert facts["question"]["tree"]["kind"] == "without"
    assert facts["question"]["not_used"] == [
        {"text": "wlak", "reason": "not in the captions; perhaps walk"},
        {"text": "for at most 2 s", "reason": "longer ones are shown, too"},
    ]
    assert {"words", "together", "excluded", "log_odds"} <= set(facts["matches"][0]["explain"])
    lines = copy_context().run(CliRunner().invoke, make_app(), command).stdout.splitlines()
    assert lines[:2] == [
        "read as: (walk for 2 s), not turn",
        "'for at most 2 s' is not used in search: longer ones are shown, too",
    ]
    assert any(line.startswith("    not turn: -") for line in lines)
    assert any(line.startswith("    walk: ") and " = usual " in line for line in lines)
    assert (tmp_path / "why.png").stat().st_size > 5_000


def test_generation_honours_alternatives_and_exclusions(db: MotionDB) -> None:
    made = db.generate("walk or run, not kick", seed=1)
    assert made.actions in ((("walk",),), (("run",),))
    assert say(made.question.tree) == "(walk or run), not kick"
    assert made.not_used == ()
    assert "was drawn; another seed may draw" in made.decided[0]
    for source in made.provenance.sources:
        assert "kick" not in " ".join(c.words for c in db.captions(source.name))
    with pytest.raises(QueryError) as error:
        db.generate("not walking")
    assert str(error.value) == (
        "generate: expected an action to show, found only what not to show in 'not walking'. "
        "Say what the motion is to show."
    )


@pytest.fixture
def writable(learned_copy: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_copy) as opened:
        yield opened


def test_a_kept_generated_capture_is_found_and_marked(writable: MotionDB) -> None:
    before = writable.like("goran/kick_1", limit=3)
    made = writable.generate("a person kicks", seed=3)
    writable.captures.save_generated("made/kick", "a person kicks", made, 3)
    nearest = writable.like("made/kick", limit=1)[0]
    assert (nearest.capture, nearest.reason) == ("made/kick", "the same motion; generated")
    assert {m.capture for m in writable.like("goran/kick_1", where="kind=captured", limit=3)} == {
        m.capture for m in before
    }
    actual = writable.search("kick", where="kind=generated").matches
    assert [m.capture for m in actual] == ["made/kick"]
    assert actual[0].reason.endswith("; generated")
    assert writable.search("kick", where="kind=captured", limit=1).matches[0].reason.endswith(" s")


def test_generated_captures_are_no_material(writable: MotionDB) -> None:
    made = writable.generate("a person kicks", seed=3)
    writable.captures.save_generated("made/kick", "a person kicks", made, 3)
    again = writable.generate("a person kicks", seed=3)
    np.testing.assert_array_equal(again.motion.local_rotations, made.motion.local_rotations)
    number = writable.captures("kind=generated")[0].capture_id
    assert number in writable.searchable.rows
    assert number not in writable.learned.rows
    assert (np.diff(writable.searchable.segments.capture_ids) >= 0).all()


def test_postures_are_measured_in_time_order_and_exclusion(db: MotionDB) -> None:
    lasting = db.search("raise both hands for a minute", limit=5)
    assert all("goes on for" in match.reason for match in lasting.matches)
    for question in ("not raise a hand", "walk without raising the arms"):
        first = db.search(question, limit=3).matches
        for match in (match for match in first if not match.contradicted):
            raised = find_occurrences(measured_track(db.motion(match.capture)), "raise")
            assert not any(a / 30 < match.end and b / 30 > match.start for a, b in raised)
    ordered = db.search("raise the left hand, then raise the right hand", limit=5)
    assert all(match.probability is None for match in ordered.matches if match.contradicted)


def test_walking_up_stairs_is_not_climbing_where_no_caption_climbs(db: MotionDB) -> None:
    assert "climb" not in db.learned.word_numbers
    assert db.search("walk up the stairs").matches
