"""The command quality."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from command_answers import answer


def test_what_captures_lack_is_printed_drawn_and_refused(command: Any, some: Path) -> None:
    assert command("add", some).code == 0
    assert command("list", "--where", "needs").code == 2
    told = answer(command("quality", "--json"))
    assert (len(told["captures"]), told["measured"], told["problems"]) == (4, 4, [])
    assert {"capture", "quality", "seconds", "findings", "untold"} <= told["captures"][0].keys()
    ended = command("quality", "jump_1", "--png", "jump.png", "--boxes", "jump.json")
    assert ended.code == 0
    assert "1 capture, 0 measured now" in ended.out
    assert Path("jump.png").exists()
    assert Path("jump.json").exists()
    assert "boxes: jump.json" in ended.out
    assert "'nothere': expected the name of a capture" in command("quality", "nothere").err
    assert "Did you mean duration?" in command("quality", "duratoin in (1, 2)").err
    assert command("quality", "--png", "all.png").code == 2
    assert command("quality", "--boxes", "all.txt").code == 2
    assert command("list", "--where", "not needs").code == 0
