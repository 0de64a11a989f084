"""Every function, class and constant of a module is used by the program, and not by tests alone."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
Name = tuple[str, str]
"""A module, and a name that it defines."""

FOR_BENCHMARKS = {
    "write_table": "benchmarks/nearby_table.py makes the shipped table with it",
}
"""Names that only benchmarks use, and what for."""
FOR_READERS = {
    "read_grammar": "reads what format_grammar writes",
    "sample": "the fourth operation on an HMM, beside fit, score and path",
    "log_probability": "log P(words | symbols), the quantity that IBM Model 2 defines",
}
"""Names that complete a module for people who work with it in Python."""


def modules(root: Path) -> dict[str, ast.Module]:
    """Modules of the program by their dotted names."""
    parsed = {}
    for folder, package in (("motiondb", "motiondb"), ("cli", "motiondb.cli")):
        for path in root.glob(f"{folder}/**/*.py"):
            parts = path.relative_to(root / folder).with_suffix("").parts
            name = ".".join([package, *(part for part in parts if part != "__init__")])
            parsed[name] = ast.parse(path.read_text(encoding="utf-8"))
    return parsed


def defined(trees: dict[str, ast.Module]) -> set[Name]:
    """Functions, classes and constants at the top of the modules."""
    actual = set()
    for module, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                actual.add((module, node.name))
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                actual |= {(module, t.id) for t in targets if isinstance(t, ast.Name)}
    return actual


class Uses:
    """Which definitions are used, names followed through imports of imported names."""

    def __init__(self, trees: dict[str, ast.Module]) -> None:
        self.trees, self.names = trees, defined(trees)

    def origin(self, module: str, name: str, depth: int = 0) -> Name | None:
        """Where a name that a module offers is defined."""
        if (module, name) in self.names or depth > 5:
            return (module, name) if depth <= 5 else None
        for node in ast.walk(self.trees.get(module, ast.Module([], []))):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    if (alias.asname or alias.name) == name:
                        return self.origin(node.module, alias.name, depth + 1)
        return None

    def imported(self, module: str) -> tuple[dict[str, str], dict[str, Name]]:
        """Modules, and definitions, by the names under which a module imports them."""
        whole, single = {}, {}
        for node in ast.walk(self.trees[module]):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    full, here = f"{node.module}.{alias.name}", alias.asname or alias.name
                    if full in self.trees:
                        whole[here] = full
                    elif origin := self.origin(node.module, alias.name):
                        single[here] = origin
        return whole, single

    def of(self, module: str) -> set[Name]:
        """Definitions that a module uses, its own ones included."""
        whole, single = self.imported(module)
        actual: set[Name | None] = set()
        for node in ast.walk(self.trees[module]):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                actual.add(single.get(node.id, (module, node.id)))
            elif isinstance(node, ast.Attribute):
                module_of = whole.get(getattr(node.value, "id", ""))
                actual.add(self.origin(module_of, node.attr) if module_of else None)
        return {name for name in actual if name in self.names}


def unused(root: Path) -> list[Name]:
    """Definitions that no module uses and that are not public."""
    uses = Uses(modules(root))
    used = set().union(*(uses.of(module) for module in uses.trees))
    public = set(uses.imported("motiondb")[1].values()) if "motiondb" in uses.trees else set()
    return sorted(
        (module, name)
        for module, name in uses.names - used - public
        if module != "motiondb" and not name.startswith("__")
    )


def test_no_function_is_used_by_tests_alone() -> None:
    commands = {"register", "_options", "main"}  # called by cli.main, Typer and the entry point
    allowed = FOR_BENCHMARKS.keys() | FOR_READERS.keys()
    actual = [
        (module, name)
        for module, name in unused(ROOT)
        if name not in allowed
        and not (module.startswith("motiondb.cli") and name in commands)
        and not (module.startswith("motiondb.page.routes") and name == "router")
    ]
    assert actual == []


@pytest.mark.parametrize("name", sorted(FOR_BENCHMARKS))
def test_what_is_kept_for_benchmarks_is_used_there(name: str) -> None:
    assert any(name in path.read_text() for path in ROOT.glob("benchmarks/**/*.py"))


def test_unused_names_are_found(tmp_path: Path) -> None:
    folder = tmp_path / "motiondb"
    folder.mkdir()
    (folder / "__init__.py").write_text("from motiondb.a import shown\n")
    (folder / "a.py").write_text(
        "LIMIT = 3\nOLD = 4\ndef shown(): return LIMIT\ndef helped(): return 1\ndef lost(): ...\n"
    )
    (folder / "b.py").write_text("from motiondb import a\ndef run(): return a.helped()\nrun()\n")
    assert unused(tmp_path) == [("motiondb.a", "OLD"), ("motiondb.a", "lost")]
