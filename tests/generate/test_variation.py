"""Long cyclic movements: other excerpts, as long as the repetitions, and none that stops."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from motiondb.generate.cuts import Take, is_monotonous, vary
from motiondb.generate.excerpts import TOLERANCE, Layout
from motiondb.generate.stitching import Candidates
from motiondb.records import FloatArray

LOOPED = Layout(((0, 60), (20, 60), (20, 60), (20, 60), (20, 60), (20, 80)), "looped")


def _take(speed: FloatArray | float) -> Take:
    return Take(np.zeros((201, 1)), np.zeros((200, 1)), np.zeros(200), np.full(200, speed))


def _vary(
    lengths: list[int],
    captures: list[int],
    takes: dict[int, Take],
    is_last: bool = True,
    is_least: bool = False,
) -> tuple:
    n = len(lengths)
    moved = Candidates(
        np.array(captures), np.zeros(n, dtype=np.int64), np.array(lengths),
        np.zeros((n, 1)), np.zeros((n, 1)), np.zeros(n),
    )  # fmt: skip
    rng = np.random.default_rng(0)
    return vary(1, LOOPED, (moved, np.arange(n)), takes, (1.0, math.inf), is_last, is_least, rng)


def test_only_a_loop_that_is_played_more_than_twice_is_monotonous() -> None:
    assert is_monotonous(LOOPED)
    assert not is_monotonous(Layout(((0, 100), (20, 100))))
    assert not is_monotonous(Layout(((0, 30), (20, 30), (20, 40))))  # not long


@pytest.mark.parametrize("lengths", [[80, 82], [55, 50], [36, 30]])
def test_other_excerpts_fill_the_time_of_the_repetitions(lengths: list[int]) -> None:
    layout, between = _vary(lengths, [2, 3], {c: _take(1.0) for c in (1, 2, 3)})
    total = layout.n_frames + sum(piece.end - piece.start for piece in between)
    assert abs(total - LOOPED.n_frames) <= TOLERANCE * LOOPED.n_frames
    assert len(layout.parts) == 2
    assert {piece.capture for piece in between} <= {2, 3}
    assert all(a.capture != b.capture for a, b in pairwise(between))


def test_nobody_stops_on_the_way() -> None:
    takes = {c: _take(1.0) for c in (1, 3, 4)} | {2: _take(np.where(np.arange(200) < 40, 0.0, 1.0))}
    _, between = _vary([80, 75, 76], [2, 3, 4], takes)
    assert {piece.capture for piece in between} == {3, 4}


def test_the_cut_to_the_next_action_stays() -> None:
    takes = {c: _take(1.0) for c in (1, 2, 3)}
    layouts = [_vary([88, 83], [2, 3], takes, is_last)[0] for is_last in (True, False)]
    assert [layout.parts[-1][1] for layout in layouts] == [80 - 11, 80]


def test_at_least_is_meant_strictly() -> None:
    takes = {c: _take(1.0) for c in (1, 2, 3)}
    totals = []
    for is_least in (False, True):
        layout, between = _vary([78, 77], [2, 3], takes, is_least=is_least)
        totals.append(layout.n_frames + sum(piece.end - piece.start for piece in between))
    assert totals[0] < LOOPED.n_frames <= totals[1]


def test_without_excerpts_that_fit_the_loop_stays() -> None:
    assert _vary([8], [2], {1: _take(1.0), 2: _take(1.0)}) == (LOOPED, ())
