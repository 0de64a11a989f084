"""Wrong use and wrong data: a sentence on standard error, 2 or 1, and nothing changed."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest


@pytest.mark.parametrize(
    "words",
    [
        ("search", "walk"), ("like", "a"), ("describe", "a"), ("learn",), ("list",), ("info",),
        ("check",), ("compact",), ("remove", "a"), ("export", "a", "-o", "a.bvh"),
        ("words",), ("words", "set", "a", "b"), ("generate", "walk", "-o", "a.bvh"), ("symbols",),
    ],
)  # fmt: skip
def test_a_missing_database_is_not_made(command: Any, words: tuple[str, ...]) -> None:
    ended = command(*words)
    assert (ended.code, ended.out) == (1, "")
    assert ended.err.splitlines()[-1] == (
        "error: motions.duckdb: expected a database of motiondb, found no such file. "
        "Make one: motiondb add FOLDER --db motions.duckdb."
    )
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("search", "the of"), "expected words that describe a motion"),
        (("like", "ana/bow1"), "Did you mean ana/bow_1"),
        (("list", "--where", "bad"), "expected NAME OPERATOR VALUE"),
        (("show", "nobody"), "expected the name of a capture"),
        (
            ("show", "ana/bow_1", "--png", "p.xyz"),
            "expected a name that ends in .png, found '.xyz'",
        ),
        (("describe", "nix.bvh"), "'nix.bvh': expected a file or the name of a capture, found no"),
        (("generate", "walk"), "Missing option"),
        (("bogus",), "No such command 'bogus'"),
        (("list", "--db", ""), ".: expected a database of motiondb, found a folder"),
        (("add", ".", "--db", "."), ".: expected a database of motiondb, found a folder"),
        (("check", "--db", "/"), "/: expected a database of motiondb, found a folder"),
    ],
)
def test_wrong_use_ends_with_two(
    command: Any, learned_file: Path, monkeypatch: pytest.MonkeyPatch, words: Any, sentence: str
) -> None:
    monkeypatch.setenv("MOTIONDB", str(learned_file))
    ended = command(*words)
    assert ended.code == 2
    assert sentence in ended.err
    assert "Traceback" not in ended.err
    assert list(Path().iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_what_is_no_file_is_named_and_leaves_nothing(command: Any, learned_file: Path) -> None:
    os.mkfifo("pipe")
    for words, says in (
        (("add", "pipe"), "pipe: expected a capture or a folder of captures, found a pipe; save"),
        (("add", "n" * 300), "expected a capture or a folder of captures, found nothing."),
    ):
        assert says in command(*words, "--db", "new.duckdb").err
        assert not Path("new.duckdb").exists()
    for words, says in (
        (("like", "pipe"), "'pipe': expected a file or the name of a capture, found a pipe; save"),
        (("describe", "."), "'.': expected a file or the name of a capture, found a folder;"),
        (("like", "ana/walk_1", "--from", "2", "--to", "1"), "and the end comes after the start."),
    ):
        assert says in command(*words, "--db", learned_file).err


def test_terms_without_an_answer_are_not_accepted(
    command: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    ended = command("fetch", "cmu", "--subjects", "14")
    assert (ended.code, "found no answer. Accept them with --yes." in ended.err) == (2, True)


def test_wrong_data_ends_with_one(command: Any, some: Path) -> None:
    Path("empty.tsv").touch()
    for words, sentence in {
        ("add", some, "--words", "empty.tsv"): "expected a header with a column `file`",
        ("add", some, "--words", "none.tsv"): "none.tsv: expected a readable sheet",
        ("add", "nowhere"): "nowhere: expected a capture or a folder of captures, found nothing",
        ("add", some, "--db", "no/such.duckdb"): "Make the folder first",
    }.items():
        ended = command(*words)
        assert ended.code == 1
        assert sentence in ended.err


def test_help_and_version() -> None:
    program = shutil.which("motiondb", path=str(Path(sys.executable).parent))
    assert program is not None
    told = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=60)
    assert told.returncode == 0
    for name in ("add", "learn", "search", "like", "describe", "generate", "words", "compact"):
        assert f"  {name} " in told.stdout
    told = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60)
    assert told.stdout == "motiondb 0.1.0\n"


LONG = "n" * 300


@pytest.mark.parametrize(
    "words",
    [
        ("like", LONG), ("describe", LONG), ("add", LONG, "--db", "new.duckdb"),
        ("scene", "report", LONG), ("scene", "grammar", "check", LONG),
        ("scene", "validate", LONG, "run"), ("symbols", "--png", f"{LONG}.png"),
        ("list", "--db", LONG), ("rescue", "x.duckdb", "-o", LONG),
    ],
    ids=lambda words: words[0],
)  # fmt: skip
def test_names_that_are_too_long_for_files_are_refused(
    command: Any, learned_file: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MOTIONDB", str(learned_file))
    ended = command(*words)
    assert ended.code in (1, 2)
    assert ended.err.lstrip().startswith("error: ")


PROGRAM = [sys.executable, "-c", "from motiondb.cli.main import main; main()"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="output that is always full")
def test_output_that_is_full_is_told(learned_file: Path) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [*PROGRAM, "list", "--db", str(learned_file)],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert ended.returncode == 1
    assert ended.stderr == (
        "error: output: expected to write all of it, found: no space left on device.\n"
    )
