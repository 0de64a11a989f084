"""Copies: planted ones are found, different takes are not."""

from __future__ import annotations

import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from naive_copies import find_everywhere
from sample_motions import sample_motion

from motiondb.body import retarget
from motiondb.records import Float32Array, Motion
from motiondb.search import copies

NAMES = (
    "ana/walk_1",
    "ana/dance_1",
    "boris/walk_1",
    "boris/idle_1",
    "emil/dance_1",
    "boris/kick_1",
)


@pytest.fixture(scope="module")
def motions() -> list[Motion]:
    return [sample_motion(name) for name in NAMES]


def poses_of(motions: list[Motion]) -> list[Float32Array]:
    return [copies.copy_poses(m) for m in motions]


def relations_of(poses: list[Float32Array], query: int) -> list[tuple[int, str, int, int]]:
    library = copies.build_library(poses)
    return [(c.take, c.kind, c.start, c.end) for c in copies.find_copies(library, [query])]


def cut(motion: Motion, start: int, end: int) -> Motion:
    return replace(
        motion,
        local_rotations=motion.local_rotations[start:end],
        root_positions=motion.root_positions[start:end],
    )


def test_different_takes_are_no_copies(motions: list[Motion]) -> None:
    """Not even two walks, or an idle take and any other."""
    library = copies.build_library(poses_of(motions))
    assert copies.find_copies(library, range(len(motions))) == []


def test_the_same_take_in_another_file(motions: list[Motion]) -> None:
    """Turned, elsewhere, and with the noise of another export."""
    rng = np.random.default_rng(0)
    positions, _ = retarget.motion_positions(motions[1])
    other = positions[:, :, [2, 1, 0]] * [1, 1, -1] + [4.0, 0.0, 1.0]
    other = other + rng.normal(0, 0.002, positions.shape)
    again = retarget.motion_from_positions(other * 1.3, 30.0)
    poses = poses_of([*motions, again])
    n = motions[1].n_frames
    assert relations_of(poses, 6) == [(1, "same", 0, n)]
    assert relations_of(poses, 1) == []  # the later number is the copy


@pytest.mark.parametrize("shorter", [0, 1, 2])
def test_a_frame_or_two_more_or_less_is_the_same_take(motions: list[Motion], shorter: int) -> None:
    """Also where the shorter file is the last of all."""
    poses = poses_of(motions)
    n = len(poses[5])
    assert relations_of([*poses, poses[5][: n - shorter]], 6) == [(5, "same", 0, n - shorter)]
    assert relations_of([*poses[:5], poses[5][: n - shorter], poses[5]], 6) == [
        (5, "same", 0, n - shorter)
    ]


def test_a_mirrored_take(motions: list[Motion]) -> None:
    poses = poses_of([*motions, retarget.mirror(motions[4])])
    assert relations_of(poses, 6) == [(4, "mirror", 0, motions[4].n_frames)]


def test_a_cut_of_a_longer_take(motions: list[Motion]) -> None:
    """Heading and place begin anew in a cut, so the poses are made from its own frames."""
    poses = poses_of([*motions, cut(motions[1], 31, 75)])
    assert relations_of(poses, 6) == [(1, "cut", 31, 75)]
    assert relations_of(poses, 1) == []


def test_a_cut_of_a_mirrored_take(motions: list[Motion]) -> None:
    poses = poses_of([*motions, cut(retarget.mirror(motions[1]), 20, 64)])
    assert relations_of(poses, 6) == [(1, "mirror", 20, 64)]


def test_only_the_places_asked_for_are_looked_at(motions: list[Motion]) -> None:
    library = copies.build_library(poses_of([*motions, motions[1], motions[1]]))
    hits = copies.find_copies(library, [7], takes=[0, 6])
    assert [(c.take, c.kind) for c in hits] == [(6, "same")]
    assert hits[0].distance < 1e-3


def test_two_who_stand_still_are_no_copies() -> None:
    """Nearer than two centimetres, but as near as the motion itself is wide."""
    rng = np.random.default_rng(1)
    still = np.cumsum(rng.normal(0, 0.001, (2, 60, 63)), axis=1).astype(np.float32)
    assert relations_of([still[0], still[1]], 1) == []
    assert relations_of([still[0], still[0]], 1) == [(0, "same", 0, 60)]


