"""The same seed makes the same choices on another processor.

``benchmarks/machines.py`` compares all commands, and compiled code for another processor too.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from machines import OTHER

TESTS = Path(__file__).resolve().parents[1]
SHARED = ("grammar", "scene")  # toy motions and toy clips lie in these folders


def choices() -> list[dict[str, list[float]]]:
    """What is chosen while learning symbols and terminals and sampling a scene, and how good."""
    import naive_terminals
    from conftest import wandering_library

    from motiondb.database.scenes.scene_texts import read_scene_text
    from motiondb.grammar.terminals.terminals import TerminalSettings, find_terminals
    from motiondb.scene.sampling.annealing import SamplerSettings, sample
    from motiondb.scene.sampling.play import make_play
    from motiondb.symbols.acquisition import acquire
    from motiondb.symbols.feature_space import fit_feature_space

    rng = np.random.default_rng(1)
    steps = rng.normal(size=(900, 130)) + 4.0 * rng.normal(size=(6, 130))[np.arange(900) // 30 % 6]
    features = np.cumsum(steps, axis=0).astype(np.float32)
    frames = fit_feature_space([features]).project(features)
    cuts = np.arange(0, 901, 15)
    learned = acquire(frames, np.array([0, 900]), cuts[:-1], cuts[1:], rng)
    takes = [naive_terminals.actions_motion("abcabdacb", seed)[0] for seed in range(2)]
    settings = TerminalSettings(n_starts=2, n_trials=200)
    found = find_terminals(takes, 4, rng, settings=settings)
    text = read_scene_text("give-and-go")
    clips = wandering_library([terminal.name for terminal in text.grammar.terminals])
    how = SamplerSettings(rounds=2, jumps=4, inner=60, steps=60, cooling=400)
    play = make_play(text.diagram, text.grammar, clips, how.most_actions, how.prices)
    state, trace = sample(play, how, rng)
    chosen = {
        "cuts": learned.cutting.starts.tolist(),
        "symbols": learned.cutting.winners.tolist(),
        "segments": found.starts.tolist(),
        "terminals": found.labels.tolist(),
        "clips": [k for player in state.players for k in player.entries.tolist()],
        "delays": [player.delay for player in state.players],
    }
    bits = list(learned.description_lengths)
    return [chosen, {"bits": bits, "objective": [found.objective], "error": [trace.final]}]


def on_machine(environment: dict[str, str]) -> list[dict[str, list[float]]]:
    paths = os.pathsep.join([*(str(TESTS / name) for name in SHARED), *filter(None, sys.path)])
    ended = subprocess.run(
        [sys.executable, __file__],
        env=os.environ | {"PYTHONPATH": paths} | environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
    )
    return json.loads(ended.stdout)


@pytest.mark.slow
def test_another_processor_makes_the_same_choices() -> None:
    """But for the kernels of numba, whose code for another processor takes minutes to compile."""
    other = {name: value for name, value in OTHER.items() if not name.startswith("NUMBA")}
    (chosen, numbers), (chosen_there, numbers_there) = on_machine({}), on_machine(other)
    assert chosen_there == chosen
    for name, values in numbers.items():
        np.testing.assert_allclose(numbers_there[name], values, rtol=1e-7, err_msg=name)


if __name__ == "__main__":
    print(json.dumps(choices()))
