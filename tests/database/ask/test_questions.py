"""Questions with not, or, counts and lengths, asked of the sample data."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

import motiondb
from motiondb.cli.main import app
from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.language.question.readings import readings, say
from motiondb.meaning import by_question
from motiondb.search import reasons

QUESTIONS = (
    "walk but not turn", "not walking", "kick or punch", "walk and kick", "walk twice",
    "walk for 4 s, not sit", "wave while walking", "walk slowly", "walk, then not (turn and sit)",
    "not walk, not turn",
)  # fmt: skip


@pytest.fixture(scope="module")
def asked(learned_file: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_file, read_only=True) as opened:
        yield opened


@pytest.mark.parametrize("question", QUESTIONS)
def test_reasons_of_any_question_sum_to_what_ranks(asked: MotionDB, question: str) -> None:
    answer = asked.search(question, limit=30)
    learned = asked.learned
    number = {word: n for n, word in enumerate(learned.association.words)}
    read, _ = readings(answer.question.tree)
    ids = {info.name: capture for capture, info in learned.captures.items()}
    assert answer.matches
    for match, why in zip(answer.matches, answer.reasons):
        hit = by_question.search_take(learned.evidence.takes[ids[match.capture]], read, number)
        assert hit is not None
        assert math.isclose(reasons.total(why), hit.log_odds, rel_tol=1e-9, abs_tol=1e-9)
    totals = [reasons.total(why) for why in answer.reasons]
    assert totals == sorted(totals, reverse=True)


def test_excluded_actions_are_not_in_the_first_answers(asked: MotionDB) -> None:
    said = {info.name: caption for info in asked.captures() for caption in
            [" ".join(c.words for c in asked.captions(info.name))]}  # fmt: skip
    walks = {name for name, text in said.items() if "walk" in text}
    turns = {name for name, text in said.items() if "turn" in text}
    assert walks & turns
    first = [m.capture for m in asked.search("walk but not turn", limit=5).matches]
    assert set(first) <= walks - turns
    assert not walks & {m.capture for m in asked.search("not walking", limit=20).matches}
    lowest = asked.search("walk but not turn", limit=200)
    plain = {m.capture: m.score for m in asked.search("walk", limit=200).matches}
    assert all(match.score <= plain[match.capture] + 1e-12 for match in lowest.matches)


def test_alternatives_are_found_each_by_itself(asked: MotionDB) -> None:
    either = [(m.capture, m.score) for m in asked.search("kick or punch", limit=200).matches]
    kick = {m.capture: m.score for m in asked.search("kick", limit=200).matches}
    punch = {m.capture: m.score for m in asked.search("punch", limit=200).matches}
    for capture, score in either:
        assert score == pytest.approx(max(kick[capture], punch[capture]), rel=1e-12)


def test_only_measured_kinds_of_questions_have_a_probability(asked: MotionDB) -> None:
    answer = asked.search("walk twice")
    assert {match.probability for match in answer.matches} == {None}
    assert [left.text for left in answer.not_used] == ["at most 2 times"]
    longest = asked.search("walk for at least 4 s")
    assert all(match.end - match.start >= 4.0 - 1e-6 for match in longest.matches)
    assert asked.search("walk for at least 10 minutes").matches == ()
    unmeasured = (
        "walk, then (kick or punch)", "walk but not turn or run", "walk then run, but not turn",
        "(walk but not turn) or kick",
    )  # fmt: skip
    for text in unmeasured:
        for match in asked.search(text).matches:
            assert match.probability is match.interval_probability is None
            assert {part.probability for part in match.parts} == {None}
    for text in ("walk", "walk, then sit", "not walking", "kick or punch"):
        assert None not in {match.probability for match in asked.search(text).matches}


def test_nothing_matches_where_what_is_asked_is_excluded(asked: MotionDB) -> None:
    assert asked.search("kick").matches_anything
    assert asked.search("kick, not kick").matches_anything is False
    assert asked.search("not kick").matches_anything


def test_a_word_that_is_like_none_is_left_out_beside_a_known_one(asked: MotionDB) -> None:
    answer = asked.search("xqzzyqv and walk")
    assert [(left.text, left.reason) for left in answer.not_used] == [
        ("xqzzyqv", "no caption says it")
    ]
    assert answer.matches[0].capture == asked.search("walk").matches[0].capture


def test_question_stands_in_json_and_above_the_answers(learned_file: Path) -> None:
    command = ["search", "wlak or walk for 2 s but not turning", "--limit", "2", "--explain"]
    ended = CliRunner().invoke(app, [*command, "--json", "--db", str(learned_file)])
    assert ended.exit_code == 0
    facts = json.loads(ended.stdout)
    assert facts["question"]["understood"] == "(walk for 2 s), not turn"
    assert facts["question"]["tree"]["kind"] == "without"
    assert facts["question"]["not_used"] == [
        {"text": "wlak", "reason": "no caption says it; the nearest known: walk"},
        {"text": "for at most 2 s", "reason": "search cannot tell that it ends by then"},
    ]
    for row in facts["matches"]:
        why = row["explain"]
        parts = [
            part
            for word in why["words"]
            for part in (word["prior"], word["written"], *(s["share"] for s in word["symbols"]))
        ]
        amounts = [one["amount"] for one in why["excluded"]]
        assert [w["word"] for one in why["excluded"] for w in one["words"]] == ["turn"]
        assert amounts[0] < 0
        assert math.fsum([*parts, why["together"], *amounts]) == why["log_odds"]
    ended = CliRunner().invoke(app, [*command, "--db", str(learned_file)])
    lines = ended.stdout.splitlines()
    assert lines[:2] == [
        "understood: (walk for 2 s), not turn",
        "'for at most 2 s' is not used in search: search cannot tell that it ends by then",
    ]
    assert any(line.startswith("    not turn: -") for line in lines)


def test_generation_honours_alternatives_and_exclusions(asked: MotionDB) -> None:
    made = asked.generate("walk or run, not kick", seed=1)
    assert made.actions in ((("walk",),), (("run",),))
    assert say(made.question.tree) == "(walk or run), not kick"
    assert made.not_used == ()
    assert "was drawn; another seed may draw" in made.decided[0]
    for source in made.provenance.sources:
        assert "kick" not in " ".join(c.words for c in asked.captions(source.name))
    with pytest.raises(QueryError) as error:
        asked.generate("not walking")
    assert str(error.value) == (
        "generate: expected an action to show, found only what not to show in 'not walking'. "
        "Say what the motion is to show."
    )


def test_search_by_symbols_names_what_it_leaves_out(asked: MotionDB) -> None:
    answer = asked.search("walk, not kick", by_symbols=True)
    assert [left.text for left in answer.not_used] == ["not kick"]


@pytest.mark.parametrize("text", ["walk " * 3_000, "walk, " * 800, "jump 5000 times"])
def test_questions_that_are_too_long_are_refused(asked: MotionDB, text: str) -> None:
    for verb in (asked.search, asked.generate):
        with pytest.raises(QueryError, match=r"question: expected at most [\d,]+ "):
            verb(text)
