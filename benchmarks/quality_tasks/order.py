"""Order: "walk, then kick" compared with "kick, then walk" in a capture that shows the former.

Sample-data takes with their true segments, real captures joined two by two, the long take 86_01,
and real captions of two or more actions. Words come from other performers.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.language import vocabulary
from motiondb.meaning import word_map
from motiondb.meaning.by_question import search_order
from motiondb.records import IntArray, Motion
from quality_protocol.captures import (
    Capture,
    load_cmu,
    load_sheet,
    performer_folds,
    without_copies,
)
from quality_protocol.confidence import mean_of
from quality_protocol.recognition import Recognised, recognise
from quality_protocol.report import Measure, TaskReport
from quality_tasks.example import main_verb

SAMPLE = Path(__file__).resolve().parents[2] / "sample_data"
N_JOINED = 120
"""Pairs of captures that are joined. Chosen by hand for the time that it takes."""
COMMON_VERBS = ("walk", "run", "jump", "dance", "climb", "kick")


@dataclass(frozen=True)
class Told:
    """A capture (its place), the actions that it shows, in order, and where the truth is from."""

    capture: int
    actions: tuple[tuple[str, ...], ...]
    source: str


def run(data: Path, seed: int) -> TaskReport:
    """Accuracy by source; a tie counts half."""
    real = without_copies(load_cmu(data))
    joined, truths = _joined(real, seed)
    captions = [
        Told(n, actions, "real captions of two actions or more")
        for n, c in enumerate(real)
        for actions in _told(c.captions)
    ]
    questions = [*truths, *_long_take(data, real), *captions]
    made = load_sheet(SAMPLE / "captures", SAMPLE / "captions.tsv")
    rows = _rows([*real, *joined], len(real), questions, seed)
    rows = _rows(made, len(made), _sample_sequences(made), seed) + rows
    return TaskReport(
        "Order",
        "A sequence of two or more actions is compared with the same actions in reversed order, "
        "in the capture that shows them. The words are learned from other performers' captions "
        "(five folds). The true order is known for the sample data (synthetic), for joined "
        "captures and for 86_01. Captions often list actions that happen at the same time or in "
        "another order.",
        ("source", "questions", "motiondb", "bag of words"),
        tuple(rows),
        (
            "A bag of words gives both orders the same score, so half of its answers are right by "
            "chance.",
        ),
    )


def _rows(
    captures: Sequence[Capture], n_known: int, questions: Sequence[Told], seed: int
) -> list[tuple[str | float | Measure, ...]]:
    known = np.arange(len(captures)) < n_known
    seen = recognise(captures, known, seed)
    folds = performer_folds([c.performer for c in captures])
    right: dict[str, list[float]] = {}
    for k in np.unique(folds):
        train = np.flatnonzero((folds != k) & known)
        of_fold = [q for q in questions if folds[q.capture] == k]
        for question, value in zip(of_fold, _answer(seen, captures, train, of_fold)):
            if not np.isnan(value):
                right.setdefault(question.source, []).append(value)
    return [
        (source, str(len(values)), mean_of(values, seed), 0.5) for source, values in right.items()
    ]


def _answer(
    seen: Recognised,
    captures: Sequence[Capture],
    train: IntArray,
    questions: Sequence[Told],
) -> list[float]:
    """1, 0.5 or 0 for every question; NaN where fewer than two different actions are known."""
    said = [{w for t in captures[n].captions for w in vocabulary.words_of(t)} for n in train]
    there = np.array([bool(words) for words in said])
    names = sorted(set().union(*said))
    number = {word: n for n, word in enumerate(names)}
    words = np.array([[name in row for name in names] for row in said])
    groups = np.unique([captures[n].performer for n in train], return_inverse=True)[1]
    fit = word_map.fit_word_map(seen.vectors[train[there]], words[there], groups[there])
    captions = seen.captions(train[there], words[there], names)
    answers = []
    for question in questions:
        actions = [[number[w] for w in a if w in number] for a in question.actions]
        actions = [action for action in actions if action]
        if len(actions) < 2 or actions == actions[::-1]:
            answers.append(float("nan"))
            continue
        take = seen.hear(fit, captions, [question.capture])[0]
        hits = [search_order(take, asked) for asked in (actions, actions[::-1])]
        first, second = (-np.inf if hit is None else hit.log_odds for hit in hits)
        answers.append(0.5 if first == second else float(first > second))
    return answers


def _told(captions: Sequence[str]) -> list[tuple[tuple[str, ...], ...]]:
    split = [tuple(tuple(a) for a in vocabulary.split_actions(text) if a) for text in captions]
    return [actions for actions in split if len(actions) > 1 and actions != actions[::-1]]


def join_pairs(real: Sequence[Capture], seed: int) -> list[tuple[int, int, tuple[str, str]]]:
    """Pairs of captures of one performer with different main verbs, and these verbs."""
    rng = np.random.default_rng(seed)
    verbs = [main_verb(c.captions) for c in real]
    single = [n for n, c in enumerate(real) if verbs[n] in COMMON_VERBS and len(c.features) < 300]
    pairs = [
        (a, b)
        for a in single
        for b in single
        if real[a].performer == real[b].performer and verbs[a] != verbs[b]
    ]
    chosen = [pairs[i] for i in rng.permutation(len(pairs))[:N_JOINED]]
    return [(a, b, (verbs[a], verbs[b])) for a, b in chosen]


def _joined(real: Sequence[Capture], seed: int) -> tuple[list[Capture], list[Told]]:
    """Pairs of captures, one after the other."""
    captures, truths = [], []
    for a, b, (verb_a, verb_b) in join_pairs(real, seed):
        first, second = real[a], real[b]
        motion = Motion(
            np.concatenate([first.motion.local_rotations, second.motion.local_rotations]),
            np.concatenate([first.motion.root_positions, second.motion.root_positions]),
        )
        features = np.concatenate([first.features, second.features])
        name = f"{first.name}+{second.name}"
        captures.append(Capture(name, first.performer, (), "", motion, features))
        place = len(real) + len(captures) - 1
        truths.append(Told(place, ((verb_a,), (verb_b,)), "joined real captures"))
    return captures, truths


def _long_take(data: Path, real: Sequence[Capture]) -> list[Told]:
    """Neighbouring true segments of 86_01."""
    labels = _labels(data / "cmu-segments.tsv", "clip").get("86_01", [])
    place = next(n for n, c in enumerate(real) if c.name.endswith("86_01"))
    actions = [tuple(vocabulary.words_of(label)) for label in labels]
    source = "86_01, runs of three true segments"
    return [
        Told(place, tuple(actions[n : n + 3]), source)
        for n in range(len(actions) - 2)
        if all(actions[n : n + 3])
    ]


def _sample_sequences(made: Sequence[Capture]) -> list[Told]:
    """The true segments of every sample take, without standing about, in order."""
    labels = _labels(SAMPLE / "segments.tsv", "file")
    told = []
    for place, capture in enumerate(made):
        rows = labels.get(f"{capture.name}.bvh", [])
        actions = [tuple(vocabulary.words_of(label)) for label in rows if label != "idle"]
        actions = [a for n, a in enumerate(actions) if a and (n == 0 or a != actions[n - 1])]
        if len(actions) > 1:
            told.append(Told(place, tuple(actions[:4]), "sample data (synthetic)"))
    return told


def _labels(sheet: Path, column: str) -> dict[str, list[str]]:
    labels_of: dict[str, list[str]] = {}
    with sheet.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            labels_of.setdefault(row[column], []).append(row["label"].replace("_", " "))
    return labels_of
