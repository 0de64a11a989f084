"""Search by a path on the floor: the intervals that travel along a drawn line.

Both lines are compared at points that are as far apart along each of them, so that it does not
matter how fast somebody goes, or whether there is a rest in between. A part of a capture may lie
anywhere and in any direction, and be somewhat shorter or longer than the drawn line; a mirror image
is another path::

    for every size s:                          # of .7 to 1.4 times the drawn length L
        for every part of length s L:          # of the way of the pelvis
            turn and shift it onto the line    # in closed form, as complex numbers
            deviation = root mean square distance / (s E) + PER_OCTAVE * |log2 s|
    best part of each capture; captures in the order of their deviations

E is the length of a straight line whose points are as far from their mean as those of the drawn
one: a line that goes to and fro in a small place is not near another one by that alone.

The way is that of the velocities in the features, averaged over a second: the pelvis sways.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP
from motiondb.errors import QueryError
from motiondb.meaning.score_vectors import averaged_rows
from motiondb.meaning.travelled import STEADY, speeds_of
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.search.nearest_parts import Part

N_POINTS = 33  # Points at which two lines are compared
SIZES = tuple(float(size) for size in 2.0 ** np.linspace(-0.5, 0.5, 7))  # .7 to 1.4
PER_OCTAVE = 0.02  # Deviation that half or twice the size counts as
STANDS = 0.15  # Speed, m/s, up to which a body sways and does not travel
MOST_ALONG = 0.05
"""Largest deviation of a part that goes along a line: a turn of 45 degrees is .06 from a straight
line, a quarter of a circle .10 from a corner."""
BETWEEN = 1.0  # Length between the way of a capture and the next one, m
AT_ONCE = 50_000  # Parts that are compared at once: some 50 MB
SHORTEST, LONGEST, MOST_POINTS = 0.5, 100.0, 1000  # m, m, points of a drawn line


@dataclass(frozen=True, eq=False)
class Ways:
    """The ways of captures over the ground, end to end; that of each begins anywhere.

    The lengths grow from way to way, so that a length names a capture and a place in it.
    """

    captures: IntArray  # (captures,): numbers
    firsts: IntArray  # (captures,): feature frames of the captures at which the ways begin
    starts: IntArray  # (captures,): rows where they begin
    points: NDArray[np.complex128]  # (rows,): places, as ``way_of`` gives them, m
    gone: FloatArray  # (rows,): lengths of the ways up to there, m

    @staticmethod
    def of(rows: Mapping[int, Float32Array], firsts: Mapping[int, int] | None = None) -> Ways:
        """The ways of captures, or of parts of them, of their rows (see ``frame_rows``).

        `firsts`: Capture -> its frame at which the part begins; 0 for those that it lacks.
        """
        points, gone, end = list[NDArray[np.complex128]](), list[FloatArray](), 0.0
        for each in rows.values():
            way = way_of(speeds_of(each))
            steps = np.abs(np.diff(way))
            steps[steps * FEATURE_FPS < STANDS] = 0.0
            lengths = end + np.concatenate([[0.0], np.cumsum(steps)])
            end = float(lengths[-1]) + BETWEEN
            points.append(way)
            gone.append(lengths)
        starts = np.cumsum([0, *map(len, points)], dtype=np.int64)[:-1]
        if not points:
            points, gone = [np.zeros(0, dtype=np.complex128)], [np.zeros(0)]
        begins = [(firsts or {}).get(number, 0) for number in rows]
        numbers = np.array(list(rows), dtype=np.int64), np.array(begins, dtype=np.int64)
        return Ways(*numbers, starts, np.concatenate(points), np.concatenate(gone))


@dataclass(frozen=True)
class Along:
    """The part of a capture that goes along a line best."""

    capture: int
    first: int  # Feature frame
    behind: int  # Feature frame + 1
    apart: float  # Root mean square distance from the line, m
    size: float  # Length of the part as a share of that of the line
    deviation: float  # What ranks, smaller is better


def read_path(points: Sequence[Sequence[float]] | FloatArray) -> NDArray[np.complex128]:
    """A drawn line as ``N_POINTS`` complex numbers, equally far apart along it, m.

    `points` (points, 2): to the right and up, as seen from above, m.

    Raises
    ------
    QueryError
        If they are no finite points, or the line is shorter than 0.5 m or longer than 100 m.

    >>> line = read_path([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
    >>> len(line), complex(line[0]), complex(line[16]), complex(line[-1])
    (33, 0j, 1j, (1+1j))
    """
    try:
        xy = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        xy = np.zeros(0)
    if xy.ndim != 2 or xy.shape[1] != 2 or not 2 <= len(xy) <= MOST_POINTS:
        raise QueryError(
            f"path: expected 2 to {MOST_POINTS} points of 2 numbers, metres to the right and up as "
            "seen from above, such as '0,0 0,3 2,3', found something else."
        )
    if not (np.abs(xy) < 1e6).all():
        raise QueryError("path: expected numbers of metres below 1e6, found NaN or larger ones.")
    line = xy[:, 0] + 1j * xy[:, 1]
    along = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(line)))])
    if not SHORTEST <= along[-1] <= LONGEST:
        raise QueryError(
            f"path: expected a line of {SHORTEST:g} to {LONGEST:g} m, found one of "
            f"{along[-1]:.3g} m. Points are in metres."
        )
    return _at(line, along, np.linspace(0.0, along[-1], N_POINTS))


def points_of(text: str) -> list[tuple[float, float]]:
    """The points of a path as it is written: "0,0 0,3 2,3", m.

    Raises
    ------
    QueryError
        If it is not made of pairs of numbers.

    >>> points_of("0,0 0,3 -2,3.5")
    [(0.0, 0.0), (0.0, 3.0), (-2.0, 3.5)]
    """
    points = []
    for pair in text.replace(";", " ").split():
        try:
            right, up = (float(number) for number in pair.replace("_", "?").split(","))
        except ValueError:
            raise QueryError(
                f"path: expected points such as '0,0 0,3 2,3', metres to the right and up as seen "
                f"from above, found {pair!r}."
            ) from None
        points.append((right, up))
    return points


def parts_along(ways: Ways, line: NDArray[np.complex128], allowed: Collection[int]) -> list[Part]:
    """The part of each capture that goes along a line best; `line`: As ``read_path`` gives it."""
    return [
        Part(
            one.capture,
            one.first * FEATURE_STEP,
            one.behind * FEATURE_STEP,
            one.deviation,
            f"{100.0 * one.apart:.0f} cm off a path of {one.size * _length(line):.1f} m",
        )
        for one in best_parts(ways, line, allowed)
    ]


def best_parts(ways: Ways, line: NDArray[np.complex128], allowed: Collection[int]) -> list[Along]:
    """The part of each capture that goes along a line best; of those that travel far enough."""
    is_allowed = np.isin(ways.captures, np.fromiter(allowed, np.int64, len(allowed)))
    best = dict[int, Along]()
    begins = ways.gone[ways.starts]
    lengths = ways.gone[np.append(ways.starts[1:], len(ways.gone)) - 1] - begins
    for size in SIZES if is_allowed.any() else ():
        apart = size * _length(line) / (N_POINTS - 1)
        # points of each way, from its own beginning on
        counts = np.where(is_allowed, np.floor(lengths / apart + 1e-9).astype(np.int64) + 1, 0)
        owners = np.repeat(np.arange(len(counts)), counts)
        nth = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
        at = begins[owners] + apart * nth
        for low in range(0, len(at), AT_ONCE):
            some = slice(low, low + AT_ONCE + N_POINTS - 1)
            _keep_best(best, ways, size, line, at[some], owners[some])
    return list(best.values())


def _keep_best(
    best: dict[int, Along],
    ways: Ways,
    size: float,
    line: NDArray[np.complex128],
    at: NDArray[np.floating],
    owners: IntArray,
) -> None:
    """Keep the parts of a size that are better than those before.

    They begin at lengths `at` of the ways of `owners` (points,).
    """
    first, last = owners[: 1 - N_POINTS], owners[N_POINTS - 1 :]
    whole = first == last
    if not whole.any():
        return
    places = _at(ways.points, ways.gone, at)
    parts = np.lib.stride_tricks.sliding_window_view(places, N_POINTS)[whole]
    parts = parts - parts.mean(axis=1, keepdims=True)
    wanted = size * (line - line.mean())
    # the turn that brings a part nearest to the line leaves the modulus of this product
    product = np.abs(parts @ wanted.conj())
    squares = (np.abs(parts) ** 2).sum(axis=1) + (np.abs(wanted) ** 2).sum() - 2.0 * product
    distance = np.sqrt(np.maximum(squares, 0.0) / N_POINTS)
    deviation = distance / (size * _extent(line)) + PER_OCTAVE * abs(np.log2(size))
    starts, owner = at[: 1 - N_POINTS][whole], first[whole]
    for k in np.unique(owner).tolist():
        mine = np.flatnonzero(owner == k)
        n = int(mine[np.argmin(deviation[mine])])
        number = int(ways.captures[k])
        if number in best and best[number].deviation <= deviation[n]:
            continue
        low = int(np.searchsorted(ways.gone, starts[n] + 1e-9, side="right")) - 1
        behind = starts[n] + size * _length(line)
        high = int(np.searchsorted(ways.gone, behind - 1e-9)) + 1
        begin = int(ways.starts[k] - ways.firsts[k])
        best[number] = Along(
            number, low - begin, high - begin, float(distance[n]), size, float(deviation[n])
        )


def _extent(line: NDArray[np.complex128]) -> float:
    """Length of a straight line whose points are as far from their mean as those of a line, m."""
    return float(np.sqrt(12.0 * (np.abs(line - line.mean()) ** 2).mean()))


def _length(line: NDArray[np.complex128]) -> float:
    return float(np.abs(np.diff(line)).sum())


def way_of(speeds: FloatArray) -> NDArray[np.complex128]:
    """The way over the ground from the first frame, as seen from above, m: array (frames,).

    `speeds` (frames, 3): those of ``speeds_of``. The real part is to the right, the imaginary part
    ahead, of the first frame.

    >>> speeds = np.zeros((46, 3)); speeds[:, 1] = 1.0  # 3 s straight ahead
    >>> way = way_of(speeds)
    >>> bool(np.abs(way[-1] - 3j) < 1e-9)
    True
    """
    heading = np.concatenate([[0.0], np.cumsum(speeds[:-1, 2])]) / FEATURE_FPS
    velocity = (-speeds[:, 0] + 1j * speeds[:, 1]) * np.exp(1j * heading)
    velocity = averaged_rows(velocity, round(STEADY * FEATURE_FPS) // 2)
    way = np.concatenate([[0.0], np.cumsum(velocity[:-1])]) / FEATURE_FPS
    return np.asarray(way, dtype=np.complex128)


def _at(
    line: NDArray[np.complex128], along: FloatArray, places: NDArray[np.floating]
) -> NDArray[np.complex128]:
    """The points of a line at some lengths along it."""
    right, up = (np.interp(places, along, each) for each in (line.real, line.imag))
    return np.asarray(right + 1j * up, dtype=np.complex128)
