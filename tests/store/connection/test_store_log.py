"""Links, forks and logs: one log by whatever name, one process, and a missing log is told."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import ModuleType

import pytest
from rights import as_others

from motiondb import store
from motiondb.errors import StoreError
from motiondb.files.safe_files import MARKING, beside, log_of
from motiondb.store.connection import handle, opening

_KILLED = """
import os, signal, sys
from motiondb import store
database = store.open_store(sys.argv[1])
store.save_synonyms(database, {"jog": "run"})
os.kill(os.getpid(), signal.SIGKILL)
"""


def kill_after_a_change(path: Path) -> None:
    """Another process acknowledges a change and is killed: the change is in the log alone."""
    ended = subprocess.run([sys.executable, "-c", _KILLED, str(path)], check=False)
    assert ended.returncode == -signal.SIGKILL


def test_a_change_by_the_name_of_a_link_is_seen_by_the_other_after_a_kill(tmp_path: Path) -> None:
    path, link = tmp_path / "m.duckdb", tmp_path / "there" / "link.duckdb"
    link.parent.mkdir()
    store.open_store(path).close()
    link.symlink_to(path)
    kill_after_a_change(link)
    with store.open_store(path, read_only=True) as database:
        assert store.load_synonyms(database) == {"jog": "run"}


def test_compacting_by_a_link_replaces_the_file_that_it_stands_for(
    database: store.Store, samples: ModuleType
) -> None:
    samples.add(database, "a")
    database.close()
    link, second = database.path.with_name("link"), database.path.with_name("second")
    link.symlink_to(database.path)
    store.compact(link)
    assert link.is_symlink()
    with store.open_store(link) as opened:
        store.save_synonyms(opened, {"jog": "run"})
    with store.open_store(database.path) as opened:
        assert store.load_synonyms(opened) == {"jog": "run"}
    second.hardlink_to(database.path)
    with pytest.raises(StoreError, match=r"found a file with 2 names \(hard links\)"):
        store.compact(second)
    assert second.samefile(database.path)


def test_a_log_that_is_a_link_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    (tmp_path / "m.duckdb.wal").symlink_to("elsewhere.wal")
    with pytest.raises(StoreError, match=r"expected its log m.duckdb.wal as a file, found a link"):
        store.open_store(path)


def test_a_database_that_came_without_its_log_says_so(tmp_path: Path) -> None:
    path, moved = tmp_path / "m.duckdb", tmp_path / "moved.duckdb"
    store.open_store(path).close()
    kill_after_a_change(path)
    shutil.copy(path, moved)
    with store.open_store(path, read_only=True) as whole:
        assert store.check_store(whole) == []
    assert whole.log_note == (
        f"{path}.wal: holds the latest changes, which are not in m.duckdb yet. Keep the two files "
        "together; the next command that writes brings them in."
    )
    with store.open_store(moved, read_only=True) as lacking:
        assert store.check_store(lacking) == [lacking.log_note]
        assert lacking.log_note == (
            f"{moved}: expected its log moved.duckdb.wal beside it, found none: a program was "
            "ended by force, and the file moved or copied without the log, which holds the latest "
            "changes. Put the log beside the file; if it is gone, so are these changes."
        )
    store.open_store(moved).close()  # changes nothing, so that the log still fits
    with pytest.raises(StoreError, match=r"expected its log moved\.duckdb\.wal"):
        store.compact(moved)
    shutil.copy(log_of(path), log_of(moved))
    for file in (path, moved):
        store.open_store(file).close()  # brings the log in
        with store.open_store(file, read_only=True) as opened:
            assert store.check_store(opened) == []
            assert store.load_synonyms(opened) == {"jog": "run"}
        assert opened.log_note == ""


def test_a_change_of_a_file_without_its_log_is_told_until_it_is_compacted(tmp_path: Path) -> None:
    path, moved = tmp_path / "m.duckdb", tmp_path / "moved.duckdb"
    kill_after_a_change(path)
    shutil.copy(path, moved)
    with store.open_store(moved) as database:
        assert "expected its log" in database.log_note
        store.save_synonyms(database, {"dash": "run"})
    with store.open_store(moved, read_only=True) as opened:
        (fault,) = store.check_store(opened)
        assert "found that the log with the latest ones was missing when the file was" in fault
        assert store.check_quickly(opened) == [fault]
        assert opened.log_note == ""
        assert store.load_synonyms(opened) == {"dash": "run"}
        store.backup(opened, tmp_path / "copy.duckdb", _faults)
    assert _faults(tmp_path / "copy.duckdb") == [fault.replace("moved.duckdb", "copy.duckdb")]
    store.compact(moved)
    assert _faults(moved) == []


def test_a_change_that_fails_gives_up_the_missing_log_too(tmp_path: Path) -> None:
    path, moved = tmp_path / "m.duckdb", tmp_path / "moved.duckdb"
    kill_after_a_change(path)
    shutil.copy(path, moved)
    with store.open_store(moved) as database, pytest.raises(KeyError), store.transaction(database):
        raise KeyError
    assert "was missing when the file was changed" in _faults(moved)[0]


def _faults(path: Path) -> list[str]:
    with store.open_store(path, read_only=True) as opened:
        return store.check_store(opened)


def test_a_file_with_several_names_is_not_opened_for_writing(tmp_path: Path) -> None:
    path, other = tmp_path / "m.duckdb", tmp_path / "other.duckdb"
    store.open_store(path).close()
    other.hardlink_to(path)
    with pytest.raises(StoreError, match=r"found a file with 2 \(hard links\)"):
        store.open_store(other)
    store.open_store(other, read_only=True).close()


def test_there_is_a_log_from_the_first_change_on(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        store.save_synonyms(database, {"jog": "run"})
        database._open_root().execute("CHECKPOINT")  # as DuckDB does after much data
        store.save_synonyms(database, {"dash": "run"})
        shutil.copy(path, tmp_path / "copy.duckdb")
        assert log_of(path).exists()
    with store.open_store(tmp_path / "copy.duckdb", read_only=True) as lacking:
        assert "expected its log copy.duckdb.wal beside it" in lacking.log_note


_REFUSED = """
import os, signal, sys
from motiondb import store
database = store.open_store(sys.argv[1])
try:
    with store.transaction(database):
        raise ValueError
