"""Wrong use and wrong data: a sentence on standard error, 2 or 1, and nothing changed."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import duckdb
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


def test_questions_before_learning(command: Any, some: Path) -> None:
    command("add", some)
    ended = command("search", "walk")
    assert ended.code == 2
    assert ended.err == (
        "error: motions.duckdb: expected a database that has learned, found only captures. "
        "Run motiondb learn first.\n"
    )


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("search", ""), "expected words, found an empty question"),
        (("search", "the of"), "expected words that describe a motion"),
        (("like", "ana/bow1"), "Did you mean ana/bow_1"),
        (("like", "ana/bow_1", "--from", "40"), "expected an interval within 0 to 2.70 s"),
        (("list", "--where", "performr=x"), "Did you mean performer?"),
        (("list", "--where", "bad"), "expected NAME OPERATOR VALUE"),
        (("show", "nobody"), "expected the name of a capture"),
        (("generate", "walk", "-o", "a.txt"), "expected an ending .bvh, .glb or .gltf"),
        (("generate", "walk", "-o", "a.bvh", "--method", "x"), "expected one of stitched"),
        (("generate", "walk"), "Missing option"),
        (("search", "walk", "--limit", "0"), "--limit"),
        (("bogus",), "No such command 'bogus'"),
        (("list", "--db", ""), ".: expected a database of motiondb, found a folder"),
        (("add", ".", "--db", "."), ".: expected a database of motiondb, found a folder"),
        (("check", "--db", "/"), "/: expected a database of motiondb, found a folder"),
        (("search",), "Missing argument"),
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


def test_another_file_and_a_newer_database(command: Any, some: Path, tmp_path: Path) -> None:
    Path("text.duckdb").write_text("no database" * 1000)
    ended = command("list", "--db", "text.duckdb")
    assert ended.code == 1
    assert "text.duckdb: expected a database of motiondb, found another kind of file" in ended.err
    command("add", some)
    with duckdb.connect("motions.duckdb") as connection:
        connection.execute("UPDATE meta SET value = '999' WHERE key = 'schema'")
    for words in (("list",), ("learn",), ("add", some), ("check",)):
        ended = command(*words)
        assert ended.code == 1
        assert "newer" in ended.err
        assert "Traceback" not in ended.err


HOLD = "import sys, motiondb\nwith motiondb.open(sys.argv[1]): print(1, flush=True); input()"


def test_a_second_process_hears_who_holds_the_file(command: Any, learned_copy: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(learned_copy)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as holder:  # fmt: skip
        assert holder.stdin is not None
        assert holder.stdout is not None
        holder.stdout.readline()
        for words in (("search", "walk"), ("learn",), ("remove", "ana/bow_1")):
            ended = command(*words, "--db", learned_copy)
            assert ended.code == 1
            assert f"found it held by process {holder.pid} (" in ended.err
            assert "Wait until it has ended, or wait longer with --wait SECONDS." in ended.err
        holder.stdin.write("\n")
        holder.stdin.flush()
        holder.wait(20)
    assert command("search", "walk", "--db", learned_copy).code == 0


def test_several_may_ask_at_once(command: Any, learned_copy: Path) -> None:
    program = HOLD.replace("argv[1]", "argv[1], read_only=True")
    with subprocess.Popen(
        [sys.executable, "-c", program, str(learned_copy)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as reader:  # fmt: skip
        assert reader.stdout is not None
        reader.stdout.readline()
        assert command("search", "walk", "--db", learned_copy).code == 0
        reader.communicate("\n", timeout=20)


def test_help_and_version() -> None:
    program = shutil.which("motiondb", path=str(Path(sys.executable).parent))
    assert program is not None
    told = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=60)
    assert told.returncode == 0
    for name in ("add", "learn", "search", "like", "describe", "generate", "words", "compact"):
        assert f"  {name} " in told.stdout
    told = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60)
    assert told.stdout == "motiondb 0.1.0\n"
