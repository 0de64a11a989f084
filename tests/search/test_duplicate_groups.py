"""Groups of duplicates: by hand, against a slow twin, and planted among sample takes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_motions import sample_motion

from motiondb.body import retarget
from motiondb.records import Motion, Relation
from motiondb.search import copies
from motiondb.search.copies import group_duplicates


def relation(capture: str, other: str, kind: str = "same") -> Relation:
    return Relation(capture, other, kind, 0.0, 1.0, 0.001)


def test_groups_by_hand() -> None:
    """a is a cut of b, d mirrors b: one group, whose longest comes first. e and f are another."""
    durations = {"a": 1.0, "b": 9.0, "c": 5.0, "d": 9.0, "e": 3.0, "f": 3.0}
    relations = [relation("f", "e"), relation("a", "b", "cut"), relation("d", "b", "mirror")]
    first, second = group_duplicates(relations, durations)
    assert first.captures == ("b", "a", "d")
    assert [r.kind for r in first.relations] == ["cut", "mirror"]
    assert second.captures == ("e", "f")
    assert group_duplicates([], durations) == ()


def test_two_files_of_one_take_that_differ_by_a_frame_keep_the_first() -> None:
    assert group_duplicates([relation("b", "a")], {"a": 4.0, "b": 4.03})[0].captures == ("a", "b")


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=14))
def test_groups_are_the_connected_ones(pairs: list[tuple[int, int]]) -> None:
    """Against spreading from every capture until nothing more is reached."""
    durations = {f"n{n}": float(n % 4) for n in range(10)}
    relations = [relation(f"n{a}", f"n{b}") for a, b in pairs if a != b]
    reached = {name: {name} for name in durations}
    for _ in durations:
        for r in relations:
            both = reached[r.capture] | reached[r.other]
            for name in both:
                reached[name] = both | reached[name]
    expected = {frozenset(group) for group in reached.values() if len(group) > 1}
    groups = group_duplicates(relations, durations)
    assert {frozenset(g.captures) for g in groups} == expected
    assert sorted(map(id, (r for g in groups for r in g.relations))) == sorted(map(id, relations))
    for group in groups:
        assert durations[group.captures[0]] == max(durations[n] for n in group.captures)


def planted(motion: Motion, rng: np.random.Generator) -> list[tuple[str, Motion]]:
    """The same take at another rate, turned, moved, scaled and noisy; a cut of it; its mirror."""

    def rewritten(shown: Motion, start: float, end: float) -> Motion:
        positions, _ = retarget.motion_positions(shown)
        fps = float(rng.choice([50.0, 60.0, 100.0]))
        times = np.arange(start, end, 1.0 / fps) * 30.0
        times = times[times <= len(positions) - 1]
        low = np.minimum(times.astype(int), len(positions) - 2)
        share = (times - low)[:, None, None]
        points = positions[low] * (1 - share) + positions[low + 1] * share
        turn = rng.uniform(0, 2 * np.pi)
        c, s = np.cos(turn), np.sin(turn)
        points = points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + [2.0, 0.0, -1.0]
        points = points * rng.uniform(0.8, 1.2) + rng.normal(0, 0.001, points.shape)
        return retarget.motion_from_positions(points, fps)

    seconds = motion.n_frames / 30.0
    start = float(rng.uniform(0.0, 0.4)) * seconds
    return [
        ("same", rewritten(motion, 0.0, seconds)),
        ("cut", rewritten(motion, start, start + 0.5 * seconds)),
        ("mirror", rewritten(retarget.mirror(motion), 0.0, seconds)),
    ]


def test_a_cut_between_frames_is_found() -> None:
    """Half a frame of a kick is more than copies may differ by; frames in between are looked at."""
    take = sample_motion("boris/kick_1")
    poses = copies.copy_poses(take)
    between = (0.5 * poses[10:50] + 0.5 * poses[11:51]).astype(np.float32)
    for offset in (10, 11):
        near = poses[offset : offset + 40]
        assert np.sqrt(np.mean((near - between) ** 2) * 3) > copies.NEAR
    (copy,) = copies.find_copies(copies.build_library([poses, between]), [1])
    assert (copy.kind, copy.take) == ("cut", 0)
    assert copy.start in (10, 11)
    assert copy.distance < 1e-4
