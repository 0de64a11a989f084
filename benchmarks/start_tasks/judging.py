"""Judge the answers of one state of knowledge, and sum over folds with intervals."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from motiondb.meaning.regression import probability
from motiondb.records import FloatArray
from quality_protocol.confidence import weighted_draws, weighted_measure

CALIBRATION = "calibration error of the first five answers"
WITHHELD = "calibration error of the start's probabilities, which are not given"


@dataclass(frozen=True, eq=False)
class Asked:
    """One state of knowledge, asked: word scores, described scores (captures, words), threshold.

    ``sure`` are the probabilities that are given, None where there are none; NaN beside words that
    own captions have not checked. ``withheld`` are those of the start that are not given.
    """

    names: tuple[str, ...]
    ranked: FloatArray
    described: FloatArray
    added: FloatArray
    threshold: float | None
    sure: FloatArray | None
    withheld: FloatArray | None = None


def judge(
    words: Sequence[frozenset[str]],
    answers: Asked | None,
    gallery: NDArray[np.int64],
    asked: Sequence[str],
    seed: int,
) -> dict[str, Any]:
    """Rankings of captures per word, ranks of true words per capture, and "nothing matches".

    An unknown word ranks all captures at random. If no word is known, the words of a capture are in
    random order, and absent actions cannot be recognised.
    """
    rng = np.random.default_rng(seed)
    number = {} if answers is None else {w: n for n, w in enumerate(answers.names)}
    rankings, told = [], []
    calibration: list[tuple[float, bool]] = []
    withheld: list[tuple[float, bool]] = []
    for word in asked:
        right = np.array([word in words[g] for g in gallery])
        known = answers is not None and word in number
        noise = rng.random(len(gallery))
        scores = answers.ranked[:, number[word]] if known and answers else noise
        order = np.lexsort([noise, -scores])
        rankings.append((gallery[order].tolist(), right[order].tolist()))
        if known and answers is not None and answers.threshold is not None:
            added = answers.added[:, number[word]]
            there, gone = added.max(), added[~right].max()
            told.append([bool(there >= answers.threshold), bool(gone < answers.threshold)])
        else:
            told.append([False, True])  # an unknown word is refused: never found, never wrong
        if known and answers is not None:
            best = order[:5]
            for chances, kept in ((answers.sure, calibration), (answers.withheld, withheld)):
                if chances is not None:
                    said = chances[best, number[word]].tolist()
                    kept += [(p, r) for p, r in zip(said, right[best].tolist()) if p == p]
    reciprocal, share = {}, {}
    for place, capture in enumerate(gallery):
        true = np.array([w in words[capture] for w in asked])
        if not true.any():
            continue
        noise = rng.random(len(asked))
        scores = np.array([
            answers.described[place, number[w]] if answers is not None and w in number else -1e9
            for w in asked
        ])  # fmt: skip
        hits = true[np.lexsort([noise, -scores])]
        reciprocal[int(capture)] = 1.0 / (1 + int(np.argmax(hits)))
        share[int(capture)] = float(hits[: true.sum()].mean())
    return {"rankings": rankings, "reciprocal": reciprocal, "f1": share, "told": told,
            "calibration": calibration, "withheld": withheld}  # fmt: skip


def measures(folds: list[dict[str, Any]], draws: FloatArray) -> dict[str, FloatArray]:
    """Every measure of every draw of captures."""
    total, count = np.zeros(len(draws)), np.zeros(len(draws))
    for fold in folds:
        for captures, right in fold["rankings"]:
            weight = draws[:, captures]
            hits = np.cumsum(weight * np.array(right), axis=1)
            share = hits / np.maximum(np.cumsum(weight, axis=1), 1e-12)
            total += (weight * np.array(right) * share).sum(axis=1) / np.maximum(hits[:, -1], 1e-12)
            count += hits[:, -1] > 0
    value_of = {"words to motion, mAP": total / np.maximum(count, 1)}
    for name, key in (
        ("reciprocal", "motion to words, reciprocal rank"),
        ("f1", "motion to words, F1"),
    ):
        values = {c: v for fold in folds for c, v in fold[name].items()}
        weight = draws[:, list(values)]
        value_of[key] = (
            weight @ np.array(list(values.values())) / np.maximum(weight.sum(axis=1), 1e-12)
        )
    told = np.array([pair for fold in folds for pair in fold["told"]], dtype=float)
    some = weighted_draws(len(told), 0, len(draws) - 1)
    value_of["nothing matches, balanced accuracy"] = some @ told.mean(axis=1) / some.sum(axis=1)
    for name, key in ((CALIBRATION, "calibration"), (WITHHELD, "withheld")):
        error = calibration_error(pairs_of(folds, key))
        value_of[name] = np.full(len(draws), error)
    return value_of


def pairs_of(folds: Sequence[dict[str, Any]], key: str) -> FloatArray:
    """Probabilities and whether they were right, of all folds: array (answers, 2)."""
    pairs = [pair for fold in folds for pair in fold.get(key, [])]
    return np.array(pairs, dtype=float).reshape(-1, 2)


def calibration_error(pairs: FloatArray) -> float:
    """Expected calibration error over ten bins of probability; NaN without answers."""
    if not len(pairs):
        return float("nan")
    gaps = [abs(rows.sum(axis=0) @ (1.0, -1.0)) for _, rows in _binned(pairs)]
    return float(np.sum(gaps) / len(pairs))


def oracle_shift(pairs: FloatArray) -> list[float] | None:
    """The constant that makes log-odds most likely on the answers themselves, and the error left.

    No one knows it without captions: it tells how much of an error is one bias of all answers.
    """
    if not len(pairs):
        return None
    log_odds = np.log(pairs[:, 0]) - np.log1p(-pairs[:, 0])
    shift = brentq(lambda c: probability(log_odds + c).sum() - pairs[:, 1].sum(), -20.0, 20.0)
    mended = np.column_stack([probability(log_odds + shift), pairs[:, 1]])
    return [round(float(shift), 2), round(calibration_error(mended), 4)]


def diagram(pairs: FloatArray) -> list[list[float]]:
    """The reliability diagram: per bin its lower end, mean probability, share right, answers."""
    return [
        [round(low, 1), *(round(float(v), 3) for v in rows.mean(axis=0)), len(rows)]
        for low, rows in _binned(pairs)
    ]


def _binned(pairs: FloatArray) -> list[tuple[float, FloatArray]]:
    bins = np.minimum((pairs[:, 0] * 10).astype(int), 9)
    return [(0.1 * b, pairs[bins == b]) for b in range(10) if (bins == b).any()]


def told_interval(values: FloatArray) -> list[float] | None:
    if np.isnan(values[0]):
        return None
    measure = weighted_measure(values)
    low, high = (measure.value if b is None else b for b in (measure.low, measure.high))
    return [round(v, 4) for v in (measure.value, low, high)]


def brief(judged: dict[str, Any]) -> str:
    precision = []
    for _, right in judged["rankings"]:
        hits = np.array(right)
        precision.append(float((np.cumsum(hits) / np.arange(1, len(hits) + 1))[hits].mean()))
    return f"mAP {np.mean(precision):.3f}, {time.strftime('%H:%M:%S')}"
