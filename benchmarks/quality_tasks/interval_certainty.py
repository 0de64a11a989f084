"""Whether the probability that a place is right is right, on joined real captures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.language import vocabulary
from motiondb.learn.learned import Learned
from motiondb.meaning import place_certainty
from motiondb.meaning.place_certainty import JoinedTake, ShortCapture
from motiondb.meaning.place_fitting import (
    Places,
    Written,
    find_places,
    fit_arrays,
    place_evidence,
)
from motiondb.records import Caption, FloatArray, SegmentTable
from quality_protocol.captures import load_bandai, without_copies
from quality_protocol.learned_database import learned_database
from quality_protocol.recognition import recognise
from quality_protocol.report import TaskReport

N_FOLDS, N_BINS, N_DRAWS = 5, 10, 10
"""Folds of performers, bins of the calibration error, and draws of joined takes."""
KINDS = ("joined", "of two", "whole")


@dataclass(frozen=True, eq=False)
class PlaceData:
    """What places were learned from: as of a database that has learned."""

    table: SegmentTable
    standardised: FloatArray
    written: Written
    places: Places
    performers: Mapping[int, str]


@dataclass(frozen=True)
class Told:
    """One question: the predicted probability, whether the interval is right, and the question."""

    probability: float
    right: bool
    asked: tuple[str, tuple[int, ...], int]


def run(data: Path, seed: int) -> TaskReport:
    """The probability of a place against the truth, on captures of CMU and of Bandai-Namco."""
    return calibration(learned_database(data, seed), data, seed)


def calibration(database: Path, data: Path, seed: int) -> TaskReport:
    """The same on a database that has learned CMU."""
    with motiondb.open(database, read_only=True) as db:
        cmu = judge_folds(of_learned(db.learned), seed)
    bandai = judge_folds(_of_bandai(data, seed), seed)
    rows = []
    for name, (told, unasked) in (("CMU", cmu), ("Bandai-Namco", bandai)):
        whole = told["whole"] * max(1, round(len(told["joined"]) / max(len(told["whole"]), 1)))
        for kind, of in (
            ("joined, one performer", told["joined"]),
            ("joined, two performers", told["of two"]),
            ("captures as they are", told["whole"]),
            ("joined of one performer, and captures as they are as often", told["joined"] + whole),
        ):
            if of:
                rows.append((f"{name}: {kind}", *_row(of, seed)))
        rows.append((f"{name}: no probability told", unasked, "", "", "", "", ""))
    return TaskReport(
        "Probability that an interval is right",
        "Short captures of one action each are joined, and every action is searched in the "
        "joined take. The interval is right if its intersection over union with the true one is "
        "at least 0.5. The same is done with the captures as they are, where the whole capture "
        "is the true interval. Performers (CMU) or styles (Bandai-Namco) are divided into five "
        "folds; the probability is learned from the other folds, and the map is fitted without "
        "the performers of the take. *No probability told*: questions whose words are in no "
        "other performer's captions. Expected calibration error: ten bins, weighted by their "
        "numbers of questions. Each capture is joined "
        f"{N_DRAWS}"
        " times; *different questions* are those that differ in performer or words. With so "
        "few, even a perfect probability would have an error: *of a perfect probability* is its "
        "mean if every different question is right or wrong as a whole with the mean of its "
        "probabilities (200 draws). Not measured here: a regression on a take's length "
        "estimates whether it shows one action throughout, so a long walk counts as several "
        "actions.",
        ("asked of", "questions", "different questions", "right", "mean probability",
         "expected calibration error", "of a perfect probability"),
        tuple(rows),
    )  # fmt: skip


def judge_folds(data: PlaceData, seed: int) -> tuple[dict[str, list[Told]], int]:
    """Questions of every kind with probabilities from other folds; how many had none."""
    table, standardised = data.table, data.standardised
    short = place_certainty.short_captures(table, standardised, data.written, data.performers)
    n_words = len(data.written.numbers)
    arrays = fit_arrays(data.places, table, standardised, n_words, {})
    known = place_evidence(data.places, table, standardised, n_words, data.performers, arrays)
    rng = np.random.default_rng(seed)
    groups = sorted({capture.group for capture in short})
    folds = dict(zip(rng.permutation(groups).tolist(), np.arange(len(groups)) % N_FOLDS))
    told: dict[str, list[Told]] = {kind: [] for kind in KINDS}
    unasked = 0
    for fold in range(N_FOLDS):
        rest = [capture for capture in short if folds[capture.group] != fold]
        of_fold = [capture for capture in short if folds[capture.group] == fold]
        sure = place_certainty.fit_certainty(rest, known, rng)
        if sure is None:
            continue
        for kind, take in _takes(of_fold, rng):
            judged = place_certainty.judge(take, known)
            unasked += len(place_certainty.questions_of(take)) - len(judged)
            told[kind] += [Told(sure.probability(one.cues), one.right, one.kind) for one in judged]
    return told, unasked


def calibration_error(p: FloatArray, right: FloatArray) -> float:
    """Expected calibration error over equally wide bins.

    >>> calibration_error(np.array([0.95, 0.95]), np.array([1.0, 0.0])).__round__(9)
    0.45
    """
    bins = np.minimum((p * N_BINS).astype(int), N_BINS - 1)
    gaps = [abs(float((p - right)[bins == b].sum())) for b in range(N_BINS)]
    return float(np.sum(gaps) / len(p))


def of_learned(learned: Learned) -> PlaceData:
    """The places of a database that has learned."""
    assert learned.places is not None
    written = Written(learned.captions, learned.synonyms, learned.lemmas, learned.word_numbers)
    performers = {c: learned.captures[c].tags.get("performer", str(c)) for c in learned.rows}
    return PlaceData(learned.segments, learned.segment_rows[:], written, learned.places, performers)


def _takes(
    captures: Sequence[ShortCapture], rng: np.random.Generator
) -> list[tuple[str, JoinedTake]]:
    """Joined takes of every draw, and every capture once as it is."""
    takes = [("whole", place_certainty.join([each])) for each in captures]
    for _ in range(N_DRAWS):
        takes += [("joined", take) for take in place_certainty.join_captures(captures, rng)]
        takes += [
            ("of two", take)
            for take in place_certainty.join_pairs(captures, rng)
            if len(take.groups) == 2
        ]
    return takes


def _of_bandai(data: Path, seed: int) -> PlaceData:
    """Bandai-Namco with its captions; a style counts as a performer."""
    captures = without_copies(load_bandai(data))
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    words = sorted({w for c in captures for text in c.captions for w in vocabulary.words_of(text)})
    captions = {n: tuple(map(Caption, c.captions)) for n, c in enumerate(captures)}
    written = Written(captions, {}, {}, {word: n for n, word in enumerate(words)})
    places = find_places(seen.table, seen.rows, written)
    assert places is not None
    styles = {n: c.style for n, c in enumerate(captures)}
    return PlaceData(seen.table, seen.rows, written, places, styles)


def _row(told: Sequence[Told], seed: int) -> tuple[int | float, ...]:
    p = np.array([one.probability for one in told])
    right = np.array([one.right for one in told], dtype=float)
    kinds = {one.asked: n for n, one in enumerate(told)}
    number = {kind: n for n, kind in enumerate(kinds)}
    which = np.array([number[one.asked] for one in told])
    means = np.bincount(which, p) / np.bincount(which)
    rng = np.random.default_rng(seed)
    perfect = [
        calibration_error(p, (rng.random(len(means)) < means)[which].astype(float))
        for _ in range(200)
    ]
    return (len(told), len(means), float(right.mean()), float(p.mean()),
            calibration_error(p, right), float(np.mean(perfect)))  # fmt: skip