@pytest.mark.parametrize("n_frames", [0, 1, copies.LEAST_FRAMES - 1])
def test_very_short_takes_are_never_copies(motions: list[Motion], n_frames: int) -> None:
    poses = poses_of(motions)
    assert relations_of([*poses, poses[1][:n_frames]], 6) == []


def test_an_empty_library_holds_nothing() -> None:
    library = copies.build_library([])
    assert len(library.sizes) == 0
    assert copies.find_copies(library, []) == []


def test_the_mirror_image_of_poses(motions: list[Motion]) -> None:
    poses = copies.copy_poses(motions[2])
    mirrored = copies.copy_poses(retarget.mirror(motions[2]))
    np.testing.assert_allclose(copies.mirror_poses(poses), mirrored, atol=1e-5)
    np.testing.assert_array_equal(copies.mirror_poses(copies.mirror_poses(poses)), poses)


@pytest.mark.parametrize("at_once", [copies.AT_ONCE, 200, 1])
def test_the_outlines_rule_out_no_place_that_a_full_comparison_finds(
    motions: list[Motion], at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Parts, mirror images, other rates and noise, against every take at every offset.

    `at_once`: Frames that are put into boxes together.
    """
    monkeypatch.setattr(copies, "AT_ONCE", at_once)
    rng = np.random.default_rng(0)
    poses = poses_of(motions)
    for number in range(24):
        take = poses[rng.integers(len(motions))]
        start = int(rng.integers(0, len(take) - 24)) if number % 4 else 0
        part = take[start : start + int(rng.integers(22, len(take) - start + 1))]
        part = take if number == 12 else part
        part = (part[:-1] + part[1:]) / 2 if number % 3 == 1 else part
        noise = rng.normal(0.0, 0.012 * rng.random(), part.shape)
        part = (part + noise).astype(np.float32)
        poses.append(copies.mirror_poses(part) if number % 2 else part)
    library, everything = copies.build_library(poses), range(len(poses))
    found = copies.find_copies(library, everything)
    assert found == find_everywhere(poses, everything, everything)
    assert {copy.kind for copy in found} == {"mirror", "cut", "same"}
    some, old = list(range(20, 30)), list(range(20))
    assert copies.find_copies(library, old, some) == find_everywhere(poses, old, some)


class Ahead:
    """Workers with many pieces in hand, as many as a cluster of sixteen has."""

    def n_pieces(self, seconds: float = 0.0) -> int:
        return 64

    def map(
        self, work: Callable[..., Any], pieces: Iterable[Any], *shared: object
    ) -> Iterator[Any]:
        running = deque[Any]()
        for piece in pieces:
            running.append(piece)
            if len(running) == self.n_pieces():
                yield work(running.popleft(), *shared)
        while running:
            yield work(running.popleft(), *shared)


def test_few_groups_of_few_frames_are_in_memory(
    motions: list[Motion], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many takes there are, of whatever lengths, and however many pieces are in hand."""
    long = poses_of(motions)
    short = [pose[:21] for pose in long for _ in range(6)]
    library = copies.build_library([*short, *long, *long])
    everything = range(len(library.sizes))
    at_once = copies.find_copies(library, everything)
    monkeypatch.setattr(copies, "AT_ONCE", max(map(len, long)))
    made, most, n_frames = weakref.WeakSet[Any](), 0, list[int]()
    make = copies.make_boxes

    def watched(*args: Any, **options: Any) -> object:
        nonlocal most
        boxes = make(*args, **options)
        made.add(boxes)
        most = max(most, len(made))
        n_frames.append(len(boxes.outlines.limbs))
        return boxes

    monkeypatch.setattr(copies, "make_boxes", watched)
    assert copies.find_copies(library, everything, workers=Ahead()) == at_once
    assert sum(n_frames) == library.sizes.sum()
    assert max(n_frames) <= copies.AT_ONCE
    assert len(n_frames) > most == copies.TOGETHER
