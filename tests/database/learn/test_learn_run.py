"""What learning stores: segments that tile, likeliest symbols, the same in every process."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from dataclasses import fields
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.body.features import N_FEATURES
from motiondb.errors import MotionDBError
from motiondb.learn import recognition
from motiondb.learn.recognition import FeaturePool, LearnSettings
from motiondb.records import Float32Array, IntArray, MotionSymbols, SegmentTable
from motiondb.symbols.acquisition import AcquisitionSettings, Cutting

LEARN_AND_DIGEST = """
import hashlib, sys
import motiondb
from motiondb.learn.recognition import LearnSettings
with motiondb.open(sys.argv[1]) as db:
    found = db.learn(LearnSettings(seed=5))
digest = hashlib.sha256()
for part in (found.segments.starts, found.segments.symbols, found.segments.scores,
             found.symbols.means, found.symbols.covars, found.symbols.self_loops):
    digest.update(part.tobytes())
print(digest.hexdigest())
"""


@pytest.fixture(scope="module")
def table(learned_file: Path) -> SegmentTable:
    with motiondb.open(learned_file, read_only=True) as db:
        return store.load_segments(db.store)


def test_every_symbol_wins_and_is_left_to_right(learned_file: Path, table: SegmentTable) -> None:
    """A3, A4: no idle symbol stays; every state is left for the next."""
    with motiondb.open(learned_file, read_only=True) as db:
        symbols, lengths = db.learned.symbols, db.learned.description_lengths
    np.testing.assert_array_equal(np.unique(table.symbols), np.arange(symbols.n_symbols))
    real = np.arange(symbols.self_loops.shape[1]) < symbols.n_states[:, None]
    assert np.all((symbols.self_loops[real] > 0) & (symbols.self_loops[real] < 1))
    assert np.all(np.diff(lengths) < 0)


def test_two_symbols_tie_to_the_lowest() -> None:
    one = MotionSymbols(
        np.ones(2, dtype=np.int64), np.full((2, 1), 0.5), np.zeros((2, 1, 1)), np.ones((2, 1, 1))
    )
    pool = pool_of([6])
    cutting = Cutting(*(np.array(c) for c in ([0, 3], [3, 6], [0, 0])))
    actual = recognition.segment_table(pool.features[:, :1], pool, one, cutting)
    np.testing.assert_array_equal(actual.symbols, [0, 0])
    np.testing.assert_array_equal(actual.scores[:, 0], actual.scores[:, 1])


def pool_of(n_rows: list[int], odd: int = 0) -> FeaturePool:
    """Captures 7, 8, ... of so many rows of zeros; 2 frames of motion a row, less ``odd``.

    The whitened frames are one of the columns.
    """
    bounds = np.concatenate([[0], np.cumsum(n_rows)])
    features: Float32Array = np.zeros((bounds[-1], N_FEATURES), dtype=np.float32)
    ids: IntArray = np.arange(7, 7 + len(n_rows))
    return FeaturePool(ids, bounds, features, 2 * np.array(n_rows) - odd)


def test_frames_of_the_table_are_frames_of_the_motion() -> None:
    """Rows run at 15 a second, motions at 30; a motion with an odd number ends a frame early."""
    one = MotionSymbols(
        np.ones(1, dtype=np.int64), np.full((1, 1), 0.5), np.zeros((1, 1, 1)), np.ones((1, 1, 1))
    )
    pool = pool_of([4, 5], odd=1)
    cutting = Cutting(*(np.array(c) for c in ([0, 4, 6], [4, 6, 9], [0, 0, 0])))
    actual = recognition.segment_table(pool.features[:, :1], pool, one, cutting)
    np.testing.assert_array_equal(actual.capture_ids, [7, 8, 8])
    np.testing.assert_array_equal(actual.starts, [0, 0, 4])
    np.testing.assert_array_equal(actual.ends, [7, 4, 9])


def test_background_by_hand() -> None:
    """-(x^2 + y^2) / 2 - ln 2 pi, a frame's mean: x = 0, 2 and y = 0, 1 make -1.25 - ln 2 pi."""
    frames = np.array([[0.0, 0.0], [2.0, 1.0], [3.0, 0.0]], dtype=np.float32)
    actual = recognition.background(frames, np.array([0, 2]), np.array([2, 3]))
    np.testing.assert_allclose(actual, np.array([-1.25, -4.5]) - 1.8378770664)


def test_what_is_stored_is_what_was_learned_and_by_which_run(tmp_path: Path, some: Path) -> None:
    chosen = LearnSettings(seed=4, acquisition=AcquisitionSettings(n_states=3))
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        db.words.set("ana/bow_1", "bow")
        learned = db.learn(chosen)
        for _ in range(2):
            stored = db.learned.segments
            for part in fields(SegmentTable):
                np.testing.assert_array_equal(
                    getattr(stored, part.name), getattr(learned.segments, part.name)
                )
            # scores then come from the file, movement from the motions
            shutil.rmtree(tmp_path / "m.duckdb.cache")
            db.captures.set_tags({"seen": "yes"}, ["ana/bow_1"])  # so that all is loaded anew
        runs = {run.run_id: run for run in store.load_runs(db.store)}
        run = runs[learned.run_id]
        assert (run.kind, run.seed) == ("learn", 4)
        assert run.finished is not None
        assert run.parameters["acquisition"]["n_states"] == 3
        assert set(learned.symbols.n_states.tolist()) == {3}


def test_a_failed_learning_leaves_the_last_one(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        before = db.learn()
        with pytest.raises(MotionDBError, match="Ask for fewer symbols"):
            db.learn(LearnSettings(n_symbols=10_000))
        after = store.load_segments(db.store)
        np.testing.assert_array_equal(after.scores, before.segments.scores)
        assert db.check() == []


def test_generated_captures_teach_nothing(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        db.words.set("ana/bow_1", "bow")
        first = db.learn()
        made = db.generate("bow", 1)
        info = db.captures.save_generated("made/bow", "bow", made, 1)
        again = db.learn()
        assert info.capture_id not in again.segments.capture_ids
        np.testing.assert_array_equal(again.symbols.means, first.symbols.means)
        np.testing.assert_array_equal(again.segments.scores, first.segments.scores)


def test_processes_and_thread_counts_learn_the_same(
    tmp_path: Path, some: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.duckdb"
    with motiondb.open(path) as db:
        db.add(some)
        learned = db.learn(LearnSettings(seed=5))
    digest = hashlib.sha256()
    table, symbols = learned.segments, learned.symbols
    for part in (table.starts, table.symbols, table.scores,
                 symbols.means, symbols.covars, symbols.self_loops):  # fmt: skip
        digest.update(part.tobytes())
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        monkeypatch.setenv(name, "1" if name.startswith("NUMBA") else "2")
    run = subprocess.run(
        [sys.executable, "-c", LEARN_AND_DIGEST, str(path)],
        capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    assert run.stdout.split() == [digest.hexdigest()]


def test_progress_names_every_step_in_order(tmp_path: Path, some: Path) -> None:
    told: list[str] = []
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        db.learn(progress=lambda what, _share: told.append(what))
    steps = [what for what, after in pairwise([*told, ""]) if what != after]
    wanted = "features, symbols compete, cutting anew, scoring, symbol space, words, saving"
    assert steps == wanted.split(", ")
