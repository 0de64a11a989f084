"""docs/acceptance.md names tests and benchmarks for every line, and all of them exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "acceptance.md").read_text(encoding="utf-8")
LINES = (
    *(f"A{n}" for n in range(1, 20)),
    *(f"B{n}" for n in range(1, 21)),
    *(f"C{n}" for n in range(1, 22)),
    *("X1", "X2", "X3", "X4"),
)
ROWS = {row.split("|")[1].strip(): row for row in PAGE.splitlines() if row.startswith("| ")}
NAMED = sorted(set(re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)))
FILES = sorted(set(re.findall(r"`((?:motiondb|cli|schema|benchmarks|docs|tests)/[\w/.-]+)`", PAGE)))


@pytest.mark.parametrize("line", LINES)
def test_every_line_has_a_place_and_a_test_or_benchmark(line: str) -> None:
    _, _, asked, place, shown, _ = (cell.strip() for cell in re.split(r"(?<!\\)\|", ROWS[line]))
    assert asked
    assert re.search(r"`motiondb/\S+`", place) or line.startswith("X")
    assert re.search(r"`tests/\S+::test_\w+`|`benchmarks/\S+`", shown)


@pytest.mark.parametrize(("file", "name"), NAMED)
def test_a_named_test_exists(file: str, name: str) -> None:
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("file", FILES)
def test_a_named_file_exists(file: str) -> None:
    assert (ROOT / file).exists()
