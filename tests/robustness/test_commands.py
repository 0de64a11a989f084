"""Every command is killed, or only asks: both lists are compared with ``motiondb --help``."""

from __future__ import annotations

import hashlib
from contextvars import copy_context
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from motiondb.cli.main import make_app
from robustness_tasks import commands, kills
from robustness_tasks.commands import ASKING, COMMANDS, NOT_ATTACKED, words_of

LEAVES: dict[str, Any] = dict(commands.leaves(typer.main.get_command(make_app())))


def command_of(kind: str) -> str:
    """The command that a kind of kill runs: the longest one whose name its words begin with."""
    words = COMMANDS[kind]
    return next(name for n in range(len(words), 0, -1) if (name := " ".join(words[:n])) in LEAVES)


def test_the_two_lists_hold_every_command_once() -> None:
    killed = {command_of(kind) for kind in COMMANDS}
    assert killed | set(ASKING) | set(NOT_ATTACKED) == set(LEAVES)
    assert not killed & set(ASKING)
    assert {name: " ".join(words[: len(name.split())]) for name, words in ASKING.items()} == {
        name: name for name in ASKING
    }


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Path:
    folder = tmp_path_factory.mktemp("asking") / "base"
    commands.prepare(folder, learned_file)
    return folder


def digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file() and not path.parent.name.endswith(".cache")
    }


def test_commands_that_ask_leave_the_folder_as_it_was(
    base: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(base)
    before = digests(base)
    for name in ASKING:
        ended = copy_context().run(CliRunner().invoke, make_app(), list(words_of(name)))
        has_grammar = words_of(name)[0] != "grammar" or name == "grammar list"  # else: none learned
        assert ended.exit_code == 0 or not has_grammar, (name, ended.output, ended.exception)
        assert digests(base) == before, name


@pytest.fixture(scope="module")
def killed_base(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Path:
    return kills.prepared(
        tmp_path_factory.mktemp("killed") / "killed_base", learned_file, has_scene=False
    )


@pytest.mark.parametrize("kind", ["words set", "compact"])
def test_a_killed_command_did_all_or_nothing(killed_base: Path, kind: str) -> None:
    usual = kills.reference(killed_base, kind)
    outcome = kills.kill(sorted(kills.COMMANDS).index(kind), kind, killed_base, usual)
    assert outcome.faults == ()
    assert outcome.rows in ("before", "after")
