"""SIGKILL at random moments of every command that writes; then: is everything there?

A case copies the small database, sets words of a capture (an acknowledged change), starts a command
and kills it after a random share of the time that it takes undisturbed. What must hold afterwards:

* the database opens and ``check`` finds nothing;
* its rows are those from before the command or those from after it, and the latter where the
  command had printed that it was done;
* files that the command writes are not there, or whole;
* after a further command no file is left that two undisturbed commands would not leave, and no
  process of the command goes on.

Commands run in processes that are forked from one in which motiondb is imported, so that the kills
meet the work and not the start of Python.
"""

from __future__ import annotations

import functools
import hashlib
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import numpy as np

from robustness_tasks.databases import GRAMMAR, SAMPLES, copy_captures

DB = "motions.duckdb"
MARK = ("words", "set", "ana/jump_1", "a marked jump", "--db", DB)
NEXT = ("words", "set", "ana/walk_1", "a later walk", "--db", DB)
LATEST = 1.1
"""Kills come at a random share of the undisturbed time, up to this one, so that some come late."""
PATIENCE = 600.0
"""Seconds after which a command counts as hanging, on a computer that does other work too."""

COMMANDS: dict[str, tuple[str, ...]] = {
    "add": ("add", "more", "--words", "more/captions.tsv"),
    "add one": ("add", "more/ana/wave_1.bvh"),
    "learn": ("learn", "--symbols", "3"),
    "words set": ("words", "set", "ana/bow_1", "bow to the audience", "--keep"),
    "words import": ("words", "import", "words.tsv"),
    "words synonyms": ("words", "synonyms", "synonyms.txt"),
    "events import": ("events", "import", "events.tsv"),
    "remove": ("remove", "ana/bow_1", "boris/kick_1"),
    "generate": ("generate", "walk", "-o", "made.bvh", "--save", "made", "--png", "made.png"),
    "grammar learn": (
        "grammar", "learn", "boris/long_2", "chidi/long_3", "--terminals", "4", "--name", "other",
    ),
    "grammar generate": (
        "grammar", "generate", GRAMMAR, "-o", "new.glb", "--length", "10", "--save", "new",
    ),
    "grammar edit": (
        "grammar", "edit", GRAMMAR, "kept", "--at", "2", "--choose", "1", "--save", "edited",
    ),
    "grammar remove": ("grammar", "remove", GRAMMAR),
    "compact": ("compact",),
    "rescue": ("rescue", DB, "-o", "rescued.duckdb"),
}  # fmt: skip
"""Name -> words of each command that writes; ``--db`` is added, but to ``rescue``."""


@dataclass(frozen=True)
class Outcome:
    """What became of a killed command.

    Attributes
    ----------
    seed, kind : the case.
    moment : seconds after the start at which it was killed.
    usual : seconds that it takes undisturbed.
    ended : whether it had ended by then.
    told : whether it had printed that it was done.
    rows : "before", "after" or "neither".
    faults : what did not hold.
    """

    seed: int
    kind: str
    moment: float
    usual: float
    ended: bool
    told: bool
    rows: str
    faults: tuple[str, ...]

    @property
    def is_failure(self) -> bool:
        """Whether anything did not hold."""
        return bool(self.faults)


@dataclass(frozen=True)
class Reference:
    """What a command does undisturbed: seconds, rows before and after, files it leaves."""

    seconds: float
    before: dict[str, str]
    after: dict[str, str]
    outputs: dict[str, str]
    names: frozenset[str]


def run(seeds: range, database: Path) -> Iterator[Outcome]:
    """Kill one command for each seed, all kinds in turn."""
    import motiondb.database.motion_db
    import motiondb.pictures  # once, before the processes part

    assert motiondb
    kinds = tuple(COMMANDS)
    with tempfile.TemporaryDirectory() as folder:
        base = prepared(Path(folder) / "base", database)
        usual = functools.cache(functools.partial(reference, base))
        for seed in seeds:
            kind = kinds[seed % len(kinds)]
            yield kill(seed, kind, base, usual(kind))


def words_of(kind: str) -> tuple[str, ...]:
    """The words of a command."""
    words = COMMANDS[kind]
    return words if kind == "rescue" else (*words, "--db", DB)


