"""Strings played as motion: best clips, seams that follow, feet that stand, frames that know."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from sample_motions import SAMPLES, sample_motion

from motiondb.body import features, pose_vectors, retarget
from motiondb.body.contacts import foot_slip
from motiondb.errors import QueryError
from motiondb.generate import stitching
from motiondb.grammar import synthesis
from motiondb.grammar.terminals.terminals import Terminals
from motiondb.records import FloatArray, Motion


def true_terminals(name: str, take: int = 0) -> tuple[Motion, Terminals]:
    """A sample take and its true segmentation."""
    rows = [
        line.split("\t")
        for line in (SAMPLES / "segments.tsv").read_text().splitlines()
        if line.startswith(f"{name}.bvh\t")
    ]
    kinds = sorted({row[5] for row in rows})
    labels = np.array([kinds.index(row[5]) for row in rows])
    actual = Terminals(
        tuple(kinds),
        np.full(len(rows), take),
        np.array([int(row[3]) for row in rows]),
        np.array([int(row[4]) for row in rows]),
        labels,
        np.array([np.flatnonzero(labels == k)[0] for k in range(len(kinds))]),
        1.0,
    )
    return sample_motion(name), actual


@pytest.fixture(scope="module")
def dance() -> tuple[Terminals, synthesis.ClipSource]:
    motion, terminals = true_terminals("ana/long_dance_2")
    return terminals, synthesis.clip_source({0: motion})


STRING = ("dance_left", "dance_clap", "dance_dip", "dance_left", "dance_right")


def join_cost(terminals: Terminals, source: synthesis.ClipSource, a: int, b: int) -> float:
    """j of the definition, for one pair."""
    if terminals.takes[a] == terminals.takes[b] and terminals.ends[a] == terminals.starts[b]:
        return 0.0
    edges = source.edges[int(terminals.takes[a])]
    gap = edges[min(terminals.ends[a], len(edges) - 1)] - edges[terminals.starts[b]]
    return float(gap @ gap) + 1e-3


def test_the_choice_is_the_best_of_all(dance: tuple[Terminals, synthesis.ClipSource]) -> None:
    terminals, source = dance
    candidates, numbers = synthesis.clip_candidates(terminals, STRING, source)
    every = [
        sum(join_cost(terminals, source, a, b) for a, b in pairwise(clips))
        for clips in product(*(n.tolist() for n in numbers))
    ]
    best = synthesis.choose_clips(candidates, numbers)
    assert len(every) == 7 * 4 * 2 * 7 * 7
    assert best.cost == pytest.approx(min(every))
    assert tuple(terminals.names[terminals.labels[clip]] for clip in best.clips) == STRING
    joins = [join_cost(terminals, source, a, b) for a, b in pairwise(best.clips)]
    assert best.cost == pytest.approx(sum(joins))


def test_preferred_segments_are_the_only_candidates_where_there_are_some(
    dance: tuple[Terminals, synthesis.ClipSource],
) -> None:
    terminals, source = dance
    _, numbers = synthesis.clip_candidates(terminals, STRING, source)
    some, none = numbers[0][2:4], numbers[2]
    _, kept = synthesis.clip_candidates(terminals, STRING, source, None, {0: some, 1: none})
    assert kept[0].tolist() == some.tolist()
    assert [k.tolist() for k in kept[1:]] == [n.tolist() for n in numbers[1:]]
    pinned = {0: int(numbers[0][0])}  # what is pinned stays, preferred or not
    _, kept = synthesis.clip_candidates(terminals, STRING, source, pinned, {0: some})
    assert kept[0].tolist() == [pinned[0]]


def test_a_take_is_played_as_it_was(dance: tuple[Terminals, synthesis.ClipSource]) -> None:
    terminals, source = dance
    string = [terminals.names[k] for k in terminals.labels]
    candidates, numbers = synthesis.clip_candidates(terminals, string, source)
    choice = synthesis.choose_clips(candidates, numbers)
    assert choice.cost == 0.0
    assert choice.clips == tuple(range(len(string)))
    made = synthesis.synthesise(terminals, choice.clips, source)
    original = pose_vectors.from_path(*source.paths[0])
    np.testing.assert_allclose(made.motion.root_positions, original.root_positions, atol=1e-5)
    assert made.frames.tolist() == list(range(original.n_frames))
    assert set(made.edits) == {"foot lock"}


def values(motion: Motion) -> FloatArray:
    """Height, planar velocity, turning, and all rotations but those of legs, which feet correct."""
    path, local = pose_vectors.to_path(motion)
    upper = [0, *range(9, 21)]
    return np.concatenate([path, np.abs(local[:, upper]).reshape(len(path), -1)], axis=1)


def test_what_lies_outside_an_edited_region_stays(
    dance: tuple[Terminals, synthesis.ClipSource],
) -> None:
    terminals, source = dance
    before = ("dance_sway", "dance_left", "dance_right", "dance_clap", "dance_dip", "dance_sway")
    after = ("dance_sway", "dance_clap", "dance_dip", "dance_sway")
    first = synthesis.choose_clips(*synthesis.clip_candidates(terminals, before, source))
    pinned = {0: first.clips[0], 2: first.clips[4], 3: first.clips[5]}
    edited = synthesis.choose_clips(*synthesis.clip_candidates(terminals, after, source, pinned))
    assert {k: edited.clips[k] for k in pinned} == pinned
    old = synthesis.synthesise(terminals, first.clips, source)
    new = synthesis.synthesise(terminals, edited.clips, source)
    blend = stitching.BLEND_FRAMES // 2 + 1
    for a, b in ((0, 0), (4, 2), (5, 3)):
        (i, j), (m, n) = old.spans[a], new.spans[b]
        assert j - i == n - m
        inside = slice(blend, -blend)
        np.testing.assert_allclose(
            values(new.motion)[m:n][inside], values(old.motion)[i:j][inside], atol=2e-3
        )
        assert new.frames[m:n][inside].tolist() == old.frames[i:j][inside].tolist()


def test_place_and_heading_are_carried_on_and_no_seam_jumps(
    dance: tuple[Terminals, synthesis.ClipSource],
) -> None:
    terminals, source = dance
    string = ("dance_right", "dance_right", "dance_sway", "dance_right", "dance_dip", "dance_left")
    choice = synthesis.choose_clips(*synthesis.clip_candidates(terminals, string, source))
    made = synthesis.synthesise(terminals, choice.clips, source)
    assert [b for _, b in made.spans[:-1]] == [a for a, _ in made.spans[1:]]
    assert made.spans[-1][1] == made.motion.n_frames
    positions, world = retarget.motion_positions(made.motion)
    original, turned = retarget.motion_positions(pose_vectors.from_path(*source.paths[0]))
    for new, old in (
        (positions, original),
        (features.headings(world)[:, None], features.headings(turned)[:, None]),
    ):
        fastest = np.abs(np.diff(old, axis=0)).max()
        assert np.abs(np.diff(new, axis=0)).max() < 1.5 * fastest


@pytest.mark.parametrize("seed", range(2))
def test_feet_slip_no_more_than_in_the_sources(
    dance: tuple[Terminals, synthesis.ClipSource], seed: int
) -> None:
    terminals, source = dance
    rng = np.random.default_rng(seed)
    string = [terminals.names[k] for k in rng.integers(len(terminals.names), size=10)]
    choice = synthesis.choose_clips(*synthesis.clip_candidates(terminals, string, source))
    made = synthesis.synthesise(terminals, choice.clips, source)
    assert made.slip == pytest.approx(foot_slip(made.motion))
    assert 0 < made.slip <= made.source_slip


def test_every_frame_knows_its_take_and_frame(
    dance: tuple[Terminals, synthesis.ClipSource],
) -> None:
    terminals, source = dance
    choice = synthesis.choose_clips(*synthesis.clip_candidates(terminals, STRING, source))
    made = synthesis.synthesise(terminals, choice.clips, source)
    assert len(made.takes) == len(made.frames) == len(made.edits) == made.motion.n_frames
    for clip, (start, end) in zip(choice.clips, made.spans):
        low, high = terminals.starts[clip], terminals.ends[clip]
        half = stitching.BLEND_FRAMES // 2
        frames = made.frames[start + half : end - half]
        assert frames.tolist() == list(range(low + half, high - half))
    assert any(edit.startswith("blend") for edit in made.edits)


def test_what_cannot_be_played_is_told(dance: tuple[Terminals, synthesis.ClipSource]) -> None:
    terminals, source = dance
    with pytest.raises(QueryError, match="expected at least one terminal, found none"):
        synthesis.clip_candidates(terminals, (), source)
    with pytest.raises(QueryError, match="'jump': expected a terminal of the grammar"):
        synthesis.clip_candidates(terminals, ("jump",), source)
    with pytest.raises(QueryError, match="expected captures of the grammar, found none left"):
        synthesis.clip_source({})
    lost = synthesis.ClipSource({}, {}, {})
    with pytest.raises(QueryError, match="dance_dip: expected a capture with this terminal"):
        synthesis.clip_candidates(terminals, ("dance_dip",), lost)
