"""The number of terminals: which are tried, how much is chance, which is chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.selection import terminal_number
from motiondb.grammar.selection.ledger import Ledger
from motiondb.grammar.selection.terminal_number import (
    CANDIDATES,
    Choice,
    choose_number,
    choose_terminals,
    search_noise,
)

NUMBERS = (4, 6, 8, 10, 12, 24)


def curve(number: int) -> float:
    """900 - 200 log K + 25 K: least at 8."""
    return float(900.0 - 200.0 * np.log(number) + 25.0 * number)


@pytest.mark.parametrize("least", [4, 7, 12, 24, 60])
def test_numbers_are_tried_from_coarse_to_fine_and_the_least_is_found(least: int) -> None:
    bits: dict[int, float] = {}
    tried: set[int] = set()
    while waiting := terminal_number._next_numbers(CANDIDATES, tried, bits, True):
        for number in waiting:
            tried.add(number)
            bits[number] = abs(np.log(number / least))
    assert min(bits, key=lambda number: bits[number]) == least
    assert len(tried) <= 11
    assert set(terminal_number._next_numbers([5, 9, 30], {9}, {}, False)) == {5, 30}


def test_takes_too_short_for_many_terminals_are_tried_with_fewer() -> None:
    tried = {7, 16, 36}
    assert terminal_number._next_numbers(CANDIDATES, tried, {}, True) == [6]
    assert terminal_number._next_numbers(CANDIDATES, tried | {4, 5, 6}, {}, True) == []


def test_noise_is_what_the_curve_leaves() -> None:
    rng = np.random.default_rng(0)
    bits = {k: curve(k) + rng.normal(scale=30.0) for k in NUMBERS}
    # by projection onto what is orthogonal to the curve's three terms
    basis = np.array([[1.0, np.log(k), k] for k in NUMBERS])
    rest = np.linalg.qr(basis, mode="complete")[0][:, 3:]
    left = rest.T @ np.array(list(bits.values()))
    assert search_noise(bits) == pytest.approx(np.sqrt((left**2).sum() / 3))
    assert search_noise({k: curve(k) for k in NUMBERS}) == pytest.approx(0.0, abs=1e-9)
    assert search_noise({4: 100.0, 6: 50.0, 8: 70.0, 10: 90.0}) == 0.0  # too few to tell


def test_the_fewest_terminals_within_a_standard_error_are_chosen() -> None:
    bits = {6: 514.2, 8: 507.0, 12: 500.0}
    assert choose_number(bits, 20.0) == 8  # 20 / sqrt 2 = 14.14
    assert choose_number(bits, 20.1) == 6
    assert choose_number(bits, 0.0) == 12


class FakeTakes:
    """Stands for poses: only the search is tried here."""

    values = bounds = None


Try = Callable[..., Choice]


@pytest.fixture
def try_numbers(monkeypatch: pytest.MonkeyPatch) -> Try:
    """Chooses among numbers whose bits are given, one value for each try; K terminals are ``K``."""
    asked: list[int] = []

    def run(sums: dict[int, list[float]], **how: object) -> Choice:
        left: dict[int, Iterator[float]] = {k: iter(values) for k, values in sums.items()}

        def find(_takes: object, number: int, _rng: object, settings: object) -> int:
            asked.append(number)
            if number not in sums:
                raise GrammarError(f"too short for {number}")
            return number

        def count(_poses: object, number: int, _sentences: object, _precision: object) -> Ledger:
            return Ledger(next(left[number]), 0.0, 0.0)

        monkeypatch.setattr(terminal_number, "make_poses", lambda takes: FakeTakes)
        monkeypatch.setattr(terminal_number, "performance_noise", lambda values, bounds: 0.5)
        monkeypatch.setattr(terminal_number, "find_terminals", find)
        monkeypatch.setattr(terminal_number, "ledger_of", count)
        choice = choose_terminals([], np.random.default_rng(0), learn=lambda k, rng: -k, **how)
        run.asked = asked
        return choice

    return run


def test_the_best_and_the_next_smaller_are_tried_again_and_the_better_try_counts(
    try_numbers: Try,
) -> None:
    sums = {k: [curve(k)] for k in NUMBERS} | {8: [685.0, 680.0], 6: [691.0, 700.0]}
    choice = try_numbers(sums, candidates=NUMBERS)
    assert try_numbers.asked == [*NUMBERS, 6, 8]
    bits = {k: trial.ledger.total for k, trial in choice.trials.items()}
    assert (bits[6], bits[8]) == (691.0, 680.0)
    assert choice.noise == pytest.approx(search_noise(bits))
    assert choice.number == 8
    assert (choice.terminals, choice.sentences) == (8, -8)
    assert list(choice.ledgers) == sorted(NUMBERS)


def test_a_lucky_try_does_not_ask_for_more_terminals(try_numbers: Try) -> None:
    chance = {4: 15.0, 6: -20.0, 8: 12.0, 10: -22.0, 12: 20.0, 24: -4.0}
    sums = {k: [curve(k) + chance[k]] * 2 for k in NUMBERS}
    assert min(sums, key=lambda k: sums[k][0]) == 10
    assert try_numbers(sums, candidates=NUMBERS).number == 6
    worth = sums | {10: [400.0] * 2}
    assert try_numbers(worth, candidates=NUMBERS).number == 10


def test_few_numbers_are_tried_once_and_the_fewest_bits_win(try_numbers: Try) -> None:
    choice = try_numbers({4: [60.0], 5: [50.0]})  # the takes are too short for more
    asked = try_numbers.asked
    assert asked[:5] == [6, 12, 24, 52, 5]
    assert len(asked) == len(set(asked))
    assert (choice.number, choice.noise) == (5, 0.0)


def test_no_number_to_choose_from_is_told(try_numbers: Try) -> None:
    with pytest.raises(GrammarError, match=r"found none\. Give some, such as 12 20 40"):
        try_numbers({}, candidates=[])
    with pytest.raises(GrammarError, match="too short for 6"):
        try_numbers({})
