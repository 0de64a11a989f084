"""Four captures, and two dances with the grammars learned from them."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dances import SETTINGS, TAKES
from sample_motions import copied_samples

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.grammar.cfg import context_free


@pytest.fixture
def base(tmp_path: Path, some: Path) -> Iterator[MotionDB]:
    """A database of four captures, which a test may change."""
    with motiondb.open(tmp_path / "motions.duckdb") as db:
        db.add(some)
        yield db


@pytest.fixture(scope="session")
def learned_dance(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two dances and a third capture, and the grammar of the dances."""
    folder = tmp_path_factory.mktemp("dances")
    captures, words = copied_samples(folder, TAKES, ["fatou/dance_1"])
    path = folder / "motions.duckdb"
    with motiondb.open(path) as db:
        db.add(captures, words=words)
        db.grammars.learn(TAKES, "dance", SETTINGS)
        _keep_nested_grammar(db)
    return path


def _keep_nested_grammar(db: MotionDB) -> None:
    """The grammar "nested": each take of "dance" one sentence of three parts, to be exchanged."""
    learned = db.grammars.load("dance")
    edges = [np.flatnonzero(learned.terminals.takes == take)[[0, -1]] + [0, 1] for take in (0, 1)]
    strings = [learned.string(int(first), int(end)) for first, end in edges]
    thirds = [(s[: 6 + n], s[6 + n : -3 - n], s[-3 - n :]) for n, s in enumerate(strings)]
    rules = [context_free.Rule("S", ("A", "B")), context_free.Rule("B", ("C", "D"))]
    rules += [context_free.Rule(left, t[k], 0.5) for k, left in enumerate("ACD") for t in thirds]
    nested = replace(
        learned,
        name="nested",
        grammar=context_free.Grammar("S", tuple(rules), learned.terminals.names),
        sentences=np.array(edges),
        parses=tuple((0, 2 + take, 1, 4 + take, 6 + take) for take in (0, 1)),
    )
    with store.transaction(db.store):
        run_id = store.start_run(db.store, "grammar", {"name": "nested"})
        store.save_grammar(db.store, nested.stored, run_id)
        store.finish_run(db.store, run_id)


@pytest.fixture
def dances(tmp_path: Path, learned_dance: Path) -> Iterator[MotionDB]:
    """A copy of the database that a test may change."""
    path = shutil.copy(learned_dance, tmp_path / "motions.duckdb")
    with motiondb.open(path) as opened:
        yield opened


@pytest.fixture(scope="module")
def asked_dances(learned_dance: Path) -> Iterator[MotionDB]:
    """The database itself: only ask it."""
    with motiondb.open(learned_dance, read_only=True) as opened:
        yield opened