def prepared(base: Path, database: Path) -> Path:
    """A folder with the database and everything that commands read; the mark is set in it."""
    base.mkdir()
    shutil.copy(database, base / DB)
    if Path(f"{database}.cache").is_dir():
        shutil.copytree(f"{database}.cache", base / f"{DB}.cache")
    names = ("ana/wave_1", "boris/punch_1", "dora/idle_1", "emil/jump_1", "fatou/run_1")
    copy_captures(names, base / "more")
    (base / "words.tsv").write_text(
        "file\twords\tperformer\nana/bow_1\tbow low\tann\nboris/kick_1\tkick high\tbob\n"
    )
    (base / "synonyms.txt").write_text("stroll = walk\nleap = jump\n")
    head, *rows = (SAMPLES / "events.tsv").read_text(encoding="utf-8").splitlines()
    kept = [row for row in rows if row.startswith(("ana/walk_1", "boris/kick_1"))]
    (base / "events.tsv").write_text("\n".join([head, *kept]) + "\n")
    ended = _start(base, MARK)
    ended.join(PATIENCE)
    if ended.exitcode:
        raise RuntimeError((base / "errors.txt").read_text())
    for name in ("printed.txt", "errors.txt"):
        (base / name).unlink()
    return base


def reference(base: Path, kind: str) -> Reference:
    """Run a command undisturbed, and the next one."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "case"
        shutil.copytree(base, place)
        before = _beside(_rows, place)
        process, began = _start(place, words_of(kind)), time.monotonic()
        process.join(PATIENCE)
        seconds = time.monotonic() - began
        if process.exitcode != 0:
            raise RuntimeError(f"{kind}: {(place / 'errors.txt').read_text()}")
        after, outputs = _beside(_rows, place), _outputs(base, place)
        _start(place, NEXT).join(PATIENCE)
        return Reference(seconds, before, after, outputs, frozenset(_names(place)))


def kill(seed: int, kind: str, base: Path, usual: Reference) -> Outcome:
    """Start a command, kill it, look at what is there, and run a further one."""
    share = np.random.default_rng([seed, 3]).uniform(0.0, LATEST)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "case"
        shutil.copytree(base, place)
        process = _start(place, words_of(kind))
        process.join(share * usual.seconds)
        ended = process.exitcode is not None
        process.kill()
        process.join()
        printed = place / "printed.txt"
        told = printed.exists() and bool(printed.read_text().strip())
        faults = [] if not ended or process.exitcode == 0 else [f"ended with {process.exitcode}"]
        faults += _going_on(process)
        found = _beside(_examine, place)
        if isinstance(found, str):
            return Outcome(
                seed, kind, share * usual.seconds, usual.seconds, ended, told, "neither", (found,)
            )
        checked, rows = found
        faults += checked
        state = "after" if rows == usual.after else "neither"
        state = "before" if rows == usual.before else state
        done = told or (ended and process.exitcode == 0)
        if state == "neither":
            parts = [name for name in rows if rows[name] not in
                     (usual.before.get(name), usual.after.get(name))]  # fmt: skip
            faults.append(f"rows of neither: {', '.join(parts) or 'a mixture of tables'}")
        elif done and rows != usual.after:
            faults.append("said to be done, and it is not there")
        faults += [
            f"{name} is not whole"
            for name, digest in _outputs(base, place).items()
            if name in usual.outputs and digest != usual.outputs[name]
        ]
        faults += _beside(_examine_rescued, place)
        later = _start(place, NEXT)
        later.join(PATIENCE)
        if later.exitcode != 0:
            faults.append(f"the next command: {(place / 'errors.txt').read_text().strip()[-200:]}")
        faults += [f"left over: {name}" for name in sorted(_names(place) - usual.names)]
    return Outcome(
        seed, kind, share * usual.seconds, usual.seconds, ended, told, state, tuple(faults)
    )


def _start(place: Path, words: tuple[str, ...]) -> BaseProcess:
    """Run a command in a process, and a session, of its own."""
    process = multiprocessing.get_context("fork").Process(target=_command, args=(place, words))
    process.start()
    return process


def _command(place: Path, words: tuple[str, ...]) -> None:
    """Be the command line: its own folder, output into files."""
    from motiondb.cli.main import main

    os.setsid()
    os.chdir(place)
    for number, name in ((1, "printed.txt"), (2, "errors.txt")):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), number)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    sys.argv = ["motiondb", *words]
    try:
        main()
    except SystemExit as ended:
        sys.stdout.flush()
        sys.stderr.flush()
        # at once: multiprocessing would wait for the readers of `add`, which wait for more work
        os._exit(ended.code if isinstance(ended.code, int) else 1)


def _going_on(process: BaseProcess) -> list[str]:
    """Processes of the command's session that outlive it by more than 20 s; they are ended."""
    import psutil

    def alive() -> list[psutil.Process]:
        found = []
        for other in psutil.process_iter():
            try:
                if os.getsid(other.pid) == process.pid and other.status() != "zombie":
                    found.append(other)
            except (OSError, psutil.Error):
                continue
        return found

    limit = time.monotonic() + 20.0
    while (left := alive()) and time.monotonic() < limit:
        time.sleep(0.1)
    faults = [f"a process goes on: {' '.join(other.cmdline())[:80]}" for other in left]
    for other in left:
        os.kill(other.pid, signal.SIGKILL)
    return faults


