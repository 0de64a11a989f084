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


def _speeds(*steps: tuple[float, int]) -> np.ndarray:
    path = np.zeros((sum(n for _, n in steps), 4))
    path[:, 2] = np.concatenate([np.full(n, speed) for speed, n in steps])
    return path


def test_a_stop_ends_at_rest() -> None:
    assert direction.gone(_speeds((1.2, 60), (0.0, 30)), "stop") == pytest.approx(1.2)
    assert direction.gone(_speeds((0.0, 30), (1.2, 60), (0.0, 30)), "stop") == pytest.approx(1.2)
    assert direction.gone(_speeds((1.2, 60), (0.0, 30), (1.2, 60)), "stop") == pytest.approx(0.0)


def test_running_slower_is_no_stop() -> None:
    assert direction.gone(_speeds((3.5, 60), (1.5, 60)), "stop") == 0.0


def test_a_start_begins_at_rest() -> None:
    assert direction.gone(_speeds((0.0, 30), (1.2, 60)), "start") == pytest.approx(1.2)
    assert direction.gone(_speeds((1.2, 60), (0.0, 30)), "start") == pytest.approx(0.0)


def test_the_part_that_stops_is_cut_where_the_speed_falls() -> None:
    path = _speeds((1.2, 60), (0.0, 30), (1.2, 60))
    first, behind = direction.furthest_part(path, "stop", 90)
    assert 55 <= first <= 60 < behind <= 70


def test_a_turn_is_measured_to_either_side() -> None:
    path = np.zeros((61, 4))
    for yaw in (1.4, -1.4):
        path[:30, 3] = yaw
        assert direction.gone(path, "turn") == pytest.approx(2.0)
        assert direction.gone(path, "around") == pytest.approx(1.4 / 2.5)


def test_a_jump_leaves_the_usual_height_and_a_run_does_not() -> None:
    height = np.full((90, 1), 0.9)
    jump, run = np.zeros((90, 4)), np.zeros((90, 4))
    jump[:, :1] = run[:, :1] = height
    jump[40:49, 0] += 0.3
    run[:, 0] += 0.04 * np.sin(2 * np.pi * np.arange(90) / 10)
    assert direction.gone(jump, "jump") == pytest.approx(9 / 30 / 0.2)
    assert direction.gone(run, "hop") < 0.5
    assert direction.gone(np.full((90, 4), 0.9), "hop") == 0.0
