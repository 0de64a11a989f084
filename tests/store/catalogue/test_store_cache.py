from __future__ import annotations

import hashlib
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motiondb import store
from motiondb.records import Motion
from motiondb.store.catalogue.joined_rows import page_checksum


def _folder(database: store.Store) -> Path:
    return database.path.with_name("motions.duckdb.cache")


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    for number, name in enumerate(("a", "bb", "ccc")):
        samples.add(database, name, n_frames=5 + number)
    return database


def is_mapped(array: np.ndarray | None) -> bool:
    while array is not None and not isinstance(array, np.memmap):
        array = array.base
    return array is not None


def flip(file: Path, place: int, bit: int = 1) -> None:
    content = bytearray(file.read_bytes())
    content[place] ^= bit
    file.write_bytes(content)


def _rows_file(database: store.Store) -> Path:
    (file,) = _folder(database).glob("places-*.arrays")
    return file


class Maker:
    """Makes the first numbers of every frame, and notes for how many frames."""

    def __init__(self) -> None:
        self.made: list[int] = []

    def __call__(self, motions: Sequence[Motion]) -> list[tuple[np.ndarray, float]]:
        self.made += [motion.n_frames for motion in motions]
        return [(motion.root_positions[:, :2], motion.leg_length) for motion in motions]


def test_rows_of_every_capture(filled: store.Store) -> None:
    make = Maker()
    for _ in range(2):
        held = store.cached_rows(filled, "places", make)
        assert held.capture_ids.tolist() == [1, 2, 3]
        assert held.bounds.tolist() == [0, 5, 11, 18]
        assert held.values.tolist() == [store.load_motion(filled, n).leg_length for n in (1, 2, 3)]
        expected = [store.load_motion(filled, n).root_positions[:, :2] for n in (1, 2, 3)]
        np.testing.assert_array_equal(held.rows, np.concatenate(expected))
        assert is_mapped(held.rows[:])
    assert make.made == [5, 6, 7]


def _place_rows(filled: store.Store, numbers: Sequence[int]) -> np.ndarray:
    return np.concatenate([store.load_motion(filled, n).root_positions[:, :2] for n in numbers])


@pytest.fixture
def full(filled: store.Store, monkeypatch: pytest.MonkeyPatch) -> store.Store:
    """A store whose batches are full with two captures."""
    monkeypatch.setattr("motiondb.store.catalogue.cache._BATCH", 8 * 11)
    return filled


def test_only_rows_of_new_captures_are_made_and_old_files_go(
    filled: store.Store, samples: ModuleType
) -> None:
    make = Maker()
    store.cached_rows(filled, "places", make)
    kept = _folder(filled) / "places-2024.json"
    kept.write_text("a user's own")
    key = _rows_file(filled).name.split("-")[1]
    for former in (f"places-{key}.json", f"places-{key}-rows.npy", f"places-{'0' * 32}-x.npy"):
        (_folder(filled) / former).write_text("of another motiondb")
    samples.add(filled, "dddd", n_frames=2)
    assert list(store.lacking_rows(filled, "places")) == [4]
    assert store.cached_rows(filled, "places", make).bounds.tolist() == [0, 5, 11, 18, 20]
    assert make.made == [5, 6, 7, 2]
    store.remove_captures(filled, [2])
    held = store.cached_rows(filled, "places", make)
    assert held.capture_ids.tolist() == [1, 3, 4]
    np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 3, 4]))
    assert make.made == [5, 6, 7, 2]
    assert store.lacking_rows(filled, "places") == {}
    assert {*_folder(filled).iterdir()} == {kept, _rows_file(filled)}
    assert kept.read_text() == "a user's own"


