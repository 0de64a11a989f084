"""Vectors that describe an interval of motion: scores under all symbols, and movement.

The scores of a segment are its log-likelihoods under every symbol, nats per frame, less their mean
over the symbols, which measures how usual the motion is. They are standardised per symbol over all
segments, and clipped. The vector of an interval is the mean over its segments, weighted by their
duration inside it, scaled to length 1. Unlike the best symbol alone it keeps the similarity of a
new performer to *several* symbols. On real captures no other choice had a larger effect.

The columns of movement follow, standardised and clipped in the same way. Each of their five blocks
is scaled to the weight of all symbols together, travel to one and a half times that.

Notation: x_t the whitened features of frame t (15 a second, D dimensions); p_t the joint positions
of frame t in the frame of the heading, metres on the standard body
(:mod:`motiondb.body.features`); r_t = (velocity to the left, up, ahead, turning) in their usual
spreads 0.3 m/s, 0.3 m/s, 0.6 m/s, 0.9 rad/s; r*_t the mean of r over two seconds around t; s the
logistic function of (x - level) / 0.25 or (r* - level) / 0.25, for the levels -1.5, -0.75, 0, 0.75
and 1.5. Every column is a mean over the segment's frames, so that functions linear in them can be
decomposed exactly:

========  ==============  ================================================================
block     columns         mean over frames of
========  ==============  ================================================================
places    5 D             s of x, for each level
joint     D (D + 1) / 2   products of two dimensions of x
rhythm    5 D             absolute change of x within 1/15 to 1 second
posture   63              p_t, which distinguishes sitting, kneeling and hanging
travel    24              s of r*, for each level, and the absolute value of r_t
========  ==============  ================================================================

Blocks, levels, averaging and weights were chosen among about 270 settings by leaving performers out
of the CMU training parts (``docs/measured/quality.md``, "Words to motion").
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from motiondb.body import body
from motiondb.body.features import FEATURE_FPS, ROOT_WEIGHT, VELOCITY_SECONDS
from motiondb.records import LARGEST, Axes, Float32Array, FloatArray, IntArray, SegmentTable, Within


def unit(vectors: NDArray[Any], out: NDArray[Any] | None = None) -> NDArray[Any]:
    """Scale rows to length 1; zero rows stay zero; `vectors` (..., columns).

    `out`: Where to write them, which may be `vectors`.
    """
    length = np.sqrt(np.add.reduce(vectors * vectors, axis=-1, keepdims=True))
    length[~(length > 0.0)] = 1.0
    return np.divide(vectors, length, out=out)


ROWS_AT_ONCE = 24  # Rows that are multiplied together where there are few
AT_ONCE = 256  # Segments that are standardised together: intermediate arrays of 2 MB stay in caches
FITTED_AT_ONCE = 2**11  # Segments whose means are summed together: 14 MB of 831 columns
CLIP = 3.0  # Standard deviations beyond which a value is clipped


@dataclass(frozen=True, eq=False)
class ScoreSpace:
    """Means and standard deviations over segments."""

    # Means; those of the symbols are of the scores less their mean over symbols
    mean: Annotated[FloatArray, Axes("columns")]
    # Standard deviations
    spread: Annotated[
        FloatArray, Axes("columns"), Within(1e-12, LARGEST, "spreads of scores above 0")
    ]

    def standardise(self, scores: Float32Array, movement: Float32Array | None = None) -> FloatArray:
        """Standardised, clipped and weighted rows (segments, symbols + columns).

        Shapes: `scores` (segments, symbols); `movement` (segments, columns).
        """
        n_symbols = scores.shape[1]
        n_movement = 0 if movement is None else len(self.mean) - n_symbols
        rows = np.empty((len(scores), n_symbols + n_movement))
        rows[:, :n_symbols] = _relative(scores)
        if movement is not None:
            rows[:, n_symbols:] = movement[:, :n_movement]
        return self._standardise(rows, n_symbols, 0)

    def standardise_last(self, movement: Float32Array, n: int) -> Float32Array:
        """The last n columns of such rows, made some at a time: array (segments, n).

        Shapes: `movement` (segments, columns), all columns of the rows that are not symbols.
        """
        rows, width = np.empty((len(movement), n), np.float32), movement.shape[1]
        for some in (slice(low, low + AT_ONCE) for low in range(0, len(rows), AT_ONCE)):
            last = movement[some][:, width - n :].astype(np.float64)
            rows[some] = self._standardise(last, len(self.mean) - width, len(self.mean) - n)
        return rows

    def _standardise(self, rows: FloatArray, n_symbols: int, first: int) -> FloatArray:
        """Standardise the columns of rows from the first on, in place: of hours they are large."""
        sizes = block_sizes(len(self.mean) - n_symbols)
        weights = [block_weight(n) * np.sqrt(n_symbols / size) for n, size in enumerate(sizes)]
        rows -= self.mean[first:]
        rows /= self.spread[first:]
        np.clip(rows, -CLIP, CLIP, out=rows)
        rows *= np.repeat([1.0, *weights], [n_symbols, *sizes])[first:]
        return rows


@dataclass(frozen=True, eq=False)
class StandardisedRows:
    """Standardised rows of all segments, computed where they are looked at.

    An index gives an array (segments, columns). A row does not depend on the others, to the last
    bit.
    """

    space: ScoreSpace
    scores: Float32Array  # (segments, symbols)
    movement: Float32Array  # (segments, columns)

    @classmethod
    def of_table(cls, space: ScoreSpace, table: SegmentTable) -> StandardisedRows:
        """The rows of the segments of a table."""
        return cls(space, table.scores, table.movement)

    @property
    def shape(self) -> tuple[int, int]:
        """Segments and columns."""
        return len(self.scores), len(self.space.mean)

    def __getitem__(self, which: slice | IntArray) -> FloatArray:
        return self.space.standardise(self.scores[which], self.movement[which])


Rows = FloatArray | StandardisedRows
"""Standardised rows (segments, columns), all there or computed where they are looked at."""


def some_of(rows: Rows, which: slice) -> Rows:
    """Some of the rows, of the same memory: all there, or computed where they are looked at."""
    if isinstance(rows, StandardisedRows):
        return StandardisedRows(rows.space, rows.scores[which], rows.movement[which])
    return rows[which]


def in_memory(rows: Rows, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """All rows as one new array, made some at a time."""
    array = np.empty(rows.shape, dtype)
    for first in range(0, len(array), AT_ONCE):
        array[first : first + AT_ONCE] = rows[slice(first, first + AT_ONCE)]
    return array


def times(rows: NDArray[Any], matrix: NDArray[Any], at_once: int = ROWS_AT_ONCE) -> NDArray[Any]:
    """``rows @ matrix``, where a row's product does not depend on the other rows.

    The last bits of a product depend on its shape, and in single precision on where in it a row
    stands (OpenBLAS on AMD). So all products have one shape, and are of double precision, in which
    a row has the same one wherever it stands: measured, with multiples of 24 rows and 60 to 657
    columns, on all kernels of OpenBLAS for processors with AVX
    (docs/decisions/the-same-seed-on-any-machine.md).

    Shapes: `rows` (n, columns), or (columns,) for one; `matrix` (columns, m).

    `at_once`: Number of rows that are multiplied together, a multiple of 24.
    """
    if rows.ndim == 1:
        return np.asarray(rows @ matrix)
    found = np.empty((len(rows), matrix.shape[1]), np.result_type(rows, matrix))
    matrix = matrix.astype(np.float64, copy=False)
    for first in range(0, len(rows), at_once):
        some = rows[first : first + at_once].astype(np.float64, copy=False)
        if (n := len(some)) < at_once:
            some = np.concatenate([some, np.zeros((at_once - n, some.shape[1]))])
        found[first : first + n] = (some @ matrix)[:n]
    return found


def fit_score_space(
    scores: Float32Array, lengths: IntArray, movement: Float32Array | None = None
) -> ScoreSpace:
    """Mean and standard deviation over segments, weighted by their length.

    Shapes: `scores` (segments, symbols); `lengths` (segments,); `movement` (segments, columns).
    """
    weights = lengths / lengths.sum()
    parts = [slice(n, n + FITTED_AT_ONCE) for n in range(0, len(scores), FITTED_AT_ONCE)]
    means, spreads = [], []
    for columns in [scores] if movement is None else [scores, movement]:

        def rows(some: slice, columns: Float32Array = columns) -> NDArray[Any]:
            return _relative(columns[some]) if columns is scores else columns[some]

        mean = sum((weights[some] @ rows(some) for some in parts), np.zeros(columns.shape[1]))
        squares = sum(weights[some] @ np.square(rows(some) - mean) for some in parts)
        spread = np.sqrt(squares)
        means.append(mean)
        spreads.append(np.maximum(spread, 1e-6 + 0.01 * spread.max(initial=0.0)))
    return ScoreSpace(np.concatenate(means), np.concatenate(spreads))


def _relative(scores: Float32Array) -> FloatArray:
    return scores - scores.mean(axis=1, keepdims=True, dtype=np.float64)


def interval_vectors(
    standardised: FloatArray,
    starts: IntArray,
    ends: IntArray,
    low: FloatArray | IntArray,
    high: FloatArray | IntArray,
) -> FloatArray:
    """Vectors of length 1 of intervals [low, high) of one capture: array (intervals, columns).

    Shapes: `standardised` (segments, symbols); `starts`, `ends` (segments,); `low`, `high`
    (intervals,).
    """
    return unit(overlaps(starts, ends, low, high) @ standardised)


def overlaps(
    starts: IntArray, ends: IntArray, low: FloatArray | IntArray, high: FloatArray | IntArray
) -> FloatArray:
    """Frames that intervals [low, high) share with segments: array (intervals, segments)."""
    inside = np.minimum(ends, high[:, None]) - np.maximum(starts, low[:, None])
    return np.maximum(inside, 0.0)


def interval_vector(
    standardised: FloatArray, starts: IntArray, ends: IntArray, low: float, high: float
) -> FloatArray:
    """As :func:`interval_vectors`, of one interval: array (columns,)."""
    return interval_vectors(standardised, starts, ends, np.array([low]), np.array([high]))[0]


VECTORS_AT_ONCE = 384
"""Vectors that are made, and multiplied, together. All products of a word map thus have the same
shape, in which the sums of a row have the same order wherever it stands: measured, with this number
on the processors at hand."""


def window_vectors_of(
    standardised: Rows, table: SegmentTable, parts: Sequence[slice], margin: int
) -> Iterator[tuple[slice, FloatArray]]:
    """Vectors of the windows around segments, and of whole captures, some captures at a time.

    Numbers of captures, and the vectors of the windows of each, with that of the whole behind them;
    rows of zeros behind all make their number a multiple of ``VECTORS_AT_ONCE``. Those of a capture
    follow from its own rows alone.

    Shapes: `standardised` (segments, columns).

    `parts`: The rows of each capture, at least one.

    `margin`: Frames by which a window extends beyond its segment on both sides.
    """
    sizes = np.array([part.stop - part.start for part in parts], dtype=np.int64)
    ends = np.cumsum(sizes + 1)
    first = 0
    while first < len(parts):
        room = ends[first] - sizes[first] - 1 + VECTORS_AT_ONCE
        last = max(int(np.searchsorted(ends, room, side="right")), first + 1)
        yield slice(first, last), _vectors_of(standardised, table, parts[first:last], margin)
        first = last


def _vectors_of(
    standardised: Rows, table: SegmentTable, parts: Sequence[slice], margin: int
) -> FloatArray:
    """As :func:`window_vectors_of`, of captures that are all looked at together."""
    which: slice | IntArray = slice(parts[0].start, parts[-1].stop)
    sizes = np.array([part.stop - part.start for part in parts], dtype=np.int64)
    if parts[-1].stop - parts[0].start != sizes.sum():
        which = np.concatenate([np.arange(part.start, part.stop) for part in parts])
    rows, starts, ends = standardised[which], table.starts[which], table.ends[which]
    behind = np.cumsum(sizes)
    low = np.insert(starts - margin, behind, 0)
    high = np.insert(ends + margin, behind, ends[behind - 1])
    vectors = np.zeros((-(-len(low) // VECTORS_AT_ONCE) * VECTORS_AT_ONCE, rows.shape[1]))
    for n, (b, size) in enumerate(zip(behind.tolist(), sizes.tolist())):
        own, made = slice(b - size, b), slice(b - size + n, b + n + 1)
        weights = overlaps(starts[own], ends[own], low[made], high[made])
        np.matmul(weights, rows[own], out=vectors[made])
    unit(vectors[: len(low)], out=vectors[: len(low)])
    return vectors


N_POSTURE = 3 * len(body.JOINTS)  # Columns of posture
N_TRAVEL = 24  # Columns of travel
LEVELS = (-1.5, -0.75, 0.0, 0.75, 1.5)  # Levels of x in standard deviations, of r* in spreads
SOFTNESS = 0.25  # Width of the logistic function, in the same units
SPREADS = (0.3, 0.3, 0.6, 0.9)
"""Spreads of r: m/s to the left, up, ahead; rad/s. Measured on real captures, rounded."""
AVERAGED = 2.0  # Seconds over which r is averaged, because the pelvis sways within every step
TRAVEL_WEIGHT = 1.5  # Weight of travel relative to the other blocks, chosen together with them
LAGS = (1, 2, 4, 8, 15)  # Feature frames between which change is measured: 1/15 to 1 second


def describe_posture_and_travel(
    features: Float32Array, starts: IntArray, ends: IntArray
) -> Float32Array:
    """Compute posture and travel of the segments of one capture.

    Shapes: `features` (frames, 130); `starts`, `ends` (segments,); result (segments, 87).
    """
    each = np.concatenate([features[:, :N_POSTURE], travel(features[:, -4:])], axis=1)
    rows = np.empty((len(starts), each.shape[1]), dtype=np.float32)
    for row, start, end in zip(rows, starts, ends):
        row[:] = each[start:end].mean(axis=0)
    return rows


def travel(root: Float32Array) -> FloatArray:
    """Compute the 24 columns of travel for every frame: array (frames, 24); `root` (frames, 4).

    >>> still = travel(np.zeros((1, 4), dtype=np.float32))
    >>> still[0, 8:12].tolist(), still[0, 20:].tolist()  # on the level 0; sizes
    ([0.5, 0.5, 0.5, 0.5], [0.0, 0.0, 0.0, 0.0])
    """
    r = root.astype(np.float64) / (ROOT_WEIGHT * VELOCITY_SECONDS * np.array(SPREADS))
    smooth = averaged_rows(r, round(AVERAGED * FEATURE_FPS / 2.0))
    return np.concatenate([soft_levels(smooth), np.abs(r)], axis=1)


def averaged_rows(rows: FloatArray, reach: int) -> FloatArray:
    """Mean of the rows (rows, ...) within ``reach`` rows of each row."""
    sums = np.concatenate([np.zeros((1, *rows.shape[1:])), np.cumsum(rows, axis=0)])
    now = np.arange(len(rows))
    low, high = np.maximum(now - reach, 0), np.minimum(now + reach + 1, len(rows))
    return np.asarray((sums[high] - sums[low]) / (high - low).reshape(-1, *(1,) * (rows.ndim - 1)))


def running_median(values: FloatArray, size: int) -> FloatArray:
    """Median of ``size`` values around each, an odd number; the first and last are repeated.

    As ``scipy.ndimage.median_filter`` with ``mode="nearest"``, whose import takes 0.2 s.

    >>> running_median(np.array([0.0, 9.0, 1.0, 2.0, 2.0]), 3).tolist()
    [0.0, 1.0, 2.0, 2.0, 2.0]
    """
    padded = np.pad(values, size // 2, mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, size)
    return np.partition(around, size // 2, axis=1)[:, size // 2]


def soft_levels(values: FloatArray) -> FloatArray:
    """s of the module's docstring, level after level: array (frames, levels * columns)."""
    halves = [np.tanh((values - level) / (2.0 * SOFTNESS)) for level in LEVELS]
    return np.asarray(0.5 + 0.5 * np.concatenate(halves, axis=1))