except ValueError:
    os.kill(os.getpid(), signal.SIGKILL)
"""
_IN_BETWEEN = f"""
import os, signal
from motiondb.store.connection import log_mark
log_mark.keep_log = lambda *_of: os.kill(os.getpid(), signal.SIGKILL)
{_KILLED}
"""


def test_the_note_of_a_process_that_was_killed_while_it_waited_goes(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    (tmp_path / ".m.duckdb.waits").touch()
    store.open_store(path).close()
    assert [file.name for file in tmp_path.iterdir()] == ["m.duckdb"]


_OWN_CHECKPOINT = """
import os, signal, sys
from motiondb import store
database = store.open_store(sys.argv[1])
store.save_synonyms(database, {"jog": "run"})
database.connection.execute("SET wal_autocheckpoint = '1KB'")
database.keep_log = lambda: os.kill(os.getpid(), signal.SIGKILL)
store.save_synonyms(database, {"jog": "run", "dash": "run"})
"""
_KILLS = {"refused": _REFUSED, "in between": _IN_BETWEEN, "own checkpoint": _OWN_CHECKPOINT}


@pytest.mark.parametrize("program", _KILLS.values(), ids=_KILLS)
def test_a_kill_that_lost_nothing_is_not_told(tmp_path: Path, program: str) -> None:
    path = tmp_path / "m.duckdb"
    subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    with store.open_store(path, read_only=True) as database:
        assert store.check_store(database) == []
    with store.open_store(path) as database:
        store.save_synonyms(database, {"jog": "run"})
    assert [file.name for file in tmp_path.iterdir()] == ["m.duckdb"]


@pytest.mark.parametrize("ending", ["", "\ndel database"])
def test_a_program_that_does_not_close_the_file_leaves_no_mark(tmp_path: Path, ending: str) -> None:
    program = _KILLED.replace("os.kill(os.getpid(), signal.SIGKILL)", ending)
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "m.duckdb")], check=True)
    with store.open_store(tmp_path / "m.duckdb", read_only=True) as opened:
        assert store.load_synonyms(opened) == {"jog": "run"}
        assert opened.log_note == ""
    assert opened.log_note == ""


_FORKED = """
import os, sys
from motiondb import store
from motiondb.errors import StoreError
path = sys.argv[1]
database = store.open_store(path)
store.save_synonyms(database, {"jog": "run"})
child = os.fork()
if not child:
    folder, name = os.path.split(path)
    spelled = os.path.join(folder, "..", os.path.basename(folder), name)
    uses = [lambda: store.save_synonyms(database, {}), lambda: store.open_store(path)]
    for use in [*uses, lambda: store.open_store(spelled)]:
        try:
            use()
        except StoreError as error:
            said = str(error).replace(spelled, path).replace(str(os.getpid()), "CHILD")
            print(said.replace(str(os.getppid()), "PARENT"))
    database.close()
    sys.exit(7)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
