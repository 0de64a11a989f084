"""Part ``languages of long takes`` of task ``truth``: takes long enough to hold a grammar.

The sample data's two takes of a grammar hold 4 to 7 sentences. Here the same program makes two
takes of ten sentences each, of the same performers, with a seed that no setting was chosen on.
Languages are learned from the true labels and from the motion; sentences are found, or given.
In addition to the languages of sentences, the tables have their factors (``factors``), which do not
depend on where sentences are cut, and the borders of sentences: a border counts as found where a
true one is.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grammar_tasks.factors import match_factors
from grammar_tasks.tables import table
from motiondb.body.retarget import to_motion
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.sentences.partition import find_sentences
from motiondb.records import IntArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from grammar_tasks import truth as known
from sample_data.score import FPS
from sample_data.takes import Capture, perform

PERFORMERS = {"dance": ("dora", "ana"), "fight": ("boris", "goran"), "play": ("chidi", "fatou")}
SENTENCES_A_TAKE = 10
"""Sentences in every generated take. Chosen by hand; not tuned."""
SEED = 2
"""Settings were chosen on strings of seeds 0 to 3 and on takes of seed 101."""

HEADS = ["learned from", "grammar", "precision", "recall", "F1", "of factors", "recall", "F1"]


def long_take_rows(grammars: dict[str, Grammar]) -> str:
    """The tables: languages, and borders of the sentences found."""
    rows: list[list[str]] = []
    borders: list[list[str]] = []
    for name, truth in grammars.items():
        takes, begins = long_takes(name)
        width = 2 * round(sum(len(t.labels) for t in takes) / sum(map(len, begins)))
        for what, strings, starts, meaning in (
            known.true_strings(takes),
            known.found_strings(takes),
        ):
            partition = find_sentences(strings, np.random.default_rng(0))
            given = known.given_sentences(strings, starts, begins)
            borders.append([f"{name}: {what}", *_border_row(partition.cuts, starts, begins)])
            for how, sentences in (("found", partition.sentences), ("given", given)):
                for kind, learn in known.KINDS.items():
                    learned_cuts = kind == "motiondb" and how == "found"
                    learned = partition.grammar if learned_cuts else learn(sentences)
                    labelled = known.as_labels(learned, meaning, truth)
                    measures = (
                        *known.match_row([labelled], truth),
                        *_factors(labelled, truth, width),
                    )
                    rows.append([f"{name}: {what}, sentences {how}", kind, *measures])
    heads = ["borders between sentences", "true", "found", "of these true"]
    return f"{table(HEADS, rows)}\n\n{table(heads, borders)}"


def long_takes(name: str, seed: int = SEED) -> tuple[list[known.TrueTake], list[list[int]]]:
    """Takes of a grammar's performers, and the frames at which their sentences begin.

    The rest before the first sentence and after the last is cut off: it belongs to none.
    """
    takes, begins = [], []
    for number, person in enumerate(PERFORMERS[name], start=1):
        capture = Capture(person, f"long_{name}_{number}", grammar=name, sentences=SENTENCES_A_TAKE)
        take, derivations = perform(capture, seed)
        motion, words = to_motion(take.clip()), [d.words() for d in derivations]
        starts = [round(start * FPS) for _, start, _ in take.segments]
        labels = tuple(label for label, _, _ in take.segments)
        whole = known.TrueTake(capture.file, motion, np.array([*starts, motion.n_frames]), labels)
        frames = known.sentence_begins(whole, words)
        takes.append(_without_rests(whole, sum(map(len, words))))
        begins.append([frame - frames[0] for frame in frames])
    return takes, begins


def _without_rests(take: known.TrueTake, n_labels: int) -> known.TrueTake:
    first = 1 if take.labels[0] == "idle" else 0
    cuts = take.cuts[first : first + n_labels + 1]
    low, high = cuts[0], cuts[-1]
    motion = replace(
        take.motion,
        local_rotations=take.motion.local_rotations[low:high],
        root_positions=take.motion.root_positions[low:high],
    )
    return known.TrueTake(take.name, motion, cuts - low, take.labels[first : first + n_labels])


def _border_row(
    cuts: Sequence[Sequence[int]], starts: Sequence[IntArray], begins: Sequence[Sequence[int]]
) -> list[str]:
    """How many borders there are between true sentences, between found ones, and in both."""
    wanted = hits = made = 0
    for inner, cuts_of_string, true in zip(cuts, starts, begins, strict=True):
        places = {int(np.argmin(np.abs(cuts_of_string - frame))) for frame in true[1:]}
        wanted += len(true) - 1
        made += len(inner)
        hits += len(places & set(inner))
    return [str(wanted), str(made), str(hits)]


def _factors(learned: Grammar, truth: Grammar, width: int) -> list[str]:
    precision, recall = match_factors(learned, truth, width, np.random.default_rng(0))
    both = 2.0 * precision * recall / max(precision + recall, 1e-12)
    return [f"{precision:.2f}", f"{recall:.2f}", f"{both:.2f}"]
