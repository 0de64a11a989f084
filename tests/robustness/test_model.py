"""A chain of random steps, with kills; ``benchmarks/robustness.py model`` runs many."""

from __future__ import annotations

from pathlib import Path

import pytest

from robustness_tasks import model, model_processes

pytest.importorskip("resource")
OFTEN = {
    "": 0.88,
    "kill": 0.04,
    "late kill": 0.01,
    "full disk": 0.03,
    "clock": 0.02,
    "rights": 0.02,
}


def test_a_chain_of_steps_makes_no_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model_processes, "STRACE", None)  # limits of files do the same everywhere
    monkeypatch.setattr(model, "HARMS", OFTEN)
    material = model.tiny(tmp_path)
    model.warm_up(material)
    outcomes = list(model.chain(1, material, steps=30))
    assert [outcome for outcome in outcomes if outcome.faults] == []
    assert len(outcomes) == 30
    assert {"kill", "late kill"} & {outcome.harm for outcome in outcomes}
