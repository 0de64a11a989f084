"""What commands print and write: nothing that a terminal obeys, no file of others overwritten."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import unicodedata
from pathlib import Path
from typing import Any

import pytest
import typer

import motiondb
from motiondb.cli import printing
from motiondb.cli.main import COMMANDS, make_app

PROGRAM = [sys.executable, "-c", "from motiondb.cli.main import main; main()"]


HOSTILE = "bow \x1b]0;title\x07 \x9b2J\x7f\u202e\u2028 caf\u00e9 \u4e2d\nnext"


def test_control_characters_are_printed_as_escapes(command: Any, some: Path) -> None:
    Path("sheet.tsv").write_text(f'file\tperformer\tlicence\nana/bow_1\t"{HOSTILE}"\t"{HOSTILE}"\n')
    command("add", some)
    for words in (
        ("words", "import", "sheet.tsv"), ("words", "set", "ana/bow_1", HOSTILE),
        ("list",), ("show", "ana/bow_1"), ("show", HOSTILE), ("info",),
    ):  # fmt: skip
        for more in ((), ("--json",)):
            ended = command(*words, *more)
            text = (ended.out + ended.err).replace("\n", "")
            assert not [c for c in text if unicodedata.category(c) in ("Cc", "Cf", "Zl", "Zp")]
    shown = command("show", "ana/bow_1")
    assert (
        "words:        bow \\x1b]0;title\\x07 \\x9b2J\\x7f\\u202e\\u2028 café 中\\nnext"
        in shown.out
    )
    assert json.loads(command("show", "ana/bow_1", "--json").out)["words"] == [HOSTILE]


def test_output_in_another_encoding(command: Any, some: Path) -> None:
    command("add", some)
    command("words", "set", "ana/bow_1", "bow 中 café")

    def text_of(encoding: str, *words: str) -> str:
        ended = subprocess.run(
            [*PROGRAM, *words], capture_output=True, check=False,
            env={**os.environ, "PYTHONIOENCODING": encoding},
        )  # fmt: skip
        assert (ended.returncode, ended.stderr) == (0, b"")
        return ended.stdout.decode(encoding)

    for encoding in ("cp1252", "ascii"):
        assert "\\u4e2d" in text_of(encoding, "show", "ana/bow_1")
    assert json.loads(text_of("ascii", "show", "ana/bow_1", "--json"))["words"] == ["bow 中 café"]


def test_files_of_others_are_overwritten_only_by_force(
    command: Any, learned_few: Path, monkeypatch: pytest.MonkeyPatch, samples_folder: Path
) -> None:
    monkeypatch.setenv("MOTIONDB", str(learned_few))
    writers: list[tuple[str, tuple[str, ...]]] = [
        ("take.bvh", ("generate", "kick", "-o", "take.bvh")),
        ("take.glb", ("export", "ana/walk_1", "-o", "take.glb")),
        ("take.gltf", ("export", "ana/walk_1", "-o", "take.gltf")),
        ("take.bvh", ("export", "ana/walk_1", "-o", "take.bvh", "--to", "1")),
        ("take.png", ("symbols", "--png", "take.png")),
        ("take.gif", ("show", "ana/walk_1", "--to", "0.2", "--gif", "take.gif")),
        ("take.knowledge", ("knowledge", "export", "take.knowledge")),
        ("take.png", ("scene", "draw", "give-and-go", "-o", "take.png")),
    ]  # fmt: skip
    capture = (samples_folder / "ana/bow_1.bvh").read_bytes()
    for name, words in writers:
        Path(name).write_bytes(capture)
        ended = command(*words)
        assert ended.code == 2, words
        assert f"error: {name}: expected a new file, or one that motiondb is known" in ended.err
        assert Path(name).read_bytes() == capture
        assert [path.name for path in Path().iterdir()] == [name]
        assert command(*words, "--force").code == 0
        assert command(*words).code == 0  # its own, written again
        if Path(name).suffix in (".png", ".gif"):
            with Path(name).open("ab") as file:
                file.write(b"edited")
            assert command(*words).code == 2
        Path(name).unlink()
        Path("take.bvh.provenance.json").unlink(missing_ok=True)
    assert command("generate", "kick", "-o", "take.bvh").code == 0
    assert command("generate", "kick", "-o", "take.glb").code == 0  # has an origin of its own
    assert command("generate", "kick", "-o", "take.bvh", "--seed", "1").code == 0
    with Path("take.bvh").open("a") as file:
        file.write("\n")  # edited by hand
    assert command("generate", "kick", "-o", "take.bvh").code == 2
    Path("notes.txt").write_text("Now run:\nmotiondb knowledge export notes.txt\n")
    assert command("knowledge", "export", "notes.txt").code == 2


def test_outputs_are_refused_before_the_work(command: Any, learned_file: Path) -> None:
    Path("taken.bvh").write_text("HIERARCHY")
    for words, told in (
        (("knowledge", "export", "."), ".: expected a file that can be written, found: a folder;"),
        (("knowledge", "export", ".."), "..: expected a file that can be written, found: a folder"),
        (("generate", "no such word", "-o", "new.txt"), "a name that ends in .bvh, .fbx, .glb"),
        (("generate", "no such word", "-o", "taken.bvh"), "taken.bvh: expected a new file"),
        (("grammar", "generate", "none", "-o", "taken.bvh"), "taken.bvh: expected a new file"),
        (("show", "none", "--gif", "new.png"), "a name that ends in .gif, found '.png'."),
    ):
        ended = command(*words, "--db", learned_file)
        assert ended.code == 2
        assert told in ended.err


@pytest.mark.parametrize(
    "fault",
    [
        MemoryError(), RuntimeError("can't start new thread"),
        motiondb.StoreError("found: Out of Memory Error: Failed to allocate block"),
    ],
)  # fmt: skip
def test_memory_that_runs_out_is_told(
    command: Any, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    def run_out(_app: object) -> None:
        raise fault

    monkeypatch.setattr("typer.Typer.__call__", run_out)
    ended = command("list")
    assert (ended.code, ended.out, ended.err.count("\n")) == (1, "", 1)
    assert "memory: expected enough for this command, found that it ran out." in ended.err


def test_too_little_memory_is_refused_at_once() -> None:
    """Libraries would end the program without a word."""
    code = "from motiondb.cli.main import main; main()"
    command = ["sh", "-c", 'ulimit -v 900000; exec "$@"', "sh", sys.executable, "-c", code, "list"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert "memory: expected a limit of at least 1,000 MB, found 922 MB." in done.stderr


NO_SCIENCE = ("scipy", "sklearn", "numba", "matplotlib", "pandas", "pydantic", "click", "http")
NO_STORE = ("numpy", "duckdb", "motiondb.store.connection")
NO_SCENES = ("motiondb.store.scenes", "motiondb.store.checks", "concurrent.futures")
NO_ANSWERS = tuple(f"motiondb.answers.{name}" for name in ("catalogue", "curation"))


@pytest.mark.parametrize(
    ("words", "spared"),
    [
        (["list"], (*NO_SCENES, *NO_ANSWERS, "motiondb.store.grammars", "numpy.ma")),
        (["info"], (*NO_SCENES, *NO_ANSWERS)),
        (["check", "--quick"], NO_STORE),  # its other process needs them
        (["search", "walk"], NO_SCENES),
        ([], (*NO_STORE[1:], "motiondb.page")),
    ],
    ids=lambda words: "-".join(words[:1]) or "reading-files",
)
def test_what_is_not_needed_is_not_loaded(
    learned_file: Path, words: list[str], spared: tuple[str, ...]
) -> None:
    """Of commands that only look, and of the processes in which ``add`` reads files."""
    code = "import atexit, sys\natexit.register(lambda: print(*sys.modules, file=sys.stderr))\n"
    if words:
        code += (
            f"sys.argv = ['motiondb', *{words!r}, '--db', {str(learned_file)!r}]\n"
            "from motiondb.cli.main import main\n"
            "main()\n"
        )
    else:
        code += "import motiondb.database.catalogue.file_reading\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stderr.split())
    assert "motiondb.errors" in loaded
    assert not loaded & {*NO_SCIENCE, *spared}


def test_a_command_is_run_by_an_app_that_has_it_alone() -> None:
    for name in (name for names in COMMANDS.values() for name in names):
        alone = typer.main.get_group(make_app(name))
        assert list(alone.commands) == [name]
    every = typer.main.get_group(make_app("--help")).commands
    assert sorted(every) == sorted(name for names in COMMANDS.values() for name in names)
    code = (
        "import sys; from motiondb.cli.main import make_app; make_app('list'); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "motiondb.cli.archive" in done.stdout.split()
    assert "motiondb.cli.search" not in done.stdout.split()


def test_a_table_is_as_wide_as_its_cells_and_folded_where_that_is_too_wide(
    capsys: pytest.CaptureFixture[str],
) -> None:
    printing.print_table(["name", "duration"], [["a\x1b", "1.00"], ["歩く", "12.50"]])
    assert capsys.readouterr().out.splitlines() == [
        "name   duration",
        "a\\x1b      1.00",
        "歩く      12.50",
    ]
    printing.print_table(["name", "note"], [["walk", "x" * 200]])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) == 160
    assert len(lines) == 3


@pytest.mark.parametrize("words", [["add", ""], ["like", "walk_1", "--export", ""]])
def test_an_empty_name_is_not_the_working_folder(
    command: Any, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shell gives one for a variable that is not set."""
    monkeypatch.chdir(tmp_path)
    ended = command(*words)
    assert ended.code == 2
    assert "expected the name of a folder or a file, found an empty name." in ended.err
    assert [*tmp_path.iterdir()] == []


def test_answers_columns_and_sql_as_csv(command: Any, learned_file: Path, tmp_path: Path) -> None:
    given = ("--db", learned_file)
    kick = command("search", "kick", "--limit", "1", "--csv", "-", *given).out.splitlines()
    assert kick[0].startswith("rank,capture,start,end,score,probability,")
    assert (len(kick), kick[1].split(",")[0]) == (2, "1")
    told = command("like", "goran/kick_1", "--limit", "2", "--csv", tmp_path / "a.tsv", *given)
    assert (told.out, told.err) == ("", f"2 answers in {tmp_path / 'a.tsv'}\n")
    some = ("list", "--columns", "name,licence", "--limit", "1", *given)
    assert command(*some, "--csv").out == "name,licence\nana/bow_1,CC0-1.0\n"
    assert command(*some).out.splitlines()[0] == "name       licence"
    assert command("list", "--columns", "nme", *given).code == 2
    count = "SELECT count(*) AS n FROM capture"
    assert command("sql", count, "--csv", *given).out == "n\n101\n"
    assert json.loads(command("sql", count, "--json", *given).out) == {
        "columns": ["n"],
        "rows": [[101]],
    }
