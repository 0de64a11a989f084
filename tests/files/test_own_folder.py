"""Folders of motiondb's own files: nothing is reached through what stands in their place."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from motiondb.files import own_folder
from motiondb.files.safe_files import HeldFile

VICTIM = b"bytes of a person"


def _link(place: Path, victim: Path) -> None:
    place.symlink_to(victim)


def _dangling(place: Path, victim: Path) -> None:
    place.symlink_to(victim.with_name("not yet"))


def _link_to_device(place: Path, _victim: Path) -> None:
    place.symlink_to(os.devnull)


def _pipe(place: Path, _victim: Path) -> None:
    os.mkfifo(place)


def _socket(place: Path, _victim: Path) -> None:
    with socket.socket(socket.AF_UNIX) as bound:
        here = Path.cwd()
        os.chdir(place.parent)  # the whole path may be too long
        bound.bind(place.name)
        os.chdir(here)


def _folder(place: Path, _victim: Path) -> None:
    place.mkdir()


ODD = {
    "a link": _link,
    "a link to nothing": _dangling,
    "a link to a device": _link_to_device,
    "a pipe": _pipe,
    "a socket": _socket,
    "a folder": _folder,
}


@pytest.fixture(params=["below an open folder", "by whole names"])
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    if request.param == "by whole names":  # as on Windows
        monkeypatch.setattr(own_folder, "_IS_RELATIVE", False)
    return tmp_path / "own"


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    path = tmp_path / "victim"
    path.write_bytes(VICTIM)
    return path


@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize("is_read", [True, False])
def test_what_is_no_file_is_removed_and_told(
    folder: Path, victim: Path, kind: str, is_read: bool
) -> None:
    told = list[str]()
    put: Callable[[Path, Path], None] = ODD[kind]
    with own_folder.own_folder(folder, told.append, make=True) as own:
        put(folder / "a.npy", victim)
        if is_read:
            with pytest.raises(FileNotFoundError):
                own.open("a.npy")
        else:
            with own.draft("a.npy") as file:
                file.write(b"new")
            assert (folder / "a.npy").read_bytes() == b"new"
        assert own.names() == ([] if is_read else ["a.npy"])
    found = "a link" if "link" in kind else kind
    assert told == [
        f"{folder / 'a.npy'}: expected a file that motiondb made, found {found}. It was removed; "
        "what it stood for was not touched."
    ]
    assert victim.read_bytes() == VICTIM
    assert sorted(path.name for path in victim.parent.iterdir()) == ["own", "victim"]


@pytest.mark.parametrize("kind", ODD)
def test_where_nobody_is_told_nothing_is_removed(folder: Path, victim: Path, kind: str) -> None:
    with own_folder.own_folder(folder, make=True) as own:
        ODD[kind](folder / "a.npy", victim)
        with pytest.raises(OSError, match="in the place of a file that motiondb made"):
            own.open("a.npy")
        with pytest.raises(OSError, match="in the place of a file"), own.draft("a.npy") as file:
            file.write(b"new")
        assert own.names() == ["a.npy"]  # and no draft
    assert victim.read_bytes() == VICTIM


def test_a_folder_that_holds_something_stays(folder: Path) -> None:
    told = list[str]()
    with own_folder.own_folder(folder, told.append, make=True) as own:
        (folder / "a.npy").mkdir()
        (folder / "a.npy" / "kept").touch()
        with pytest.raises(OSError), own.draft("a.npy"):  # noqa: PT011  the system's own
            pass
        assert own.names() == ["a.npy"]
    assert (folder / "a.npy" / "kept").exists()
    assert "found a folder, which could not be removed" in told[0]


def test_a_folder_that_is_a_link_is_not_followed_unless_a_user_named_it(
    folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "elsewhere").mkdir()
    folder.symlink_to(tmp_path / "elsewhere")
    told = list[str]()
    with pytest.raises(OSError), own_folder.own_folder(folder, told.append, make=True):  # noqa: PT011
        pass
    assert "expected a folder that motiondb made, found a link, which is not followed" in told[0]
    with own_folder.own_folder(folder, is_users=True) as own, own.draft("a") as file:
        file.write(b"new")
    assert (tmp_path / "elsewhere" / "a").read_bytes() == b"new"


@pytest.mark.parametrize("name", ["../victim", "..", ".", "a/b", "a\0"])
def test_a_name_leads_nowhere_else(folder: Path, victim: Path, name: str) -> None:
    with own_folder.own_folder(folder, make=True) as own:
        with pytest.raises(ValueError, match="no name of a file"):
            own.open(name)
        own.remove("victim")
    assert victim.read_bytes() == VICTIM


def test_a_second_name_of_a_file_keeps_its_bytes(folder: Path, victim: Path) -> None:
    with own_folder.own_folder(folder, make=True) as own:
        os.link(victim, folder / "a.npy")
        with own.draft("a.npy") as file:
            file.write(b"new")
        held = HeldFile.hold(victim)
        os.link(victim, folder / "b.npy")
        with pytest.raises(OSError, match="the database that this program has open"):
            own.open("b.npy")
        held.let_go()
    assert victim.read_bytes() == VICTIM


def test_after_an_error_the_former_file_and_no_draft_stay(folder: Path) -> None:
    with own_folder.own_folder(folder, make=True) as own:
        with own.draft("a") as file:
            file.write(b"old")
        with pytest.raises(TypeError), own.draft("a") as file:
            file.write("half")  # type: ignore[arg-type]
        assert (folder / "a").read_bytes() == b"old"
        assert own.names() == ["a"]
