"""Questions of users in SQL."""

from __future__ import annotations

from pathlib import Path

import pytest

import motiondb


def test_one_select_is_answered(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        columns, rows = db.tables.sql("SELECT name, fps FROM capture ORDER BY name LIMIT 1")
    assert (columns, rows) == (["name", "fps"], [("ana/bow_1", 30.0)])


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("SELECT * FROM read_csv('/etc/passwd')", "disabled by configuration"),
        ("SELECT * FROM '/etc/passwd.parquet'", "disabled by configuration"),
        ("SELECT * FROM glob('/etc/*')", "disabled by configuration"),
        ("COPY capture TO 'out.csv'", "expected one SELECT"),
        ("ATTACH 'other.duckdb'", "expected one SELECT"),
        ("SET enable_external_access = true", "expected one SELECT"),
        ("INSTALL httpfs", "expected one SELECT"),
        ("SELECT 1; DROP TABLE capture", "expected one SELECT"),
        ("", "expected one SELECT"),
        ("SELECT nme FROM capture", 'Referenced column "nme" not found'),
        ("SELEC", "syntax error"),
    ],
)
def test_nothing_else_is_read_or_changed(query: str, said: str, learned_file: Path) -> None:
    with (
        motiondb.open(learned_file, read_only=True) as db,
        pytest.raises(motiondb.QueryError, match=said),
    ):
        db.tables.sql(query)


def test_a_database_that_may_write_is_not_asked(learned_copy: Path) -> None:
    with (
        motiondb.open(learned_copy) as db,
        pytest.raises(motiondb.QueryError, match="opened to read only"),
    ):
        db.tables.sql("SELECT 1")
