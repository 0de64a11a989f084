"""The model of benchmarks/cluster.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cluster_tasks import cluster_page, model


def row(hours: float, clock: float) -> dict[str, Any]:
    """What ``learn`` took of two workers: seconds in proportion to the hours."""
    times = {"own, s": 3.0 * hours, "scheduler, s": 1.0 * hours, "worked, s": 12.0 * hours}
    sizes = ("received", "held", "own peak", "worker peak", "scheduler peak")
    return {
        **{"command": "learn", "asked hours": hours, "hours": hours, "workers": 2.0},
        **{"clock, s": clock, "tasks": 1.0, **times},
        **{f"{name}, bytes": 1e9 for name in sizes},
    }


def test_the_scheduler_works_on_the_longest_path() -> None:
    known = [row(1.0, 0.0), row(2.0, 0.0)]
    assert model.taken(known[0]).seconds(2) == 3.0 + 1.0 + 12.0 / 2
    assert model.predict(known, 300.0, 16).seconds(16) == pytest.approx(300 * (4.0 + 12.0 / 16))


def test_the_page_says_what_the_clock_showed_and_calls_no_processor_time_a_duration(
    tmp_path: Path,
) -> None:
    rows = [row(1.0, 25.0), row(2.0, 20.0)]
    cluster_page.write_page(rows, [], tmp_path / "page.md")
    page = (tmp_path / "page.md").read_text()
    first, second = (line for line in page.splitlines() if line.startswith("| `learn` |"))
    assert first.endswith("| 2.5 |")
    assert second.endswith("| 1.0 |")
    assert "T = 1,425 s, processor seconds on the longest path, not a duration" in page
    assert "the clock showed 1.0 to 2.5 times T" in page
    assert "erred" not in page  # nothing was compared
