"""Drift: shares by hand, and what a database says after it changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import AddSettings, store
from motiondb.learn import drift
from motiondb.records import FloatArray, SegmentTable


def table_of(ids: list[int], explained: FloatArray, lengths: list[int]) -> SegmentTable:
    ends = np.cumsum(lengths)
    none = np.zeros((len(ids), 1), dtype=np.float32)
    numbers = np.array(ids)
    return SegmentTable(
        numbers, ends - lengths, ends, numbers * 0, explained, explained - 1.0, none
    )


def test_baseline_by_hand() -> None:
    """Twenty segments of 10 frames: the worst twentieth of the motion is one of them."""
    explained = np.arange(20.0)
    baseline = drift.fit_baseline(table_of([3] * 10 + [5] * 10, explained, [10] * 20))
    assert baseline.captures.tolist() == [3, 5]
    assert (baseline.mean, baseline.worst, baseline.frames) == (9.5, 0.0, 200.0)


def test_nothing_changed_is_no_drift(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        drift_now = db.symbols.drift()
        assert drift_now is not None
        assert not drift_now.relearn
        assert (drift_now.captures_added, drift_now.captures_removed, drift_now.words) == (0, 0, ())
        assert (drift_now.strange, drift_now.new_words, drift_now.turnover) == (0.0, 0.0, 0.0)
        assert store.learning_is_current(db.store)


def test_new_words_make_learning_worthwhile(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        db.words.set("ana/walk_1", "moonwalk")
        few = db.symbols.drift()
        assert few is not None
        assert few.words == ("moonwalk",)
        assert not few.relearn
        assert 0 < few.new_words < drift.NEW_WORDS
        db.words.set("ana/run_1", " ".join(["zorb"] * 200))
        many = db.symbols.drift()
        assert many is not None
        assert many.relearn
        assert many.reasons == (
            f"{many.new_words:.0%} of all words in captions are new (moonwalk, zorb)",
        )


def test_turnover_counts_what_came_and_what_went(learned_copy: Path, some: Path) -> None:
    with motiondb.open(learned_copy) as db:
        seconds = sum(i.motion_frames for i in db.captures()) / 30
        gone = db.captures("performer=ana")
        db.captures.remove([info.name for info in gone])
        drift_now = db.symbols.drift()
        assert drift_now is not None
        assert drift_now.captures_removed == len(gone)
        assert drift_now.turnover == pytest.approx(
            sum(i.motion_frames for i in gone) / 30 / seconds
        )
        db.add(some / "ana")
        again = db.symbols.drift()
        assert again is not None
        assert (again.captures_added, again.captures_removed) == (2, len(gone))
        assert again.turnover > drift_now.turnover
        assert again.strange <= 0.5  # it learned from these very motions
        assert again.seconds_added == pytest.approx(
            sum(i.motion_frames for i in db.captures() if "/" not in i.name) / 30
        )


def test_motion_of_another_kind_is_strange(learned_copy: Path, some: Path) -> None:
    """A performer hanging head down, shaking."""
    with motiondb.open(learned_copy) as db:
        rng = np.random.default_rng(0)
        text = (some / "ana/jump_1.bvh").read_text().splitlines()
        first = next(n for n, line in enumerate(text) if line.startswith("Frame Time")) + 1
        for n in range(first, len(text)):
            values = np.array(text[n].split(), dtype=float)
            values[3:] += 40 * np.sin(n / 3 + rng.permutation(len(values) - 3))
            text[n] = " ".join(f"{v:.4f}" for v in values)
        (some / "shaking.bvh").write_text("\n".join(text))
        db.add(some / "shaking.bvh", settings=AddSettings(keep_implausible=True))
        drift_now = db.symbols.drift()
        assert drift_now is not None
        assert drift_now.strange > 0.9
        assert drift_now.explained_less > 5.0


def test_a_database_that_has_not_learned_has_no_drift(tmp_path: Path) -> None:
    with motiondb.open(tmp_path / "new.duckdb") as db:
        assert db.symbols.drift() is None
