"""Names longer than a file system allows are refused by name, wherever a command takes one."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from motiondb.cli.main import app
from motiondb.errors import MotionDBError

LONG = "n" * 300


@pytest.mark.parametrize(
    "words",
    [
        ("like", LONG),
        ("describe", LONG),
        ("add", LONG),
        ("scene", "report", LONG),
        ("scene", "grammar", "check", LONG),
        ("scene", "validate", LONG, "run"),
        ("symbols", "--png", f"{LONG}.png"),
    ],
    ids=lambda words: " ".join(words[:-1]),
)
def test_long_names_are_refused(learned_file: Path, words: tuple[str, ...]) -> None:
    at = () if words[0] == "scene" and words[1] != "report" else ("--db", str(learned_file))
    if words[0] == "add":
        at = ("--db", str(learned_file.with_name("new.duckdb")))
    ended = CliRunner().invoke(app, [*words, *at])
    assert isinstance(ended.exception, (MotionDBError, SystemExit)), ended.exception
    assert ended.exit_code != 0


@pytest.mark.parametrize("how", ["--db", "-o"])
def test_databases_of_long_names_are_refused(learned_file: Path, how: str) -> None:
    words = ["list"] if how == "--db" else ["rescue", str(learned_file)]
    ended = CliRunner().invoke(app, [*words, how, LONG])
    assert isinstance(ended.exception, MotionDBError)
    assert "expected the name of a file, found: file name too long." in str(ended.exception)