def block_sizes(n_columns: int) -> tuple[int, ...]:
    """Number of columns of places, joint, rhythm, posture and travel, given the total.

    >>> block_sizes(627), block_sizes(0)
    ((120, 300, 120, 63, 24), ())
    """
    if n_columns == 0:
        return ()
    return (*_sizes(n_columns - N_POSTURE - N_TRAVEL), N_POSTURE, N_TRAVEL)


def count_posture_and_travel(n_columns: int) -> int:
    """Number of the last columns that are posture and travel, given the number of all columns.

    >>> count_posture_and_travel(627), count_posture_and_travel(0)
    (87, 0)
    """
    return sum(block_sizes(n_columns)[3:])


def block_weight(block: int) -> float:
    """Weight of a block of :func:`block_sizes` relative to all symbols together.

    >>> [block_weight(block) for block in range(5)]
    [1.0, 1.0, 1.0, 1.0, 1.5]
    """
    return TRAVEL_WEIGHT if block == 4 else 1.0


def _sizes(n_columns: int) -> tuple[int, int, int]:
    """Columns of places, joint and rhythm, given their total."""
    per_dimension = 2 * (len(LEVELS) + len(LAGS)) + 1
    n_dims = (np.sqrt(per_dimension**2 + 8.0 * max(n_columns, 0)) - per_dimension) / 2.0
    n_dims = round(float(n_dims))
    return len(LEVELS) * n_dims, n_dims * (n_dims + 1) // 2, len(LAGS) * n_dims


def describe_movement(
    frames: FloatArray | Float32Array, starts: IntArray, ends: IntArray
) -> Float32Array:
    """Compute places, joint and rhythm of the segments of one capture.

    Shapes: `frames` (frames, D); `starts`, `ends` (segments,); result (segments, columns).
    """
    # In double precision: tanh and products differ in their last bits between processors.
    values = frames.astype(np.float64)
    n_frames, n_dims = values.shape
    first, second = np.triu_indices(n_dims)
    now = np.arange(n_frames)
    rhythm = [np.abs(values[np.minimum(now + lag, n_frames - 1)] - values) for lag in LAGS]
    each = np.concatenate([soft_levels(values), *rhythm], axis=1)
    n_places = len(LEVELS) * n_dims
    rows = np.empty((len(starts), each.shape[1] + len(first)), dtype=np.float32)
    for row, start, end in zip(rows, starts, ends):
        means = each[start:end].mean(axis=0)
        products = values[start:end].T @ values[start:end] / (end - start)
        row[:] = np.concatenate([means[:n_places], products[first, second], means[n_places:]])
    return rows
