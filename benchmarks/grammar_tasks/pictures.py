"""Task ``pictures`` of ``benchmarks/grammar.py``: strings, trees and synthesised motion.

All by the verbs that the commands call, on a database made from the captures.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

import motiondb
from grammar_tasks.real_takes import STYLES
from grammar_tasks.tables import table
from motiondb.database.catalogue.file_reading import AddSettings
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material
from motiondb.database.motion_db import MotionDB
from motiondb.generate.stitching import join_costs
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.synthesis import clip_candidates
from quality_protocol.captures import Capture, load_cmu

N_TERMINALS = 20
"""Terminals of every style. Chosen by hand; not tuned."""
LENGTH, N_SEQUENCES, SEEDS = 12, 8, 100
"""Terminals of a generated sequence, sequences of a style, and seeds. Chosen by hand; not tuned."""
TREES = ("break-dance", "basketball")


def pictures(data: Path, styles: Sequence[str], folder: Path) -> str:
    """The section: what the synthesised motion costs, and links to the pictures."""
    captures = load_cmu(data)
    rows, shown = [], []
    with tempfile.TemporaryDirectory() as place, motiondb.open(Path(place) / "g.duckdb") as base:
        for style in styles:
            of_style = [capture for capture in captures if STYLES[style](capture)]
            rows.append([style, *_drawn(base, data, style, of_style, folder)])
            names = ["strings", *(["trees"] if style in TREES else []), "sequence"]
            shown += [f"![{style}: {name}](pictures/grammar-{style}-{name}.png)" for name in names]
    heads = ["take", "seams, cost by dynamic programming", "greedily as printed",
             "foot slip, m/s", "of the sources"]  # fmt: skip
    said = (
        f"{N_TERMINALS} terminals; means of {N_SEQUENCES} sequences of {LENGTH} terminals or as "
        "near to that as a sentence has."
    )
    return "\n\n".join([said, table(heads, rows), *shown])


def _drawn(
    base: MotionDB, data: Path, style: str, captures: Sequence[Capture], folder: Path
) -> list[str]:
    """Draw a style's pictures; costs and foot slip of its sequences."""
    for performer in sorted({capture.name.split("/")[0] for capture in captures}):
        sheet, settings = data / "cmu-captions.tsv", AddSettings(skip_bad_frames=True)
        base.add(data / "cmu" / performer, sheet, settings)
    there = {info.name for info in base.captures()}
    names = [c.name if c.name in there else c.name.split("/")[1] for c in captures]
    sentences = "captures" if style == "basketball" else "auto"
    base.grammars.learn(names, style, GrammarSettings(N_TERMINALS, sentences=sentences))
    path = folder / f"grammar-{style}"
    base.grammars.draw_strings(style, f"{path}-strings.png")
    if style in TREES:
        base.grammars.draw_trees(style, f"{path}-trees.png")
    made = [base.grammars.generate(style, seed, LENGTH) for seed in range(N_SEQUENCES)]
    base.grammars.draw_sequence(_new_one(base, style) or made[0], f"{path}-sequence.png")
    material = base.grammars.material(style)
    means = np.mean(
        [
            (s.choice.cost, greedy_cost(material, s, seed), s.made.slip, s.made.source_slip)
            for seed, s in enumerate(made)
        ],
        axis=0,
    )
    return [f"{value:.2f}" for value in means]


def greedy_cost(material: Material, sequence: GrammarSequence, seed: int) -> float:
    """Cost of the joins of the paper's choice: any first segment, then always the best next one."""
    sentences, n = material.learned.sentences, len(sequence.string)
    ends = {n - 1: sentences[:, 1] - 1, 0: sentences[:, 0]}
    candidates, _ = clip_candidates(
        material.learned.terminals, sequence.string, material.source, None, ends
    )
    pick, total = int(np.random.default_rng(seed).integers(len(candidates[0].starts))), 0.0
    for before, after in pairwise(candidates):
        costs = join_costs(before, after)[pick]
        pick = int(np.argmin(costs))
        total += float(costs[pick])
    return total


def _new_one(base: MotionDB, style: str) -> GrammarSequence | None:
    """The first sequence that is none of the sentences that the grammar was learned from."""
    learned = base.grammars.load(style)
    for seed in range(SEEDS):
        if derive(learned.grammar, np.random.default_rng(seed)).leaves() not in learned.strings:
            return base.grammars.generate(style, seed)
    return None
