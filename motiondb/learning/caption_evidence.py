"""Log-odds that the captions of a capture add to those of its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motiondb.learning.counting import Described
from motiondb.records import FloatArray, SegmentTable
from motiondb.search.questions import by_words


def caption_evidence(
    described: Sequence[Described],
    table: SegmentTable,
    rows: Mapping[int, slice],
    number: Mapping[str, int],
) -> dict[int, FloatArray]:
    """Log-odds that captions add, for captures that have any: arrays (segments, words).

    Parameters
    ----------
    described : sequence of Described
        Described intervals.
    table : SegmentTable
        Segments of all captures.
    rows : mapping of int to slice
        Capture number -> its rows of the table.
    number : mapping of str to int
        Word -> its column; other words are left out.
    """
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
