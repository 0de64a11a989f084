from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import duckdb
import pytest
from holding import holding

from motiondb import store
from motiondb.database.catalogue.rescuing import rescue
from motiondb.database.catalogue.sheets import import_events
from motiondb.database.checking import check_file
from motiondb.errors import HeldError, MotionDBError, StoreError
from motiondb.files.safe_files import check_output
from motiondb.store.connection import handle, opening


def test_a_second_process_is_told_who_holds_the_file(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    with holding(path, "write") as pid:
        for read_only in (False, True):
            with pytest.raises(StoreError) as error:
                store.open_store(path, read_only=read_only)
            message = str(error.value)
            assert message.startswith(
                f"{path}: expected a free database, found it held by process {pid} (python"
            )
            assert f"), command `{sys.executable} -c" in message
            assert f", on {socket.gethostname()} since {time.strftime('%Y-%m-%d')}" in message
            assert message.endswith(
                ". Wait until it has ended, or wait longer with --wait SECONDS."
            )
    store.open_store(path).close()


@pytest.mark.parametrize("sentence", ["The process cannot access the file.", "进程无法访问。"])
def test_a_file_held_on_windows_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sentence: str
) -> None:
    """DuckDB says it in other words there, and partly in the language of the system."""
    path, connect, left = tmp_path / "m.duckdb", duckdb.connect, [3]
    store.open_store(path).close()
    said = (
        f'IO Error: Cannot open file "{path}": {sentence}\n\nFile is already open in \n'
        r"C:\Program Files\Python\python.exe (PID 999999999)"
    )

    def held(*given: Any, **settings: Any) -> duckdb.DuckDBPyConnection:
        left[0] -= 1
        if left[0] < 0:
            return connect(*given, **settings)
        raise duckdb.IOException(said)

    monkeypatch.setattr(duckdb, "connect", held)
    with pytest.raises(HeldError, match=r"found it held by process 999999999 \(python.exe\)\. "):
        store.open_store(path)
    store.open_store(path, wait=30.0).close()
    assert left[0] == -1


def test_naming_the_open_file_as_input_or_output_keeps_other_writers_out(tmp_path: Path) -> None:
    """On POSIX, closing any descriptor of a file ends the locks of the process on it."""
    path = tmp_path / "m.duckdb"
    try_it = [sys.executable, "-c", "import sys, duckdb; duckdb.connect(sys.argv[1])", str(path)]
    with store.open_store(path) as held:
        with pytest.raises(OSError, match="a database of that name"):
            check_output(path)
        with pytest.raises(MotionDBError, match="found: the database that this program has open"):
            import_events(held, path)
        other = subprocess.run(try_it, capture_output=True, text=True, check=False)
        assert "Could not set lock" in other.stderr
    assert subprocess.run(try_it, check=False).returncode == 0


