"""Places of the actions of captions: what is listed, what labels give, what is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_takes import fit_places, map_places, weights_of

from motiondb.meaning.place_fitting import (
    Written,
    complete_labels,
    find_places,
    fit_arrays,
    label_intervals,
    listed_takes,
    place_evidence,
    window_vectors,
)
from motiondb.records import Caption, FloatArray, SegmentTable

NUMBERS = {"walk": 0, "sit": 1, "jump": 2}
N_COLUMNS = 6


def made_table(lengths: list[int], seed: int = 0) -> tuple[SegmentTable, FloatArray]:
    """Captures 1, 2 ... of segments of 60 frames, and standardised vectors that say anything."""
    n = sum(lengths)
    starts = np.concatenate([60 * np.arange(k) for k in lengths])
    table = SegmentTable(
        np.repeat(np.arange(1, len(lengths) + 1), lengths), starts, starts + 60,
        np.zeros(n, dtype=np.int64), np.zeros(n), np.zeros(n), np.zeros((n, 1), dtype=np.float32),
        np.zeros((n, 1), dtype=np.float32),
    )  # fmt: skip
    return table, np.random.default_rng(seed).normal(size=(n, N_COLUMNS))


def written(**captions: list[Caption]) -> Written:
    """Captions by the number of their capture: c1=[...]."""
    return Written({int(k[1:]): tuple(v) for k, v in captions.items()}, {}, {}, NUMBERS)


def test_the_caption_of_most_actions_gives_the_order() -> None:
    table, rows = made_table([4, 3])
    said = written(c1=[Caption("jump"), Caption("walk, sit"), Caption("cook")], c2=[Caption("sit")])
    listed = listed_takes(table, rows, said)
    assert listed is not None
    captures, takes = listed
    assert captures == [1, 2]
    assert takes.actions == [[[0], [1]], [[1]]]
    assert list(takes.further) == [[2], []]
    assert takes.labelled is None


def test_captures_without_known_words_take_no_part() -> None:
    table, rows = made_table([4, 3])
    assert listed_takes(table, rows, written(c1=[Caption("cook")])) is None
    assert find_places(table, rows, written()) is None


def test_an_interval_labels_the_segments_that_it_covers_by_half() -> None:
    table, _ = made_table([4])
    said = written(c1=[Caption("sit", 1.5, 5.0)])  # frames 45-150 of segments of 60
    labelled = label_intervals(table, slice(0, 4), said.of_intervals(1), True, 3)
    assert labelled is not None
    assert labelled[:, 1].tolist() == [0.0, 1.0, 1.0, 0.0]
    assert np.isnan(labelled[:, [0, 2]]).all()
    free = label_intervals(table, slice(0, 4), said.of_intervals(1), False, 3)
    assert free is not None
    assert free[1:3, 1].tolist() == [1.0, 1.0]
    assert np.isnan(free[[0, 3], 1]).all()


def test_a_short_interval_labels_the_segment_that_it_meets_most() -> None:
    table, _ = made_table([3])
    said = written(c1=[Caption("sit", 2.1, 2.5)])
    labelled = label_intervals(table, slice(0, 3), said.of_intervals(1), True, 3)
    assert labelled is not None
    assert labelled[:, 1].tolist() == [0.0, 1.0, 0.0]


def test_labels_are_kept_as_people_said_them() -> None:
    table, rows = made_table([5, 4, 4])
    said = written(
        c1=[Caption("sit", 2.0, 4.0)], c2=[Caption("walk, sit"), Caption("jump", 0.0, 2.0)],
        c3=[Caption("walk")],
    )  # fmt: skip
    places = find_places(table, rows, said)
    assert places is not None
    assert places.words == {1: (1,), 2: (0, 1, 2), 3: (0,)}
    assert places.shown[1][:, 0].tolist() == [0.0, 1.0, 0.0, 0.0, 0.0]
    assert places.shown[2][0, 2] == 1.0
    assert places.shown[3] == pytest.approx(1.0)


def test_a_label_says_what_is_not_shown_in_and_beside_it() -> None:
    nan = np.nan
    labelled = np.full((5, 4), nan)
    labelled[2, [0]] = 1.0
    complete_labels(labelled, [{1}, {2, 3}])
    assert np.array_equal(labelled[2], [1.0, 0.0, 0.0, 0.0])
    assert np.array_equal(labelled[:, 0], [nan, 0.0, 1.0, 0.0, nan], equal_nan=True)
    assert np.isnan(labelled[[0, 1, 3, 4], 1:]).all()


def test_a_listed_action_with_more_words_may_be_what_the_label_says() -> None:
    labelled = np.full((3, 4), np.nan)
    labelled[1, 0] = 1.0  # "twist", and listed are "side twist" and "jog"
    complete_labels(labelled, [{0, 1}, {2}])
    assert np.isnan(labelled[1, 1])
    assert labelled[1, 2] == 0.0


def test_the_segments_beside_a_label_may_show_another_action_with_its_words() -> None:
    labelled = np.full((3, 4), np.nan)
    labelled[1, [0, 1]] = 1.0  # "raise left", and listed is "raise right"
    complete_labels(labelled, [{0, 2}])
    assert np.isnan(labelled[[0, 2], 0]).all()
    assert labelled[[0, 2], 1].tolist() == [0.0, 0.0]
    assert labelled[1, 2] == 0.0


def test_words_of_labels_in_other_takes_are_inferred_and_not_listed() -> None:
    table, _ = made_table([4, 4, 4])
    moves = np.eye(N_COLUMNS)[[0, 1, 2, 3, 0, 4, 1, 5, 3, 5, 4, 2]] + 1e-3
    said = written(
        c1=[Caption("walk, sit"), Caption("jump", 2.0, 4.0)], c2=[Caption("walk, sit")],
        c3=[Caption("sit")],
    )  # fmt: skip
    places = find_places(table, moves, said)
    assert places is not None
    assert places.words == {1: (0, 1, 2), 2: (0, 1), 3: (1,)}
    assert places.inferred == {2: (2,)}
    assert places.inferred_shown[2].shape == (4, 1)
    assert places.inferred_shown[2][:, 0].argmax() == 2
    assert places.only({3}).inferred == {}
    assert [words for words, _ in places.of(1)] == [[0, 1, 2]]
    assert [words for words, _ in places.of(2)] == [[0, 1], [2]]
    assert places.listed_by({1: "a", 2: "b", 3: "c"})["b"] == {0, 1}


def test_evidence_of_a_later_capture_is_of_the_map_of_all() -> None:
    table, rows = made_table([5, 4, 4])
    said = written(c1=[Caption("walk, sit")], c2=[Caption("sit, jump")])
    places = find_places(table, rows, said)
    listed = listed_takes(table, rows, said)
    assert places is not None
    assert listed is not None
    takes = listed[1]
    arrays = fit_arrays(places, table, rows, 3, {})
    evidence = place_evidence(places, table, rows, 3, {1: "a", 2: "b", 3: "a"}, arrays)
    shown = np.zeros((9, 3))
    shown[:5, list(places.words[1])] = places.shown[1]
    shown[5:, list(places.words[2])] = places.shown[2]
    fit = map_places(takes.vectors, shown, weights_of(takes))
    later = window_vectors(table, rows, [slice(9, 13)])
    of_later, of_first = evidence.take(3), evidence.take(1)
    assert of_later is not None
    assert of_first is not None
    assert of_later.windows == pytest.approx(fit.evidence(later), abs=2e-6)  # single precision
    first = window_vectors(table, rows, [slice(0, 5)])
    assert np.abs(of_first.windows - fit.evidence(first)).max() > 1e-3  # this one is left out
    without = evidence.without(frozenset("a"))
    assert evidence.by_others(3) == pytest.approx(without.evidence(later))
    assert evidence.by_others(1) == pytest.approx(without.evidence(first), abs=1e-8)


def test_evidence_without_places_is_of_the_map_of_the_other_takes() -> None:
    table, rows = made_table([5, 4, 4])
    said = written(c1=[Caption("walk, sit")], c2=[Caption("sit, jump")], c3=[Caption("walk")])
    places = find_places(table, rows, said)
    listed = listed_takes(table, rows, said)
    assert listed is not None
    takes = listed[1]
    numbers = {1: (frozenset({0, 1}), 2), 2: (frozenset({1, 2}), 2), 3: (frozenset({0}), 1)}
    assert places is not None
    arrays = fit_arrays(places, table, rows, 3, numbers)
    evidence = place_evidence(places, table, rows, 3, {}, arrays).unplaced(numbers, arrays)
    assert evidence is not None
    shares = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [1.0, 0.0, 0.0]]) ** 0.5
    even = np.repeat(shares, [5, 4, 4], axis=0)
    inside = slice(0, 5)
    fit = map_places(takes.vectors, even, weights_of(takes))
    assert evidence[1].shape == (5, 3)
    assert np.abs(evidence[1] - fit.evidence(takes.vectors[inside])).max() > 1e-3
    assert evidence[1] == pytest.approx(
        fit_places(takes, even).left_out(takes.rows())[inside], abs=2e-6
    )


def test_only_keeps_the_captures_named() -> None:
    table, rows = made_table([3, 3])
    places = find_places(table, rows, written(c1=[Caption("walk")], c2=[Caption("sit")]))
    assert places is not None
    assert list(places.only({2}).words) == [2]
    assert list(replace(places).only(()).shown) == []
