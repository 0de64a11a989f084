"""Motion read as a string: the cheapest cuts, terminals found again in another take."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from test_synthesis import true_terminals

from motiondb.errors import QueryError
from motiondb.grammar.terminals import labelling
from motiondb.records import FloatArray, Motion


def part(motion: Motion, start: int, end: int) -> Motion:
    return Motion(motion.local_rotations[start:end], motion.root_positions[start:end])


def best_cost(reader: labelling.Reader, values: FloatArray) -> float:
    """C by plain recursion over the first segment."""
    medoids = [reader.poses[a:b] for a, b in zip(reader.bounds[:-1], reader.bounds[1:])]

    def distance(segment: FloatArray, medoid: FloatArray) -> float:
        long, short = (segment, medoid) if len(segment) >= len(medoid) else (medoid, segment)
        matched = [short[m * len(short) // len(long)] for m in range(len(long))]
        return float(np.linalg.norm(long - np.array(matched), axis=1).mean())

    @lru_cache
    def cost(start: int) -> float:
        if start == len(values):
            return 0.0
        actual = [
            length * distance(values[start : start + length], medoid)
            + reader.price
            + cost(start + length)
            for k, medoid in enumerate(medoids)
            for length in range(reader.shortest[k], reader.longest[k] + 1)
            if start + length <= len(values)
        ]
        return min(actual, default=np.inf)

    return cost(0)


@pytest.mark.parametrize("price", [0.0, 0.4])
def test_a_reading_is_the_cheapest_of_all(price: float) -> None:
    rng = np.random.default_rng(1)
    poses = rng.normal(size=(7, 3))
    reader = labelling.Reader(
        ("a", "b"), poses, np.array([0, 3, 7]), np.array([2, 3]), np.array([4, 5]), price
    )
    values = rng.normal(size=(23, 3))
    table = labelling._table(reader, values)
    starts, ends, _, distances = labelling._read(reader, table, price)
    assert starts[0] == 0
    assert ends[-1] == 23
    assert starts[1:].tolist() == ends[:-1].tolist()
    cost = float(((ends - starts) * distances + price).sum())
    assert cost == pytest.approx(best_cost(reader, values))


@pytest.fixture(scope="module")
def dance() -> tuple[Motion, labelling.Reader]:
    motion, terminals = true_terminals("ana/long_dance_2")
    return motion, labelling.make_reader(terminals, {0: motion})


def labels_per_frame(names: tuple[str, ...], starts, ends, labels) -> list[str]:
    return [names[k] for a, b, k in zip(starts, ends, labels) for _ in range(a, b)]


def test_the_take_that_was_learned_from_reads_as_it_was(
    dance: tuple[Motion, labelling.Reader],
) -> None:
    motion, reader = dance
    _, truth = true_terminals("ana/long_dance_2")
    transcription = labelling.read_string(reader, motion)
    assert len(transcription.starts) == len(truth.starts)
    labels = labels_per_frame(
        reader.names, transcription.starts, transcription.ends, transcription.labels
    )
    true = labels_per_frame(truth.names, truth.starts, truth.ends, truth.labels)
    assert np.mean([a == b for a, b in zip(labels, true)]) > 0.95


def test_another_performers_dance_reads_as_its_truth(
    dance: tuple[Motion, labelling.Reader],
) -> None:
    _, reader = dance
    motion, truth = true_terminals("dora/long_dance_1")
    transcription = labelling.read_string(reader, motion)
    labels = labels_per_frame(
        reader.names, transcription.starts, transcription.ends, transcription.labels
    )
    true = labels_per_frame(truth.names, truth.starts, truth.ends, truth.labels)
    known = [(a, b) for a, b in zip(labels, true) if b in reader.names]
    assert np.mean([a == b for a, b in known]) > 0.85
    assert transcription.ends[-1] == motion.n_frames
    assert (transcription.distances > 0).all()


def test_terminals_without_their_medoid_are_read_by_another_segment() -> None:
    motion, terminals = true_terminals("ana/long_dance_2")
    moved = type(terminals)(
        terminals.names, np.where(terminals.starts < 400, 0, 1),
        terminals.starts, terminals.ends, terminals.labels, terminals.medoids, 1.0,
    )  # fmt: skip
    reader = labelling.make_reader(moved, {1: motion})
    assert "dance_left" in reader.names
    assert len(reader.bounds) == len(reader.names) + 1
    with pytest.raises(QueryError, match="expected captures of the grammar, found none left"):
        labelling.make_reader(terminals, {})


def test_a_motion_too_short_for_any_terminal_is_told(
    dance: tuple[Motion, labelling.Reader],
) -> None:
    motion, reader = dance
    short = part(motion, 0, int(reader.shortest.min()) - 1)
    with pytest.raises(QueryError, match=r"expected frames that segments tile, each of at least"):
        labelling.read_string(reader, short)


def test_the_reach_is_the_lesser_of_two_bounds() -> None:
    # log D: middle log 0.2, deviations 0 or log 2, their middle log 2: 2.5 * 1.4826 log 2 above
    spread = np.array([0.1, 0.1, 0.2, 0.2, 0.4, 0.4, 0.4])
    assert labelling.find_reach(spread) == pytest.approx(0.4)  # the quantile
    one_far = np.array([0.1, 0.1, 0.2, 0.2, 0.2, 0.4, 50.0])
    bound = 0.2 * 2 ** (2.5 * 1.4826)
    assert np.quantile(one_far, 0.95) > 10 * bound
    assert labelling.find_reach(one_far) == pytest.approx(bound)
    assert np.isnan(labelling.find_reach(np.array([0.1, 0.2, 0.3, 0.4])))  # too few
    assert labelling.find_reach(np.zeros(9)) == 0.0
