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
MODULES = sorted([*ROOT.glob("motiondb/**/*.py"), *ROOT.glob("cli/**/*.py")])
PURE = ("pose", "symbols", "words", "search", "generate", "learning", "grammar", "scene")
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


def imports_of_commands() -> Iterator[tuple[str, str, str]]:
    """Module of a command, module that it imports, and name that it imports from there or ""."""
    for path in sorted(ROOT.glob("cli/**/*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                yield from ((short(path), alias.name, "") for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, short(path)
                yield from ((short(path), node.module or "", alias.name) for alias in node.names)


def test_commands_use_only_public_names() -> None:
    import motiondb

    allowed = {*sys.stdlib_module_names, "typer", "rich"}
    for path, module, name in imports_of_commands():
        if module.split(".")[0] != "motiondb":
            assert module.split(".")[0] in allowed, (path, module)
        elif module == "motiondb":
            assert not name or name in motiondb.__all__, (path, name)
        else:
            assert f"{module}.".startswith("motiondb.cli."), (path, module)


def test_the_contract_of_the_commands_names_every_other_part() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    (contract,) = [
        contract
        for contract in project["tool"]["importlinter"]["contracts"]
        if contract.get("source_modules") == ["motiondb.cli"]
    ]
    parts = {p.parent.name for p in ROOT.glob("motiondb/*/__init__.py")} | {"schema"}
    parts |= {p.stem for p in ROOT.glob("motiondb/*.py") if p.stem != "__init__"}
    assert set(contract["forbidden_modules"]) == {f"motiondb.{part}" for part in parts}


def test_every_package_is_installed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    listed = set(project["tool"]["setuptools"]["packages"])
    packages = [*ROOT.glob("motiondb/**/__init__.py"), *ROOT.glob("cli/**/__init__.py")]
    actual = {short(p.parent).replace("/", ".") for p in packages} | {"motiondb.schema"}
    actual = {re.sub(r"^cli\b", "motiondb.cli", name) for name in actual}
    assert actual <= listed


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


MUTATING = {
    "add", "append", "appendleft", "clear", "discard", "extend", "insert", "move_to_end", "pop",
    "popitem", "popleft", "remove", "reverse", "setdefault", "sort", "update",
}  # fmt: skip
EMPTY = {"dict", "list", "set", "defaultdict", "Counter", "OrderedDict", "deque", "bytearray"} | {
    "WeakKeyDictionary", "WeakValueDictionary", "WeakSet", "local", "count",
}  # fmt: skip


def module_names(tree: ast.Module) -> set[str]:
    """Names that are assigned at the top of a module."""
    targets = [
        target
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
    ]
    return {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}


def local_names(function: ast.AST) -> set[str]:
    """Parameters and names that are assigned inside a function."""
    return {n.arg for n in ast.walk(function) if isinstance(n, ast.arg)} | {
        n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    }


def state_of_a_module(text: str) -> list[str]:
    """What makes a module remember: state that is made to be filled, or is changed anywhere."""
    tree, faults = ast.parse(text), []
    names = module_names(tree)
    for node in tree.body:
        value = getattr(node, "value", None)
        if isinstance(node, ast.Assign | ast.AnnAssign) and (
            (isinstance(value, ast.Dict) and not value.keys)
            or (isinstance(value, ast.List) and not value.elts)
            or (isinstance(value, ast.Call) and not value.args
                and ast.unparse(value.func).split("[")[0].split(".")[-1] in EMPTY)
        ):  # fmt: skip
            faults.append(f"{ast.unparse(node)}: made to be filled")
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        shared = names - local_names(function)
        for node in ast.walk(function):
            if isinstance(node, ast.Global):
                faults.append(f"global {', '.join(node.names)}")
            if (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
                    and node.func.attr in MUTATING
                    and ast.unparse(node.func.value) in shared):  # fmt: skip
                faults.append(ast.unparse(node))
            if isinstance(node, ast.Subscript | ast.Attribute) and not isinstance(
                node.ctx, ast.Load
            ):
                root: ast.AST = node
                while isinstance(root, ast.Subscript | ast.Attribute):
                    root = root.value
                if isinstance(root, ast.Name) and root.id in shared:
                    faults.append(f"{ast.unparse(node)} is set")
    return faults


@pytest.mark.parametrize(
    ("text", "n_faults"),
    [
        ("_seen: dict[str, int] = {}", 1),
        ("_seen = []\ndef f(x):\n    _seen.append(x)", 2),
        ("_made = WeakKeyDictionary()", 1),
        ("_made = dict[str, int]()", 1),
        ("TABLE = {'a': 1}\ndef f():\n    return TABLE['a']", 0),
        ("TABLE = {'a': 1}\ndef f():\n    TABLE['b'] = 2", 1),
        ("TABLE = {'a': 1}\ndef f(TABLE):\n    TABLE['b'] = 2", 0),
        ("A = np.zeros(3)\ndef f():\n    A[0] += 1.0", 1),
        ("A = 1\ndef f():\n    global A\n    A = 2", 1),
        ("def f():\n    seen = []\n    seen.append(1)\n    return seen", 0),
    ],
)
def test_state_of_a_module_is_seen(text: str, n_faults: int) -> None:
    assert len(state_of_a_module(text)) == n_faults


@pytest.mark.parametrize("path", PURE_MODULES, ids=short)
def test_pure_stages_remember_nothing(path: Path) -> None:
    """What one database taught never changes another's answers in the same process.

    Memos of functions (``functools.cache``) are no such state: they change no result. Which may be
    kept, and why, is listed in ``MEMOS``.
    """
    assert state_of_a_module(path.read_text()) == []


MEMOS = {
    "motiondb/grammar/cfg/compiled.py": "the compiled form of a grammar, a frozen record",
    "motiondb/grammar/cfg/lengths.py": "string lengths of a grammar, a frozen record",
    "motiondb/grammar/derivation/derive.py": "plans of derivation of a grammar, a frozen record",
    "motiondb/meaning/certainty/place_certainty.py": "word maps inside one call, gone with it",
    "motiondb/scene/sampling/play.py": "derivations of a grammar, a frozen record",
    "motiondb/symbols/hmm_jobs.py": "the thread pools of this process, which never change",
    "motiondb/language/lemmas.py": "lemmas of words, by tables and by an installed dictionary",
}
"""Modules of the pure folders with memos: what is remembered, from which arguments alone."""


def test_memos_are_of_functions_without_a_database() -> None:
    actual = {
        short(path)
        for path in PURE_MODULES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Name) and node.id in ("cache", "lru_cache")
        and isinstance(node.ctx, ast.Load)
    }  # fmt: skip
    assert actual <= MEMOS.keys()


CHANGING = {
    "add", "append", "clear", "discard", "extend", "insert", "pop", "popitem", "remove", "reverse",
    "setdefault", "sort", "update",
}  # fmt: skip


def changes_of_module_level_state(tree: ast.Module) -> list[str]:
    """Statements inside functions that change what a module holds."""
    held = {
        name.id
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        for name in ast.walk(target)
        if isinstance(name, ast.Name)
    }
    actual = []
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        local = {arg.arg for arg in ast.walk(function) if isinstance(arg, ast.arg)}
        local |= {
            name.id
            for name in ast.walk(function)
            if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
        }
        for node in ast.walk(function):
            changed: ast.expr | None = None
            if isinstance(node, ast.Global):
                actual.append(ast.unparse(node))
            if isinstance(node, ast.Subscript | ast.Attribute) and not isinstance(
                node.ctx, ast.Load
            ):
                changed = node.value
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                changed = node.func.value if node.func.attr in CHANGING else None
            if isinstance(changed, ast.Name) and changed.id in held - local:
                actual.append(ast.unparse(node))
    return actual


@pytest.mark.parametrize("path", PURE_MODULES, ids=short)
def test_pure_stages_keep_no_module_level_state(path: Path) -> None:
    assert changes_of_module_level_state(ast.parse(path.read_text())) == []


def test_changes_of_module_level_state_are_found() -> None:
    text = "KEPT = {}\nTOLD: list = []\ndef f(x):\n    "
    for line in ("KEPT[x] = 1", "TOLD.append(x)", "KEPT.update(x)", "global KEPT", "del KEPT[x]"):
        assert changes_of_module_level_state(ast.parse(text + line)), line
    for line in ("return KEPT[x]", "TOLD = []; TOLD.append(x)", "x.append(TOLD)"):
        assert not changes_of_module_level_state(ast.parse(text + line)), line


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_only_the_command_line_prints(path: Path) -> None:
    calls = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
    printed = [c for c in calls if ast.unparse(c.func) in ("print", "sys.exit")]
    assert not printed or path.relative_to(ROOT).parts[0] == "cli"


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


def test_public_names_are_shown_and_there() -> None:
    import motiondb

    assert set(motiondb.__all__) <= set(dir(motiondb))
    for name in motiondb.__all__:
        assert getattr(motiondb, name) is not None
    assert not {"Path", "TYPE_CHECKING"} & set(dir(motiondb))
    with pytest.raises(AttributeError, match="no attribute 'opne'"):
        motiondb.opne  # noqa: B018


def test_types_are_shipped() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert "py.typed" in project["tool"]["setuptools"]["package-data"]["motiondb"]
    assert (ROOT / "motiondb" / "py.typed").is_file()
