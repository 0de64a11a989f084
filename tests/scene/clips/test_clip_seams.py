"""The cost of seams against a slow twin, and by hand."""

from __future__ import annotations

import numpy as np

from motiondb.scene.clips.clips import SeamEnds, rest_costs, seam_costs


def ends(n: int, seed: int = 0) -> SeamEnds:
    rng = np.random.default_rng(seed)
    shape = (n, 2, 21, 3)
    return SeamEnds(
        captures=np.arange(n) % 3,
        starts=np.arange(n) * 10,
        ends=np.arange(n) * 10 + 30,
        entries=rng.normal(size=shape),
        exits=rng.normal(size=shape),
    )


def test_ten_centimetres_off_and_one_metre_a_second_too_fast_cost_one_each() -> None:
    zero = np.zeros((2, 2, 21, 3))
    off = zero.copy()
    off[1, 0, :, 1] = 0.10  # the second clip begins 10 cm higher,
    off[1, 1, :, 2] = 2.0  # and 2 m/s faster
    costs = seam_costs(SeamEnds(np.array([0, 1]), np.zeros(2), np.full(2, 9), off, zero))
    np.testing.assert_allclose(costs, [[0.0, 3.0], [0.0, 3.0]], atol=1e-6)


def test_costs_equal_those_of_the_slow_twin() -> None:
    clips = ends(150, seed=1)
    costs = seam_costs(clips)
    assert costs.dtype == np.float32
    rng = np.random.default_rng(2)
    for a, b in rng.integers(150, size=(200, 2)):
        pose = np.mean([np.linalg.norm(clips.exits[a, 0, j] - clips.entries[b, 0, j])
                        for j in range(21)])  # fmt: skip
        speed = np.mean([np.linalg.norm(clips.exits[a, 1, j] - clips.entries[b, 1, j])
                         for j in range(21)])  # fmt: skip
        follows = clips.captures[a] == clips.captures[b] and clips.ends[a] == clips.starts[b]
        expected = 0.0 if follows else pose / 0.10 + speed / 1.0
        np.testing.assert_allclose(costs[a, b], expected, rtol=1e-5)
    assert costs[0, 3] == 0.0  # frames 0..30 and 30..60 of capture 0
    assert costs[1, 2] > 0.0


def test_no_clips_have_no_seams() -> None:
    assert seam_costs(ends(0)).shape == (0, 0)


def test_to_begin_and_to_stop_costs_as_much_as_one_moves() -> None:
    clips = ends(3)
    clips.entries[:, 1] = 0.0
    clips.entries[0, 1, :, 2] = 3.0  # runs at 3 m/s when it begins
    clips.exits[:, 1] = 0.0
    clips.exits[1, 1, :7, 0] = 1.5  # a third of the joints moves when it ends
    np.testing.assert_allclose(rest_costs(clips), [[3.0, 0.0], [0.0, 0.5], [0.0, 0.0]])
