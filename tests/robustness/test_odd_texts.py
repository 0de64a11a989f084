"""No text, however odd, makes its reader raise anything but this project's errors.

``benchmarks/robustness.py fuzz`` reads many more cases, and measures time and memory.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

from motiondb.errors import MotionDBError
from robustness_tasks.odd_texts import text_case
from robustness_tasks.reading import READS, Place

ASKING = ("filter", "question", "terminals", "name")
"""Kinds of text that are read with a database."""


@pytest.mark.parametrize("kind", sorted(set(READS) - set(ASKING)))
def test_odd_texts_are_read_or_refused_by_name(tmp_path: Path, kind: str) -> None:
    for seed in range(25):
        with suppress(MotionDBError):
            READS[kind](text_case(seed, kind)[1], Place(tmp_path, tmp_path / "none"))


@pytest.mark.parametrize("kind", ["filter", "question", "name"])
def test_odd_questions_are_answered_or_refused(
    tmp_path: Path, learned_file: Path, kind: str
) -> None:
    for seed in range(25):
        with suppress(MotionDBError):
            READS[kind](text_case(seed, kind)[1], Place(tmp_path, learned_file))
