"""Every row of phrasings.txt is understood as it says, and so is the line that restates it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tree_notation import notation

from motiondb.language.question.parse import parse
from motiondb.language.question.readings import say

ROWS = [
    [cell.strip() for cell in line.split(" | ")]
    for line in Path(__file__).with_name("phrasings.txt").read_text("utf-8").splitlines()
    if line.strip() and not line.startswith("#")
]


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_phrasing_has_its_tree_and_so_has_its_restatement(row: list[str]) -> None:
    question = parse(row[0])
    assert notation(question.tree) == row[1]
    assert "; ".join(left.text for left in question.not_used) == (row[2] if len(row) > 2 else "")
    assert parse(say(question.tree)).tree == question.tree
