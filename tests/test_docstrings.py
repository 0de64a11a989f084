"""Public docstrings follow numpydoc: every parameter documented is real, one parameter an entry."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SECTIONS = ("Parameters", "Attributes")

MODULES = sorted(ROOT.glob("motiondb/**/*.py"))


def short(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def public(tree: ast.Module) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    """Public functions, classes and methods of a module."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                for inner in node.body:
                    if isinstance(inner, ast.FunctionDef) and not inner.name.startswith("_"):
                        yield inner


def real_names(node: ast.FunctionDef | ast.ClassDef) -> set[str]:
    """Names that a docstring may document: parameters, or fields of a class."""
    if isinstance(node, ast.FunctionDef):
        a = node.args
        every = [*a.posonlyargs, *a.args, *a.kwonlyargs]
        starred = {f"*{a.vararg.arg}"} if a.vararg else set()
        starred |= {f"**{a.kwarg.arg}"} if a.kwarg else set()
        return {arg.arg for arg in every} | starred
    names: set[str] = set()
    for inner in node.body:
        if isinstance(inner, ast.AnnAssign):
            names.add(ast.unparse(inner.target))
        if isinstance(inner, ast.FunctionDef):  # properties, or what ``__init__`` takes
            names |= {inner.name}
            names |= real_names(inner) if inner.name == "__init__" else set()
    return names


def faults(text: str, real: set[str]) -> list[str]:
    """What is wrong in the sections of parameters of a docstring."""
    wrong: list[str] = []
    lines = text.splitlines()
    for at, line in enumerate(lines):
        if line not in SECTIONS or at + 1 == len(lines) or set(lines[at + 1]) != {"-"}:
            continue
        seen: set[str] = set()
        described = True
        for entry in lines[at + 2 :]:
            if not entry.strip():
                break
            if entry.startswith(" "):
                described = True
                continue
            match = re.fullmatch(r"(\**\w+) : (\S.*)", entry)
            if match is None:
                wrong.append(f"expected 'name : type', one parameter an entry, found {entry!r}")
                continue
            name = match[1]
            if not described:
                wrong.append(f"the entry before {name} has no description")
            if name not in real:
                wrong.append(f"{name} is documented, but is no parameter")
            if name in seen:
                wrong.append(f"{name} is documented twice")
            if re.search(r"[.;] \w+ : ", entry):
                wrong.append(f"more than one parameter in {entry!r}")
            seen.add(name)
            described = False
        if not described:
            wrong.append("the last entry has no description")
    return wrong


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_documented_parameters_are_real_one_an_entry(path: Path) -> None:
    wrong = []
    for node in public(ast.parse(path.read_text(encoding="utf-8"))):
        text = ast.get_docstring(node) or ""
        wrong += [f"{node.name}: {fault}" for fault in faults(text, real_names(node))]
    assert not wrong, "\n".join(wrong)


def section(*entries: str) -> str:
    return "\n".join(["Do it.", "", "Parameters", "----------", *entries])


def test_a_sound_section_has_no_faults() -> None:
    assert (
        faults(section("a : int", "    First.", "b : str, optional", "    Other."), {*"ab"}) == []
    )


@pytest.mark.parametrize(
    ("entries", "fault"),
    [
        (("a, b : int", "    Both."), "one parameter an entry, found 'a, b : int'"),
        (("c : int", "    Third."), "c is documented, but is no parameter"),
        (("a : int",), "the last entry has no description"),
        (("a : int", "b : int", "    Second."), "the entry before b has no description"),
        (("a : int. b : int", "    Two."), "more than one parameter"),
        (("a : int", "    One.", "a : int", "    Again."), "a is documented twice"),
    ],
)
def test_each_fault_is_found(entries: tuple[str, ...], fault: str) -> None:
    assert any(fault in actual for actual in faults(section(*entries), {"a", "b"}))
