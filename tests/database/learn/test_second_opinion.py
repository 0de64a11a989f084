"""The map from pooled statistics and the calibration of told words: learned, kept, optional."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.language import vocabulary
from motiondb.meaning.description_map import score_probabilities
from motiondb.meaning.score_vectors import unit
from motiondb.search.described import word_probabilities

SAMPLE = Path(__file__).parents[3] / "sample_data"
LATER = (
    "pooled_centre",
    "pooled_spread",
    "pooled_mean",
    "pooled_weights",
    "description_calibration",
)


@pytest.fixture
def older(learned_copy: Path) -> Path:
    """What was learned, without both, as versions before this one left it."""
    with motiondb.open(learned_copy) as db, store.transaction(db.store):
        learning = store.load_learning(db.store)
        kept = {n: v for n, v in learning.parameters.items() if n not in LATER}
        assert len(kept) == len(learning.parameters) - len(LATER)
        store.save_learning(db.store, replace(learning, parameters=kept))
    return learned_copy


def naive_statistics(frames: np.ndarray) -> np.ndarray:
    x = frames.astype(np.float64)
    quantiles = [np.quantile(x, share, axis=0) for share in (0.1, 0.5, 0.9)]
    return np.concatenate([x.mean(axis=0), x.std(axis=0), *quantiles])


def described(db: MotionDB) -> tuple[np.ndarray, np.ndarray]:
    """Statistics and words of every described interval, capture by capture."""
    learned, rows = db.learned, {}
    for number, captions in learned.captions.items():
        frames = learned.feature_space.project(db.session.features.of_capture(number))
        for caption in captions:
            actions = vocabulary.split_actions(caption.words, learned.synonyms, learned.lemmas)
            words = [
                learned.word_numbers[w] for a in actions for w in a if w in db.learned.word_numbers
            ]
            if not words:
                continue
            start = int((caption.start or 0.0) * 15.0 + 1e-6)
            end = len(frames) if caption.end is None else int(np.ceil(caption.end * 15.0 - 1e-6))
            key = (number, caption.start, caption.end)
            said = rows.setdefault(
                key, (naive_statistics(frames[start:end]), np.zeros(len(learned.word_numbers)))
            )[1]
            said[words] = 1.0
    return tuple(np.stack(part) for part in zip(*rows.values()))


def test_it_is_fitted_to_the_described_intervals(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        pooled = db.learned.pooled
        assert pooled is not None
        statistics, presence = described(db)
    np.testing.assert_allclose(pooled.centre, statistics.mean(axis=0), atol=1e-6)
    p = unit((statistics - pooled.centre) / pooled.spread)
    t = unit(presence)
    p, t = p - p.mean(axis=0), t - t.mean(axis=0)
    weights = np.linalg.solve(p.T @ p + 0.3 * np.eye(p.shape[1]), p.T @ t)
    np.testing.assert_allclose(pooled.weights, weights, atol=1e-3)


def test_words_are_told_by_the_map_of_descriptions(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        learned = db.learned
        vectors = unit(np.random.default_rng(0).normal(size=(3, len(learned.score_space.mean))))
        assert learned.description_calibration is not None
        assert learned.description_map is not None
        np.testing.assert_array_equal(
            word_probabilities(learned, vectors),
            score_probabilities(
                learned.description_map.scores(vectors), learned.description_calibration
            ),
        )


def test_databases_that_learned_before_answer_as_before(older: Path) -> None:
    with motiondb.open(older, read_only=True) as db:
        learned = db.learned
        assert (learned.pooled, learned.description_calibration) == (None, None)
        vectors = unit(np.random.default_rng(0).normal(size=(3, len(learned.score_space.mean))))
        np.testing.assert_array_equal(
            word_probabilities(learned, vectors), learned.word_map.probabilities(vectors)
        )
        assert db.like("ana/bow_1")[0].capture == "ana/bow_1"
        assert db.describe("ana/bow_1")[0].words


def test_adding_and_removing_leave_both_as_they_are(learned_copy: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.bvh"
    again.write_text((SAMPLE / "captures/ana/walk_1.bvh").read_text() + "\n")
    (tmp_path / "words.tsv").write_text("file\twords\nagain.bvh\twalks slowly\n")
    with motiondb.open(learned_copy) as db:
        before = store.load_learning(db.store).parameters
        vectors = unit(np.random.default_rng(0).normal(size=(2, len(db.learned.score_space.mean))))
        told = word_probabilities(db.learned, vectors)
        db.add(again, tmp_path / "words.tsv", AddSettings(jobs=1))
        assert not np.array_equal(
            word_probabilities(db.learned, vectors), told
        )  # the new caption takes part
        db.remove(["again"])
        after = store.load_learning(db.store).parameters
        np.testing.assert_array_equal(word_probabilities(db.learned, vectors), told)
    for name in LATER:
        np.testing.assert_array_equal(after[name], before[name])


def test_a_second_opinion_changes_which_captures_are_alike(learned_file: Path, older: Path) -> None:
    """And only the order of captures: the interval within a capture is that of the motion."""
    with motiondb.open(learned_file, read_only=True) as db:
        now = {m.capture: m for m in db.like("ana/bow_1", limit=20)}
        by_motion = [m.score for m in db.like("ana/bow_1", limit=20, meaning=False)]
    with motiondb.open(older, read_only=True) as db:
        then = {m.capture: m for m in db.like("ana/bow_1", limit=20)}
        assert by_motion == [m.score for m in db.like("ana/bow_1", limit=20, meaning=False)]
    both = [name for name in now if name in then and name != "ana/bow_1"]
    assert any(now[name].score != then[name].score for name in both)