def test_full_batches_stay_and_small_ones_are_joined(
    full: store.Store, samples: ModuleType
) -> None:
    store.cached_rows(full, "places", Maker())
    first = {file: file.stat().st_ino for file in _folder(full).iterdir()}
    assert len(first) == 2  # of 5 and 6 frames, and of 7
    for name, n_frames in (("dddd", 1), ("eeeee", 2), ("ffffff", 3)):
        samples.add(full, name, n_frames=n_frames)
        make = Maker()
        held = store.cached_rows(full, "places", make)
        assert make.made == [n_frames]
    second = {file: file.stat().st_ino for file in _folder(full).iterdir()}
    assert first.items() <= second.items()
    assert len(second) == 3
    np.testing.assert_array_equal(held.rows, _place_rows(full, range(1, 7)))


def test_what_belongs_to_removed_captures_goes_where_it_is_more_than_half(
    full: store.Store,
) -> None:
    store.cached_rows(full, "places", Maker())
    before = set(_folder(full).iterdir())
    store.remove_captures(full, [1])
    for number, n_files, changes in ((1, 2, False), (2, 1, True), (3, 0, True)):
        if number > 1:
            store.remove_captures(full, [number])
        make = Maker()
        held = store.cached_rows(full, "places", make)
        assert held.capture_ids.tolist() == list(range(number + 1, 4))
        after = set(_folder(full).iterdir())
        assert (len(after), after != before, make.made) == (n_files, changes, [])


def test_rows_of_several_batches_are_looked_at_as_one_array(
    full: store.Store, samples: ModuleType
) -> None:
    store.cached_rows(full, "places", Maker())
    samples.add(full, "dddd", n_frames=12)
    store.remove_captures(full, [2])
    held = store.cached_rows(full, "places", Maker())
    expected = _place_rows(full, [1, 3, 4])
    assert (held.rows.shape, held.rows.size, len(held.rows)) == ((24, 2), 48, 24)
    for part in (slice(3, 7), slice(5, 12), slice(1, 24, 5), slice(None), slice(4, 4)):
        np.testing.assert_array_equal(held.rows[part], expected[part])
    assert is_mapped(held.rows[5:12])
    second, numbers = held.rows.columns(1, 2), np.array([[23, 0], [6, 6]])
    assert second.shape == (24, 1)
    np.testing.assert_array_equal(second[numbers], expected[:, 1:][numbers])
    np.testing.assert_array_equal(second[np.arange(24) % 2 == 0], expected[::2, 1:])
    np.testing.assert_array_equal(second.argmax(axis=0), expected[:, 1:].argmax(axis=0))
    np.testing.assert_array_equal(2.0 * second - 1.0, 2.0 * expected[:, 1:] - 1.0)
    sent = pickle.loads(pickle.dumps(second))
    assert type(sent) is np.ndarray
    np.testing.assert_array_equal(sent, expected[:, 1:])


@pytest.mark.skipif(sys.platform != "linux", reason="/proc tells what memory holds of a file")
def test_memory_of_rows_that_were_looked_at_is_given_back(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def make(motions: Sequence[Motion]) -> list[tuple[np.ndarray, float]]:
        return [(np.full((2**14, 64), motion.n_frames, np.float32), 0.0) for motion in motions]

    monkeypatch.setattr("motiondb.store.catalogue.joined_rows._HELD", 2**20)
    rows = store.cached_rows(filled, "places", make).rows
    for first in range(0, len(rows), 2**11):
        assert set(rows[first : first + 2**11].ravel()) <= {5, 6, 7}
    parts = Path("/proc/self/smaps").read_text().split("\nVmFlags")
    (part,) = (part for part in parts if str(_rows_file(filled)) in part)
    (held,) = (int(line.split()[1]) for line in part.splitlines() if line.startswith("Rss:"))
    assert held <= 2**12  # KiB, with what the system reads ahead; the file has 12 MiB


def test_files_of_rows_are_not_written_to(
    filled: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    """Such as those of a copy by links, or of a process that reads another state."""
    before = store.cached_rows(filled, "places", Maker())
    os.link(_rows_file(filled), tmp_path / "backup")
    content = (tmp_path / "backup").read_bytes()
    samples.add(filled, "dddd", n_frames=2)
    held = store.cached_rows(filled, "places", Maker())
    np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 2, 3, 4]))
    np.testing.assert_array_equal(before.rows, held.rows[:18])
    assert (tmp_path / "backup").read_bytes() == content


