"""Names of databases that lead to a pipe, to another program's file, or to nothing any more."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from motiondb import store
from motiondb.database.catalogue.rescuing import rescue
from motiondb.errors import StoreError


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
