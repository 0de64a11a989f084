"""Values of semantic rules: numbers worked by hand, and slow obvious twins."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from motiondb.scene.language import semantic_rules

angles = st.floats(-20.0, 20.0)
lengths = st.floats(-10.0, 10.0)


def test_a_place_is_as_wrong_as_it_is_far() -> None:
    assert semantic_rules.position_error(np.array([1.0, 2.0]), np.array([4.0, 6.0])) == 5.0


@pytest.mark.parametrize(
    ("heading", "wanted", "error"),
    [(0, 90, 90), (10, 350, 20), (180, -180, 0), (270, 0, 90), (720, 181, 179)],
)
def test_directions_differ_by_the_smaller_turn(heading: float, wanted: float, error: float) -> None:
    errors = semantic_rules.direction_error(np.radians(heading), np.radians(wanted))
    assert np.degrees(errors) == pytest.approx(error, abs=1e-9)


@given(angles, angles)
def test_a_turn_is_what_the_arrows_enclose(one: float, other: float) -> None:
    arrows = [np.array([math.sin(a), math.cos(a)]) for a in (one, other)]
    enclosed = math.acos(np.clip(arrows[0] @ arrows[1], -1.0, 1.0))
    assert float(semantic_rules.direction_error(one, other)) == pytest.approx(enclosed, abs=1e-6)


def test_bearings_go_from_z_towards_x() -> None:
    targets = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]])
    actual = np.degrees(semantic_rules.bearing(np.zeros(2), targets))
    assert np.abs(actual).tolist() == pytest.approx([0.0, 90.0, 180.0, 90.0])
    assert actual[3] == pytest.approx(-90.0)


def test_synchronisation_compares_the_gap_with_the_lag() -> None:
    # the pass leaves at 2.0 s, is caught at 2.7 s, and should fly 0.5 s
    assert semantic_rules.synchronisation_error(2.0, 2.7, 0.5) == pytest.approx(0.2)
    assert semantic_rules.synchronisation_error(2.7, 2.0, 0.5) == pytest.approx(1.2)
    assert semantic_rules.flight_time(np.array([0.0, 0.0]), np.array([3.0, 4.0])) == pytest.approx(
        0.625
    )


def test_distances_include_their_bounds() -> None:
    places = np.array([[0.0, 0.499], [0.0, 0.5], [0.0, 2.0], [0.0, 2.001]])
    errors = semantic_rules.distance_error(places, np.zeros(2), 0.5, 2.0)
    assert errors.tolist() == [1.0, 0.0, 0.0, 1.0]


def test_behind_the_ends_a_line_is_as_far_as_its_end() -> None:
    opponent, rim = np.array([0.0, 4.0]), np.array([0.0, 0.0])
    places = np.array([[0.5, 2.0], [0.0, 7.0], [3.0, -4.0]])
    assert semantic_rules.line_error(places, opponent, rim).tolist() == [0.5, 3.0, 5.0]


@example([0.0, 0.0, 0.0, 1e-7, 0.0, 0.0])  # a line of a tenth of a micrometre
@example([1.0, 1.0, 2.0, 2.0, 2.0, 2.0])
@given(st.lists(lengths, min_size=6, max_size=6))
def test_a_line_is_as_far_as_its_nearest_point(values: list[float]) -> None:
    place, first, second = np.array(values).reshape(3, 2)
    share = np.linspace(0.0, 1.0, 4001)[:, None]
    nearest = np.linalg.norm(first + share * (second - first) - place, axis=1).min()
    actual = float(semantic_rules.line_error(place, first, second))
    assert actual == pytest.approx(nearest, abs=0.01)
    assert actual <= nearest + 1e-9
