"""What commands print with ``--json``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def answer(ended: Any, code: int = 0) -> Any:
    assert ended.code == code, ended.err
    return json.loads(ended.out)


def string_of(command: Any, path: Path) -> list[str]:
    facts = answer(
        command("grammar", "parse", "fight", "boris/long_fight_1", "--json", "--db", path)
    )
    return [str(name) for name in facts["sentences"][0]["string"]]