def test_rows_of_a_capture_whose_motion_is_damaged_are_left_out(
    filled: store.Store, samples: ModuleType
) -> None:
    filled.connection.execute("UPDATE motion SET poses = 'x'::BLOB WHERE capture_id = 2")
    store.cached_rows(filled, "places", Maker())
    samples.add(filled, "dddd", n_frames=2)
    for made in ([2], []):
        make = Maker()
        held = store.cached_rows(filled, "places", make)
        assert (held.capture_ids.tolist(), make.made) == ([1, 3, 4], made)
        np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 3, 4]))


def test_an_interrupt_leaves_what_was_there(full: store.Store, samples: ModuleType) -> None:
    store.cached_rows(full, "places", Maker())
    before = set(_folder(full).iterdir())
    samples.add(full, "dddd", n_frames=12)
    samples.add(full, "eeeee", n_frames=2)

    def ends(motions: Sequence[Motion]) -> list[tuple[np.ndarray, float]]:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        store.cached_rows(full, "places", ends)
    assert before <= set(_folder(full).iterdir())
    make = Maker()
    held = store.cached_rows(full, "places", make)
    np.testing.assert_array_equal(held.rows, _place_rows(full, [1, 2, 3, 4, 5]))
    assert make.made == [12, 2]


def test_what_a_kill_left_beside_its_joined_batch_goes(
    filled: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.cached_rows(filled, "places", Maker())
    former = _rows_file(filled)
    content = former.read_bytes()
    samples.add(filled, "dddd", n_frames=2)
    store.cached_rows(filled, "places", Maker())
    joined = _rows_file(filled)
    assert joined != former
    for least in (0, 0.5):  # also where the joined one is full
        former.write_bytes(content)
        monkeypatch.setattr("motiondb.store.catalogue.cache._BATCH", 8 * 20 if least else 2**25)
        make = Maker()
        held = store.cached_rows(filled, "places", make)
        np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 2, 3, 4]))
        assert make.made == []
        (file,) = _folder(filled).iterdir()
        assert file.stat().st_size == joined.stat().st_size


def test_damaged_rows_are_made_anew_when_they_are_looked_at(full: store.Store) -> None:
    make = Maker()
    expected = np.array(store.cached_rows(full, "places", make).rows)
    files = sorted(_folder(full).iterdir(), key=lambda file: file.stat().st_size)
    flip(files[0], 8 * 3 - 64)  # in the rows of the third capture, which end after 56 bytes of 64
    held = store.cached_rows(full, "places", make)
    np.testing.assert_array_equal(held.rows[:11], expected[:11])
    assert make.made == [5, 6, 7]  # the damage is not in these
    for part in (slice(9, 13), slice(8, 18, 3), slice(None), slice(4, 4)):
        np.testing.assert_array_equal(held.rows[part], expected[part])
    np.testing.assert_array_equal(held.rows.columns(1, 2)[np.array([17, 0])], expected[[17, 0], 1:])
    assert make.made == [5, 6, 7, 7]
    again = store.cached_rows(full, "places", make)
    np.testing.assert_array_equal(again.rows, expected)
    assert is_mapped(again.rows[11:])
    assert make.made == [5, 6, 7, 7, 7]


def test_damaged_rows_are_not_joined_to_others(full: store.Store, samples: ModuleType) -> None:
    store.cached_rows(full, "places", Maker())
    samples.add(full, "dddd", n_frames=2)
    before = set(_folder(full).iterdir())
    store.cached_rows(full, "places", Maker())
    (new,) = set(_folder(full).iterdir()) - before
    flip(new, -64)
    samples.add(full, "eeeee", n_frames=1)
    make = Maker()
    held = store.cached_rows(full, "places", make)
    np.testing.assert_array_equal(held.rows, _place_rows(full, [1, 2, 3, 4, 5]))
    assert make.made == [1, 2]


