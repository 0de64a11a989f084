"""Threads of one program and processes of a shell that ask and change at once, without a refusal.

Sixteen threads share one open database: ten ask (search, like, describe, list), the others set
words, add and remove captures, import events, and one learns. Twenty processes are commands that
are started at the same moment, some of which write. Every answer is compared with facts that do not
depend on the other threads; a message of any kind is a failure.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from motiondb import LearnSettings, MotionDB
from robustness_tasks.databases import copy_captures

ROUNDS = 5
"""How often threads and processes meet."""
TURNS = 6
"""Questions, or changes, of one thread in a round; the one that learns does so twice."""
PATIENCE = 900.0
"""Seconds after which a process or thread counts as hanging. Chosen by hand; not tuned."""


@dataclass(frozen=True)
class Outcome:
    """How one thread or process fared: ``done`` of its turns, and messages that it got."""

    kind: str
    done: int
    messages: tuple[str, ...]

    @property
    def is_failure(self) -> bool:
        """Whether there was any message."""
        return bool(self.messages)


def run(database: Path) -> Iterator[Outcome]:
    """Threads and processes meet several times."""
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(shutil.copy(database, Path(folder) / "motions.duckdb"))
            yield from _threads(copy, copy_captures(("ana/wave_1",), Path(folder) / "more"))
            yield _checked(copy, "check after threads")
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(shutil.copy(database, Path(folder) / "motions.duckdb"))
            yield from _processes(copy, copy_captures(("ana/wave_1",), Path(folder) / "more"))
            yield _checked(copy, "check after processes")


def _threads(path: Path, more: Path) -> list[Outcome]:
    """Sixteen threads on one open database."""
    outcomes: list[Outcome] = []
    with MotionDB(path) as db:
        asks = (_search, _like, _describe, _list)
        turns: list[tuple[str, Callable[[MotionDB, int], None], int]] = [
            (f"thread: {ask.__name__[1:]}", ask, TURNS) for ask in (*asks, *asks, *asks[:2])
        ]
        turns += [("thread: words set", _set_words(n), TURNS) for n in range(3)]
        turns += [("thread: add and remove", _add_and_remove(more), 2)]
        turns += [("thread: events import", _import_events(more), TURNS)]
        turns += [("thread: learn", _learn, 2)]
        gate = threading.Barrier(len(turns))

        def work(kind: str, turn: Callable[[MotionDB, int], None], times: int) -> None:
            done, messages = 0, []
            gate.wait()
            for number in range(times):
                try:
                    turn(db, number)
                    done += 1
                except Exception as error:
                    messages.append(f"{type(error).__name__}: {error}"[:400])
            outcomes.append(Outcome(kind, done, tuple(messages)))

        threads = [threading.Thread(target=work, args=each) for each in turns]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
        if any(thread.is_alive() for thread in threads):
            outcomes.append(Outcome("thread", 0, (f"no end after {PATIENCE:g} s",)))
    return outcomes


def _search(db: MotionDB, _turn: int) -> None:
    _expect(len(db.search("walk").matches) > 0, "search finds nothing")


def _like(db: MotionDB, _turn: int) -> None:
    match = db.like("boris/kick_1").matches[0]
    _expect(match.capture == "boris/kick_1", f"like finds {match.capture} first")


def _describe(db: MotionDB, _turn: int) -> None:
    _expect(len(db.describe("ana/walk_1")) > 0, "describe says nothing")


def _list(db: MotionDB, _turn: int) -> None:
    names = {info.name for info in db.captures()}
    _expect({"ana/bow_1", "ana/walk_1", "kept"} <= names, f"list has {sorted(names)}")


def _set_words(number: int) -> Callable[[MotionDB, int], None]:
    name = ("ana/bow_1", "ana/jump_1", "boris/long_2")[number]

    def turn(db: MotionDB, turn: int) -> None:
        words = f"walk and jump {'again ' * turn}".strip()
        db.words.set(name, words)
        _expect(db.words.captions(name)[0].words == words, f"the words of {name} are others")

    return turn


def _add_and_remove(more: Path) -> Callable[[MotionDB, int], None]:
    def turn(db: MotionDB, _turn: int) -> None:
        report = db.add(more, words=more / "captions.tsv")
        _expect(len(report.problems) == 0, f"add: {report.problems}")
        db.captures.remove(["ana/wave_1"])

    return turn


def _import_events(more: Path) -> Callable[[MotionDB, int], None]:
    sheet = more.parent / "events.tsv"
    sheet.write_text("file\tframe\tevent\tjoint\nana/walk_1\t12\tfoot_strike\tl_ankle\n")

    def turn(db: MotionDB, _turn: int) -> None:
        db.captures.import_events(sheet)
        _expect(len(db.captures.events("ana/walk_1")) == 1, "the event is not there")

    return turn


def _learn(db: MotionDB, turn: int) -> None:
    db.learn(LearnSettings(n_symbols=3, seed=turn))


def _expect(holds: bool, otherwise: str) -> None:
    if not holds:
        raise AssertionError(otherwise)


def _processes(path: Path, more: Path) -> Iterator[Outcome]:
    """Twenty commands at the same moment."""
    words: list[tuple[str, ...]] = [("learn", "--symbols", "3"), ("add", str(more))]
    words += [("words", "set", f"ana/{name}_1", name) for name in ("bow", "jump", "walk")]
    words += [("search", "walk")] * 5 + [("like", "boris/kick_1")] * 4
    words += [("describe", "ana/walk_1")] * 3 + [("list",)] * 3
    program = [sys.executable, "-c", "from motiondb.cli.main import main; main()"]
    began = time.monotonic()
    started = [
        subprocess.Popen(
            [*program, *each, "--db", str(path), "--wait", str(PATIENCE)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for each in words
    ]  # fmt: skip
    for each, process in zip(words, started):
        _, complaint = process.communicate(timeout=max(1.0, PATIENCE - time.monotonic() + began))
        done = process.returncode == 0
        told = "" if done else complaint.strip()[-400:] or f"ended with {process.returncode}"
        yield Outcome(f"process: {' '.join(each[:2]) if 'set' in each else each[0]}", int(done),
                      (told,) if told else ())  # fmt: skip


def _checked(path: Path, kind: str) -> Outcome:
    """What ``check`` finds in the end."""
    with MotionDB(path, read_only=True) as db:
        faults = db.check()
    return Outcome(kind, 1, tuple(faults))
