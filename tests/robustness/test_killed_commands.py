"""Commands that write, killed at random moments; ``benchmarks/robustness.py kills`` does more."""

from __future__ import annotations

from pathlib import Path

import pytest

from robustness_tasks import kills


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Path:
    return kills.prepared(tmp_path_factory.mktemp("killed") / "base", learned_file, has_scene=False)


@pytest.mark.parametrize("kind", ["words set", "events import", "compact"])
def test_a_killed_command_did_all_or_nothing(base: Path, kind: str) -> None:
    usual = kills.reference(base, kind)
    outcome = kills.kill(sorted(kills.COMMANDS).index(kind), kind, base, usual)
    assert outcome.faults == ()
    assert outcome.rows in ("before", "after")