def test_rows_of_another_run_are_not_used(filled: store.Store, samples: ModuleType) -> None:
    """A copy that was put back gives a number again, to a capture that was read otherwise."""
    make = Maker()
    store.cached_rows(filled, "places", make)
    filled.connection.execute("UPDATE run SET parameters = '{}', started = 'later'")
    samples.add(filled, "dddd", n_frames=2)
    store.cached_rows(filled, "places", make)
    assert make.made == [5, 6, 7, 5, 6, 7, 2]


def test_rows_that_were_made_while_the_file_was_free_are_used(filled: store.Store) -> None:
    make, motions = Maker(), store.lacking_rows(filled, "places")
    ready = dict(zip(motions, make(list(motions.values()))))
    held = store.cached_rows(filled, "places", make, ready)
    assert held.bounds.tolist() == [0, 5, 11, 18]
    assert make.made == [5, 6, 7]


def test_arrays_are_built_once_until_the_motions_change(
    filled: store.Store, samples: ModuleType
) -> None:
    calls: list[int] = []

    def build() -> dict[str, np.ndarray]:
        calls.append(1)
        return {"x": np.arange(3), "y": np.zeros((0, 2))}

    for _ in range(3):
        arrays = store.cached_arrays(filled, "evidence", build)
        assert arrays["x"].tolist() == [0, 1, 2]
        assert arrays["y"].shape == (0, 2)
    assert len(calls) == 1
    store.save_captions(filled, 1, [])  # words do not matter
    store.cached_arrays(filled, "evidence", build)
    assert len(calls) == 1
    samples.add(filled, "dddd")
    store.cached_arrays(filled, "evidence", build)
    assert len(calls) == 2


def test_within_a_transaction_nothing_is_kept(filled: store.Store, samples: ModuleType) -> None:
    def add_and_fail() -> None:
        with store.transaction(filled):
            samples.add(filled, "dddd", n_frames=2)
            held = store.cached_rows(filled, "places", Maker())
            assert held.bounds.tolist() == [0, 5, 11, 18, 20]
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        add_and_fail()
    assert store.cached_rows(filled, "places", Maker()).bounds.tolist() == [0, 5, 11, 18]


def _arrays() -> dict[str, np.ndarray]:
    return {"x": np.arange(3000), "y": np.linspace(0.0, 1.0, 7).reshape(7, 1)}


def _expect_healed(filled: store.Store) -> None:
    """Arrays are made anew once, are right, and are then mapped again."""
    calls: list[int] = []

    def build() -> dict[str, np.ndarray]:
        calls.append(1)
        return _arrays()

    for _ in range(2):
        cached = store.cached_arrays(filled, "evidence", build)
        for name, expected in _arrays().items():
            np.testing.assert_array_equal(cached[name], expected)
    assert set(cached) == {"x", "y"}
    assert calls == [1]


def _arrays_file(filled: store.Store) -> Path:
    (file,) = _folder(filled).glob("evidence-*.arrays")
    return file


@pytest.mark.parametrize("place", [0, 9, 20, 40, 200, 10_000, -60, "all"])
def test_a_changed_file_is_made_anew(filled: store.Store, place: int | str) -> None:
    store.cached_arrays(filled, "evidence", _arrays)
    file = _arrays_file(filled)
    if isinstance(place, int):
        flip(file, place, 2)
    else:
        file.write_bytes(b"")
    _expect_healed(filled)


@pytest.mark.parametrize(("before", "after"), [(b"3000", b"1500"), (b'"x"', b'"z"')])
def test_a_changed_head_is_noticed(filled: store.Store, before: bytes, after: bytes) -> None:
    store.cached_arrays(filled, "evidence", _arrays)
    file = _arrays_file(filled)
    file.write_bytes(file.read_bytes().replace(before, after, 1))
    _expect_healed(filled)


