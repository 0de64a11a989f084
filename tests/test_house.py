"""The house is in order: direction of imports, sizes, pure stages, helpful commands, README."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted([*ROOT.glob("motiondb/**/*.py"), *ROOT.glob("cli/*.py")])
PURE = ("pose", "symbols", "words", "search", "generate", "grammar", "scene")
PURE_MODULES = [p for p in MODULES if p.relative_to(ROOT).parts[1] in PURE]
CLOCKS = {"time", "datetime", "random", "sys", "pathlib", "io", "subprocess", "duckdb"}


def short(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_imports_go_one_way(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "motiondb", tmp_path / "motiondb")
    shutil.copytree(ROOT / "cli", tmp_path / "motiondb" / "cli")
    shutil.copytree(ROOT / "schema", tmp_path / "motiondb" / "schema")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    program = Path(sys.executable).with_name("lint-imports")
    ended = subprocess.run(
        [program, "--no-cache"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_every_package_is_installed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    listed = set(project["tool"]["setuptools"]["packages"])
    found = {short(p.parent).replace("/", ".") for p in ROOT.glob("motiondb/**/__init__.py")} | {
        "motiondb.cli",
        "motiondb.schema",
    }
    assert found <= listed


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_module_is_short_and_says_what_it_is(path: Path) -> None:
    text = path.read_text()
    assert len(text.splitlines()) <= 400
    assert not text.strip() or ast.get_docstring(ast.parse(text))


@pytest.mark.parametrize("path", PURE_MODULES, ids=short)
def test_pure_stages_touch_nothing(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert not CLOCKS & {alias.name.split(".")[0] for alias in node.names}
        if isinstance(node, ast.ImportFrom) and node.module:
            assert node.module.split(".")[0] not in CLOCKS
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            assert called not in ("print", "open", "input")
            if called.startswith("os."):  # how many processors there are changes no result
                assert called in ("os.cpu_count", "os.sched_getaffinity")
            assert not re.fullmatch(r"(np|numpy)\.random\..*", called), called


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_only_the_command_line_prints(path: Path) -> None:
    calls = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
    printed = [c for c in calls if ast.unparse(c.func) in ("print", "sys.exit")]
    assert not printed or path.parent.name == "cli"


def commands() -> Iterator[tuple[str, typer.core.TyperCommand]]:
    from motiondb.cli.main import app

    def walk(name: str, group: object) -> Iterator[tuple[str, typer.core.TyperCommand]]:
        for part, command in getattr(group, "commands", {}).items():
            yield f"{name}{part}", command
            yield from walk(f"{name}{part} ", command)

    yield from walk("", typer.main.get_command(app))


COMMANDS = dict(commands())


@pytest.mark.parametrize("name", COMMANDS)
def test_command_helps_and_answers_in_json(name: str) -> None:
    command = COMMANDS[name]
    assert command.help
    options = {o for p in command.params for o in p.opts}
    alone = getattr(command, "invoke_without_command", True)
    if alone:  # else a group that does nothing by itself
        assert {"--json", "--db"} <= options
    for parameter in command.params:
        if parameter.name != "context":
            assert getattr(parameter, "help", None), parameter.name


def test_every_command_of_the_readme_exists() -> None:
    text = (ROOT / "README.md").read_text()
    blocks = re.findall(r"```.*?\n(.*?)```", text, re.DOTALL)
    lines = re.findall(r"^\s*\$?\s*motiondb (.+)$", "\n".join(blocks), re.MULTILINE)
    assert lines
    for line in lines:
        words = line.split()
        while words and words[0].startswith("-"):
            words = words[1:]
        if not words:
            continue
        name = " ".join(words[:2]) if " ".join(words[:2]) in COMMANDS else words[0]
        assert name in COMMANDS, line
        known = {o for p in COMMANDS[name].params for o in p.opts} | {"--help"}
        asked = {w.split("=")[0] for w in re.findall(r"(?<!\S)--[a-z][a-z-]*", line)}
        assert asked <= known, line
