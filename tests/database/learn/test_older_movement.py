"""A database that learned before there were posture and travel: asked and added to as before."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.meaning.movement import N_POSTURE, N_TRAVEL

SAMPLE = Path(__file__).parents[3] / "sample_data"
LATER = N_POSTURE + N_TRAVEL


@pytest.fixture
def older(learned_copy: Path) -> Path:
    """What was learned, without the columns of posture and travel, their sums and their weights."""
    with motiondb.open(learned_copy) as db, store.transaction(db.store):
        learning = store.load_learning(db.store)
        table = replace(learning.segments, movement=learning.segments.movement[:, :-LATER])
        parameters = dict(learning.parameters)
        for name in (
            "score_mean",
            "score_spread",
            "moment_vectors",
            "moment_cross",
            "word_weights",
        ):
            parameters[name] = parameters[name][:-LATER]
        for name in ("moment_caption_words", "moment_caption_cross"):  # later still
            parameters.pop(name)
        parameters["moment_gram"] = parameters["moment_gram"][:-LATER, :-LATER]
        store.save_learning(db.store, replace(learning, segments=table, parameters=parameters))
    return learned_copy


def test_it_answers_by_words_by_example_and_describes(older: Path) -> None:
    with motiondb.open(older, read_only=True) as db:
        name = db.search("walk").matches[0].capture
        assert db.like(name)[0].capture == name
        assert db.describe(name)[0].words


def test_what_is_added_has_as_many_columns_and_leaves_no_trace(older: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.bvh"
    again.write_text((SAMPLE / "captures/ana/walk_1.bvh").read_text() + "\n")
    (tmp_path / "words.tsv").write_text("file\twords\nagain.bvh\twalks slowly\n")
    with motiondb.open(older) as db:
        before = store.load_learning(db.store)
        report = db.add(again, tmp_path / "words.tsv", AddSettings(jobs=1))
        assert (report.added, report.counted) == (("again",), 1)
        learning = store.load_learning(db.store)
        assert learning.segments.movement.shape[1] == before.segments.movement.shape[1] == 540
        assert np.any(learning.parameters["moment_gram"] != before.parameters["moment_gram"])
        db.remove(["again"])
        after = store.load_learning(db.store)
    for name in ("vectors", "words", "gram", "cross"):
        np.testing.assert_array_equal(
            after.parameters[f"moment_{name}"], before.parameters[f"moment_{name}"]
        )
