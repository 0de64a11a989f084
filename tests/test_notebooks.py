"""The notebooks of the documentation run, and print what they show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from notebooks import NOTEBOOKS, run


def printed(notebook: dict[str, Any]) -> list[Any]:
    return [cell.get("outputs") for cell in notebook["cells"]]


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run_and_print_what_they_show(path: Path, tmp_path: Path) -> None:
    import json

    shown = json.loads(path.read_text(encoding="utf-8"))
    assert printed(run(path, tmp_path)) == printed(shown), "run python tests/notebooks.py"
