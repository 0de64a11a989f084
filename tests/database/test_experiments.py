"""Learn on some captures, judge on the others; results as tables."""

from __future__ import annotations

from pathlib import Path

import pytest

import motiondb
from motiondb import LearnSettings, QueryError


def test_only_captures_that_were_not_learned_from_judge_and_nothing_changes(
    some: Path, tmp_path: Path
) -> None:
    """The notebook `experiment` shows how well captures are found that were never learned from."""
    words = {
        "ana/bow_1": "bow",
        "ana/jump_1": "kick",
        "boris/kick_1": "kick",
        "boris/punch_1": "bow",
    }
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        for name, said in words.items():
            db.words.set(name, said)
        db.learn(LearnSettings(n_symbols=3), where="name~ana/")
        assert set(db.captures.unlearned()) == {"boris/kick_1", "boris/punch_1"}
        with pytest.raises(QueryError, match="that it has, such as ana/"):
            db.evaluate("name~ana/")
        with pytest.raises(QueryError, match="expected two or more captures with captions"):
            db.evaluate("name=boris/kick_1")
        before = db.revision()
        told = db.evaluate("name~boris/")
        assert db.revision() == before
    assert (told.learned_from, told.judged) == (2, 2)
    assert [(word.word, word.captures, word.chance) for word in told.words] == [
        ("bow", 1, 0.5),
        ("kick", 1, 0.5),
    ]


def test_a_database_as_arrow_tables(learned_file: Path) -> None:
    pytest.importorskip("pyarrow")
    with motiondb.open(learned_file, read_only=True) as db:
        tables = db.tables
        assert tables.captures("performer=ana")["tag.performer"].unique().to_pylist() == ["ana"]
        segments = tables.segments()
        assert segments.num_rows == sum(row.count for row in db.symbols.rows())
        assert tables.symbols()["count"].to_pylist() == [
            row.count for row in sorted(db.symbols.rows(), key=lambda row: row.symbol)
        ]
        kick = next(row for row in db.words.rows() if row.word == "kick")
        told = {
            (row["word"], row["symbol"]): row["probability"] for row in tables.words().to_pylist()
        }
        for symbol in kick.symbols:
            assert told["kick", symbol.symbol] == pytest.approx(symbol.probability)
        answer = db.search("kick", limit=3)
        assert tables.matches(answer)["capture"].to_pylist() == [m.capture for m in answer.matches]
        assert tables.captions().num_rows == sum(map(len, db.words.all_captions().values()))
