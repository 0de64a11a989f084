"""Scores of segments in Parquet files: the same bits, until ``learn`` makes others."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import ModuleType

import duckdb
import numpy as np
import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.records import StoredLearning
from motiondb.store import moving
from motiondb.store.catalogue import parquet_files, places
from motiondb.store.connection.faults import DamagedFileError, DamagedMotionError
from motiondb.store.connection.transactions import read_meta

SCORES = parquet_files.SCORES
ODD = np.array([np.nan, np.inf, -np.inf, -0.0, 1e-45], dtype=np.float32)


@pytest.fixture
def learned(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> store.Store:
    """Three captures with scores for two Parquet files, of 2 and 1 captures."""
    monkeypatch.setitem(moving._AT_MOST, SCORES, (10**6, 2))
    for name in ("a", "bb", "ccc"):
        samples.add(database, name)
    learn(database, samples)
    return database


def learn(database: store.Store, samples: ModuleType, seed: int = 0) -> StoredLearning:
    infos = store.load_captures(database)
    made = samples.learning(infos, store.start_run(database, "learn"), seed=seed)
    made.segments.scores[2] = ODD
    store.save_learning(database, made)
    return made


def bits(database: store.Store) -> dict[int, bytes]:
    """The bits of the scores of every capture."""
    return {number: part.tobytes() for number, part in store.load_scores(database).items()}


def score_files(database: store.Store) -> list[parquet_files.ParquetFile]:
    return [file for file in store.load_parquet_files(database) if file.kind == SCORES]


def test_scores_come_out_bit_for_bit(learned: store.Store, moved_to: str) -> None:
    rows = "SELECT capture_id, scores, run_id FROM segment_score ORDER BY ALL"
    before, there = bits(learned), learned.connection.execute(rows).fetchall()
    assert np.frombuffer(before[2][: 4 * len(ODD)], dtype="<f4").tobytes() == ODD.tobytes()
    mark = read_meta(learned, "segment_revision")
    assert store.move_motions(learned, moved_to) == 3
    files = score_files(learned)
    assert [file.place for file in files] == [moved_to] * 2
    assert learned.connection.value("SELECT sum(len(scores)) FROM segment_score") == 0
    assert bits(learned) == before
    assert {n: store.load_scores(learned, [n])[n].tobytes() for n in (3, 1)} == {
        n: before[n] for n in (3, 1)
    }
    assert read_meta(learned, "segment_revision") == mark  # the cache stays valid
    assert store.check_store(learned) == []
    assert store.move_motions(learned, moved_to) == 0
    assert store.move_motions(learned, moving.IN_DATABASE) == 3
    assert score_files(learned) == []
    assert {file.path for file in files} < set(parquet_files.untold_files(learned))
    assert learned.connection.execute(rows).fetchall() == there  # a NaN is NULL again
    assert bits(learned) == before


def test_any_program_reads_the_scores(learned: store.Store, tmp_path: Path) -> None:
    expected = store.load_scores(learned)
    store.move_motions(learned, str(tmp_path / "out"))
    query = "SELECT capture_id, name, n_symbols, scores FROM read_parquet(?) ORDER BY 1"
    rows = duckdb.execute(query, [str(tmp_path / "out/scores-*.parquet")]).fetchall()
    assert [row[1] for row in rows] == ["a", "bb", "ccc"]
    for number, _, n_symbols, data in rows:
        found = np.frombuffer(data, dtype="<f4").reshape(-1, n_symbols)
        np.testing.assert_array_equal(found, expected[number])


def test_learning_again_leaves_the_files_unused(
    learned: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    place = str(tmp_path / "out")
    store.move_motions(learned, place)
    old = [file.path for file in score_files(learned)]
    again = learn(learned, samples, seed=1)
    samples.assert_equal(store.load_learning(learned), again)  # from the database
    assert score_files(learned) == []
    assert parquet_files.untold_files(learned) == old
    for path in old:
        Path(path).unlink()  # they were left there, and nothing needs them
    assert store.check_store(learned, sources=True) == []
    assert store.move_motions(learned, place) == 3  # the scores
    samples.assert_equal(store.load_learning(learned), again)
    learned.close()
    assert store.compact(learned.path).unused == tuple(old)
    assert store.compact(learned.path).unused == ()  # they were told


def test_scores_of_other_captures_stay_where_they_are(
    learned: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    """As when a capture is removed, or added, and what follows from it is saved anew."""
    store.move_motions(learned, str(tmp_path / "out"))
    before, files = bits(learned), score_files(learned)
    store.remove_captures(learned, [3])
    samples.add(learned, "dddd")
    new = store.load_captures(learned, "name=dddd")
    made = samples.learning(new, store.start_run(learned, "add"))
    store.save_learning(learned, made, kept=(1, 2))
    assert bits(learned) == {1: before[1], 2: before[2], 4: made.segments.scores.tobytes()}
    assert score_files(learned) == files[:1]
    assert parquet_files.untold_files(learned) == [files[1].path]
    assert store.move_motions(learned, str(tmp_path / "out")) == 1
    assert bits(learned) == {1: before[1], 2: before[2], 4: made.segments.scores.tobytes()}
    assert store.check_store(learned) == []


def test_an_interrupted_move_leaves_scores_whole_and_is_continued(
    learned: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, place, write = bits(learned), str(tmp_path / "out"), places._Folder.write

    def fails_at_the_last(self: places._Folder, name: str, file: Path) -> None:
        if list(self._path.glob("scores-*")):
            raise KeyboardInterrupt
        write(self, name, file)

    with monkeypatch.context() as patch:
        patch.setattr(places._Folder, "write", fails_at_the_last)
        with pytest.raises(KeyboardInterrupt):
            store.move_motions(learned, place)
    there = "SELECT capture_id, len(scores) > 0, scores_at IS NULL FROM segment_score ORDER BY 1"
    assert learned.connection.execute(there).fetchall() == [
        (1, False, False),
        (2, False, False),
        (3, True, True),
    ]
    assert bits(learned) == before
    assert store.check_store(learned) == []
    assert store.move_motions(learned, place) == 1
    assert bits(learned) == before


def test_a_missing_file_is_named_and_learning_does_without_it(
    learned: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    store.move_motions(learned, str(out))
    file = score_files(learned)[0]
    Path(file.path).unlink()
    learned.local.block = None
    sentence = (
        f"{file.path}: expected a file or folder, found none. It holds scores of segments of "
        f"{learned.path}: put a copy there, say where it lies now (motiondb compact --db "
        f"{learned.path} --motions-to PLACE), or make them anew (motiondb learn --db "
        f"{learned.path})."
    )
    with pytest.raises(StoreError) as error:
        store.load_scores(learned)
    assert str(error.value) == sentence
    assert store.check_quickly(learned) == []
    assert store.check_store(learned, sources=True) == [sentence]
    store.check_places(learned)  # what is rescued has no scores
    learn(learned, samples, seed=1)
    assert store.check_store(learned, sources=True) == []
    assert store.move_motions(learned, str(tmp_path / "new")) == 3


def test_damaged_scores_are_told_and_the_others_are_moved(
    learned: store.Store, tmp_path: Path
) -> None:
    store.move_motions(learned, str(tmp_path / "out"))
    before, file = bits(learned), score_files(learned)[0]
    start = learned.connection.value(
        "SELECT scores_at.start FROM segment_score WHERE capture_id = 1"
    )
    data = bytearray(Path(file.path).read_bytes())
    data[start + 5] ^= 1
    Path(file.path).write_bytes(data)
    learned.local.block = None
    sentence = (
        f"{file.path}: expected the bytes of the scores of the capture a as they were written, "
        f"found others. {parquet_files.advice(learned, file)}"
    )
    with pytest.raises(DamagedFileError) as error:
        store.load_scores(learned)
    assert str(error.value) == sentence
    assert not isinstance(error.value, DamagedMotionError)  # answers are not given without it
    assert set(store.load_scores(learned, [2, 3])) == {2, 3}
    of_file, of_capture = store.check_store(learned)
    assert of_file.startswith(f"{file.path}: expected the digest {file.sha256[:12]}, found ")
    assert of_capture == sentence
    with pytest.raises(StoreError) as error:
        store.move_motions(learned, moving.IN_DATABASE)
    assert str(error.value) == (
        f"{learned.path}: expected motions, originals and scores as they were written, found "
        "others of the captures a. What is damaged of them stays where it is. Of 2 captures, all "
        "was moved. Put "
        "a copy of the damaged files in their place, or remove these captures; scores are made "
        "anew by motiondb learn."
    )
    assert store.load_parquet_files(learned) == [file]
    data[start + 5] ^= 1
    Path(file.path).write_bytes(data)  # a copy in its place
    assert bits(learned) == before
    assert store.move_motions(learned, moving.IN_DATABASE) == 1
    shutil.rmtree(tmp_path / "out")
    learned.local.block = None
    assert bits(learned) == before


def test_scores_of_version_6_come_to_today(learned: store.Store, tmp_path: Path) -> None:
    before = bits(learned)
    learned.connection.execute("ALTER TABLE segment_score DROP scores_at")
    for table in ("known_file", "finding", "capture_quality"):
        learned.connection.execute(f"DROP TABLE {table}")
    learned.connection.execute("UPDATE meta SET value = '6' WHERE key = 'schema'")
    learned.close()
    with store.open_store(learned.path) as newer:
        assert bits(newer) == before
        assert store.check_store(newer) == []
        store.move_motions(newer, str(tmp_path / "out"))
        assert bits(newer) == before
