"""Many questions to workers that open the database: the answers of this process, in its order."""

from __future__ import annotations

import pickle
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb import Cluster, ClusterError, MotionDB, Question
from motiondb.database import questions as asked_of

QUESTIONS = (
    Question("kick"),
    Question("walk, turn left, sit down", limit=40),
    Question("walk but not run"),
    Question("wave or clap", limit=2),
    Question("jump twice"),
    Question("walk in place for 2 seconds"),
    Question("saunter"),  # known words stand for it
    Question("lumber along"),  # heard by its meaning
    Question("xqzzy"),
    Question("kick", where="performer=ana"),
    Question("kick", where="name=ana/bow_1"),
    Question(like="ana/bow_1", limit=3),
    Question(like="ana/long_1", start=0.5, end=2.5, limit=40),
    Question(like="ana/kick_1", where="performer=boris"),
)


class Others(Cluster):
    """Workers that share nothing with this process but files: whatever they get is pickled."""

    def __init__(self) -> None:
        pass

    def n_pieces(self, _seconds: float = 0.0) -> int:
        return 3

    def each(self, ask: Callable[..., Any], /, *given: object) -> dict[str, Any]:
        return {"tcp://w:1": ask(*pickle.loads(pickle.dumps(given)))}

    def map(
        self, work: Callable[..., Any], pieces: Iterable[Any], *shared: object, **_: object
    ) -> Iterator[Any]:
        for piece in pieces:
            there, rest = pickle.loads(pickle.dumps((piece, shared)))
            yield pickle.loads(pickle.dumps(work(there, *rest)))


def asked(db: MotionDB, workers: Others | None) -> list[str]:
    """Answers to the questions."""
    return list(map(repr, db.ask_many(QUESTIONS, workers)))


def test_workers_answer_as_this_process_does(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        made = db.generate("a person kicks", seed=3)
        db.save_generated("made/kick", "a person kicks", made, 3)
    with motiondb.open(learned_copy, read_only=True) as db:
        here = asked(db, None)
        assert any("made/kick" in answer for answer in here)
        assert asked(db, Others()) == here
    assert not asked_of._lent


def test_a_database_that_workers_cannot_open_is_refused(
    learned_copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (
        motiondb.open(learned_copy) as db,
        pytest.raises(ClusterError, match=r"found one that this process may change.*read_only"),
    ):
        asked(db, Others())
    with motiondb.open(learned_copy, read_only=True) as db:
        monkeypatch.setattr(Others, "each", lambda *_: {"tcp://w:1": "m: expected a file."})
        with pytest.raises(ClusterError) as error:
            asked(db, Others())
    assert str(error.value) == (
        f"tcp://w:1: expected a worker that can open {learned_copy}, found one that cannot (m: "
        "expected a file). Put the database or a copy of it, with its cache, into a folder that "
        "all workers see under the same path, and ask it there."
    )


def test_a_worker_refuses_another_database_than_the_one_that_asks(
    learned_file: Path, tmp_path: Path
) -> None:
    for path, reason in (
        (learned_file, "another state"),
        (tmp_path / "none.duckdb", "no such file"),
    ):
        file = asked_of.DatabaseFile(path, "of another database")
        assert reason in asked_of.why_not_opened(file)
        with pytest.raises(ClusterError, match=f"expected a database that every.*{reason}"):
            asked_of._answer_some([], file)
    asked_of._lent.clear()


def test_a_worker_needs_the_cache_of_the_database(learned_copy: Path) -> None:
    shutil.rmtree(f"{learned_copy}.cache")
    with motiondb.open(learned_copy, read_only=True) as db, db.session.reading():
        file = asked_of.DatabaseFile(learned_copy, asked_of._state(db.session.store))
    assert "expected its cache beside it, found none" in asked_of.why_not_opened(file)
    asked_of.close(file)


def test_a_worker_answers_from_the_database_that_is_there_now(
    learned_file: Path, tmp_path: Path
) -> None:
    path, names = tmp_path / "m.duckdb", list[str]()
    for name in ("one", "other"):  # as many changes, so that the numbers of the states are the same
        shutil.copy(learned_file, path)
        with motiondb.open(path) as db:
            db.rename("ana/bow_1", name)
        with motiondb.open(path, read_only=True) as db, db.session.reading():
            file = asked_of.DatabaseFile(path, asked_of._state(db.session.store))
        with asked_of._opened(file) as session:
            names += [info.name for info in session.searchable.captures.values()]
    assert {"one", "other"} <= set(names)
    assert list(asked_of._lent) == [file]
    asked_of.close(file)
    assert not asked_of._lent
