from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
import threading
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motiondb import store
from motiondb.records import Motion
from motiondb.store.catalogue.checked_rows import page_checksum, page_checksums


def _folder(database: store.Store) -> Path:
    return database.path.with_name("motions.duckdb.cache")


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    for number, name in enumerate(("a", "bb", "ccc")):
        samples.add(database, name, n_frames=5 + number)
    return database


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
        assert isinstance(held.rows.rows.base, np.memmap)
    assert make.made == [5, 6, 7]


def test_columns_and_chosen_rows_are_checked_as_the_whole(filled: store.Store) -> None:
    make = Maker()
    expected = np.array(store.cached_rows(filled, "places", make).rows)
    (file,) = _folder(filled).glob("places-*-rows.npy")
    content = bytearray(file.read_bytes())
    content[-1] ^= 1  # in the last row of the third capture
    file.write_bytes(content)
    second = store.cached_rows(filled, "places", make).rows.columns(1, 2)
    assert (second.shape, second.size) == ((18, 1), 18)
    np.testing.assert_array_equal(second[np.array([7, 2, 2])], expected[[7, 2, 2], 1:])
    assert make.made == [5, 6, 7]  # the damage is not in these
    np.testing.assert_array_equal(second[np.array([17, 0])], expected[[17, 0], 1:])
    assert make.made == [5, 6, 7, 7]
    np.testing.assert_array_equal(second.argmax(axis=0), expected[:, 1:].argmax(axis=0))
    np.testing.assert_array_equal(2.0 * second - 1.0, 2.0 * expected[:, 1:] - 1.0)
    sent = pickle.loads(pickle.dumps(second))
    assert type(sent) is np.ndarray
    np.testing.assert_array_equal(sent, expected[:, 1:])


def test_only_rows_of_new_captures_are_made_and_old_files_go(
    filled: store.Store, samples: ModuleType
) -> None:
    make = Maker()
    store.cached_rows(filled, "places", make)
    (_folder(filled) / "places-2024.json").write_text("a user's own")
    n_files = len(list(_folder(filled).iterdir()))
    samples.add(filled, "dddd", n_frames=2)
    assert list(store.lacking_rows(filled, "places")) == [4]
    assert store.cached_rows(filled, "places", make).bounds.tolist() == [0, 5, 11, 18, 20]
    assert make.made == [5, 6, 7, 2]
    store.remove_capture(filled, 2)
    held = store.cached_rows(filled, "places", make)
    assert held.capture_ids.tolist() == [1, 3, 4]
    expected = [store.load_motion(filled, n).root_positions[:, :2] for n in (1, 3, 4)]
    np.testing.assert_array_equal(held.rows, np.concatenate(expected))
    assert make.made == [5, 6, 7, 2]
    assert store.lacking_rows(filled, "places") == {}
    assert len(list(_folder(filled).iterdir())) == n_files == 8
    assert (_folder(filled) / "places-2024.json").read_text() == "a user's own"


def _place_rows(filled: store.Store, numbers: Sequence[int]) -> np.ndarray:
    return np.concatenate([store.load_motion(filled, n).root_positions[:, :2] for n in numbers])


def test_rows_of_new_captures_are_written_behind_the_others(
    filled: store.Store, samples: ModuleType
) -> None:
    before = store.cached_rows(filled, "places", Maker())
    (file,) = _folder(filled).glob("places-*-rows.npy")
    first = file.stat()
    samples.add(filled, "dddd", n_frames=2)
    held = store.cached_rows(filled, "places", Maker())
    (file,) = _folder(filled).glob("places-*-rows.npy")
    second = file.stat()
    assert (second.st_ino, second.st_size) == (first.st_ino, first.st_size + 2 * 2 * 4)
    np.testing.assert_array_equal(np.load(file), _place_rows(filled, [1, 2, 3, 4]))
    np.testing.assert_array_equal(held.rows, np.load(file))
    np.testing.assert_array_equal(before.rows, held.rows[:18])


def test_a_file_of_rows_with_another_name_is_not_written_to(
    filled: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    """Such as that of a copy by links, or of a process that reads another state."""
    store.cached_rows(filled, "places", Maker())
    (file,) = _folder(filled).glob("places-*-rows.npy")
    os.link(file, tmp_path / "backup.npy")
    before = (tmp_path / "backup.npy").read_bytes()
    samples.add(filled, "dddd", n_frames=2)
    held = store.cached_rows(filled, "places", Maker())
    np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 2, 3, 4]))
    assert (tmp_path / "backup.npy").read_bytes() == before


def test_rows_grow_behind_a_capture_whose_motion_is_damaged(
    filled: store.Store, samples: ModuleType
) -> None:
    filled.connection.execute("UPDATE motion SET poses = 'x'::BLOB WHERE capture_id = 2")
    store.cached_rows(filled, "places", Maker())
    (file,) = _folder(filled).glob("places-*-rows.npy")
    first = file.stat().st_ino
    samples.add(filled, "dddd", n_frames=2)
    make = Maker()
    held = store.cached_rows(filled, "places", make)
    (file,) = _folder(filled).glob("places-*-rows.npy")
    assert (file.stat().st_ino, make.made) == (first, [2])
    np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 3, 4]))