def test_readers_share_and_a_writer_waits(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    with holding(path, "read") as pid:
        with store.open_store(path, read_only=True) as database:
            assert store.load_captures(database) == []
        with pytest.raises(StoreError, match=f"held by process {pid} "):
            store.open_store(path)


def test_two_modes_in_one_process_are_refused(database: store.Store) -> None:
    with pytest.raises(StoreError, match=r"found it held by this process \(\d+\) in another mode"):
        store.open_store(database.path, read_only=True)


@pytest.mark.parametrize("read_only", [False, True])
def test_missing_file(tmp_path: Path, read_only: bool) -> None:
    path = tmp_path / "m.duckdb"
    with pytest.raises(StoreError) as error:
        store.open_store(path, read_only=read_only, create=read_only)
    assert str(error.value) == (
        f"{path}: expected a database of motiondb, found no such file. "
        f"Make one: motiondb add FOLDER --db {path}."
    )
    assert list(tmp_path.iterdir()) == []


def test_missing_folder(tmp_path: Path) -> None:
    path = tmp_path / "none" / "m.duckdb"
    with pytest.raises(StoreError) as error:
        store.open_store(path)
    assert str(error.value) == (
        f"{path}: expected the folder {tmp_path / 'none'}, found none. Make the folder first."
    )


@pytest.mark.parametrize("content", [b"x", b"HIERARCHY\n" * 2000])
def test_another_kind_of_file_is_refused_and_left_alone(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "walk.bvh"
    path.write_bytes(content)
    with pytest.raises(StoreError) as error:
        store.open_store(path)
    assert str(error.value) == (
        f"{path}: expected a database of motiondb, found another kind of file. "
        "Name another file with --db."
    )
    assert path.read_bytes() == content


def test_a_damaged_file_is_refused_with_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    content = bytearray(path.read_bytes())
    content[20] ^= 255
    path.write_bytes(content)
    with pytest.raises(StoreError) as error:
        store.open_store(path)
    assert str(error.value).startswith(f"{path}: expected a database that can be opened, found: ")
    assert str(error.value).endswith("restore a copy.")


def test_an_empty_file_becomes_a_database_and_nothing_else_is_left(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    path.touch()
    store.open_store(path).close()
    assert [item.name for item in tmp_path.iterdir()] == ["m.duckdb"]


@pytest.mark.parametrize("read_only", [False, True])
def test_the_next_command_sweeps_what_a_killed_one_left(tmp_path: Path, read_only: bool) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        ended.wait()
    drafts = [tmp_path / f".m.duckdb.{ended.pid}.1.part{end}" for end in ("", ".wal")]
    running = tmp_path / f".m.duckdb.{os.getppid()}.1.part"
    copies = [tmp_path / f".m.duckdb.compact{end}" for end in ("", ".wal")]
    for left in (*drafts, running, *copies):
        left.write_text("half a file")
    store.open_store(path, read_only=read_only).close()
    expected = {path, running, *(copies if read_only else ())}  # a reader may meet a compact
    assert set(tmp_path.iterdir()) == expected


def test_a_transaction_is_undone_as_a_whole(database: store.Store) -> None:
    def save_and_stop() -> None:
        with store.transaction(database):
            store.save_synonyms(database, {"stroll": "walk"})
            assert store.load_synonyms(database) == {"stroll": "walk"}
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save_and_stop()
    assert store.load_synonyms(database) == {}
    store.save_synonyms(database, {"dash": "run"})
    assert store.load_synonyms(database) == {"dash": "run"}


def test_a_store_opened_for_reading_is_not_changed(database: store.Store) -> None:
    database.close()
    with (
        store.open_store(database.path, read_only=True) as reading,
        pytest.raises(StoreError) as error,
    ):
        store.save_synonyms(reading, {})
    assert str(error.value) == (
        f"{database.path}: expected a database opened for writing, found one opened for reading. "
        "Open it without read_only."
    )


class _InterruptedAfter:
    """A connection whose statement ``words`` is done, and met by Ctrl-C right after."""

    def __init__(self, connection: duckdb.DuckDBPyConnection, words: str) -> None:
        self._connection, self._words = connection, words

    def execute(self, *arguments: Any) -> duckdb.DuckDBPyConnection:
        result = self._connection.execute(*arguments)
        if arguments[0] == self._words:
            raise KeyboardInterrupt
        return result


@pytest.mark.parametrize(("words", "saved"), [("COMMIT", 1), ("INSERT INTO meta VALUES (1, 2)", 0)])
def test_an_interrupt_knows_whether_the_change_was_saved(
    tmp_path: Path, words: str, saved: int
) -> None:
    with store.open_store(tmp_path / "m.duckdb") as opened:
        before, connection = store.Store.changes_saved, opened.connection
        opened.local.connection = _InterruptedAfter(connection, words)
        with pytest.raises(KeyboardInterrupt), store.transaction(opened):
            opened.connection.execute("INSERT INTO meta VALUES (1, 2)")
        opened.local.connection = connection
        assert store.Store.changes_saved - before == saved
        assert len(connection.execute("FROM meta WHERE key = '1'").fetchall()) == saved


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(StoreError) as caught:
        store.open_store(path)
    assert str(caught.value) == (
        f"{path}: expected a database of motiondb, found neither a file nor a folder. "
        "Name another file with --db."
    )


def test_a_file_that_was_removed_meanwhile_is_not_made_anew(tmp_path: Path) -> None:
    path = tmp_path / "motions.duckdb"

    def remove_meanwhile() -> None:
        with store.open_store(path) as opened, store.released(opened):
            path.unlink()

    with pytest.raises(StoreError) as caught:
        remove_meanwhile()
    assert str(caught.value).startswith(
        f"{path}: expected a database of motiondb, found no such file."
    )
    assert not path.exists()


def test_a_missing_file_cannot_be_rescued(tmp_path: Path) -> None:
    with pytest.raises(StoreError) as caught:
        rescue(tmp_path / "none", tmp_path / "new.duckdb")
    assert str(caught.value) == (
        f"{tmp_path}/none: expected a database, found no such file. Name another file."
    )
    assert list(tmp_path.iterdir()) == []


def kept(opened: store.Store) -> tuple[str, ...] | None:
    """What was kept under a key of the test's."""
    return opened.connection.execute("SELECT value FROM meta WHERE key = 'kept'").fetchone()


@pytest.mark.parametrize("name", [":memory:", "a'b\".duckdb", "[a]*?"])
def test_every_name_is_that_of_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with store.open_store(name) as opened:
        opened.connection.execute("INSERT INTO meta VALUES ('kept', 'yes')")
    assert [path.name for path in tmp_path.iterdir()] == [name]
    with store.open_store(name, read_only=True) as opened:
        assert kept(opened) == ("yes",)
    store.compact(name)
    with store.open_store(name, read_only=True) as opened:
        assert kept(opened) == ("yes",)


def test_a_name_that_is_no_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError) as caught:
        store.open_store(tmp_path / os.fsdecode(b"caf\xe9.duckdb"))
    assert str(caught.value) == (
        f"{tmp_path}/caf\\xe9.duckdb: expected a file name in UTF-8, found other bytes. "
        "Give another name."
    )


@pytest.mark.parametrize("use", [store.open_store, store.compact, check_file])
def test_a_name_that_no_system_accepts_is_refused(use: Callable[[str], object]) -> None:
    with pytest.raises(StoreError) as caught:
        use("a\0b.duckdb")
    assert str(caught.value) == (
        r"'a\x00b.duckdb': expected the name of a file, found: a name that no system accepts. "
        "Give another name."
    )


def test_no_progress_bar_is_printed_into_answers(tmp_path: Path) -> None:
    with store.open_store(tmp_path / "m.duckdb") as opened:
        setting = "SELECT current_setting('enable_progress_bar')"
        assert opened.connection.value(setting) is False


@pytest.mark.parametrize("n_bytes", [0, 2**30])
def test_row_groups_of_a_large_file_are_joined_seldom(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch, n_bytes: int
) -> None:
    monkeypatch.setattr(opening, "LARGE", 1)
    monkeypatch.setattr(handle, "LARGE", 1)
    monkeypatch.setattr(opening, "MOST_GROUPS", 3)
    database.close()
    groups = []
    for name in "abcdefg":
        with store.open_store(database.path) as opened, store.bounded_memory(opened, n_bytes):
            samples.add(opened, name)
        with duckdb.connect(str(database.path), read_only=True) as raw:
            query = "SELECT count(DISTINCT row_group_id) FROM pragma_storage_info('motion')"
            groups += raw.execute(query).fetchone() or ()
    assert groups[:3] == [1, 2, 3]
    assert 1 in groups[3:]
    with store.open_store(database.path, read_only=True) as opened:
        assert [info.name for info in store.load_captures(opened)] == list("abcdefg")


def test_a_file_that_becomes_large_is_not_written_anew(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handle, "LARGE", 2**28)
    for name in "abc":
        with store.bounded_memory(database, 2**28):
            samples.add(database, name)
        database.close()
        database = store.open_store(database.path)
    groups = "SELECT count(DISTINCT row_group_id) FROM pragma_storage_info('motion')"
    assert database.connection.value(groups) == 3
    database.close()


@pytest.mark.parametrize(
    ("made", "told"),
    [
        ("ALTER TABLE caption RENAME TO c2; CREATE VIEW caption AS FROM c2", "view 'caption'"),
        ("CREATE SCHEMA trash; CREATE VIEW trash.capture AS FROM capture", "view 'capture'"),
        ("CREATE MACRO count(x) AS (SELECT content FROM read_text('secret'))", "macro 'count'"),
        ("CREATE MACRO rows() AS TABLE FROM capture", "macro 'rows'"),
        (
            "CREATE TRIGGER t AFTER INSERT ON synonym REFERENCING NEW TABLE AS n "
            "FOR EACH STATEMENT INSERT INTO meta SELECT word, canonical FROM n",
            "trigger 't'",
        ),
    ],
)
def test_a_file_with_more_than_tables_is_refused(tmp_path: Path, made: str, told: str) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    with duckdb.connect(str(path)) as connection:
        connection.execute(made)

    def opened(**how: bool) -> None:
        store.open_store(path, **how)

    def salvaged() -> None:
        with store.opened_damaged(path):
            pass

    for use in (opened, partial(opened, read_only=True), salvaged, partial(store.compact, path)):
        with pytest.raises(StoreError, match=f"expected tables alone, found the {told}, which"):
            use()


def test_one_who_reads_reaches_no_other_file(database: store.Store, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("secret")
    query = f"SELECT content FROM read_text('{tmp_path}/secret')"
    assert database.connection.value(query) == "secret"
    database.lend()
    with pytest.raises(StoreError, match="file system operations are disabled"):
        database.connection.value(query)
    store.backup(database, tmp_path / "lent.duckdb", lambda _: [])
    with store.open_store(database.path) as writing:  # two of one program share the file
        assert database.connection.value(query) == "secret"
        assert writing.connection.value(query) == "secret"
    database.close()
    with store.open_store(database.path, read_only=True) as opened:
        for _ in range(2):
            with pytest.raises(StoreError, match="file system operations are disabled"):
                opened.connection.value(query)
            copy = tmp_path / "it's a copy.duckdb"
            store.backup(opened, copy, lambda _: [])  # it may write this file alone
            copy.unlink()


def test_two_readers_in_one_program_do_not_copy(database: store.Store, tmp_path: Path) -> None:
    database.close()
    with (
        store.open_store(database.path, read_only=True) as one,
        store.open_store(database.path, read_only=True),
        pytest.raises(StoreError, match="expected no other part of this program that reads it"),
    ):
        store.backup(one, tmp_path / "copy.duckdb", lambda _: [])
    assert not (tmp_path / "copy.duckdb").exists()
