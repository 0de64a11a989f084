"""How far an activity lasts: the best interval against a slow twin, and takes with known ends."""

import numpy as np
import pytest

from motiondb.meaning import by_motion, extents


def swinging(n_frames: int, height: float, rng: np.random.Generator) -> np.ndarray:
    """Six features that swing about one height."""
    phase = 2 * np.pi * np.arange(n_frames)[:, None] / 12.0
    return (
        height * np.linspace(-1, 1, 6)
        + np.sin(phase + np.arange(6))
        + rng.normal(0, 0.05, (n_frames, 6))
    )


def test_an_activity_is_found_from_its_beginning_to_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(extents, "N_AXES", 3)  # the other axes of so little motion are noise
    rng = np.random.default_rng(0)
    take = np.concatenate([swinging(n, h, rng) for n, h in ((90, 0.0), (120, 4.0), (90, -3.0))])
    example = swinging(45, 4.0, rng)
    space = extents.fit_context_space([take, example])
    distance, start, end = extents.extent(space.view(example), space.view(take))
    assert abs(start - 90) <= 25
    assert abs(end - 210) <= 25
    assert distance < 2.0


def test_contexts_are_whitened() -> None:
    rng = np.random.default_rng(1)
    takes = [np.cumsum(rng.normal(size=(400, 3)), axis=0) for _ in range(3)]
    space = extents.fit_context_space(takes)
    seen = np.concatenate([space.view(take)[:: extents.THINNED] for take in takes])
    assert np.allclose(seen.T @ seen / len(seen), np.eye(6), atol=1e-6)


def test_a_take_shorter_than_an_activity_is_one() -> None:
    views = np.random.default_rng(2).normal(size=(10, 4))
    assert extents.extent(views, views[:5])[1:] == (0, 5)


@pytest.mark.parametrize(("warp", "expected"), [(0.05, (20, 60)), (0.9, (0, 90))])
def test_only_what_differs_frame_by_frame_gets_another_interval(
    warp: float, expected: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extents, "extent", lambda _example, _take: (0.1, 0, 90))
    actual = [by_motion.Candidate(7, 20, 60, 0.8, 0.5, warp)]
    placed = by_motion.to_activities(np.zeros((5, 2)), actual, {7: np.zeros((100, 2))})
    assert [(c.start, c.end) for c in placed] == [expected]


def test_an_answer_beside_the_activity_stays_where_it_is() -> None:
    actual = [by_motion.Candidate(7, 20, 60, 0.8, 0.5, 0.9)]
    assert by_motion.to_activities(np.zeros((5, 2)), actual, {}) == actual