def test_rows_that_an_interrupt_left_behind_the_others_do_no_harm(
    filled: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motiondb.store.catalogue.cache._AT_ONCE", 1)
    store.cached_rows(filled, "places", Maker())
    (listed,) = _folder(filled).glob("places-*.json")
    for name in ("dddd", "eeeee"):
        samples.add(filled, name, n_frames=2)

    def ends(motions: Sequence[Motion]) -> list[tuple[np.ndarray, float]]:
        raise KeyboardInterrupt

    one = Maker()([store.load_motion(filled, 4)])[0]
    with pytest.raises(KeyboardInterrupt):
        store.cached_rows(filled, "places", ends, {4: one})
    assert listed.is_file()  # what it lists is still there
    for _ in range(2):
        make = Maker()
        held = store.cached_rows(filled, "places", make)
        np.testing.assert_array_equal(held.rows, _place_rows(filled, [1, 2, 3, 4, 5]))
    assert make.made == []
    assert len(list(_folder(filled).iterdir())) == 7


def test_damaged_rows_are_made_anew_when_they_are_looked_at(filled: store.Store) -> None:
    make = Maker()
    expected = np.array(store.cached_rows(filled, "places", make).rows)
    (file,) = _folder(filled).glob("places-*-rows.npy")
    content = bytearray(file.read_bytes())
    content[-8 * 3] ^= 1  # in the first rows of the third capture
    file.write_bytes(content)
    held = store.cached_rows(filled, "places", make)
    np.testing.assert_array_equal(held.rows[:11], expected[:11])
    assert make.made == [5, 6, 7]  # the damage is not in these
    for part in (slice(9, 13), slice(8, 18, 3), slice(None), slice(4, 4)):
        np.testing.assert_array_equal(held.rows[part], expected[part])
    np.testing.assert_array_equal(held.rows[np.arange(18) % 2 == 0], expected[::2])
    assert make.made == [5, 6, 7, 7]
    again = store.cached_rows(filled, "places", make)
    np.testing.assert_array_equal(again.rows, expected)
    assert isinstance(again.rows.rows.base, np.memmap)


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
        arrays = store.cached_arrays(filled, "features", build)
        assert arrays["x"].tolist() == [0, 1, 2]
        assert arrays["y"].shape == (0, 2)
    assert len(calls) == 1
    store.save_captions(filled, 1, [])  # words do not matter
    store.cached_arrays(filled, "features", build)
    assert len(calls) == 1
    samples.add(filled, "dddd")
    store.cached_arrays(filled, "features", build)
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
        cached = store.cached_arrays(filled, "features", build)
        for name, expected in _arrays().items():
            np.testing.assert_array_equal(cached[name], expected)
    assert set(cached) == {"x", "y"}
    assert calls == [1]


def _list_file(filled: store.Store) -> Path:
    (listed,) = _folder(filled).glob("features-*.json")
    return listed


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (r"(?s).*", ""),
        (r"(?s).*", '{"version": "1", "arrays": {}, "checksum": 0}'),
        ('"x"', '"z"'),
        (r"\[3000\]", "[1500]"),
        ("<i8", "<f8"),
        ('"version": "1,', '"version": "2,'),
        ("motiondb [0-9.]+", "motiondb 0.0.1"),
    ],
)
def test_a_changed_list_is_made_anew(filled: store.Store, before: str, after: str) -> None:
    store.cached_arrays(filled, "features", _arrays)
    listed = _list_file(filled)
    changed = re.sub(before, after, listed.read_text(), count=1)
    assert changed != listed.read_text()
    listed.write_text(changed)
    _expect_healed(filled)


@pytest.mark.parametrize(("place", "bit"), [(0, 1), (10_000, 128), (-1, 1)])
def test_a_flipped_bit_is_noticed(filled: store.Store, place: int, bit: int) -> None:
    store.cached_arrays(filled, "features", _arrays)
    (file,) = _folder(filled).glob("features-*-x.npy")
    content = bytearray(file.read_bytes())
    content[place] ^= bit
    file.write_bytes(content)
    _expect_healed(filled)


def test_a_draft_stays_only_while_its_process_runs(filled: store.Store) -> None:
    store.cached_arrays(filled, "features", _arrays)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    stem, processes = _list_file(filled).stem, (ended.pid, 1, os.getpid())
    left, *growing = (_folder(filled) / f".{stem}-x.npy.{n}.7.part" for n in processes)
    for draft in (left, *growing):
        draft.write_text("half")
    _list_file(filled).unlink()
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


@pytest.mark.parametrize("n_columns", [1, 6, 130])
def test_checksums_of_many_captures_are_those_of_each(n_columns: int) -> None:
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(3000, n_columns)).astype(np.float32)
    bounds = np.array([3, 3, 4, 40, 40, 2041, 2999, 3000, 3000])
    actual = page_checksums(rows, bounds)
    assert actual.tolist() == [page_checksum(rows[a:b]) for a, b in pairwise(bounds)]


def test_threads_that_build_together_leave_a_whole_cache(filled: store.Store) -> None:
    actual: list[dict[str, np.ndarray]] = []
    threads = [
        threading.Thread(
            target=lambda: actual.append(store.cached_arrays(filled, "features", _arrays))
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
    assert not isinstance(held.rows, np.memmap)
    assert held.rows.shape == (18, 2)
