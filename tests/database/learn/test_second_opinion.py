"""The map from pooled statistics and the calibration of told words: learned and kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import motiondb
from motiondb.database import MotionDB
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.language import vocabulary
from motiondb.meaning.score_vectors import unit
from motiondb.search.described import word_probabilities

SAMPLE = Path(__file__).parents[3] / "sample_data"


def naive_statistics(frames: np.ndarray) -> np.ndarray:
    x = frames.astype(np.float64)
    quantiles = [np.quantile(x, share, axis=0) for share in (0.1, 0.5, 0.9)]
    return np.concatenate([x.mean(axis=0), x.std(axis=0), *quantiles])


def described(db: MotionDB) -> tuple[np.ndarray, np.ndarray]:
    """Statistics and words of every described interval, capture by capture."""
    learned, rows = db.learned, {}
    for number, captions in learned.captions.items():
        frames = db.session.pool.whitened(number)
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


def test_adding_and_removing_leave_both_as_they_are(learned_copy: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.bvh"
    again.write_text((SAMPLE / "captures/ana/walk_1.bvh").read_text() + "\n")
    (tmp_path / "words.tsv").write_text("file\twords\nagain.bvh\twalks slowly\n")
    with motiondb.open(learned_copy) as db:
        before = db.learned
        vectors = unit(np.random.default_rng(0).normal(size=(2, len(db.learned.score_space.mean))))
        told = word_probabilities(db.learned, vectors)
        db.add(again, tmp_path / "words.tsv", AddSettings(jobs=1))
        assert not np.array_equal(
            word_probabilities(db.learned, vectors), told
        )  # the new caption takes part
        db.captures.remove(["again"])
        after = db.learned
        np.testing.assert_array_equal(word_probabilities(db.learned, vectors), told)
    np.testing.assert_array_equal(after.description_calibration, before.description_calibration)
    assert after.pooled is not None
    assert before.pooled is not None
    np.testing.assert_array_equal(after.pooled.weights, before.pooled.weights)
