"""The reason of a word search: exact, and the number that ranks."""

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

import motiondb
from motiondb.cli.main import app
from motiondb.meaning import by_question
from motiondb.search import reasons


@pytest.mark.parametrize("question", ["kick", "walk, turn left, sit down", "walk, ?, wave"])
def test_reasons_sum_to_the_searched_log_odds(learned_file: Path, question: str) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search(question, limit=30)
        learned = db.learned
        number = {word: n for n, word in enumerate(learned.association.words)}
        actions = [[number[w] for w in action] for action in answer.actions]
        ids = {info.name: capture for capture, info in learned.captures.items()}
        for match, why in zip(answer.matches, answer.reasons):
            hit = by_question.search_order(learned.evidence.takes[ids[match.capture]], actions)
            assert hit is not None
            assert math.isclose(reasons.total(why), hit.log_odds, rel_tol=1e-9, abs_tol=1e-9)
            probability = 1.0 / (1.0 + math.exp(-reasons.total(why)))
            assert math.isclose(match.score, probability, rel_tol=1e-14)
    totals = [reasons.total(why) for why in answer.reasons]
    assert totals == sorted(totals, reverse=True)


def test_explained_json_sums_to_its_log_odds(learned_file: Path) -> None:
    asked = ["search", "walk, sit down", "--explain", "--json", "--limit", "3"]
    result = CliRunner().invoke(app, [*asked, "--db", str(learned_file)])
    assert result.exit_code == 0
    for row in json.loads(result.stdout)["matches"]:
        words = row["explain"]["words"]
        parts = [
            part
            for word in words
            for part in (
                word["prior"],
                word["written"],
                *(share["share"] for share in word["symbols"]),
            )
        ]
        assert math.fsum([*parts, row["explain"]["together"]]) == row["explain"]["log_odds"]
        assert {word["word"] for word in words} == {"walk", "sit", "down"}


def test_explanation_reads_as_a_line_a_word(learned_file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "why.png"
    asked = ["search", "kick", "--explain", "--limit", "1", "--png", str(picture)]
    result = CliRunner().invoke(app, [*asked, "--db", str(learned_file)])
    assert result.exit_code == 0
    assert "    kick: " in result.stdout
    assert " = usual " in result.stdout
    assert picture.stat().st_size > 5_000
