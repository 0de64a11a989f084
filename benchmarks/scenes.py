"""Scenes of all shipped diagrams: are the rules kept, and how long does it take?

    python benchmarks/scenes.py table --db samples.duckdb --out scenes/ [--seeds 1 2 3 4 5]
    python benchmarks/scenes.py baseline --db ... --out scenes/ --seconds 100 [--diagrams ...]
    python benchmarks/scenes.py update --db ... --out scenes/
    python benchmarks/scenes.py page --out scenes/ > docs/measured/scenes.md

The database holds the sample data with its words and events:

    motiondb add sample_data/captures --words sample_data/captions.tsv
        --events sample_data/events.tsv --db samples.duckdb

``table`` makes each diagram at each seed from nothing. ``baseline`` is the paper's procedure, as
far as it is described: one chain at T = 1, clips exchanged by their errors and drawn uniformly,
subtrees derived by the rules' probabilities until P(X') > 0, and everything evaluated again at each
step. ``update`` moves one player and times the warm start. Results are JSON files in ``--out``;
``page`` makes the page of them. Times are elapsed and processor seconds, without the first
compilation, which is cached.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), sections 5 and 6, Table 2 and Figure 5.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np

import motiondb
from motiondb.database.scenes.scene_making import SceneSettings, make, scene_clips
from motiondb.database.scenes.scene_texts import SceneText, read_scene_text
from scene_tasks import page, paper_baseline

DIAGRAMS = (
    "pass-and-shoot",
    "screen",
    "backdoor",
    "give-and-go",
    "double-team",
    "passing-drills",
    "weave-pass",
    "figure-3",
)


def quiet(_what: str, _share: float, _error: float) -> None:
    """Tell nobody."""


def main() -> None:
    """Run one part."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=["table", "baseline", "update", "page"])
    parser.add_argument("--db", type=Path, default=Path("samples.duckdb"))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--diagrams", nargs="+", default=list(DIAGRAMS))
    parser.add_argument("--seconds", type=float, default=100.0)
    asked = parser.parse_args()
    asked.out.mkdir(exist_ok=True)
    if asked.part == "page":
        print(page.page(asked.out))
        return
    with motiondb.open(asked.db, read_only=True) as base:
        {"table": table, "baseline": baseline, "update": update}[asked.part](base, asked)


def save(out: Path, name: str, facts: dict[str, Any]) -> None:
    """Write a result with what it was measured on."""
    facts |= {"python": platform.python_version(), "processors": os.cpu_count()}
    (out / f"{name}.json").write_text(json.dumps(facts, indent=1))
    shown = {k: v for k, v in facts.items() if not isinstance(v, (list, dict))}
    print(name, shown, flush=True)


def table(base: motiondb.MotionDB, asked: argparse.Namespace) -> None:
    """Every diagram at every seed, from nothing, with its folder."""
    compiled(base)
    for seed in asked.seeds:
        for diagram in asked.diagrams:
            wall, processor = time.perf_counter(), time.process_time()
            scene = base.scenes.make(diagram, SceneSettings(seed=seed))  # bounded by steps alone
            wall, processor = time.perf_counter() - wall, time.process_time() - processor
            base.scenes.write(scene, asked.out / f"{diagram}-{seed}", drawn=seed == asked.seeds[0])
            report = scene.made.report
            facts = {
                "diagram": diagram,
                "seed": seed,
                "characters": report.n_characters,
                "clips": report.n_instances,
                "frames": report.n_frames,
                "error": scene.record.error,
                "rules": len(report.rules),
                "broken": [
                    f"{r.kind} of {r.player} at {r.action}: {r.after:.2f} {r.unit}"
                    f" (allowed {r.threshold:.2f})"
                    for r in report.broken
                ],
                "impossible": [
                    f"{one.kind} of {' and '.join(one.players)} at frame {one.frame}:"
                    f" {one.value:.2f} {one.unit} (possible {one.limit:.2f})"
                    for one in report.impossible
                ],
                "broken before": sum(r.before > r.threshold + 1e-6 for r in report.rules),
                "collisions": len(report.collisions),
                "collisions before": len(report.collisions_before),
                "synchronisation": max(
                    (r.after for r in report.rules if r.kind == "synchronisation"), default=0.0
                ),
                "feet": float(np.mean([f.slip for f in report.feet])),
                "feet of captures": float(np.mean([f.source_slip for f in report.feet])),
                "ball gap": report.ball_gap,
                "too fast": list(scene.made.too_fast),
                "pace": max(pace.after for pace in report.paces),
                "tries": scene.made.cut_at[0],
                "kept": scene.made.tries,
                "rounds": len(scene.made.trace.best) - 1,
                "seconds": wall,
                "processor": processor,
                "parts": scene.made.seconds,
            }
            save(asked.out, f"table-{diagram}-{seed}", facts)


def compiled(base: motiondb.MotionDB) -> None:
    """Make a scene in a moment, so that all that is compiled is there."""
    base.scenes.make("pass-and-shoot", SceneSettings(minutes=1e-4, tries=1))


def material(base: motiondb.MotionDB, diagram: str) -> tuple[SceneText, Any]:
    """A diagram and its clips."""
    text = read_scene_text(diagram)
    return text, scene_clips(base.session, text.grammar)


def baseline(base: motiondb.MotionDB, asked: argparse.Namespace) -> None:
    """The paper's procedure for so many processor seconds, for comparison with ours."""
    compiled(base)
    for seed in asked.seeds:
        for diagram in asked.diagrams:
            text, clips = material(base, diagram)
            rng = np.random.default_rng(seed)
            results = paper_baseline.run(text, clips.library, rng, asked.seconds)
            save(
                asked.out,
                f"baseline-{diagram}-{seed}",
                {"diagram": diagram, "seed": seed} | results,
            )


def update(base: motiondb.MotionDB, asked: argparse.Namespace) -> None:
    """Move one player by half a metre, and time going on from the scene there was."""
    from motiondb.scene.language.tactics_file import read_diagram

    for seed in asked.seeds:
        for diagram in asked.diagrams:
            text, clips = material(base, diagram)
            made = make(text, clips, SceneSettings(seed=seed, minutes=5.0), quiet)
            line = next(x for x in text.diagram_text.splitlines() if x.startswith("attack"))
            words = line.split()
            words[3] = f"{float(words[3]) + 0.5:g}"
            changed = text.diagram_text.replace(line, " ".join(words))
            new = SceneText(
                read_diagram(changed, diagram, text.grammar.activity),
                text.grammar,
                changed,
                text.grammar_text,
            )
            times, kept = [], None
            for _ in range(2):  # the first compiles nothing new, but fills caches
                began = time.perf_counter()
                kept = make(new, clips, SceneSettings(seed=seed), quiet, (text.diagram, made.state))
                times.append(time.perf_counter() - began)
            assert kept is not None
            facts = {
                "diagram": diagram,
                "seed": seed,
                "from nothing": sum(made.seconds.values()),
                "seconds": times[-1],
                "parts": kept.seconds,
                "tries": kept.tries,
                "broken": len(kept.report.broken),
                "collisions": len(kept.report.collisions),
                "error": kept.error,
                "error before": made.error,
            }
            save(asked.out, f"update-{diagram}-{seed}", facts)


if __name__ == "__main__":
    main()
