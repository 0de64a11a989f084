"""Files are written whole or not at all; what a killed process left is removed by the next one."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture
from motiondb.files.safe_files import (
    is_running,
    open_file,
    read_bounded,
    read_bounded_text,
    whole_file,
)

_KILLED = """
import os, signal, sys
from pathlib import Path
from motiondb.files.safe_files import whole_file
with whole_file(Path(sys.argv[1])) as draft:
    draft.write_bytes(b"half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["out.png", "n" * 250, "é" * 120, "[a]*.bvh"])
def test_a_file_appears_whole(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with whole_file(path) as draft:
        draft.write_bytes(b"whole")
        assert not path.exists()
        assert names(tmp_path) == {draft.name}
    assert names(tmp_path) == {name}
    assert path.read_bytes() == b"whole"


def test_an_error_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "out.png"
    path.write_bytes(b"before")

    def stop_halfway() -> None:
        with whole_file(path) as draft:
            draft.write_bytes(b"half")
            raise KeyError

    with pytest.raises(KeyError):
        stop_halfway()
    assert names(tmp_path) == {"out.png"}
    assert path.read_bytes() == b"before"


def test_a_folder_that_is_missing_is_an_error_of_the_system(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), whole_file(tmp_path / "none" / "out.png") as draft:
        draft.write_bytes(b"half")


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_what_a_kill_left_is_removed_by_the_next_writer(tmp_path: Path) -> None:
    path = tmp_path / "out.png"
    ended = subprocess.run([sys.executable, "-c", _KILLED, str(path)], check=False)
    assert ended.returncode == -signal.SIGKILL
    (left,) = names(tmp_path)
    assert left.startswith(".out.png.")
    others = {
        f".out.png.{os.getppid()}.1.part",  # its process is at work
        f".out.png.{os.getpid()}.1.part",  # another thread of this one
        f".other.png.{left.split('.')[3]}.1.part",  # of another file
        ".out.png.notes.part",
    }
    for name in others:
        (tmp_path / name).write_bytes(b"")
    with whole_file(path) as draft:
        draft.write_bytes(b"whole")
    assert names(tmp_path) == {"out.png", *others}


def test_processes_that_run_and_that_have_ended() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        ended.wait()
    assert not is_running(ended.pid)
    assert is_running(os.getppid())
    assert is_running(os.getpid())
    assert not is_running(10**12)


def test_a_database_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "motions.bvh"
    path.write_bytes(b"checksumDUCK and more")
    with pytest.raises(FileExistsError, match="never overwritten"), whole_file(path) as draft:
        draft.write_bytes(b"other")
    assert path.read_bytes() == b"checksumDUCK and more"
    assert names(tmp_path) == {"motions.bvh"}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("m.duckdb.wal", "the name of a database's log"),
        ("other.wal.checkpoint", "the name of a database's log"),
        ("m.duckdb.cache", "the cache of the database m.duckdb"),
        (".m.duckdb.marking", "a file of the database .*m.duckdb"),
        ("m.duckdb.cache/walk.bvh", "the cache of the database m.duckdb"),
    ],
)
def test_what_belongs_to_a_database_is_never_written(tmp_path: Path, name: str, said: str) -> None:
    (tmp_path / "m.duckdb").write_bytes(b"checksumDUCK and more")
    with pytest.raises(FileExistsError, match=said), whole_file(tmp_path / name) as draft:
        draft.write_bytes(b"other")
    assert names(tmp_path) == {"m.duckdb"}


def test_the_file_that_a_link_stands_for_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for target in ("there/out.bvh", "there/new.bvh"):
        link = tmp_path / Path(target).name
        link.symlink_to(target)
        (tmp_path / "there/out.bvh").write_bytes(b"before")
        with whole_file(link) as draft:
            draft.write_bytes(b"after")
        assert link.is_symlink()
        assert (tmp_path / target).read_bytes() == b"after"
    assert names(tmp_path / "there") == {"out.bvh", "new.bvh"}


def test_a_file_with_two_names_is_not_replaced_under_one(tmp_path: Path) -> None:
    path = tmp_path / "out.bvh"
    path.write_bytes(b"before")
    (tmp_path / "second").hardlink_to(path)
    with pytest.raises(OSError, match=r"2 names \(hard links\)"), whole_file(path) as draft:
        draft.write_bytes(b"after")
    assert path.read_bytes() == (tmp_path / "second").read_bytes() == b"before"


@pytest.mark.skipif(os.name != "posix", reason="pipes and sockets with names")
def test_only_files_are_opened_and_none_is_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.bvh")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(os.path.relpath(tmp_path / "socket"))
        with pytest.raises(OSError, match="a socket"):
            open_file(tmp_path / "socket")
    for name, said in (("pipe.bvh", "a pipe"), ("", "directory"), ("a\0", "no system accepts")):
        with pytest.raises(OSError, match=said):
            open_file(f"{tmp_path}/{name}")
    with pytest.raises(OSError, match="a pipe"), whole_file(tmp_path / "pipe.bvh"):
        pass
    with pytest.raises(CaptureError) as error:
        read_capture(tmp_path / "pipe.bvh")
    assert str(error.value) == (
        f"{tmp_path}/pipe.bvh: expected a readable file, found: a pipe; save what it gives in a "
        "file, and name that file."
    )


def test_a_file_is_read_up_to_the_bound(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bounded(path, 5) == b"12345"
    with pytest.raises(OSError, match="more than 4e-06 MB"):
        read_bounded(path, 4)


def test_every_end_of_line_becomes_one(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_bounded_text(path) == "a\nb\nc\n"
    path.write_bytes(b"\xff")
    with pytest.raises(UnicodeDecodeError):
        read_bounded_text(path)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="a file without an end")
def test_a_file_without_an_end_is_refused() -> None:
    with pytest.raises(OSError, match="a device; name a file"):
        read_bounded(Path("/dev/zero"), 1_000_000)
