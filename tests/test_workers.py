"""Threads that compute pieces of work."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from motiondb import workers


def slowly(piece: int, unit: float) -> int:
    """A piece, the later the sooner."""
    time.sleep(unit * (20 - piece))
    return piece


def test_few_pieces_are_taken_ahead_and_results_come_in_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(workers, "N_THREADS", 3)
    taken = list[int]()

    def pieces() -> Iterator[int]:
        for piece in range(20):
            taken.append(piece)
            yield piece

    results = workers.HERE.map(slowly, pieces(), 1e-4)
    assert next(results) == 0
    assert len(taken) == workers.PIECES_EACH * 3
    assert list(results) == list(range(1, 20))


def test_no_pieces_have_no_results() -> None:
    assert list(workers.HERE.map(slowly, [], 0.0)) == []


def test_pieces_that_nobody_wants_are_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that two threads have begun are finished; of the others, none is."""
    monkeypatch.setattr(workers, "N_THREADS", 2)
    ended, computed = Event(), list[int]()

    class Pool(ThreadPoolExecutor):
        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=False, cancel_futures=cancel_futures)
            ended.set()
            super().shutdown(wait=wait)

    def work(piece: int) -> int:
        if piece:
            ended.wait()
        computed.append(piece)
        return piece

    monkeypatch.setattr("concurrent.futures.ThreadPoolExecutor", Pool)
    for wanted in workers.HERE.map(work, range(100)):
        assert wanted == 0
        break
    assert len(computed) <= 3
