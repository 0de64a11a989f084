"""Learn on some captures, judge on the others; results as tables."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import motiondb
from motiondb import QueryError
from motiondb.answers.learning import Evaluation, Score


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Evaluation:
    path = shutil.copy(learned_file, tmp_path_factory.mktemp("held") / "m.duckdb")
    with motiondb.open(path) as db:
        where = "performer in (ana, boris, chidi)"
        db.learn(motiondb.LearnSettings(n_symbols=30), where=f"not {where}")
        assert set(db.unlearned()) == {info.name for info in db.captures(where)}
        with pytest.raises(QueryError, match="that it has, such as goran/"):
            db.evaluate("performer=goran")
        with pytest.raises(QueryError, match="expected two or more captures with captions"):
            db.evaluate("name=ana/bow_1")
        before = db.revision()
        told = db.evaluate(where)
        assert db.revision() == before
        return told


def test_answers_about_captures_never_learned_from_are_measured(report: Evaluation) -> None:
    scores = {(s.task, s.measure): s for s in report.scores}
    words = scores["words", "mean average precision"]
    assert words.questions == len(report.words) > 5
    assert words.value > 1.5 * words.chance
    assert scores["captions", "found first"].value > 2 * scores["captions", "found first"].chance
    assert scores["examples", "mean average precision"].value > 0.2
    overlap = scores["intervals", "mean overlap"]
    assert overlap.questions > 50  # of long takes
    assert 0.3 < overlap.value < 1.0
    assert isinstance(scores["descriptions", "recall of words"], Score)


def test_a_database_as_arrow_tables(learned_file: Path) -> None:
    pytest.importorskip("pyarrow")
    with motiondb.open(learned_file, read_only=True) as db:
        tables = db.tables
        assert tables.captures("performer=ana")["tag.performer"].unique().to_pylist() == ["ana"]
        segments = tables.segments()
        assert segments.num_rows == sum(row.count for row in db.symbol_rows())
        assert tables.symbols()["count"].to_pylist() == [
            row.count for row in sorted(db.symbol_rows(), key=lambda row: row.symbol)
        ]
        kick = next(row for row in db.word_rows() if row.word == "kick")
        told = {
            (row["word"], row["symbol"]): row["probability"] for row in tables.words().to_pylist()
        }
        for symbol in kick.symbols:
            assert told["kick", symbol.symbol] == pytest.approx(symbol.probability)
        answer = db.search("kick", limit=3)
        assert tables.matches(answer)["capture"].to_pylist() == [m.capture for m in answer.matches]
        assert tables.captions().num_rows == sum(map(len, db.all_captions().values()))