def test_a_file_of_objects_is_not_loaded(filled: store.Store) -> None:
    """Nor where its name fits."""
    store.cached_arrays(filled, "evidence", _arrays)
    file = _arrays_file(filled)
    content = file.read_bytes().replace(b"<i8", b"|O8", 1)
    digest = hashlib.sha256(content[8 : 8 + int.from_bytes(content[:8], "little")]).hexdigest()
    file.unlink()
    file.with_name(f"{file.stem[:-32]}{digest[:32]}.arrays").write_bytes(content)
    _expect_healed(filled)


def test_arrays_of_another_motiondb_are_not_used(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Maker()
    for version in ("0.0.1", "0.0.2"):
        monkeypatch.setattr(
            "motiondb.store.catalogue.cache.motiondb_version", lambda version=version: version
        )
        _expect_healed(filled)
        store.cached_rows(filled, "places", make)
    assert make.made == [5, 6, 7] * 2
    assert len(list(_folder(filled).iterdir())) == 2


def test_a_draft_stays_only_while_its_process_runs(filled: store.Store) -> None:
    store.cached_arrays(filled, "evidence", _arrays)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    name, processes = _arrays_file(filled).name, (ended.pid, 1, os.getpid())
    left, *growing = (_folder(filled) / f".{name}.{n}.7.part" for n in processes)
    for draft in (left, *growing):
        draft.write_text("half")
    _arrays_file(filled).unlink()
    _expect_healed(filled)
    assert all(draft.exists() for draft in growing)  # of another process, or another thread
    assert not left.exists()


@given(arrays(np.uint8, st.integers(1, 9000)), st.data())
def test_one_changed_byte_changes_the_checksum(array: np.ndarray, data: st.DataObject) -> None:
    changed = array.copy()
    place = data.draw(st.integers(0, len(array) - 1))
    changed[place] ^= data.draw(st.integers(1, 255))
    assert page_checksum(changed) != page_checksum(array)


def test_pages_that_change_places_change_the_checksum() -> None:
    pages = np.arange(4 * 512).reshape(4, 512)
    assert page_checksum(pages) != page_checksum(pages[[1, 0, 2, 3]])
    naive = sum((2 * k + 1) * int(page.sum()) for k, page in enumerate(pages))
    assert page_checksum(pages) == naive


def test_threads_that_build_together_leave_a_whole_cache(filled: store.Store) -> None:
    actual: list[dict[str, np.ndarray]] = []
    threads = [
        threading.Thread(
            target=lambda: actual.append(store.cached_arrays(filled, "evidence", _arrays))
        )
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(actual) == 8
    for each in actual:
        np.testing.assert_array_equal(each["x"], _arrays()["x"])
    assert [f.name for f in _folder(filled).iterdir() if f.suffix == ".part"] == []


def test_where_it_cannot_be_written_the_arrays_stay_in_memory(filled: store.Store) -> None:
    _folder(filled).write_text("a file where the folder should be")
    held = store.cached_rows(filled, "places", Maker())
    assert not is_mapped(held.rows[:])
    assert held.rows.shape == (18, 2)


def test_rows_beside_those_of_a_file_are_written_and_read_as_an_array(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    first, wanted = rng.normal(size=(5, 3)).astype(np.float32), rng.normal(size=(7, 2))
    with (tmp_path / "rows").open("w+b") as file:
        file.write(first.data)
        held = store.FileRows(file, (5, 3), np.float32)
        beside = held.beside((7, 2), np.float64)
        beside[4:7], beside[0:4] = wanted[4:], wanted[:4]
        np.testing.assert_array_equal(held[:], first)
        for which in (slice(2, 9), np.array([6, 0, 1, 3]), wanted[:, 0] > 0.0, slice(0, 0)):
            np.testing.assert_array_equal(beside[which], wanted[which])
        assert not held.beside((2, 2), np.float64)[:].any()


def test_rows_of_a_file_that_is_cut_are_an_error(tmp_path: Path) -> None:
    with (tmp_path / "rows").open("w+b") as file:
        rows = store.FileRows(file, (4, 2), np.float32).beside((4, 2), np.float32)
        file.truncate(8)
        with pytest.raises(OSError, match="shorter than its rows"):
            rows[1:3]
