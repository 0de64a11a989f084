"""The revision rises with every committed change; snapshots, threads and letting go of the file."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from motiondb import store
from motiondb.errors import StoreError

_SAVE = """
import sys
from motiondb import store
with store.open_store(sys.argv[1]) as database:
    store.save_synonyms(database, {"stroll": "walk"})
    print(store.revision(database))
"""


def _in_another_process(path: Path, program: str = _SAVE) -> str:
    return subprocess.run(
        [sys.executable, "-c", program, str(path)], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_every_committed_change_raises_it_by_one(
    database: store.Store, samples: ModuleType
) -> None:
    assert store.revision(database) == 0
    samples.add(database, "a")  # a run, then the capture with all that belongs to it
    assert store.revision(database) == 2
    with store.transaction(database):
        samples.add(database, "bb")
        store.save_synonyms(database, {"stroll": "walk"})
    assert store.revision(database) == 3


def test_it_is_the_same_for_every_opening_and_process(database: store.Store) -> None:
    with store.open_store(database.path) as other:
        store.save_synonyms(other, {})
        assert store.revision(database) == store.revision(other) == 1
    database.close()
    assert _in_another_process(database.path) == "2"
    with store.open_store(database.path, read_only=True) as reader:
        assert store.revision(reader) == 2


def test_a_block_of_reading_sees_one_state(database: store.Store) -> None:
    with store.open_store(database.path) as other, store.reading(database) as revision:
        store.save_synonyms(other, {"dash": "run"})
        with store.reading(database) as inner:
            assert (revision, inner, store.revision(database)) == (0, 0, 0)
        assert store.load_synonyms(database) == {}
        assert store.load_synonyms(other) == {"dash": "run"}
    assert store.load_synonyms(database) == {"dash": "run"}
    with store.transaction(database):
        store.save_synonyms(database, {})
        with store.reading(database) as revision:
            assert (revision, store.load_synonyms(database)) == (2, {})


def test_a_change_within_reading_is_refused(database: store.Store) -> None:
    with (
        store.reading(database),
        pytest.raises(StoreError, match="outside `reading`, found it inside"),
    ):
        store.save_synonyms(database, {})
    store.save_synonyms(database, {"dash": "run"})


def _together(works: list[Callable[[], None]]) -> list[BaseException]:
    """Run each in a thread, all at once; gives what they raised."""
    raised: list[BaseException] = []
    barrier = threading.Barrier(len(works))

    def run(work: Callable[[], None]) -> None:
        try:
            barrier.wait()
            work()
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=run, args=(work,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return raised


def test_threads_and_stores_of_one_process_write_in_turn(database: store.Store) -> None:
    with store.open_store(database.path) as other:

        def writer(opened: store.Store) -> Callable[[], None]:
            def write() -> None:
                for turn in range(5):
                    store.save_synonyms(opened, {"turn": str(turn)})

            return write

        assert _together([writer(s) for s in (database, other) for _ in range(4)]) == []
    assert store.revision(database) == 40


def test_a_transaction_is_hidden_from_other_threads_until_it_commits(
    database: store.Store, samples: ModuleType
) -> None:
    names = [f"{number}/take" for number in range(4)]
    seen: list[int] = []
    done = threading.Event()

    def write() -> None:
        for name in names:
            with store.transaction(database):
                samples.add(database, name)
                samples.add(database, f"{name} again")
        done.set()

    def read() -> None:
        while not done.is_set():
            with store.reading(database):
                infos = store.load_captures(database)
                seen.append(len(infos))
                for info in infos:
                    assert store.load_motion(database, info.capture_id).n_frames

    assert _together([write, *[read] * 7]) == []
    assert {count % 2 for count in seen} == {0}
    assert len(store.load_captures(database)) == 8


def test_a_released_file_can_be_changed_by_another_process(database: store.Store) -> None:
    with store.released(database):
        assert _in_another_process(database.path) == "1"
    assert store.revision(database) == 1
    store.save_synonyms(database, {})
    assert store.revision(database) == 2


def test_threads_ask_while_the_file_is_released(database: store.Store) -> None:
    store.save_synonyms(database, {"dash": "run"})
    actual: list[dict[str, str]] = []
    with store.released(database):
        assert _together([lambda: actual.append(store.load_synonyms(database))] * 4) == []
        read = _SAVE.replace("sys.argv[1])", "sys.argv[1], read_only=True)").replace(
            'store.save_synonyms(database, {"stroll": "walk"})', ""
        )
        assert _in_another_process(database.path, read) == "1"
    assert actual == [{"dash": "run"}] * 4
    store.save_synonyms(database, {})


def test_the_first_cause_of_an_aborted_transaction_is_told(database: store.Store) -> None:
    def insert_and_go_on() -> None:
        with store.transaction(database) as connection:
            try:
                connection.execute("INSERT INTO capture_tag VALUES (1, 'a', NULL)")
            except StoreError:
                connection.execute("SELECT 1")  # as one does who has not noticed

    with pytest.raises(StoreError) as error:
        insert_and_go_on()
    assert 'NOT NULL constraint failed: capture_tag."value". Nothing' in str(error.value)
    assert "aborted" not in str(error.value)


def test_a_released_file_that_another_store_holds_can_still_be_read(
    database: store.Store,
) -> None:
    with store.open_store(database.path) as other, store.released(database):
        store.save_synonyms(other, {"dash": "run"})
        assert store.load_synonyms(database) == {"dash": "run"}
    store.save_synonyms(database, {})
