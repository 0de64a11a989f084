from __future__ import annotations

from pathlib import Path
from types import ModuleType

import duckdb
import numpy as np
import pytest

from motiondb import store
from motiondb.errors import StoreError


def test_compacting_gives_the_room_back_and_loses_nothing(
    database: store.Store, samples: ModuleType
) -> None:
    noise = np.random.default_rng(0).bytes(1_500_000)
    run_id = store.start_run(database, "add")
    for name in ("a", "bb", "ccc"):
        source = store.pack_source(f"{name}.bvh", name.encode() + noise, "bvh")
        store.save_capture(database, samples.info(name, run_id), samples.motion(len(name)), source)
    infos = store.load_captures(database)
    learning = samples.learning(infos, store.start_run(database, "learn"))
    store.save_learning(database, learning)
    store.remove_capture(database, 2)
    counts = store.count_rows(database)
    database.close()
    before, after = store.compact(database.path)
    assert after < before - 1_000_000
    assert after == database.path.stat().st_size
    with store.open_store(database.path) as compacted:
        assert store.count_rows(compacted) == counts
        assert store.check_store(compacted, sources=True) == []
        assert not store.learning_is_current(compacted)
        samples.assert_equal(store.load_symbols(compacted), learning.symbols)
        assert samples.add(compacted, "dddd").capture_id == 4
        with pytest.raises(StoreError, match="under the name a"):
            store.save_capture(
                compacted,
                samples.info("e", run_id),
                samples.motion(),
                store.pack_source("a.bvh", b"a" + noise, "bvh"),
            )
    assert [item.name for item in database.path.parent.iterdir()] == ["motions.duckdb"]


def test_a_failing_copy_keeps_the_old_file(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples.add(database, "a")
    database.close()
    content = database.path.read_bytes()

    def fail(*_: object) -> None:
        raise duckdb.IOException("IO Error: No space left on device! More.")

    monkeypatch.setattr("motiondb.store.checking.compaction._copy", fail)
    with pytest.raises(StoreError) as error:
        store.compact(database.path)
    assert str(error.value) == (
        f"{database.path}: expected room for a copy beside it, found: IO Error: No space left on "
        "device. The old file was kept; look at the disk."
    )
    assert database.path.read_bytes() == content
    assert [item.name for item in database.path.parent.iterdir()] == ["motions.duckdb"]


def test_compacting_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="found no such file"):
        store.compact(tmp_path / "m.duckdb")
    assert list(tmp_path.iterdir()) == []