def _examine(place: Path) -> tuple[list[str], dict[str, str]]:
    """What ``check`` finds, and the rows."""
    return _check(place / DB), _rows(place)


def _examine_rescued(place: Path) -> list[str]:
    """What ``check`` finds in a database that ``rescue`` made, if it is there."""
    path = place / "rescued.duckdb"
    return [f"rescued: {fault}" for fault in _check(path)] if path.exists() else []


def _check(path: Path) -> list[str]:
    """What ``motiondb check`` finds, in this process."""
    from motiondb import store
    from motiondb.store.checking.blocks import find_damage

    with store.open_store(path, read_only=True, wait=60.0) as opened:
        faults = store.check_store(opened, sources=True, blocks=False)
    damage = find_damage(path)
    return faults + ([damage] if damage else [])


def _rows(place: Path) -> dict[str, str]:
    """Table -> digest of its rows; times and random marks are left out."""
    import duckdb

    with duckdb.connect(str(place / DB), read_only=True) as connection:
        run = connection.execute
        names = [name for (name,) in run("SELECT table_name FROM duckdb_tables()").fetchall()]
        rows = {name: run(f'SELECT * FROM "{name}"').fetchall() for name in names}
    rows["run"] = [row[:2] for row in rows["run"]]
    rows["meta"] = [row for row in rows["meta"] if row[0] == "revision"]
    return {
        name: hashlib.sha256("\n".join(sorted(map(repr, found))).encode()).hexdigest()
        for name, found in rows.items()
    }


def _names(place: Path) -> set[str]:
    """Files of a case; numbers in names of the cache are left out."""
    found = set()
    for path in place.rglob("*"):
        name = path.relative_to(place).as_posix()
        if path.is_file() and not _is_cached(path):
            found.add(name)
    return found


def _is_cached(path: Path) -> bool:
    """Whether a file is a whole part of the cache: its names hold random marks."""
    return path.parent.name.endswith(".cache") and path.suffix in (".npy", ".json")


def _outputs(base: Path, place: Path) -> dict[str, str]:
    """Files that a command wrote for the user -> digest."""
    new = _names(place) - _names(base) - {"printed.txt", "errors.txt", "rescued.duckdb"}
    return {name: hashlib.sha256((place / name).read_bytes()).hexdigest() for name in new}


def _beside(work: Callable[[Path], Any], place: Path) -> Any:
    """What ``work`` gives, in a process of its own: DuckDB stays out of the one that forks."""
    here, there = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(target=_tell, args=(work, place, there))
    process.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        return "looking at it ended the process"
    finally:
        process.join()


def _tell(work: Callable[[Path], Any], place: Path, pipe: Any) -> None:
    try:
        pipe.send(work(place))
    except Exception as error:
        pipe.send(f"{type(error).__name__}: {error}")
