"""Task ``speed`` of ``benchmarks/grammar.py``: times on a take of the paper's length.

Elapsed and processor seconds are both listed: on a machine with other load, only the latter can be
compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from measured_run import machine

from grammar_tasks import made_up_strings as strings
from grammar_tasks import park_2011 as paper
from grammar_tasks.tables import table
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.grammar.cfg.parse import parse
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.sentences.cutting import Room, cutting_room
from motiondb.grammar.terminals import terminals, tuning
from motiondb.grammar.terminals.distances import Poses, make_poses
from motiondb.records import Motion

K = 20
N_RULES, N_NONTERMINALS, SENTENCE_LENGTH = 150, 30, 20
"""Rules and nonterminals of the grammar, and terminals of the sentence, of the stated target."""
EVALUATIONS, SEARCH_SEEDS = 1000, 8
"""Partitions tried by each search, and searches. Chosen by hand; not tuned."""


def speed(data: Path) -> str:
    """The section's tables."""
    takes = paper.long_take(data)
    poses = make_poses(takes)
    said = [f"{machine()}. The take: {poses.n_frames:,} frames, K = {K}.", ""]
    return "\n".join([*said, terminal_rows(takes, poses), "", step_rows(takes, poses), "",
                      search_rows()])  # fmt: skip


def measured(work: Callable[[], object]) -> tuple[object, float, float]:
    """What it gives, its seconds and its processor seconds."""
    started = time.perf_counter(), time.process_time()
    result = work()
    return result, time.perf_counter() - started[0], time.process_time() - started[1]


def terminal_rows(takes: Sequence[Motion], poses: Poses) -> str:
    """Terminals as the paper finds them and as motiondb does, seed 0."""
    weight = terminals.REPETITION_WEIGHT
    terminals.find_terminals(takes[:2], 2, np.random.default_rng(0))  # compiled before
    segmentation, wall, processor = measured(
        lambda: terminals.find_terminals(takes, K, np.random.default_rng(0))
    )
    assert isinstance(segmentation, terminals.Terminals)
    theirs = paper.rescored(poses, segmentation, weight)
    rows = [
        [
            "motiondb",
            f"{theirs:.2f}",
            str(len(segmentation.starts)),
            f"{wall:.1f}",
            f"{processor:.1f}",
        ]
    ]
    ours, wall, processor = measured(lambda: _of_paper(poses, weight))
    assert isinstance(ours, tuple)
    rows.append(
        ["the paper's procedure", f"{ours[1]:.2f}", str(ours[0]), f"{wall:.1f}", f"{processor:.1f}"]
    )
    return table(["terminals", "F", "segments", "seconds", "processor seconds"], rows)


def _of_paper(poses: Poses, weight: float) -> tuple[int, float]:
    rng = np.random.default_rng(0)
    distances = paper.pose_table(poses.values)
    cuts = paper.genetic_cuts(poses, distances, K, weight, rng, paper.GENERATIONS)
    cuts, _, _, reached = paper.accept_if_better(
        poses, distances, cuts, K, weight, rng, paper.TUNING_STEPS
    )
    return len(cuts) - 1, reached


def step_rows(takes: Sequence[Motion], poses: Poses) -> str:
    """One step of tuning, one description length, one parse."""
    settings = terminals.TerminalSettings(n_starts=4, n_trials=400)
    segmentation = terminals.find_terminals(takes, K, np.random.default_rng(0), settings=settings)
    starts = poses.bounds[segmentation.takes] + segmentation.starts
    cuts = np.append(starts, poses.n_frames)
    grouping = tuning.Grouping(cuts, segmentation.labels, segmentation.medoids)
    costs = terminals.cut_costs(poses, settings)
    told, _, processor = measured(lambda: tuning.tune(grouping, costs, np.random.default_rng(0)))
    assert isinstance(told, tuple)
    rows = [["one step of Slide or Resize", f"{processor / told[1] * 1e3:.3f} ms", "0.2 ms"]]
    for n, k in ((367, 20), (885, 20), (885, 60)):
        count, spent = strings.partition_time(n, k)
        what = f"description length, {count} sentences of {n} symbols, K = {k}"
        rows.append([what, f"{spent * 1e3:.3f} ms", "1 ms"])
    grammar, spent = parse_time()
    what = f"most probable tree of {SENTENCE_LENGTH} symbols, {len(grammar.rules)} rules"
    rows.append([what, f"{spent * 1e3:.2f} ms", "10 ms"])
    return table(["step", "processor time", "asked for"], rows)


def random_grammar(rng: np.random.Generator) -> Grammar:
    """An ambiguous grammar of 150 rules, every nonterminal with a rule of terminals."""
    names = ["S", *(f"N{k}" for k in range(1, N_NONTERMINALS))]
    letters = terminals.terminal_names(K)
    rules = {Rule(name, (letters[int(rng.integers(K))],)): None for name in names}
    while len(rules) < N_RULES:
        left = names[int(rng.integers(len(names)))]
        right = [str(rng.choice([*names[1:], *letters])) for _ in range(int(rng.integers(2, 4)))]
        rules[Rule(left, tuple(right))] = None
    return Grammar("S", tuple(rules), letters).with_probabilities(
        [1.0 / sum(other.left == rule.left for other in rules) for rule in rules]
    )


def parse_time(n_sentences: int = 20) -> tuple[Grammar, float]:
    """A grammar, and the mean processor seconds of parsing its sentences of 20 symbols."""
    rng = np.random.default_rng(0)
    grammar = random_grammar(rng)
    sentences = [derive(grammar, rng, length=SENTENCE_LENGTH).leaves() for _ in range(n_sentences)]
    sentences = [s for s in sentences if len(s) == SENTENCE_LENGTH]
    parse(grammar, sentences[0])
    _, _, processor = measured(lambda: [parse(grammar, sentence) for sentence in sentences])
    return grammar, processor / len(sentences)


def search_rows() -> str:
    """Search against best-of-random at equal evaluations, paired over seeds."""
    rows = []
    for n, k in ((156, 12), (367, 20), (367, 40)):
        searched, drawn = strings.against_random(_room(n, k), EVALUATIONS, SEARCH_SEEDS)
        better = sum(a < b - 1e-9 for a, b in zip(searched, drawn))
        worse = sum(a > b + 1e-9 for a, b in zip(searched, drawn))
        rows.append(
            [str(n), str(k), f"{np.mean(searched):.1f}", f"{np.mean(drawn):.1f}",
             f"{np.mean(np.subtract(drawn, searched)):.1f}", f"{better}, {worse} of {SEARCH_SEEDS}"]
        )  # fmt: skip
    heads = [
        "symbols",
        "K",
        "bits, search",
        "bits, best of random",
        "saved",
        "search better, worse",
    ]
    return table(heads, rows)


def _room(n: int, k: int) -> Room:
    return cutting_room([strings.chain_string(n, k, 1)])
