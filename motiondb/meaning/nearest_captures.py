"""The captures nearest to a segment, by their most alike segments, without most of the cosines.

Notation: u and v score vectors of length 1 (:mod:`motiondb.meaning.score_vectors`), a and b their
products with the first ``AXES`` principal axes of all of them, |u'| and |v'| the lengths of what
the axes leave. Then

    u . v <= a . b + |u'| |v'|,

a product of rows of ``AXES`` + 1 numbers, in place of some 900. The captures of largest bounds are
compared exactly. The least of their cosines bounds that of the nearest ones from below, and only
captures whose bound is not below it are compared as well. On real captures these were one or two
in a hundred.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motiondb.meaning.score_vectors import AT_ONCE, Rows, unit
from motiondb.records import Float32Array, FloatArray, IntArray

AXES = 64  # With 32, twice as many captures are compared exactly; with 128, half as many
AXES_FROM = 4096  # The axes are computed from fewer than twice as many segments, evenly taken
TOGETHER = 64  # Segments whose bounds are computed together: more take more memory
ROUNDING = 1e-4  # By which a bound may be wrong in single precision; measured 1e-6


@dataclass(frozen=True, eq=False)
class CaptureSegments:
    """The segments of captures, to be compared with others."""

    rows: Rows  # (segments, columns): standardised rows
    spans: IntArray  # (captures, 2): first segment of each, and one past its last

    @cached_property
    def _axes(self) -> FloatArray:
        """Principal axes of the vectors: array (columns, axes)."""
        every = np.concatenate([np.arange(*span) for span in self.spans])
        some = every[:: max(len(every) // AXES_FROM, 1)]
        vectors = unit(self.rows[some])
        return np.linalg.eigh(vectors.T @ vectors)[1][:, -AXES:].copy()

    def outlines(self, vectors: FloatArray) -> Float32Array:
        """Rows (n, axes + 1) whose products bound cosines, of `vectors` (n, columns), length 1."""
        along = vectors @ self._axes
        rest = np.sqrt(np.maximum(1.0 - np.sum(along * along, axis=1), 0.0))
        return np.column_stack([along, rest]).astype(np.float32)

    @cached_property
    def _outlines(self) -> Float32Array:
        """The outlines of all segments."""
        n = self.rows.shape[0]
        parts = [slice(first, first + AT_ONCE) for first in range(0, n, AT_ONCE)]
        return np.concatenate([self.outlines(unit(self.rows[part])) for part in parts])

    def cosine_bounds(self, vectors: FloatArray) -> Float32Array:
        """Bounds of the largest cosine with a segment of each capture: array (n, captures).

        Shapes: `vectors` (n, columns), of length 1.
        """
        bounds = np.empty((len(vectors), len(self.spans)), np.float32)
        asked, borders = self.outlines(vectors), self.spans.ravel()
        borders = borders[: len(borders) - int(borders[-1] == self.rows.shape[0])]
        for first in range(0, len(vectors), TOGETHER):
            products = asked[first : first + TOGETHER] @ self._outlines.T
            largest = np.maximum.reduceat(products, borders, axis=1)
            bounds[first : first + TOGETHER] = largest[:, ::2]  # the others are between captures
        return bounds


class NearestCaptures:
    """Finds the captures nearest to segments; the vectors of captures once compared are kept."""

    def __init__(self, others: CaptureSegments) -> None:
        self._others = others
        self._vectors: dict[int, Float32Array] = {}  # kept in single precision: they may be many

    def find(
        self, vectors: FloatArray, bounds: Float32Array, n_nearest: int
    ) -> tuple[IntArray, FloatArray]:
        """Places of the nearest captures, nearest first, and their cosines, at least 0.

        Two arrays (n, nearest). Shapes: `vectors` (n, columns), of length 1; `bounds` (n,
        captures): of :meth:`CaptureSegments.cosine_bounds`, -inf for captures that are left out.
        """
        n = min(n_nearest, int((bounds[0] > -np.inf).sum()))
        first = np.unique(np.argpartition(-bounds, n - 1, axis=1)[:, :n])
        last = len(first) - n
        least = np.partition(self._cosines(vectors, first), last, axis=1)[:, last : last + 1]
        likely = np.flatnonzero((bounds >= least - ROUNDING).any(axis=0))
        cosines = np.maximum(self._cosines(vectors, likely), 0.0)
        order = np.argsort(-cosines, axis=1, kind="stable")[:, :n]
        return likely[order], np.take_along_axis(cosines, order, axis=1)

    def _cosines(self, vectors: FloatArray, captures: IntArray) -> FloatArray:
        """Largest cosines with a segment of each of some captures: array (n, captures)."""
        places = captures.tolist()
        new = [place for place in places if place not in self._vectors]
        if new:
            ranges = [np.arange(*self._others.spans[place]) for place in new]
            rows = unit(self._others.rows[np.concatenate(ranges)]).astype(np.float32)
            ends = np.cumsum([len(each) for each in ranges])
            self._vectors.update(zip(new, np.split(rows, ends[:-1])))
        return np.stack([(vectors @ self._vectors[n].T).max(axis=1) for n in places], axis=1)
