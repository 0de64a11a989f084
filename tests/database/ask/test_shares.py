"""Many questions to shares of the captures: the answers of one place, in the same order.

On processors with AVX they are the same to the last bit; the bound holds on any.
"""

from __future__ import annotations

import pickle
import re
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb import MotionDB, Question
from motiondb.database import asking_many, asking_openers
from motiondb.learn import shares as learned_shares
from motiondb.search import asking, by_words
from motiondb.search.takings import Sentence

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


class Others:
    """Workers that share nothing with this process but files: whatever they get is pickled."""

    def __init__(self, n_workers: int, *, can_open: bool) -> None:
        self.n_workers, self._can_open, self.n_sent = n_workers, can_open, list[int]()

    def n_pieces(self, _seconds: float = 0.0) -> int:
        return self.n_workers

    def agree(self, ask: Callable[..., bool], /, *given: object) -> bool:
        return self._can_open and bool(ask(*given))

    def map(
        self, work: Callable[..., Any], pieces: Iterable[Any], *shared: object
    ) -> Iterator[Any]:
        for piece in pieces:
            sent = pickle.dumps((piece, shared))
            self.n_sent.append(len(sent))
            there, rest = pickle.loads(sent)
            yield pickle.loads(pickle.dumps(work(there, *rest)))


def asked(db: MotionDB, workers: Others | None) -> list[str]:
    """Answers to the questions."""

    def motion_of(question: Question) -> motiondb.Motion:
        return db.motion(question.like, question.start, question.end)

    return list(map(repr, asking_many.ask_many(db.session, motion_of, QUESTIONS, workers)))


NUMBER = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")


def assert_same(found: list[str], here: list[str]) -> None:
    """That answers are the same, with numbers that differ by less than 1e-6."""
    for one, other in zip(found, here, strict=True):
        assert NUMBER.sub("#", one) == NUMBER.sub("#", other)
        numbers = [[float(text) for text in NUMBER.findall(each)] for each in (one, other)]
        np.testing.assert_allclose(*numbers, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("n_workers", "can_open"), [(1, False), (3, False), (40, False), (500, False), (3, True)]
)
def test_shares_answer_as_one_place_does(
    n_workers: int, can_open: bool, learned_file: Path
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        here = asked(db, None)
        assert_same(asked(db, Others(n_workers, can_open=can_open)), here)
    assert not asking_openers._lent


def test_near_words_are_asked_of_shares_too(
    learned_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def near(asked: Sentence, _: object) -> Sentence:
        return Sentence(asked.learned, "kick, jump")

    monkeypatch.setattr(asking, "near_sentence", near)
    monkeypatch.setattr(by_words.WordAnswer, "nothing", property(_nothing_but_jumps))
    with motiondb.open(learned_file, read_only=True) as db:
        here = asked(db, None)
        assert "near=('kick', 'kick, then jump')" in here[0]
        assert_same(asked(db, Others(3, can_open=False)), here)


def _nothing_but_jumps(answer: by_words.WordAnswer) -> str:
    return "" if "jump" in answer.understood else "nothing"


def test_what_is_sent_is_the_share_of_each_and_steps(learned_file: Path) -> None:
    one, four = Others(1, can_open=False), Others(4, can_open=False)
    with motiondb.open(learned_file, read_only=True) as db:
        for workers in (one, four):
            asked(db, workers)
        learned, pool = db.session.searchable, db.session.features
    whole = learned.heard.odds.nbytes + pool.features.nbytes
    rest = min(one.n_sent) - whole
    assert max(four.n_sent) - rest < 0.5 * whole


def test_generated_captures_are_in_shares_too(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        made = db.generate("a person kicks", seed=3)
        db.captures.save_generated("made/kick", "a person kicks", made, 3)
        here = asked(db, None)
        assert any("made/kick" in answer for answer in here)
        assert_same(asked(db, Others(3, can_open=True)), here)  # sent: it is open to be written


def test_runs_of_captures_have_about_equal_lengths(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        learned = db.session.searchable
    runs = learned_shares.divided(learned, 4)
    assert [capture for run in runs for capture in run] == list(learned.rows)
    lengths = [sum(learned.captures[c].motion_frames for c in run) for run in runs]
    longest = max(learned.captures[c].motion_frames for c in learned.rows)
    assert max(lengths) - min(lengths) <= 2 * longest
    assert len(learned_shares.divided(learned, 10_000)) == len(learned.rows)


def test_rows_of_other_shares_are_refused() -> None:
    rows = learned_shares.RowsFrom(2, np.arange(6.0).reshape(3, 2), 9)
    assert len(rows) == 9
    assert rows[3:5].tolist() == [[2.0, 3.0], [4.0, 5.0]]
    assert rows[np.array([4, 2])].tolist() == [[4.0, 5.0], [0.0, 1.0]]
    assert len(rows[7:7]) == len(rows[np.zeros(0, np.int64)]) == 0
    for elsewhere in (slice(1, 3), slice(4, 6), np.array([2, 5])):
        with pytest.raises(IndexError, match="expected rows of this share, found others"):
            rows[elsewhere]


def test_a_worker_refuses_another_database_than_the_one_that_asks(
    learned_file: Path, tmp_path: Path
) -> None:
    for path, reason in (
        (learned_file, "another state"),
        (tmp_path / "none.duckdb", "no such file"),
    ):
        file = asking_openers.DatabaseFile(path, "of another database")
        assert not asking_openers.can_open(file)
        with (
            pytest.raises(motiondb.ClusterError, match=f"expected a database that every.*{reason}"),
            file.searched(),
        ):
            pass
    asking_openers._lent.clear()


def test_a_worker_answers_from_the_database_that_is_there_now(
    learned_file: Path, tmp_path: Path
) -> None:
    path, names = tmp_path / "m.duckdb", list[str]()
    for name in ("one", "other"):  # as many changes, so that the numbers of the states are the same
        shutil.copy(learned_file, path)
        with motiondb.open(path) as db:
            db.captures.rename("ana/bow_1", name)
        with motiondb.open(path, read_only=True) as db, db.session.reading():
            file = asking_openers.DatabaseFile.of(db.session)
        with file.searched() as searched:
            names += [info.name for info in searched.learned.captures.values()]
    assert {"one", "other"} <= set(names)
    assert list(asking_openers._lent) == [file]
    asking_openers.close(file)
    assert not asking_openers._lent
