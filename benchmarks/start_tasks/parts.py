"""Parts of a long measurement, kept in a folder so that an ended run goes on where it stopped."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Parts:
    """Where the parts of a task are kept; without a folder, nothing is kept.

    The folder must be emptied when the code changes: nothing checks what made a part.

    Attributes
    ----------
    folder : Path or None
        The folder.
    task : str
        Prefix of the names of the parts.
    """

    folder: Path | None = None
    task: str = ""

    def of(self, task: str) -> Parts:
        """The same folder for one task."""
        return replace(self, task=task)

    def learned(self, name: str, make: Callable[[], T]) -> T:
        """What was learned, from the folder or made now."""
        if self.folder is None:
            return make()
        path = self.folder / f"{name}.pickle"
        if not path.exists():
            _write(path, pickle.dumps(make()))
        with path.open("rb") as file:
            return pickle.load(file)

    def judged(self, name: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Judged answers, from the folder or made now; keys are captures, as ``judge`` makes."""
        if self.folder is None:
            return make()
        path = self.folder / f"{self.task}-{name}.json".replace(" ", "-")
        if not path.exists():
            _write(path, json.dumps(make()).encode())
        judgement: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        for key in ("reciprocal", "f1"):
            judgement[key] = {int(capture): value for capture, value in judgement[key].items()}
        return judgement


def _write(path: Path, content: bytes) -> None:
    """Write whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".draft")
    draft.write_bytes(content)
    draft.replace(path)
