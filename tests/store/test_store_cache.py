from __future__ import annotations

import shutil
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from motiondb import store
from motiondb.errors import QueryError


def _folder(database: store.Store) -> Path:
    return database.path.with_name("motions.duckdb.cache")


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    for number, name in enumerate(("a", "bb", "ccc")):
        samples.add(database, name, n_frames=5 + number)
    return database


def test_the_pool_holds_every_motion(filled: store.Store, samples: ModuleType) -> None:
    for _ in range(2):
        pool = store.load_motion_pool(filled)
        assert pool.capture_ids.tolist() == [1, 2, 3]
        assert pool.offsets.tolist() == [0, 5, 11, 18]
        for number in (1, 2, 3):
            found, expected = pool.motion(number), store.load_motion(filled, number)
            np.testing.assert_array_equal(found.local_rotations, expected.local_rotations)
            np.testing.assert_array_equal(found.root_positions, expected.root_positions)
            assert found.leg_length == expected.leg_length
        assert isinstance(pool.poses, np.memmap)
    with pytest.raises(QueryError, match="capture 9: expected a capture in the pool, found none"):
        pool.motion(9)


def test_a_change_of_motions_makes_it_anew_and_old_files_go(
    filled: store.Store, samples: ModuleType
) -> None:
    store.load_motion_pool(filled)
    n_files = len(list(_folder(filled).iterdir()))
    samples.add(filled, "dddd", n_frames=2)
    assert store.load_motion_pool(filled).offsets.tolist() == [0, 5, 11, 18, 20]
    store.remove_capture(filled, 2)
    assert store.load_motion_pool(filled).capture_ids.tolist() == [1, 3, 4]
    assert len(list(_folder(filled).iterdir())) == n_files == 5


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
            assert store.load_motion_pool(filled).offsets.tolist() == [0, 5, 11, 18, 20]
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        add_and_fail()
    assert store.load_motion_pool(filled).offsets.tolist() == [0, 5, 11, 18]


def test_the_folder_can_be_deleted_or_damaged(filled: store.Store) -> None:
    expected = store.load_motion_pool(filled).poses.copy()
    shutil.rmtree(_folder(filled))
    np.testing.assert_array_equal(store.load_motion_pool(filled).poses, expected)
    for file in _folder(filled).glob("*.npy"):
        file.write_bytes(file.read_bytes()[:100])
    np.testing.assert_array_equal(store.load_motion_pool(filled).poses, expected)


def test_where_it_cannot_be_written_the_arrays_stay_in_memory(filled: store.Store) -> None:
    _folder(filled).write_text("a file where the folder should be")
    pool = store.load_motion_pool(filled)
    assert not isinstance(pool.poses, np.memmap)
    assert pool.poses.shape == (18, 87)


def test_an_empty_store_has_an_empty_pool(database: store.Store) -> None:
    pool = store.load_motion_pool(database)
    assert (pool.poses.shape, pool.offsets.tolist()) == ((0, 87), [0])
