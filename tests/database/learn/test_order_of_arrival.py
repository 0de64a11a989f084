"""Answers do not depend on the order in which the same captures and words arrived."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

import motiondb
from motiondb import AddSettings, LearnSettings, MotionDB

WORDS = {
    "ana/bow_1": "a person bows",
    "ana/jump_1": "jump, then walk",
    "boris/kick_1": "kick high",
    "boris/punch_1": "punch and kick",
}


def answers(db: MotionDB) -> list[tuple[object, float, float, tuple[float, ...]]]:
    """Capture, start, end, and score with probabilities, of everything that is found."""
    db.learn(LearnSettings(n_symbols=3))
    found = [*db.search("kick").matches, *db.search("bow, not jump").matches]
    found += db.like("ana/bow_1", 0.2, 1.4).matches
    rows = [(m.capture, m.start, m.end, (m.score, m.probability or 0.0)) for m in found]
    for name in WORDS:
        rows += [
            (tuple(w for w, _ in d.words), d.start, d.end, tuple(p or 0.0 for _, p in d.words))
            for d in db.describe(name)
        ]
    return rows


def test_answers_do_not_depend_on_the_order_of_arrival(some: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "words.tsv"
    sheet.write_text("file\twords\n" + "".join(f"{n}\t{w}\n" for n, w in WORDS.items()))
    with motiondb.open(tmp_path / "at_once.duckdb") as db:
        db.add(some, words=sheet)
        expected = answers(db)
    rng = np.random.default_rng(0)
    with motiondb.open(tmp_path / "by_and_by.duckdb") as db:
        for name in rng.permutation(sorted(WORDS)):
            one = tmp_path / name.replace("/", "_") / f"{name}.bvh"
            one.parent.mkdir(parents=True)
            shutil.copy(some / f"{name}.bvh", one)
            db.add(one.parents[1], settings=AddSettings(jobs=1))
        for name in rng.permutation(sorted(WORDS)):
            db.words.set(name, WORDS[name])
        found = answers(db)
    assert [row[0] for row in found] == [row[0] for row in expected]
    for row, other in zip(found, expected, strict=True):
        assert row[1:3] == other[1:3]
        np.testing.assert_allclose(row[3], other[3], atol=1e-6)
