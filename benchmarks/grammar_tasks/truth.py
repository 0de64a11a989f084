"""Task ``truth`` of ``benchmarks/grammar.py``: takes of the sample data, made from known grammars.

Boundaries count as found within 5 frames. The adjusted Rand index compares frames' terminals with
frames' labels. For the language a true segment belongs to the found segment that holds most of it,
and every terminal is taken for the labels that its segments hold most often, one, several or none;
labels that the true grammar does not know (standing idle at the ends of takes) are left out.
"""

from __future__ import annotations

import csv
import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np

from grammar_tasks import park_2011 as paper
from grammar_tasks.language_match import match_languages
from grammar_tasks.tables import table
from motiondb.body.retarget import to_motion
from motiondb.files.formats import read_capture
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.languages import finite_state_grammar
from motiondb.grammar.sentences.partition import find_sentences, sentences_between
from motiondb.grammar.terminals.distances import make_poses
from motiondb.grammar.terminals.terminals import (
    REPETITION_WEIGHT,
    Terminals,
    find_terminals,
    strings_of,
)
from motiondb.records import IntArray, Motion

SAMPLES = Path(__file__).resolve().parents[2] / "sample_data"
SEEDS = 3
"""Seeds over which a figure is averaged."""
TOLERANCE = 5
"""Frames by which a border may differ from the true one."""
GIVEN = (10, 20, 40)
"""Numbers of true sentences from which a grammar is learned."""
ORDERS = 24
"""Orders of the six sentences of the paper that are tried."""
PARTS = (
    "boundaries",
    "languages of takes",
    "languages of long takes",
    "languages of sentences",
    "the toy grammar",
)
TOY = ("rfdpm", "rfdsm", "rdfsm", "rdpm", "rdsm", "rpm")
KINDS: dict[str, Callable[[Sequence[tuple[str, ...]]], Grammar]] = {
    "motiondb": induce,
    "finite state machine": finite_state_grammar,
}


@dataclass(frozen=True, eq=False)
class TrueTake:
    """A take with its true segments: starts (segments + 1,), ends of the take included; labels."""

    name: str
    motion: Motion
    cuts: IntArray
    labels: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Found:
    """Segments found in takes: take, starts and labels of each, and what they were found for."""

    takes: IntArray
    starts: IntArray
    labels: IntArray


def truth(part: str) -> str:
    """The section of a part."""
    grammars, takes = load_truth()
    if part == "boundaries":
        return boundary_rows(takes)
    if part == "languages of takes":
        return language_rows(grammars, takes)
    if part == "languages of long takes":
        from grammar_tasks.long_takes import long_take_rows  # which needs this module

        return long_take_rows(grammars)
    return given_rows(grammars) if part == "languages of sentences" else toy_rows()


