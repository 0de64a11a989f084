"""What captions add to the evidence of the motion, and the vectors compared with captions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motiondb.meaning import by_words
from motiondb.meaning.counting import Described, known_only, training_rows
from motiondb.meaning.description_map import DescriptionMap, fit_description_map
from motiondb.meaning.listed_takes import LABELLED
from motiondb.meaning.place_fitting import Written, label_intervals
from motiondb.meaning.score_vectors import ScoreSpace, interval_vectors
from motiondb.records import FloatArray, SegmentTable


def caption_evidence(
    described: Sequence[Described],
    table: SegmentTable,
    rows: Mapping[int, slice],
    number: Mapping[str, int],
) -> dict[int, FloatArray]:
    """Log-odds that captions add, for captures that have any: arrays (segments, words)."""
    spans: dict[int, list[tuple[int, int, FloatArray]]] = {}
    for d in described:
        said = np.zeros(len(number))
        said[[number[w] for w in d.words if w in number]] = 1.0
        spans.setdefault(d.capture_id, []).append((int(d.start), int(d.end), said))
    return {
        capture: by_words.written_evidence(
            inside.stop - inside.start,
            spans[capture],
            table.starts[inside],
            table.ends[inside],
            len(number),
        )
        for capture, inside in rows.items()
        if capture in spans
    }


def interval_evidence(
    table: SegmentTable, rows: Mapping[int, slice], written: Written
) -> dict[int, FloatArray]:
    """Nats for the place of words that captions of intervals say: arrays (segments, words).

    Only for the captures that have such captions.
    """
    evidence = {}
    for capture, inside in rows.items():
        parts = written.of_intervals(capture)
        said = label_intervals(table, inside, parts, False, len(written.numbers))
        if said is not None:
            evidence[capture] = LABELLED * np.nan_to_num(said)
    return evidence


def whole_vectors(
    standardised: FloatArray, table: SegmentTable, rows: Mapping[int, slice]
) -> FloatArray:
    """Score vectors of whole captures, in their order: array (captures, columns).

    Shapes: `standardised` (segments, columns).
    """
    starts, ends, zero = table.starts, table.ends, np.zeros(1)
    return np.vstack(
        [
            interval_vectors(standardised[r], starts[r], ends[r], zero, ends[r][-1:])
            for r in rows.values()
        ]
    )


def map_descriptions(
    table: SegmentTable,
    described: Sequence[Described],
    scores: ScoreSpace,
    number: Mapping[str, int],
    performers: Mapping[int, str],
) -> DescriptionMap | None:
    """Map from score vectors to words, from all described intervals; None if there are none."""
    known = known_only(list(described), number)
    if not known:
        return None
    vectors, presence, captures = training_rows(table, known, scores, number)
    groups = np.unique([performers[int(c)] for c in captures], return_inverse=True)[1]
    return fit_description_map(vectors, presence, groups)
