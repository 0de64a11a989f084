"""Notebooks of the documentation: their cells are run, and their outputs written.

``python tests/notebooks.py`` runs the notebooks of ``docs/notebooks`` and writes what they print.
No Jupyter is needed: the cells are plain Python.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def run(path: Path, folder: Path) -> dict[str, Any]:
    """The notebook with the outputs of a run in a folder beside a link to the sample data."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    (folder / "sample_data").symlink_to(ROOT / "sample_data")
    names: dict[str, Any] = {"__name__": "__main__"}
    number = 0
    with contextlib.chdir(folder):
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                number += 1
                said = io.StringIO()
                with contextlib.redirect_stdout(said):
                    value = _execute("".join(cell["source"]), names)
                cell["execution_count"] = number
                cell["outputs"] = _outputs(said.getvalue(), value, number)
    return notebook


def _execute(text: str, names: dict[str, Any]) -> object:
    """Run a cell; the value of its last line, if that is an expression."""
    tree = ast.parse(text)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def _outputs(said: str, value: object, number: int) -> list[dict[str, Any]]:
    """Outputs of a cell, as notebooks keep them."""
    outputs: list[dict[str, Any]] = []
    if said:
        lines = said.splitlines(keepends=True)
        outputs.append({"output_type": "stream", "name": "stdout", "text": lines})
    if value is not None:
        data = {"text/plain": repr(value).splitlines(keepends=True)}
        result = {"output_type": "execute_result", "execution_count": number, "metadata": {}}
        outputs.append({**result, "data": data})
    return outputs


def write_all() -> None:
    """Run all notebooks, and write their outputs."""
    for path in NOTEBOOKS:
        with tempfile.TemporaryDirectory() as folder:
            text = json.dumps(run(path, Path(folder)), indent=1, ensure_ascii=False)
        path.write_text(text + os.linesep, encoding="utf-8")


if __name__ == "__main__":
    write_all()