def load_truth() -> tuple[dict[str, Grammar], dict[str, list[TrueTake]]]:
    """The true grammars and the takes made from them."""
    segments: dict[str, list[dict[str, str]]] = {}
    with (SAMPLES / "segments.tsv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            segments.setdefault(row["file"], []).append(row)
    said = json.loads((SAMPLES / "grammars.json").read_text(encoding="utf-8"))
    takes: dict[str, list[TrueTake]] = {}
    for name, made in said.items():
        for take in made["takes"]:
            rows = segments[take["file"]]
            motion = to_motion(read_capture(SAMPLES / "captures" / take["file"]))
            cuts = np.array([*(int(row["start_frame"]) for row in rows), motion.n_frames])
            labels = tuple(row["label"] for row in rows)
            takes.setdefault(name, []).append(TrueTake(take["file"], motion, cuts, labels))
    return {name: _grammar(made["rules"]) for name, made in said.items()}, takes


def _grammar(rules: dict[str, list[list[str]]]) -> Grammar:
    return Grammar(
        "S",
        tuple(
            Rule(left, tuple(right), 1.0 / len(rights))
            for left, rights in rules.items()
            for right in rights
        ),
    )


def boundary_rows(takes: dict[str, list[TrueTake]]) -> str:
    """Boundaries and groups of single takes, K as many as labels."""
    rows = []
    for place, what in ((0, "takes the price was chosen on"), (1, "held-out takes")):
        chosen = [[takes_of_kind[place]] for takes_of_kind in takes.values()]
        ours = np.array([judge_segments(t, _ours(t, s)) for t in chosen for s in range(SEEDS)])
        theirs = np.array([judge_segments(t, _papers(t, 0)) for t in chosen])
        for name, scores in (("motiondb", ours), ("the paper's procedure", theirs)):
            rows.append([f"{what}, {name}", *(f"{score:.2f}" for score in scores.mean(axis=0))])
    pairs = np.array([judge_segments(t, _ours(t, s)) for t in takes.values() for s in range(SEEDS)])
    rows.append(
        ["both takes together, motiondb", *(f"{score:.2f}" for score in pairs.mean(axis=0))]
    )
    heads = ["takes", "boundary F1", "adjusted Rand index", "segments / true"]
    said = f"Means over the three grammars and {SEEDS} seeds, of the paper's procedure one."
    return f"{table(heads, rows)}\n\n{said}"


def label_names(takes: Sequence[TrueTake]) -> list[str]:
    return sorted({label for take in takes for label in take.labels})


def _ours(takes: Sequence[TrueTake], seed: int) -> Found:
    motions = [take.motion for take in takes]
    terminals = find_terminals(motions, len(label_names(takes)), np.random.default_rng(seed))
    return Found(terminals.takes, terminals.starts, terminals.labels)


def _papers(takes: Sequence[TrueTake], seed: int) -> Found:
    poses, rng = make_poses([take.motion for take in takes]), np.random.default_rng(seed)
    k, distances = len(label_names(takes)), paper.pose_table(poses.values)
    cuts = paper.genetic_cuts(poses, distances, k, REPETITION_WEIGHT, rng, paper.GENERATIONS)
    cuts, _, labels, _ = paper.accept_if_better(
        poses, distances, cuts, k, REPETITION_WEIGHT, rng, paper.TUNING_STEPS
    )
    numbers = np.searchsorted(poses.bounds, cuts[:-1], side="right") - 1
    return Found(numbers, cuts[:-1] - poses.bounds[numbers], labels)


def judge_segments(takes: Sequence[TrueTake], segmentation: Found) -> tuple[float, float, float]:
    """F1 of boundaries, adjusted Rand index of frames, segments found for a true one."""
    from sklearn.metrics import adjusted_rand_score

    hits = wanted = 0
    for number, take in enumerate(takes):
        free = [
            int(start) for start in segmentation.starts[segmentation.takes == number] if start > 0
        ]
        wanted += len(free) + len(take.cuts) - 2
        for cut in take.cuts[1:-1]:
            near = [start for start in free if abs(start - cut) <= TOLERANCE]
            if near:
                free.remove(min(near, key=lambda start: abs(start - cut)))
                hits += 1
    names, said = _frames(takes, segmentation)
    n_true = sum(len(take.labels) for take in takes)
    return 2.0 * hits / wanted, adjusted_rand_score(names, said), len(segmentation.starts) / n_true


def _frames(takes: Sequence[TrueTake], segmentation: Found) -> tuple[list[str], list[int]]:
    """The true label and the terminal of every frame."""
    names: list[str] = []
    said: list[int] = []
    for number, take in enumerate(takes):
        names += np.repeat(take.labels, np.diff(take.cuts)).tolist()
        of_take = segmentation.takes == number
        ends = np.append(segmentation.starts[of_take][1:], take.motion.n_frames)
        said += np.repeat(
            segmentation.labels[of_take], ends - segmentation.starts[of_take]
        ).tolist()
    return names, said


def language_rows(grammars: dict[str, Grammar], takes: dict[str, list[TrueTake]]) -> str:
    """Languages learned from both takes of a grammar: from true labels and from their motion, the
    sentences found, or given."""
    rows = []
    for name, takes_of_kind in takes.items():
        begins = _true_begins(name, takes_of_kind)
        for what, strings, starts, meaning in (
            true_strings(takes_of_kind),
            found_strings(takes_of_kind),
        ):
            partition = find_sentences(strings, np.random.default_rng(0))
            given = given_sentences(strings, starts, begins)
            for how, sentences in (("found", partition.sentences), ("given", given)):
                for kind, learn in KINDS.items():
                    whole = kind == "motiondb" and how == "found"
                    grammar = partition.grammar if whole else learn(sentences)
                    learned = as_labels(grammar, meaning, grammars[name])
                    from_what = f"{name}: {what}, sentences {how}"
                    rows.append([from_what, kind, *match_row([learned], grammars[name])])
    return table(["learned from", "grammar", "precision", "recall", "F1"], rows)


def given_sentences(
    strings: Sequence[tuple[str, ...]], starts: Sequence[IntArray], begins: Sequence[list[int]]
) -> tuple[tuple[str, ...], ...]:
    """The true sentences in terms of the found segments; segments before the first belong to
    none."""
    told, cuts = [], []
    for string, symbols, wanted in zip(strings, starts, begins, strict=True):
        first, *others = (int(np.argmin(np.abs(symbols - frame))) for frame in wanted)
        told.append(string[first:])
        cuts.append(sorted({place - first for place in others if place > first}))
    return sentences_between(told, cuts).sentences


Meaning = dict[str, tuple[str, ...]]
Strings = tuple[str, list[tuple[str, ...]], list[IntArray], Meaning]
"""What they are made of, the strings, their segments' starts, labels of terminals."""


def _true_begins(name: str, takes: Sequence[TrueTake]) -> list[list[int]]:
    """The frames at which the sentences of each take begin."""
    said = json.loads((SAMPLES / "grammars.json").read_text(encoding="utf-8"))
    return [
        sentence_begins(take, [sentence["words"] for sentence in made["sentences"]])
        for take, made in zip(takes, said[name]["takes"], strict=True)
    ]


def sentence_begins(take: TrueTake, sentences: Sequence[Sequence[str]]) -> list[int]:
    """The frames at which sentences begin; before the first may be a rest."""
    firsts = np.cumsum([0, *map(len, sentences)])[:-1]
    idle = 1 if take.labels[0] == "idle" else 0
    return [int(take.cuts[idle + first]) for first in firsts]


def true_strings(takes: Sequence[TrueTake]) -> Strings:
    """Each label a terminal."""
    labels = [take.labels for take in takes]
    strings: dict[str, tuple[str, ...]] = {label: (label,) for label in label_names(takes)}
    return "true labels", labels, [take.cuts[:-1] for take in takes], strings


def found_strings(takes: Sequence[TrueTake], share: float = 1.0) -> Strings:
    """Terminals found in the motion, ``share`` times as many as labels, and the labels of each."""
    motions = [take.motion for take in takes]
    number = round(share * len(label_names(takes)))
    return strings_found(takes, find_terminals(motions, number, np.random.default_rng(0)))


def strings_found(takes: Sequence[TrueTake], terminals: Terminals) -> Strings:
    """The strings of terminals, and the labels that the segments of each hold most often."""
    starts = [terminals.starts[terminals.takes == number] for number in range(len(takes))]
    strings = list(strings_of(terminals))
    held: dict[str, Counter[tuple[str, ...]]] = {name: Counter() for name in terminals.names}
    for take, motion, string in zip(takes, starts, strings, strict=True):
        for name, labels in zip(string, _held_labels(take, motion), strict=True):
            held[name][labels] += 1
    meaning = {name: counts.most_common(1)[0][0] for name, counts in held.items()}
    return "motion", strings, starts, meaning


def _held_labels(take: TrueTake, starts: IntArray) -> list[tuple[str, ...]]:
    """The labels of the true segments that lie, with most of their frames, in each found one."""
    held: list[list[str]] = [[] for _ in starts]
    numbers = np.searchsorted(starts, np.arange(take.motion.n_frames), side="right") - 1
    for label, low, high in zip(take.labels, take.cuts[:-1], take.cuts[1:], strict=True):
        held[int(np.bincount(numbers[low:high]).argmax())].append(label)
    return [tuple(labels) for labels in held]


def as_labels(grammar: Grammar, meaning: Meaning, truth: Grammar) -> Grammar:
    """Terminals as labels; those that the true grammar does not know are left out."""
    known = set(truth.terminals)
    merged: dict[tuple[str, tuple[str, ...]], float] = {}
    for rule in grammar.rules:  # rules may become one
        right: list[str] = []
        for symbol in rule.right:
            said = meaning.get(symbol)
            right += [symbol] if said is None else [label for label in said if label in known]
        key = rule.left, tuple(right)
        merged[key] = merged.get(key, 0.0) + (rule.probability or 0.0)
    return Grammar(grammar.start, tuple(Rule(*key, p) for key, p in merged.items()))


def match_row(learned: Sequence[Grammar], truth: Grammar) -> list[str]:
    """Precision, recall and their F1, means over grammars."""
    rng = np.random.default_rng(0)
    matches = [match_languages(grammar, truth, rng) for grammar in learned]
    precision = float(np.mean([one.precision for one in matches]))
    recall = float(np.mean([one.recall for one in matches]))
    both = [2 * m.precision * m.recall / max(m.precision + m.recall, 1e-12) for m in matches]
    return [f"{precision:.2f}", f"{recall:.2f}", f"{np.mean(both):.2f}"]


def given_rows(grammars: dict[str, Grammar]) -> str:
    """Languages learned from more sentences, drawn from the true grammars."""
    rows = []
    for name, truth in grammars.items():
        for n in GIVEN:
            samples = [_drawn(truth, n, seed) for seed in range(SEEDS)]
            for kind, learn in KINDS.items():
                learned = [learn(sample) for sample in samples]
                rows.append([f"{name}, {n} sentences", kind, *match_row(learned, truth)])
    return table(["learned from", "grammar", "precision", "recall", "F1"], rows)


def _drawn(truth: Grammar, n: int, seed: int) -> list[tuple[str, ...]]:
    rng = np.random.default_rng(seed)
    return [derive(truth, rng).leaves() for _ in range(n)]


def toy_rows() -> str:
    """The toy grammar from its six strings, in all orders."""
    from motiondb.grammar.cfg.context_free import read_grammar

    truth = read_grammar(
        "S -> r X1 X2 m\nX1 -> X3 X4 X3\nX2 -> p | s\nX3 -> f | empty\nX4 -> d | empty"
    )
    started = time.process_time()
    orders = list(permutations(TOY))[:: 720 // ORDERS]
    learned = {induce([tuple(s) for s in order]) for order in orders}
    spent = time.process_time() - started
    rows = []
    for kind, learn in KINDS.items():
        grammar = learn([tuple(s) for s in TOY])
        size = str(len(grammar.nonterminals)), str(len(grammar.rules))
        rows.append([kind, *size, *match_row([grammar], truth)])
    said = (
        f"From the six strings {', '.join(TOY)} (the language has 14). "
        f"{ORDERS} of their 720 orders give {len(learned)} grammar{'s' * (len(learned) > 1)} "
        f"({spent / ORDERS * 1e3:.0f} ms each); a test tries 30 of them at less effort."
    )
    heads = ["grammar", "nonterminals", "rules", "precision", "recall", "F1"]
    return f"{table(heads, rows)}\n\n{said}"
