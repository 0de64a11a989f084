"""Markdown for ``benchmarks/grammar.py``: tables, and sections of a page that are replaced."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; all columns but the first to the right.

    >>> print(table(["a", "b"], [["x", "1"]]))
    | a | b |
    |---|---:|
    | x | 1 |
    """
    lines = ["| " + " | ".join(heads) + " |", "|---" + "|---:" * (len(heads) - 1) + "|"]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def table_rows(text: str) -> list[list[str]]:
    """The rows of the first table of a text, without its heads; none if it has no table.

    >>> table_rows(table(["a", "b"], [["x", "1"], ["y", ""]]))
    [['x', '1'], ['y', '']]
    """
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[1:]]


def sections(text: str) -> dict[str, str]:
    """Heading ("## ...") -> its text; the head of the page under "".

    >>> sections("top\\n## a\\n1\\n")
    {'': 'top', 'a': '1'}
    """
    head, *blocks = re.split(r"^## ", text, flags=re.MULTILINE)
    texts = {"": head.strip()}
    for block in blocks:
        title, _, body = block.partition("\n")
        texts[title.strip()] = body.strip()
    return texts


def write_sections(path: Path, head: str, order: Sequence[str], new: dict[str, str]) -> None:
    """Put sections into a page; other sections do not change."""
    known = sections(path.read_text(encoding="utf-8")) if path.exists() else {}
    known |= new
    parts = [head.strip()]
    parts += [f"## {title}\n\n{known[title]}" for title in order if known.get(title)]
    path.parent.mkdir(parents=True, exist_ok=True)  # a long run is not lost at its end
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
