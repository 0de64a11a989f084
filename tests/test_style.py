"""The code says what it holds: names of variables, reasons of constants and of ignored types."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted(
    p for top in ("motiondb", "cli", "benchmarks") for p in ROOT.glob(f"{top}/**/*.py")
)
EVERY_MODULE = sorted([*MODULES, *ROOT.glob("tests/**/*.py"), *ROOT.glob("sample_data/**/*.py")])
UNTELLING = {"found", "own"}


def short(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def untelling(tree: ast.Module) -> list[int]:
    """Lines of functions that bind a variable whose name does not say what it holds."""
    inside = (n for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f))
    return [
        node.lineno
        for node in inside
        if (isinstance(node, ast.arg) and node.arg in UNTELLING)
        or (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in UNTELLING)
    ]


def test_variables_say_what_they_hold() -> None:
    trees = {short(path): ast.parse(path.read_text(encoding="utf-8")) for path in EVERY_MODULE}
    assert {name: lines for name, tree in trees.items() if (lines := untelling(tree))} == {}


def test_untelling_variables_are_seen() -> None:
    for line in ("found = 1", "for found in x: pass", "y = [found for found in x]", "(found := x)"):
        assert untelling(ast.parse(f"def f(x):\n    {line}")) == [2], line
    assert untelling(ast.parse("def f(found): pass")) == [1]
    assert untelling(ast.parse("def f(x):\n    y = x.found; return f(found=y)")) == []


def carelessly_opened(tree: ast.Module) -> list[int]:
    """Lines that leave the database all tests share open, or open it for writing."""
    nodes = list(ast.walk(tree))
    items = [item.context_expr for n in nodes if isinstance(n, ast.With) for item in n.items]
    closed = {id(expression) for expression in items}
    return [
        call.lineno
        for call in nodes
        if isinstance(call, ast.Call)
        and ast.unparse(call.func) in ("motiondb.open", "store.open_store")
        and ast.unparse(call.args[0]) == "learned_file"
        and (id(call) not in closed or "read_only=True" not in ast.unparse(call))
    ]


def test_careless_opening_is_seen() -> None:
    lines = (
        "db = motiondb.open(learned_file, read_only=True)",
        "with motiondb.open(learned_file): pass",
    )
    for line in lines:
        assert carelessly_opened(ast.parse(line)) == [1], line
    kept = "with motiondb.open(learned_file, read_only=True) as db: pass"
    assert carelessly_opened(ast.parse(kept)) == []


def test_tests_only_ask_the_database_they_share_and_close_it() -> None:
    """One left open refuses to be opened the other way by whatever test comes next."""
    tests = [path for path in EVERY_MODULE if "tests" in path.parts]
    trees = {short(path): ast.parse(path.read_text(encoding="utf-8")) for path in tests}
    assert {n: lines for n, tree in trees.items() if (lines := carelessly_opened(tree))} == {}


def holds_a_number(node: ast.expr) -> bool:
    constants = (n.value for n in ast.walk(node) if isinstance(n, ast.Constant))
    return any(isinstance(v, int | float) and not isinstance(v, bool) for v in constants)


def groups(body: Sequence[ast.stmt]) -> Iterator[tuple[list[ast.stmt], ast.stmt | None]]:
    """Assignments on successive lines, with the statement that follows them."""
    group: list[ast.stmt] = []
    for node, following in pairwise([*body, None]):
        if not isinstance(node, ast.Assign | ast.AnnAssign):
            continue
        group.append(node)
        joined = isinstance(following, ast.Assign | ast.AnnAssign)
        if not (joined and following.lineno == (node.end_lineno or 0) + 1):
            yield group, following
            group = []


def unexplained(text: str) -> list[str]:
    """Numeric constants of a module that neither a docstring nor a comment explains.

    A docstring below, or a comment above, speaks for all constants on successive lines. What a
    module's docstring names, ``range`` numbers or ``__file__`` locates needs no further reason.
    """
    tree, lines = ast.parse(text), text.splitlines()
    told, faults = ast.get_docstring(tree) or "", []
    for group, following in groups(tree.body):
        documented = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        if documented or lines[group[0].lineno - 2].lstrip().startswith("#"):
            continue
        for node in group:
            assert isinstance(node, ast.Assign | ast.AnnAssign)
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            names = [n.id for n in ast.walk(target) if isinstance(n, ast.Name)]
            written = "\n".join(lines[node.lineno - 1 : node.end_lineno])
            if (
                node.value is not None
                and all(re.fullmatch(r"_?[A-Z][A-Z0-9_]+", name) for name in names)
                and holds_a_number(node.value)
                and not re.search(r"#|\brange\(|__file__", written)
                and not any(re.search(rf"\b{name}\b", told) for name in names)
            ):
                faults += names
    return faults


def test_constants_say_why() -> None:
    texts = {short(path): path.read_text(encoding="utf-8") for path in MODULES}
    assert {name: left for name, text in texts.items() if (left := unexplained(text))} == {}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('"""."""\nMOST = 4', ["MOST"]),
        ('"""."""\nLEAST, MOST = 3, 4\n\nNAME = "x"', ["LEAST", "MOST"]),
        ('"""."""\nMOST = 4  # frames', []),
        ('"""."""\n# frames\nMOST = 4', []),
        ('"""."""\nLEAST = 1\nMOST = 4\n"""Frames."""', []),
        ('"""."""\nLEAST = 1\n\nMOST = 4\n"""Frames."""', ["LEAST"]),
        ('"""At most MOST frames."""\nMOST = 4', []),
        ('"""."""\nA, B = range(2)\nHERE = Path(__file__).parents[1]', []),
    ],
)
def test_unexplained_constants_are_seen(text: str, names: list[str]) -> None:
    assert unexplained(text) == names


def test_ignored_types_are_few_and_have_a_reason() -> None:
    lines = [line for path in MODULES for line in path.read_text(encoding="utf-8").splitlines()]
    ignored = [line for line in lines if "# type: ignore" in line]
    assert len(ignored) < 15
    assert all(re.search(r"# type: ignore\[[a-z-]+\]  # \w", line) for line in ignored), ignored


def test_the_architecture_names_every_folder_and_no_other() -> None:
    told = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    folders = sorted(p.parent for p in ROOT.glob("motiondb/**/__init__.py"))[1:]
    ways = {folder: folder.relative_to(ROOT / "motiondb").as_posix() for folder in folders}
    assert [w for f, w in ways.items() if f"{w}/" not in told and f"`{f.name}/`" not in told] == []
    rows = re.findall(r"^\| `([a-z_]+/[a-z_/]+)`", told, flags=re.MULTILINE)
    places = [ROOT / "motiondb" / row for row in rows if not row.startswith(("motiondb/", "cli"))]
    assert [p for p in places if not p.is_dir() and not p.with_suffix(".py").is_file()] == []
