"""Search by a path: against every part compared one by one, and the ways of real motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import motiondb
from motiondb.body.features import FEATURE_FPS, FEATURE_STEP, ROOT_WEIGHT, VELOCITY_SECONDS
from motiondb.errors import QueryError
from motiondb.meaning.travelled import speeds_of
from motiondb.records import Float32Array
from motiondb.search.by_path import (
    N_POINTS,
    PER_OCTAVE,
    SIZES,
    Ways,
    best_parts,
    points_of,
    read_path,
    way_of,
)

CORNER = [(0.0, 0.0), (0.0, 2.0), (-1.5, 2.0)]  # ahead, then to the left


def rows_of(speeds: NDArray[np.float64]) -> Float32Array:
    """Rows of frames of which only the root is used; `speeds` (frames, 3): left, ahead, turning."""
    root = np.zeros((len(speeds), 4))
    root[:, [0, 2, 3]] = speeds * ROOT_WEIGHT * VELOCITY_SECONDS
    return root.astype(np.float32)


def walks(turn: float, before: float = 3.0, after: float = 3.0) -> Float32Array:
    """Somebody who walks at 1 m/s, stands for 2 s, turns by an angle on the spot, and walks on."""
    frames = [round(seconds * FEATURE_FPS) for seconds in (before, 2.0, 1.0, after)]
    speeds = np.zeros((sum(frames), 3))
    speeds[: frames[0], 1] = speeds[-frames[3] :, 1] = 1.0
    speeds[frames[0] + frames[1] : -frames[3], 2] = turn
    return rows_of(speeds)


def test_a_corner_is_found_to_its_side_at_any_place_and_in_any_direction() -> None:
    rows = {3: walks(np.pi / 2), 5: walks(-np.pi / 2), 8: walks(0.0), 9: walks(np.pi / 2, 0.2, 0.2)}
    ways, turned = Ways.of(rows), 2.0 * np.exp(0.7j) * np.exp(1j * np.pi)
    for line in (CORNER, [(z.real, z.imag) for z in (turned, turned * 2.0, turned * (2.0 + 1.0j))]):
        found = {one.capture: one for one in best_parts(ways, read_path(line), rows)}
        assert 9 not in found  # goes too short a way
        assert found[3].deviation < 0.06 < min(found[5].deviation, found[8].deviation)
        # the rest and the turn are in the part
        assert found[3].first < 3 * FEATURE_FPS < 6 * FEATURE_FPS < found[3].behind
    (alone,) = best_parts(Ways.of({5: rows[5]}), read_path(CORNER), [5])
    (beside,) = best_parts(ways, read_path(CORNER), [5])
    assert (alone.first, alone.behind, alone.size) == (beside.first, beside.behind, beside.size)
    assert alone.deviation == pytest.approx(beside.deviation, abs=1e-12)


def test_parts_are_the_best_of_all_compared_one_by_one() -> None:
    rng = np.random.default_rng(0)
    rows = {}
    for number in (1, 4, 6):
        speeds = np.column_stack(
            [0.2 * rng.normal(size=200), 1 + rng.random(200), rng.normal(size=200)]
        )
        rows[number] = rows_of(speeds)
    line, ways = read_path(CORNER), Ways.of(rows)
    length = np.abs(np.diff(line)).sum()
    for one in best_parts(ways, line, rows):
        k = ways.captures.tolist().index(one.capture)
        mine = slice(ways.starts[k], ways.starts[k] + len(rows[one.capture]))
        gone, way = ways.gone[mine], ways.points[mine]
        least = np.inf
        for size in SIZES:
            apart = size * length / (N_POINTS - 1)
            for start in np.arange(gone[0], gone[-1] - size * length + 1e-9, apart):
                at = start + apart * np.arange(N_POINTS)
                part = np.interp(at, gone, way.real) + 1j * np.interp(at, gone, way.imag)
                a, b = part - part.mean(), size * (line - line.mean())
                turn = np.vdot(b, a)
                rest = np.sqrt((np.abs(a - b * turn / abs(turn)) ** 2).mean())
                extent = np.sqrt(12.0 * (np.abs(b) ** 2).mean())
                least = min(least, rest / extent + PER_OCTAVE * abs(np.log2(size)))
        assert one.deviation == pytest.approx(least, abs=1e-9)


def test_ways_are_those_of_the_pelvis(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db, db.session.reading():
        numbers = {info.name: number for number, info in db.learned.captures.items()}
        for name in ("ana/walk_1", "fatou/curve_right_1", "goran/long_7"):
            rows = db.session.pool.of_capture(numbers[name])
            way = way_of(speeds_of(rows))
            root = db.motion(name).root_positions[::FEATURE_STEP]
            real = (root[:, 0] - 1j * root[:, 2])[: len(way)]
            a, b = way - way.mean(), real - real.mean()
            turn = np.vdot(a, b)
            assert np.sqrt((np.abs(b - a * turn / abs(turn)) ** 2).mean()) < 0.15


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("0,0 x", "found 'x'"),
        ("0,0", "expected 2 to 1000 points"),
        ("0,0 0,nan", "found NaN or larger"),
        ("0,0 0,1e300", "found NaN or larger"),
        ("0,0 0,0.1", "found one of 0.1 m"),
        ("0,0 0,1_000", "found '0,1_000'"),
        ("0,0 0,1e5", "found one of 1e\\+05 m"),
    ],
)
def test_what_is_no_path_is_refused(path: str, said: str) -> None:
    with pytest.raises(QueryError, match=said):
        read_path(points_of(path))


def test_to_and_fro_in_a_small_place_is_not_along_a_circle() -> None:
    line = read_path([(float(k % 2), 0.0) for k in range(9)])
    circle = np.zeros((round(10 * FEATURE_FPS), 3))
    circle[:, 1], circle[:, 2] = 0.8, 0.8 / 0.4
    (one,) = best_parts(Ways.of({1: rows_of(circle)}), line, [1])
    assert one.deviation > 0.3


def test_a_path_with_words_lies_where_captures_show_them(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.captures.along("0,0 0,2", "walk", limit=5)
        shown = {m.capture: (m.start, m.end) for m in db.search("walk", limit=1000).matches}
        assert answer.read_as == "walk"
        assert answer.matches
        for match in answer.matches:
            start, end = shown[match.capture]
            assert match.start < end
            assert match.end > start
            assert "; walk" in match.reason
