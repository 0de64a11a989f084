from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import duckdb
import numpy as np
import pytest
from holding import holding
from rights import as_others

from motiondb import store
from motiondb.errors import StoreError
from motiondb.files import packed_files
from motiondb.store import compaction
from motiondb.store.connection import handle


def test_compacting_gives_the_room_back_and_loses_nothing(
    database: store.Store, samples: ModuleType
) -> None:
    noise = np.random.default_rng(0).bytes(1_500_000)
    run_id = store.start_run(database, "add")
    for name in ("a", "bb", "ccc"):
        source = packed_files.pack_source(f"{name}.bvh", name.encode() + noise, "bvh")
        store.save_capture(database, samples.info(name, run_id), samples.motion(len(name)), source)
    infos = store.load_captures(database)
    learning = samples.learning(infos, store.start_run(database, "learn"))
    store.save_learning(database, learning)
    store.remove_captures(database, [2])
    counts = {k: n for k, n in store.count_rows(database).items() if not k.startswith("trash.")}
    database.close()
    sizes = store.compact(database.path)
    assert sizes.after < sizes.before - 1_000_000
    assert sizes.after == database.path.stat().st_size
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
                packed_files.pack_source("a.bvh", b"a" + noise, "bvh"),
            )
    assert [item.name for item in database.path.parent.iterdir()] == ["motions.duckdb"]


def test_a_large_file_is_copied_in_bounded_memory(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handle, "_PEAK", 10**3)  # this file is large
    monkeypatch.setattr(handle, "_LEAST_BOUND", 2**26)
    samples.add(database, "a")
    database.close()
    limits, copy = list[str](), compaction.copy_tables

    def noted(opened: store.Store, alias: str) -> None:
        limits.append(opened.connection.value("SELECT current_setting('memory_limit')"))
        copy(opened, alias)

    monkeypatch.setattr(compaction, "copy_tables", noted)
    store.compact(database.path)
    assert limits == ["64.0 MiB"]
    with store.open_store(database.path) as compacted:
        assert store.check_store(compacted, sources=True) == []


def test_a_failing_copy_keeps_the_old_file(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples.add(database, "a")
    database.close()
    content = database.path.read_bytes()

    def fail(*_: object) -> None:
        raise duckdb.IOException("IO Error: No space left on device! More.")

    monkeypatch.setattr("motiondb.store.compaction.copy_tables", fail)
    with pytest.raises(StoreError) as error:
        store.compact(database.path)
    assert str(error.value) == (
        f"{database.path}: expected room for a copy in {database.path.parent}, found: IO Error: No "
        "space left on device. Nothing was changed; look at the folder's permissions and at the "
        "disk."
    )
    assert database.path.read_bytes() == content
    assert [item.name for item in database.path.parent.iterdir()] == ["motions.duckdb"]


def test_a_copy_into_a_folder_that_may_not_be_written_names_the_folder(
    database: store.Store, tmp_path: Path
) -> None:
    folder = tmp_path / "closed"
    folder.mkdir(mode=0o555)
    with as_others() as can:
        if not can:
            pytest.skip("this user may write everything")
        with pytest.raises(
            StoreError, match=f"expected room for a copy in {folder}, found: no right"
        ):
            store.backup(database, folder / "copy.duckdb", lambda _copy: [])
    assert [*folder.iterdir()] == []


def test_compacting_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="found no such file"):
        store.compact(tmp_path / "m.duckdb")
    assert list(tmp_path.iterdir()) == []


def test_a_compact_beside_another_is_refused(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples.add(database, "a")
    database.close()
    content = database.path.read_bytes()
    draft = database.path.with_name(".motions.duckdb.compact")
    identity = compaction._identity
    with ExitStack() as others:

        def begin_another(path: Path) -> tuple[int, int]:
            """Another process begins after this one has swept what killed ones left."""
            others.enter_context(holding(draft))
            return identity(path)

        monkeypatch.setattr(compaction, "_identity", begin_another)
        with pytest.raises(StoreError) as error:
            store.compact(database.path)
        assert str(error.value) == (
            f"{database.path}: expected no other process that compacts it, found one at work. "
            "Nothing was changed; wait until it has ended."
        )
        assert draft.exists()
    assert database.path.read_bytes() == content


def test_a_file_that_took_the_name_meanwhile_is_not_overwritten(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples.add(database, "a")
    database.close()
    attach, path = compaction.attach, database.path

    def put_another(opened: store.Store, new: Path, alias: str) -> None:
        attach(opened, new, alias)
        path.with_name("other").write_bytes(b"another")
        path.with_name("other").replace(path)

    monkeypatch.setattr(compaction, "attach", put_another)
    with pytest.raises(StoreError, match="found that another program put one in its place"):
        store.compact(path)
    assert path.read_bytes() == b"another"
    assert [item.name for item in path.parent.iterdir()] == ["motions.duckdb"]
