"""The page docs/start.md and its pictures, from the results of the tasks."""

from __future__ import annotations

from pathlib import Path


def write_page(results: Path, docs: Path) -> None:
    raise NotImplementedError
