"""A file that one thread has let go of, as `learn` does: other threads ask and write meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import duckdb
import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.store.connection.faults import OtherModeError
from motiondb.store.connection.transactions import revision

THREADS, TURNS = 6, 8


def test_a_lent_store_is_written_and_lent_again(database: store.Store) -> None:
    database.lend()
    try:
        assert store.load_captures(database) == []  # opens it for reading
        store.save_synonyms(database, {"stroll": "walk"})
        with store.open_store(database.path, read_only=True) as other:
            assert store.load_synonyms(other) == {"stroll": "walk"}
    finally:
        database.take_back()
    store.save_synonyms(database, {"stroll": "run"})
    assert store.load_synonyms(database) == {"stroll": "run"}
    assert Path(database.path).is_file()


def test_an_answer_is_fetched_after_the_file_was_let_go(database: store.Store) -> None:
    answer = database.connection.execute("SELECT value FROM meta WHERE key = ?", ["revision"])
    beside(database.lend)
    first = answer.fetchone()
    beside(database.take_back)
    assert first == answer.execute("SELECT value FROM meta WHERE key = 'revision'").fetchone()
    assert first is not None


def test_an_answer_of_a_block_is_not_asked_again(database: store.Store) -> None:
    with store.reading(database):
        answer = database.connection.execute("SELECT 1")
        assert answer.fetchall() == [(1,)]
    beside(database.lend)
    with pytest.raises(StoreError):
        answer.fetchall()
    database.take_back()


def test_a_lender_waits_for_blocks_and_not_for_answers(database: store.Store) -> None:
    lent = threading.Event()
    with store.reading(database):
        lender = threading.Thread(target=lambda: (database.lend(), lent.set()))
        lender.start()
        assert not lent.wait(0.2)
        assert store.load_synonyms(database) == {}
    assert lent.wait(60.0)
    lender.join()
    database.take_back()


def test_threads_that_ask_outside_any_block_never_meet_a_closed_file(
    database: store.Store,
) -> None:
    """Without the rules of `statements`, some thousand reads beside a lender meet a closed one."""
    store.save_synonyms(database, {"stroll": "walk"})
    done, faults = threading.Event(), []

    def guarded(work: Callable[[], None]) -> Callable[[], None]:
        def run() -> None:
            try:
                work()
            except BaseException as error:
                faults.append(repr(error))

        return run

    def ask() -> None:
        while not done.is_set():
            connection = database.connection
            answer = connection.execute("SELECT canonical FROM synonym")
            assert answer.fetchall() == [("walk",)]
            assert revision(database) > 0

    def begin_and_end() -> None:
        while not done.is_set():  # a thread that ends holds its connection a little longer
            thread = threading.Thread(target=guarded(lambda: revision(database)))
            thread.start()
            thread.join()

    def write() -> None:
        for turn in range(TURNS // 4):
            store.save_synonyms(database, {f"word{turn}": "walk"})
            store.save_synonyms(database, {"stroll": "walk"})

    def lend() -> None:
        for _ in range(TURNS):
            with store.released(database) as let_go:
                assert len(store.load_synonyms(database)) == 1
                let_go()

    asks = [ask] * (THREADS - 2) + [begin_and_end] * 2
    asking = [threading.Thread(target=guarded(work)) for work in asks]
    working = [threading.Thread(target=guarded(work)) for work in (lend, write)]
    for thread in [*asking, *working]:
        thread.start()
    for thread in working:
        thread.join(300.0)
    done.set()
    for thread in asking:
        thread.join(300.0)
    assert faults == []
    assert not any(thread.is_alive() for thread in [*asking, *working])
    assert store.load_synonyms(database) == {"stroll": "walk"}


def test_a_change_inside_reading_is_refused_while_another_thread_changes(
    database: store.Store,
) -> None:
    inside, leave = threading.Event(), threading.Event()

    def change() -> None:
        with store.transaction(database):
            inside.set()
            leave.wait(60.0)

    thread = threading.Thread(target=change)
    thread.start()
    assert inside.wait(60.0)
    try:
        with (
            store.reading(database),
            pytest.raises(StoreError, match="expected to change the database outside `reading`"),
        ):
            store.save_synonyms(database, {})
    finally:
        leave.set()
        thread.join()


def test_a_file_that_duckdb_still_holds_in_the_other_mode_is_waited_for(
    database: store.Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    connect, refused = database._connect, []

    def slow(read_only: bool, wait: float | None) -> duckdb.DuckDBPyConnection:
        if len(refused) < 3:
            refused.append(read_only)
            raise OtherModeError("held by this process in another mode")
        return connect(read_only, wait)

    monkeypatch.setattr(database, "_connect", slow)
    database.lend()
    database.take_back()
    assert refused == [False] * 3
    assert store.load_synonyms(database) == {}


def beside(work: Callable[[], None]) -> None:
    """Run ``work`` in another thread, to its end."""
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_memory_is_bounded_while_many_captures_are_saved_and_no_longer(
    database: store.Store,
) -> None:
    def limit() -> str:
        row = database.connection.execute("SELECT current_setting('memory_limit')").fetchone()
        return str(row[0]) if row else ""

    usual = limit()
    for n_bytes, bound in ((0, usual), (2**29, "2.0 GiB"), (2**30, "4.0 GiB")):
        with store.bounded_memory(database, n_bytes):
            store.save_synonyms(database, {"stroll": f"walk{n_bytes}"})
            assert limit() == bound
        assert limit() == usual
    assert store.load_synonyms(database) == {"stroll": f"walk{2**30}"}
