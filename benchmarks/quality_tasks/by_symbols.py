"""Search by symbols against search by words: the same questions, performers never seen.

Five folds by performer. Per fold a database learns from all captures, with the captions of the
other performers only; the fold's captures are ranked by :meth:`MotionDB.search`, and their captions
are only used to judge.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import motiondb
from motiondb.database.catalogue.file_reading import AddSettings
from motiondb.language import vocabulary
from motiondb.learn.recognition import LearnSettings
from motiondb.records import FloatArray
from quality_protocol.captures import Capture, load_cmu, performer_folds, without_copies
from quality_protocol.confidence import weighted_draws, weighted_measure
from quality_protocol.report import Measure, TaskReport
from quality_tasks.words import (
    LEAST_SHOWN,
    LEAST_TRAINED,
    Judged,
    average_precisions,
    calibration_error,
)

METHODS = ("search by words", "search --by-symbols")
KINDS = ("one word", "one action, then another")
FIRST = 5
"""Answers of a question whose probabilities are judged."""
_Ranked = dict[tuple[int, int], tuple[NDArray[np.int64], NDArray[np.bool_]]]


def run(data: Path, seed: int) -> TaskReport:
    """Mean average precision and calibration of both searches, by kind of question."""
    captures = without_copies(load_cmu(data))
    said = [[vocabulary.split_actions(text) for text in c.captions] for c in captures]
    number = performer_folds(tuple(c.performer for c in captures))
    ranked: dict[tuple[str, str], _Ranked] = {(k, m): {} for k in KINDS for m in METHODS}
    sure: dict[tuple[str, str], list[tuple[float, bool]]] = {key: [] for key in ranked}
    for k in range(5):
        gallery = [n for n in np.flatnonzero(number == k).tolist() if said[n]]
        train = [n for n in np.flatnonzero(number != k).tolist() if said[n]]
        with tempfile.TemporaryDirectory() as folder, motiondb.open(f"{folder}/fold") as db:
            sheet = _without(data, {captures[n].performer for n in gallery}, Path(folder))
            db.add(data / "cmu", sheet, AddSettings(skip_bad_frames=True))
            db.learn(LearnSettings(seed=seed))
            for q, (kind, text, right) in enumerate(_questions(said, train, gallery)):
                for method in METHODS:
                    found = db.search(text, limit=len(captures), by_symbols=method == METHODS[1])
                    of = {match.capture: match for match in found.matches}
                    last = len(of) + 1
                    ranks = [
                        of[captures[n].name].rank if captures[n].name in of else last
                        for n in gallery
                    ]
                    order = np.argsort(ranks, kind="stable")
                    ranked[kind, method][k, q] = np.array(gallery)[order], right[order]
                    for n in order[:FIRST]:
                        match = of.get(captures[gallery[n]].name)
                        if match is not None and match.probability is not None:
                            sure[kind, method].append((match.probability, bool(right[n])))
    return _report(ranked, sure, captures, seed)


def _without(data: Path, performers: set[str], folder: Path) -> Path:
    """Write the sheet of captions without those of some performers."""
    with (data / "cmu-captions.tsv").open(encoding="utf-8", newline="") as source:
        rows = list(csv.DictReader(source, delimiter="\t"))
    sheet = folder / "captions.tsv"
    with sheet.open("w", encoding="utf-8", newline="") as target:
        writer = csv.DictWriter(target, rows[0].keys(), delimiter="\t")
        writer.writeheader()
        writer.writerows(
            row | {"words": "" if row["performer"] in performers else row["words"]} for row in rows
        )
    return sheet


def _questions(
    said: Sequence[Sequence[Sequence[Sequence[str]]]], train: Sequence[int], gallery: Sequence[int]
) -> Iterator[tuple[str, str, NDArray[np.bool_]]]:
    """Yield kind, text, and which captures of the gallery are right."""
    words = [{w for text in texts for action in text for w in action} for texts in said]
    known = {
        w
        for w in set().union(*(words[n] for n in train))
        if sum(w in words[n] for n in train) >= LEAST_TRAINED
    }
    for word in sorted(known):
        right = np.array([word in words[n] for n in gallery])
        if LEAST_SHOWN <= right.sum() < len(right):
            yield KINDS[0], word, right
    verbs = known - set(vocabulary.MODIFIERS)
    pairs = {
        (a, b)
        for n in gallery
        for text in said[n]
        for first, then in pairwise(text)
        for a in set(first) & verbs
        for b in set(then) & verbs
        if a != b
    }
    for a, b in sorted(pairs):
        right = np.array([{a, b} <= words[n] for n in gallery])
        if LEAST_SHOWN <= right.sum() < len(right):
            yield KINDS[1], f"{a}, {b}", right


def _report(
    ranked: dict[tuple[str, str], _Ranked],
    sure: dict[tuple[str, str], list[tuple[float, bool]]],
    captures: Sequence[Capture],
    seed: int,
) -> TaskReport:
    weights, empty = weighted_draws(len(captures), seed), np.zeros(0)
    rows: list[tuple[str | float | Measure, ...]] = []
    for kind in KINDS:
        of: dict[str, FloatArray] = {}
        for method in METHODS:
            queries = ranked[kind, method]
            judged = Judged(queries, empty, empty, empty, (empty, empty))
            of[method] = average_precisions(judged, weights)
            better = of[METHODS[0]] - of[method] if method != METHODS[0] else ""
            told = np.array(sure[kind, method], dtype=float).reshape(-1, 2)
            high = told[told[:, 0] >= 0.5]
            rows.append(
                (
                    kind,
                    method,
                    weighted_measure(of[method]),
                    better if isinstance(better, str) else weighted_measure(better),
                    str(len(queries)),
                    calibration_error(told[:, 0], told[:, 1]) if len(told) else "-",
                    f"{int(high[:, 1].sum())} of {len(high)}",
                )
            )
    return TaskReport(
        "Search by symbols",
        f"{len(captures)} CMU captures, 15 performers, five folds by performer. Words of at least "
        f"{LEAST_TRAINED} training captures that at least {LEAST_SHOWN} of the gallery show, and "
        "two verbs whose order a caption of the gallery tells, of which captures with both words "
        f"are right. Probabilities are those of the first {FIRST} answers where there is one; "
        "*sure and right*: of those with at least 0.5.",
        ("question", "search", "mean average precision", "words better by", "questions",
         "calibration error", "sure and right"),
        tuple(rows), (),
    )  # fmt: skip
