"""Stitching: the choice against enumeration, seams by hand, every frame with its source."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.generate import stitching
from motiondb.generate.stitching import BLEND_FRAMES, Candidates, Piece
from motiondb.records import FloatArray

Sources = dict[int, tuple[FloatArray, FloatArray]]


def random_candidates(rng: np.random.Generator) -> Candidates:
    n = int(rng.integers(1, 5))
    starts = rng.integers(0, 4, n) * 10
    return Candidates(
        rng.integers(0, 2, n),
        starts,
        starts + 10,
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3)),
        rng.uniform(0, 2, n),
    )


def cost_of(candidates: list[Candidates], path: tuple[int, ...], weight: float) -> float:
    """Target and join costs of a path, written out."""
    total = sum(float(c.targets[i]) for c, i in zip(candidates, path))
    for k in range(1, len(path)):
        a, b, i, j = candidates[k - 1], candidates[k], path[k - 1], path[k]
        if a.captures[i] == b.captures[j] and a.ends[i] == b.starts[j]:
            continue
        total += weight * (float(np.sum((a.continuations[i] - b.entries[j]) ** 2)) + 1e-3)
        if a.captures[i] == b.captures[j] and set(range(a.starts[i], a.ends[i])) & set(
            range(b.starts[j], b.ends[j])
        ):
            total += weight * stitching.AGAIN_COST
    return total


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 4), st.floats(0, 2))
def test_the_choice_equals_enumeration(seed: int, length: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    candidates = [random_candidates(rng) for _ in range(length)]
    chosen = stitching.choose(candidates, weight)
    every = product(*(range(len(c.targets)) for c in candidates))
    best = min(cost_of(candidates, path, weight) for path in every)
    assert cost_of(candidates, tuple(chosen), weight) == pytest.approx(best)


def sources(n_captures: int = 3, n_frames: int = 60) -> Sources:
    """Captures whose height is 100 * capture + frame, turned by as many milliradians."""
    made: Sources = {}
    for capture in range(n_captures):
        values = 100.0 * capture + np.arange(n_frames)
        path = np.repeat(values[:, None], 4, axis=1)
        turn = rotation.from_axis_angle(np.array([1.0, 0, 0]), values * 1e-3)
        made[capture] = (path, np.repeat(turn[:, None], 21, axis=1))
    return made


def test_a_seam_by_hand() -> None:
    made = stitching.stitch([Piece(0, 10, 30), Piece(1, 20, 40)], sources())
    half = BLEND_FRAMES // 2
    share = (np.arange(BLEND_FRAMES) + 0.5) / BLEND_FRAMES
    share = share * share * (3 - 2 * share)
    seam = slice(20 - half, 20 + half)
    old, new = np.arange(30 - half, 30 + half), 100.0 + np.arange(20 - half, 20 + half)
    np.testing.assert_allclose(made.path[seam, 0], old * (1 - share) + new * share)
    angles = rotation.log(made.rotations[seam, 4])[:, 0]
    np.testing.assert_allclose(angles, 1e-3 * (old * (1 - share) + new * share), rtol=1e-6)
    np.testing.assert_array_equal(made.captures[seam], [0] * half + [1] * half)
    np.testing.assert_array_equal(made.frames[seam], [*range(25, 30), *range(20, 25)])
    np.testing.assert_allclose(made.shares[seam], np.maximum(share, 1 - share))


@st.composite
def pieces(draw: st.DrawFn) -> list[Piece]:
    made = []
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, 58))
        end = draw(st.integers(start + 1, 60))
        made.append(Piece(draw(st.integers(0, 2)), start, end))
    return made


@settings(deadline=None, max_examples=60)
@given(pieces())
def test_frames_add_up_and_know_their_source(chosen: list[Piece]) -> None:
    made = stitching.stitch(chosen, sources())
    n_frames = sum(p.end - p.start for p in chosen)
    assert len(made.path) == len(made.rotations) == n_frames
    assert len(made.captures) == len(made.frames) == len(made.shares) == n_frames
    assert made.frames.min() >= 0
    assert made.frames.max() < 60
    assert made.shares.min() >= 0.5
    whole = made.shares == 1.0
    np.testing.assert_allclose(
        made.path[whole, 0], 100.0 * made.captures[whole] + made.frames[whole]
    )
    np.testing.assert_allclose(np.linalg.norm(made.rotations, axis=-1), 1.0)


def test_seams_hold_the_ends_of_captures() -> None:
    """Beyond its last frame a capture stands still: its height stays, its speeds are nothing."""
    made = stitching.stitch([Piece(0, 40, 60), Piece(1, 0, 20)], sources())
    first = made.path[15]
    share = (0.5 / BLEND_FRAMES) ** 2 * (3 - 1.0 / BLEND_FRAMES)
    np.testing.assert_allclose(first, [55 * (1 - share) + 100 * share] + [55 * (1 - share)] * 3)
    assert made.frames.tolist()[18:22] == [58, 59, 0, 1]
