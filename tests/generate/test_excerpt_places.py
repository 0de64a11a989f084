"""Places that show an action about as clearly as the best one."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motiondb.generate.excerpt_places import CLEAR, COMPARABLE, number_places
from motiondb.generate.excerpts import Excerpt


def _number(
    spans: list[tuple[int, int, int]], values: list[float], does: list[bool] | None = None
) -> list[int]:
    excerpts = [Excerpt(c, a, b, 0.0, (a, b)) for c, a, b in spans]
    does = [True] * len(spans) if does is None else does
    numbers = number_places(excerpts, np.array(values), np.array(does, dtype=bool))
    return [int(number) for number in numbers]


def test_what_shares_more_than_half_is_one_place() -> None:
    assert _number([(1, 0, 90), (1, 44, 134), (1, 45, 135)], [1.0, 0.9, 0.8]) == [0, 0, 1]
    assert _number([(1, 0, 90), (1, 45, 135)], [1.0, 0.9]) == [0, 1]
    assert _number([(1, 0, 90), (2, 0, 90)], [1.0, 0.9]) == [0, 1]


def test_captures_take_turns() -> None:
    spans = [(1, 0, 90), (1, 100, 190), (1, 200, 290), (2, 0, 90)]
    assert _number(spans, [2.0, 1.9, 1.8, 1.0]) == [0, 2, 3, 1]


def test_what_is_much_worse_is_no_place_unless_it_is_clear() -> None:
    spans = [(1, 0, 90), (2, 0, 90), (3, 0, 90)]
    assert _number(spans, [0.0, -COMPARABLE, -COMPARABLE - 0.1]) == [0, 1, -1]
    best = CLEAR + COMPARABLE + 3.0
    assert _number(spans, [best, CLEAR, CLEAR - 0.1]) == [0, 1, -1]


def test_what_does_not_do_what_is_measured_is_no_place_if_the_best_does() -> None:
    spans = [(1, 0, 90), (2, 0, 90)]
    assert _number(spans, [1.0, 0.9], [True, False]) == [0, -1]
    assert _number(spans, [1.0, 0.9], [False, False]) == [0, 1]


SPANS = st.tuples(st.integers(0, 3), st.integers(0, 200), st.integers(10, 90))


@given(st.lists(st.tuples(SPANS, st.floats(-4.0, 4.0)), min_size=1, max_size=20))
def test_numbers_run_from_the_best_on_without_gaps(drawn: list) -> None:
    spans = [(c, a, a + n) for (c, a, n), _ in drawn]
    values = [value for _, value in drawn]
    numbers = _number(spans, values)
    assert numbers[int(np.argmax(values))] == 0
    assert set(numbers) - {-1} == set(range(max(numbers) + 1))
    for number in set(numbers) - {-1}:
        assert len({spans[n][0] for n in range(len(spans)) if numbers[n] == number}) == 1
