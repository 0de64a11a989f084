"""A file is checked in another process, and parses give back the strings of their grammar."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import store_samples

import motiondb
from motiondb import store
from motiondb.database.checking import check
from motiondb.errors import StoreError


@pytest.fixture
def filled(tmp_path: Path) -> store.Store:
    """Two captures, a grammar of them, and a capture that it generated."""
    opened = store.open_store(tmp_path / "motions.duckdb")
    infos = [store_samples.add(opened, name) for name in ("a", "bb")]
    store_samples.add(opened, "dddd", n_frames=5, kind="generated")
    run_id = store.start_run(opened, "grammar")
    store.save_grammar(opened, store_samples.grammar("dance", infos), run_id)
    store.save_derivation(opened, 3, 1, store.Derivation("dance", (0, 1), (3, 1, 2)), run_id)
    store.finish_run(opened, run_id)
    return opened


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (
            "UPDATE sentence SET rules = [0, 2] WHERE ordinal = 0",
            "grammar dance: expected sentence 0 to be derived by its rules within one take, "
            "found otherwise.",
        ),
        (
            "UPDATE derivation SET clips = [1, 3, 77]",
            "dddd: expected clips of the terminals that grammar dance derived, found others.",
        ),
    ],
)
def test_a_wrong_parse_is_told(filled: store.Store, damage: str, sentence: str) -> None:
    assert check(filled) == []
    filled.connection.execute(damage)
    assert check(filled) == [sentence]
    filled.close()
    assert motiondb.check_file(filled.path) == [sentence]


def test_a_cut_file_is_told(filled: store.Store) -> None:
    filled.close()
    content = filled.path.read_bytes()
    filled.path.write_bytes(content[: -len(content) // 3])
    short, columns = motiondb.check_file(filled.path)
    assert (
        f"expected tables that can be read, found: {filled.path.stat().st_size} bytes of" in short
    )
    assert "expected tables that can be read, found: damaged columns: " in columns


def let_reader_end(by: str, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Let the process that reads the file do nothing but a command of a shell."""
    reader = folder / "python"
    reader.write_text(f"#!/bin/sh\n{by}\n")
    reader.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(reader))


def test_a_reader_that_dies_is_a_fault(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    let_reader_end("kill -SEGV $$", monkeypatch, tmp_path)
    (fault,) = motiondb.check_file(filled.path)
    assert "found: that reading it ends the program (SIGSEGV). The file is damaged" in fault


def test_a_file_is_not_called_damaged_where_memory_ran_out(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    let_reader_end("echo MemoryError >&2", monkeypatch, tmp_path)
    with pytest.raises(StoreError, match="expected enough memory to check it, found that it ran"):
        motiondb.check_file(filled.path)
    let_reader_end("kill -SEGV $$", monkeypatch, tmp_path)
    monkeypatch.setattr("resource.getrlimit", lambda _: (2_000_000_000, -1))
    (fault,) = motiondb.check_file(filled.path)
    assert "(SIGSEGV). Either memory ran out (allow more" in fault
    assert "or: The file is damaged: restore a copy" in fault


def test_duckdb_without_memory_is_no_error_of_the_store(filled: store.Store) -> None:
    """So that nothing that judges by a StoreError takes it for damage."""
    with pytest.raises(MemoryError, match="expected enough memory, found that it ran out"):
        filled.connection.execute("SET memory_limit = '1kB'")


def test_modules_of_the_working_folder_are_not_imported(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    filled.close()
    (tmp_path / "json.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    assert motiondb.check_file(filled.path) == []


def test_an_error_that_is_no_text_is_a_fault(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    failing = tmp_path / "python"
    failing.write_text("#!/bin/sh\nprintf 'bad \\377' >&2\n")
    failing.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(failing))
    (fault,) = motiondb.check_file(filled.path)
    assert "found: that reading it fails (bad \ufffd)" in fault


def test_what_keeps_the_check_from_looking_is_an_error(filled: store.Store, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="found it held by process"):
        motiondb.check_file(filled.path)
    other = tmp_path / "walk.bvh"
    other.write_text("HIERARCHY")
    with pytest.raises(StoreError, match="found another kind of file"):
        motiondb.check_file(other)
    with pytest.raises(StoreError, match="found no such file"):
        motiondb.check_file(tmp_path / "none.duckdb")
