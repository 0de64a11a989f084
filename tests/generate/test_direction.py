"""Words of direction, measured in the motion."""

import numpy as np
import pytest

from motiondb.generate import direction


def _heights(*steps: tuple[float, int]) -> np.ndarray:
    path = np.zeros((sum(n for _, n in steps), 4))
    path[:, 0] = np.concatenate([np.full(n, height) for height, n in steps])
    return path


def test_standing_up_goes_up_and_sitting_down_goes_down() -> None:
    up = _heights((0.5, 60), (0.8, 60))
    assert direction.gone(up, "up") == pytest.approx(2.0)
    assert direction.gone(up, "down") == pytest.approx(-2.0)


def test_a_jump_is_no_way_up() -> None:
    assert direction.gone(_heights((0.9, 60), (1.3, 12), (0.9, 60)), "up") == 0.0
    first, behind = direction.furthest_part(_heights((0.9, 60), (1.3, 12), (0.9, 60)), "up", 132)
    assert behind - first == 1


def test_turning_left_is_positive_yaw() -> None:
    path = np.zeros((31, 4))
    path[:, 3] = 0.7
    assert direction.gone(path, "left") == pytest.approx(1.0)
    assert direction.gone(path, "right") == pytest.approx(-1.0)


def test_a_step_to_either_side_is_sideways() -> None:
    path = np.zeros((31, 4))
    for speed in (0.4, -0.4):
        path[:, 1] = speed
        assert direction.gone(path, "sideways") == pytest.approx(1.0)


def test_the_furthest_part_is_the_shortest_that_goes_nearly_as_far() -> None:
    path = _heights((0.5, 50), (0.9, 80))
    assert direction.furthest_part(path, "up", 130) == (49, 51)


def test_a_side_of_a_limb_is_no_direction() -> None:
    assert direction.directions_of(("kick", "left", "leg")) == ()
    assert direction.directions_of(("turn", "left")) == ("left",)
