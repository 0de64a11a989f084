"""The long takes with true segments: labels per frame, and how well groupings agree with them."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from motiondb.body.features import FEATURE_FPS
from motiondb.records import IntArray
from quality_protocol.captures import Capture

NEAR_SECONDS = 0.5
"""Seconds by which a boundary may differ from the true one. Chosen by hand; not tuned."""

Part = tuple[float, float, str]
"""start, end (seconds), label."""


@dataclass(frozen=True, eq=False)
class LongTake:
    """A capture with its true parts, and the number of the label of every feature frame (-1: none;
    labels numbered in alphabetical order)."""

    capture: Capture
    parts: tuple[Part, ...]
    labels: IntArray


def load_takes(data: Path, captures: Sequence[Capture]) -> list[LongTake]:
    """The captures that ``cmu-segments.tsv`` speaks of, in its order."""
    parts: dict[str, list[Part]] = {}
    with (data / "cmu-segments.tsv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            part = (float(row["start_s"]), float(row["end_s"]), row["label"])
            parts.setdefault(row["clip"], []).append(part)
    by_stem = {capture.name.rsplit("/", 1)[-1]: capture for capture in captures}
    return [make_take(by_stem[clip], rows) for clip, rows in parts.items()]


def make_take(capture: Capture, parts: Sequence[Part]) -> LongTake:
    """Number the labels and lay them over the frames."""
    names = sorted({label for _, _, label in parts})
    labels = np.full(len(capture.features), -1)
    for start, end, label in parts:
        labels[round(start * FEATURE_FPS) : round(end * FEATURE_FPS)] = names.index(label)
    return LongTake(capture, tuple(parts), labels)


def agreement(truth: IntArray, labels: IntArray) -> tuple[float, float, float]:
    """Frame accuracy after the best one-to-one matching, purity, and boundary F1 at +-0.5 s.

    truth : array (frames,), -1 if nothing is known; found : array (frames,).

    >>> agreement(np.array([0, 0, 1, 1]), np.array([5, 5, 5, 3]))
    (0.75, 0.75, 1.0)
    """
    known = truth >= 0
    names = np.unique(labels, return_inverse=True)[1]
    table = np.zeros((int(truth.max()) + 1, int(names.max()) + 1))
    np.add.at(table, (truth[known], names[known]), 1.0)
    rows, columns = linear_sum_assignment(-table)
    total = table.sum()
    last = int(np.flatnonzero(known)[-1])
    score = boundary_f1(_changes(truth[: last + 1]), _changes(names[: last + 1]))
    return float(table[rows, columns].sum() / total), float(table.max(axis=0).sum() / total), score


def boundary_f1(truth: IntArray, boundaries: IntArray) -> float:
    """F1 of cuts (feature frames): each true one takes the nearest free found one within 0.5 s."""
    free = list(boundaries)
    hits = 0
    for cut in truth:
        near = [c for c in free if abs(c - cut) <= NEAR_SECONDS * FEATURE_FPS]
        if near:
            free.remove(min(near, key=lambda c: abs(c - cut)))
            hits += 1
    return 2.0 * hits / (len(truth) + len(boundaries)) if len(truth) + len(boundaries) else 1.0


def union_share(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Intersection over union of two intervals.

    >>> union_share((0.0, 2.0), (1.0, 3.0))
    0.3333333333333333
    """
    shared = max(0.0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / (max(first[1], second[1]) - min(first[0], second[0])) if shared else 0.0


def _changes(labels: IntArray) -> IntArray:
    return np.flatnonzero(np.diff(labels)) + 1
