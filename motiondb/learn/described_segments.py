"""The segments of the described captures, to be compared with one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motiondb.meaning.counting import Described
from motiondb.meaning.motion_judge import said_words
from motiondb.meaning.score_vectors import Rows
from motiondb.records import Float32Array, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class DescribedSegments:
    """The segments of the described captures and their words."""

    # (segments, values): score vectors of length 1, in the order of the captures
    vectors: FloatArray
    firsts: IntArray  # (captures,): first row of every capture
    captures: IntArray  # (captures,): numbers of the captures
    # (captures, words): 1/sqrt(actions) where its captions say a word among that many actions
    says: FloatArray

    @cached_property
    def rough(self) -> Float32Array:
        """The vectors in single precision."""
        return self.vectors.astype(np.float32)


def describe_segments(
    described: Sequence[Described],
    numbers: Mapping[str, int],
    rows: Mapping[int, slice],
    segment_rows: Rows,
) -> DescribedSegments:
    """Gather the segments of the described captures.

    `numbers`: Word -> its number. `rows`: Capture -> its rows among `segment_rows`.
    """
    said = said_words(described, numbers)
    captures = [c for c in rows if c in said and rows[c].stop > rows[c].start]
    says = np.zeros((len(captures), len(numbers)))
    for n, capture in enumerate(captures):
        words, n_actions = said[capture]
        says[n, sorted(words)] = 1.0 / np.sqrt(max(n_actions, 1))
    parts = [np.arange(rows[c].start, rows[c].stop) for c in captures]
    lengths = [len(part) for part in parts]
    every = np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)
    return DescribedSegments(
        unit_rows(segment_rows[every]),
        np.cumsum([0, *lengths])[: len(parts)],
        np.array(captures, np.int64),
        says,
    )


def unit_rows(vectors: FloatArray) -> FloatArray:
    """Rows of length 1; zero rows stay zero."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))
