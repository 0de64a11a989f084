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


def test_there_are_enough_phrasings_and_each_stands_once() -> None:
    assert len(ROWS) >= 150
    assert len({row[0] for row in ROWS}) == len(ROWS)


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_phrasing_has_its_tree(row: list[str]) -> None:
    question = parse(row[0])
    assert notation(question.tree) == row[1]
    assert "; ".join(left.text for left in question.not_used) == (row[2] if len(row) > 2 else "")


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_restatement_is_understood_in_the_same_way(row: list[str]) -> None:
    tree = parse(row[0]).tree
    assert parse(say(tree)).tree == tree
