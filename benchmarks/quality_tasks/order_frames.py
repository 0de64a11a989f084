"""Order by the evidence of frames, on joined captures of performers without words.

Two captures of one performer with different main verbs are joined. The words are learned from the
captions of other performers. Asked is whether the order is seen (``motiondb.meaning.edge_map``):
of the true order, of its reverse, and of "a, b, a" in a join of a and b, which ends with b.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import motiondb
from motiondb.body.features import FEATURE_FPS
from motiondb.database.catalogue.file_reading import AddSettings
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import LearnSettings
from motiondb.meaning.edge_map import FrameOrder, averaged, lay_in_order
from motiondb.records import Float32Array
from quality_protocol.captures import N_FOLDS, Capture, load_cmu, performer_folds, without_copies
from quality_protocol.confidence import mean_of
from quality_protocol.report import TaskReport
from quality_tasks.order import join_pairs

NEAR = 0.5  # Seconds within which the boundary between two actions is right


def run(data: Path, seed: int) -> TaskReport:
    """Share of joined captures in which each order is seen."""
    real = without_copies(load_cmu(data))
    pairs = join_pairs(real, seed)
    folds = performer_folds([c.performer for c in real])
    counted: dict[str, list[float]] = {}
    for fold in range(N_FOLDS):
        of_fold = [(a, b, verbs) for a, b, verbs in pairs if folds[a] == fold]
        if not of_fold:
            continue
        unseen = {real[n].performer for n in np.flatnonzero(folds == fold)}
        learned = _learn_without(data, unseen, seed)
        for a, b, verbs in of_fold:
            for name, value in _measure(learned, real[a], real[b], verbs):
                counted.setdefault(name, []).append(value)
    return TaskReport(
        "Order by frames",
        "Two captures of one performer with different main verbs are joined; the words are learned "
        "from the captions of other performers (five folds), the symbols from all captures. An "
        "order is seen if every action reaches half of its largest evidence in its interval.",
        ("asked of a, then b", "joins", "share"),
        tuple((name, len(values), mean_of(values, seed)) for name, values in counted.items()),
    )


def _measure(
    learned: Learned, first: Capture, second: Capture, verbs: Sequence[str]
) -> Iterator[tuple[str, float]]:
    """What is seen in one join; nothing if a verb was not learned."""
    edges, placed = learned.edges, learned.placed
    if edges is None or placed is None or not set(verbs) <= learned.word_numbers.keys():
        return
    numbers = [learned.word_numbers[verb] for verb in verbs]
    if not placed.words.issuperset(numbers):
        return

    def lay(order: Sequence[int], features: Float32Array) -> FrameOrder | None:
        frames = learned.feature_space.project(features)
        evidence = np.stack([edges.evidence(frames, [number]) for number in order])
        return lay_in_order(averaged(evidence), (0, len(frames)))

    a, b = numbers
    joined = np.concatenate([first.features, second.features])
    right, cut = lay([a, b], joined), len(first.features)
    near = NEAR * FEATURE_FPS
    apart = right is not None and (right.spans[0][1] - near <= cut <= right.spans[1][0] + near)
    yield "a, then b is seen", right is not None and right.is_seen
    yield f"a ends before the seam and b begins behind it, within {NEAR} s", apart
    for name, order, of in (
        ("b, then a is seen", [b, a], joined),
        ("a, b, a is seen", [a, b, a], joined),
        ("a, b, a is seen in a, b, a", [a, b, a], np.concatenate([joined, first.features])),
    ):
        found = lay(order, of)
        yield name, found is not None and found.is_seen


def _learn_without(data: Path, performers: set[str], seed: int) -> Learned:
    """A model of all captures, with the words of other performers."""
    with tempfile.TemporaryDirectory() as folder:
        sheet = Path(folder) / "captions.tsv"
        with (data / "cmu-captions.tsv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t"))
        with sheet.open("w", encoding="utf-8", newline="") as out:
            writer = csv.DictWriter(out, list(rows[0]), delimiter="\t")
            writer.writeheader()
            for row in rows:
                silent = row["performer"] in performers
                writer.writerow({**row, "words": "" if silent else row["words"]})
        with motiondb.open(Path(folder) / "fold.duckdb") as db:
            db.add(data / "cmu", sheet, AddSettings(skip_bad_frames=True))
            db.learn(LearnSettings(seed=seed))
            return db.learned
