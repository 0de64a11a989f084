"""Strings of clips on the ground beside composition, place by place."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.scene.clips import clip_cutting
from motiondb.scene.energy.placement import (
    chain,
    clip_arrays,
    clip_at,
    place_in_clip,
    put_origin,
)

QUARTER = math.pi / 2


def placed_string(library, entries, origin, delay):
    arrays = clip_arrays(library)
    placed, begin = np.zeros((len(entries) + 1, 5)), np.zeros(len(entries) + 1, np.int64)
    put_origin(placed, *origin)
    begin[0] = delay
    chain(placed, begin, np.asarray(entries, dtype=np.int64), arrays.clips, 0, len(entries))
    return placed, begin, arrays


def test_two_clips_by_hand(wandering) -> None:
    """From (1, 0) facing +x: 2 m ahead and a quarter turn on, then 3 m ahead: at (3, -3)."""
    library = wandering(["walk"], each=2)
    library.step[:] = [[0.0, 2.0, QUARTER], [0.0, 3.0, 0.0]]
    placed, begin, _ = placed_string(library, [0, 1], (1.0, 0.0, QUARTER), 5)
    np.testing.assert_allclose(placed[1, :3], [3.0, 0.0, math.pi], atol=1e-12)
    np.testing.assert_allclose(placed[2, :3], [3.0, -3.0, math.pi], atol=1e-12)
    assert begin.tolist() == [5, 5 + library.n_frames[0], 5 + library.n_frames.sum()]


seeds = st.integers(0, 2**32 - 1)


@settings(deadline=None)  # the first call may compile
@given(seeds, st.integers(1, 9))
def test_products_are_compositions_and_a_swap_moves_the_tail_as_one(wandering, seed, n) -> None:
    rng = np.random.default_rng(seed)
    library = wandering(["walk", "run"])
    entries, origin = rng.integers(0, 12, n), rng.normal(0.0, 3.0, 3)
    placed, begin, arrays = placed_string(library, entries, origin, 4)
    place = origin
    for k, entry in enumerate(entries):
        np.testing.assert_allclose(placed[k, :3], place, atol=1e-12)
        frame = int(rng.integers(library.n_frames[entry]))
        row = int(library.path_start[entry]) + frame
        actual = place_in_clip(placed, arrays.path, row, k)
        np.testing.assert_allclose(
            actual, clip_cutting.compose(place, library.path[row]), atol=1e-12
        )
        assert clip_at(begin, n, int(begin[k]) + frame) == k
        place = clip_cutting.compose(place, library.step[entry])
    np.testing.assert_allclose(placed[:, 3], np.cos(placed[:, 2]), atol=1e-12)
    np.testing.assert_allclose(placed[:, 4], np.sin(placed[:, 2]), atol=1e-12)

    k = int(rng.integers(n))
    swapped = entries.copy()
    swapped[k] = rng.integers(0, 12)
    after, later, _ = placed_string(library, swapped, origin, 4)
    motion = clip_cutting.compose(after[k + 1, :3], clip_cutting.inverse(placed[k + 1, :3]))
    tail = clip_cutting.compose(motion, placed[k + 1 :, :3])
    np.testing.assert_allclose(after[k + 1 :, :3], tail, atol=1e-11)
    np.testing.assert_array_equal(after[: k + 1], placed[: k + 1])
    assert len(set((later - begin)[k + 1 :].tolist())) == 1


def test_before_and_behind_a_string_its_ends_play(wandering) -> None:
    library = wandering(["walk"])
    _, begin, _ = placed_string(library, [0, 1, 2], (0.0, 0.0, 0.0), 30)
    assert clip_at(begin, 3, 0) == 0
    assert clip_at(begin, 3, int(begin[3]) + 100) == 2


def test_clips_know_their_action_their_middle_and_their_way(wandering) -> None:
    library = wandering(["walk", "run"], each=3)
    arrays = clip_arrays(library)
    assert arrays.clips["first"].tolist() == [0, 0, 0, 3, 3, 3]
    assert arrays.clips["last"].tolist() == [3, 3, 3, 6, 6, 6]
    for entry in range(6):
        n, start = int(library.n_frames[entry]), int(library.path_start[entry])
        events = library.event_frame[entry]
        assert arrays.clips["event"][entry] == (events if events >= 0 else (n - 1) // 2)
        ends = np.vstack([library.path_of(entry)[:, :2], library.step[entry, :2]])
        metres = [0.0]
        for one, other in pairwise(ends):
            metres.append(metres[-1] + float(np.hypot(*(other - one))))
        np.testing.assert_allclose(arrays.way[start : start + n], metres[:-1])
        np.testing.assert_allclose(arrays.clips["length"][entry], metres[-1])