store.save_synonyms(database, {**store.load_synonyms(database), "dash": "run"})
database.close()
child = os.fork()  # the file is closed: the child may open it
if not child:
    with store.open_store(path) as opened:
        print(sorted(store.load_synonyms(opened)))
    sys.exit(7)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
def test_a_forked_process_is_refused_and_leaves_the_file_alone(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    ended = subprocess.run(
        [sys.executable, "-u", "-c", _FORKED, str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    said = (
        f"{path}: expected to be used in the process that opened it (PARENT), found it in another "
        "(CHILD) that was forked from it. Close the database before the fork and open it again in "
        "each process, or start processes by the method 'spawn'."
    )
    assert ended.stdout.splitlines() == [said] * 3 + ["['dash', 'jog']"], ended.stderr


def test_a_file_that_may_not_be_read_is_not_called_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()

    def refuse(*_: object, **__: object) -> None:
        raise opening.duckdb.IOException(f'IO Error: Cannot open file "{path}": Permission denied')

    monkeypatch.setattr(opening.duckdb, "connect", refuse)
    with pytest.raises(StoreError) as error:
        store.open_store(path, read_only=True)
    assert str(error.value) == (
        f"{path}: expected a database that this user may open, found: permission denied. Get the "
        "right to read it, and to write it and its folder for commands that change it."
    )


def test_a_folder_that_is_closed_to_an_open_database_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    database = store.open_store(folder / "m.duckdb")
    database.lend()
    folder.chmod(0o000)
    with as_others() as can:
        if not can:
            pytest.skip("this user may read everything")
        with pytest.raises(StoreError, match="a folder that this user may read, found: permission"):
            store.load_synonyms(database)
    folder.chmod(0o700)
    assert store.load_synonyms(database) == {}
    database.close()


def test_a_change_is_saved_though_the_folder_was_closed_meanwhile(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    database = store.open_store(folder / "m.duckdb")
    store.save_synonyms(database, {"jog": "run"})
    folder.chmod(0o000)
    with as_others() as can:
        if not can:
            pytest.skip("this user may read everything")
        store.save_synonyms(database, {"dash": "run"})
        assert store.load_synonyms(database) == {"dash": "run"}
    folder.chmod(0o700)
    database.close()
    with store.open_store(folder / "m.duckdb") as again:
        assert store.load_synonyms(again) == {"dash": "run"}
        assert store.check_store(again, sources=True) == []


def test_a_change_after_an_open_question_and_beside_a_reader_is_marked(
    database: store.Store, tmp_path: Path
) -> None:
    assert not store.is_learned(database)  # an answer that was not fetched to its end
    begun, ended = threading.Event(), threading.Event()

    def read() -> None:
        with store.reading(database):
            store.load_synonyms(database)
            begun.set()
            ended.wait(0.2)

    reader = threading.Thread(target=read)
    reader.start()
    begun.wait()
    store.save_synonyms(database, {"jog": "run"})
    ended.set()
    reader.join()
    assert not beside(database.path, MARKING).exists()
    moved = shutil.copy(database.path, tmp_path / "moved.duckdb")
    with store.open_store(moved, read_only=True) as lacking:
        assert "expected its log" in lacking.log_note


def test_a_reader_that_waits_for_the_change_is_not_waited_for_without_end(
    database: store.Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handle, "_READERS", 0.1)
    with store.reading(database):
        store.load_synonyms(database)
        writer = threading.Thread(target=store.save_synonyms, args=(database, {"jog": "run"}))
        writer.start()
        writer.join()
    assert not beside(database.path, MARKING).exists()
    assert store.load_synonyms(database) == {"jog": "run"}


@pytest.mark.parametrize("is_former", [True, False])
def test_a_log_that_does_not_fit_is_told_so(tmp_path: Path, is_former: bool) -> None:
    path, other = tmp_path / "m.duckdb", tmp_path / "other.duckdb"
    for file in (path, other):
        kill_after_a_change(file)
    log = log_of(path if is_former else other).read_bytes()
    store.open_store(path).close()  # brings the log in
    log_of(path).write_bytes(log)
    for read_only in (True, False):
        with pytest.raises(StoreError) as error:
            store.open_store(path, read_only=read_only)
        assert str(error.value) == (
            f"{path}: expected its log m.duckdb.wal to fit it, found one of another database or of "
            "a former state of this one. Move the log to another folder, where its own database "
            "can find it, and open the file again."
        )
