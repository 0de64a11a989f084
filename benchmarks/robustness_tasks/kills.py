"""SIGKILL at random moments of every command that writes; then: is everything there?

A case copies a folder with the small database, in which words of a capture were set (an
acknowledged change), starts a command and kills it after a random share of the time that it takes
undisturbed. What must hold afterwards:

* the database opens and ``check`` finds nothing;
* its rows are those from before the command or those from after it, and the latter where the
  command had printed that it was done;
* files that the command writes are not there, or whole; all are there where it ended;
* no process of the command continues;
* after a further command, and the same one again where it writes files, no file is left that these
  commands would not leave undisturbed. Drafts that a kill leaves next to a file of the user are
  removed by the command that writes this file again, because no other command knows its name.

Commands run in processes that are forked from one in which motiondb is imported and its compiled
functions are loaded, so that the kills meet the work and not the start of Python.
"""

from __future__ import annotations

import io
import json
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, redirect_stderr, redirect_stdout, suppress
from dataclasses import asdict, dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import numpy as np

from robustness_tasks import commands
from robustness_tasks.commands import COMMANDS, MARK, NEXT, SCENE, words_of
from robustness_tasks.databases import import_everything
from robustness_tasks.remains import all_files, examine, row_sums, written_files

_URL = "site.txt"
LATEST = 1.1
"""Kills come at a random share of the undisturbed time, up to this one, so that some come late."""
PATIENCE = 600.0
"""Seconds after which a command counts as hanging, on a computer that does other work too."""


@dataclass(frozen=True)
class Outcome:
    """What became of a killed command.

    Attributes
    ----------
    seed, kind : the case.
    moment : seconds after the start at which it was killed.
    usual : seconds that it takes undisturbed.
    ended : whether it had ended by then.
    told : whether it had reported success.
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


def run(seeds: Sequence[int], database: Path) -> Iterator[Outcome]:
    """Kill one command for each seed, all kinds in turn.

    The folder that the cases copy, and the results of undisturbed commands, are kept next to the
    database, so that a run can be continued.
    """
    import_everything()  # once, before the processes part
    base, kinds = database.with_name("kills") / "base", tuple(COMMANDS)
    with commands.site() as url:
        if not base.exists():
            base.parent.mkdir(exist_ok=True)
            prepared(base.with_name(f"new-{os.getpid()}"), database).rename(base)
        (base / _URL).write_text(url)
        warm_up(base)
        for seed in seeds:
            kind = kinds[seed % len(kinds)]
            yield kill(seed, kind, base, _kept_reference(base, kind))


def warm_up(base: Path) -> None:
    """Run a few commands in this process, on a copy, so that those that part from it need not load.

    DuckDB's threads end when its file is closed, so that this process may be forked afterwards.
    """
    from motiondb.cli.main import make_app

    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as redirected:
        redirected.enter_context(redirect_stdout(io.StringIO()))
        redirected.enter_context(redirect_stderr(io.StringIO()))
        place = Path(folder) / "case"
        shutil.copytree(base, place)
        os.chdir(place)
        for kind in ("search", "like", "add one", "generate"):
            with suppress(SystemExit):
                make_app()(list(words_of(kind)), standalone_mode=False)
        os.chdir(here)


def prepared(base: Path, database: Path, url: str = "", *, has_scene: bool = True) -> Path:
    """A folder with the database and everything that commands read; a scene and the mark are in it.

    Parameters
    ----------
    base : Path
        The folder to make.
    database : Path
        The database to copy.
    url : str
        Address of the site that ``fetch cmu`` downloads from.
    has_scene : bool
        Whether a scene is made, which commands of scenes change.
    """
    commands.prepare(base, database)
    (base / _URL).write_text(url)
    _do(base, *([MARK, SCENE] if has_scene else [MARK]))
    for name in ("printed.txt", "errors.txt"):
        (base / name).unlink()
    return base


def reference(base: Path, kind: str) -> Reference:
    """Run a command undisturbed, and those that follow a kill."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "case"
        shutil.copytree(base, place)
        before, began = _beside(row_sums, place), time.monotonic()
        _do(place, words_of(kind))
        seconds = time.monotonic() - began
        after, outputs = _beside(row_sums, place), written_files(base, place)
        _do(place, *_further(kind, place))
        return Reference(seconds, before, after, outputs, frozenset(all_files(place)))


def _kept_reference(base: Path, kind: str) -> Reference:
    """The :func:`reference` of an earlier piece of this run, or a new one."""
    path = base.with_name(f"{kind}.json")
    if not path.exists():
        made = asdict(reference(base, kind))
        path.write_text(json.dumps(made | {"names": sorted(made["names"])}))
    kept = json.loads(path.read_text())
    return Reference(**kept | {"names": frozenset(kept["names"])})


def _do(place: Path, *commands_in_turn: tuple[str, ...]) -> None:
    """Run commands to their end, one after the other in one process.

    Raises
    ------
    RuntimeError
        One fails, or does not end.
    """
    process = _start(place, *commands_in_turn)
    process.join(PATIENCE)
    if process.exitcode != 0:
        process.kill()
        told = (place / "errors.txt").read_text().strip()
        what = "; ".join(" ".join(words) for words in commands_in_turn)
        raise RuntimeError(f"{what}: {told[-200:] or process.exitcode}")


def _further(kind: str, place: Path) -> list[tuple[str, ...]]:
    """The commands that follow: another change, and the same files once more."""
    again = commands.again_of(kind)
    new = {"rescue": "rescued.duckdb", "curate": "chosen", "selections export": "pack"}.get(kind)
    if new is not None and (place / new).exists():
        again = ()  # it writes new files and folders only
    return [NEXT, again] if again else [NEXT]


def kill(seed: int, kind: str, base: Path, usual: Reference) -> Outcome:
    """Start a command, kill it, examine the files, and run a further one."""
    share = np.random.default_rng([seed, 3]).uniform(0.0, LATEST)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "case"
        shutil.copytree(base, place)
        process = _start(place, words_of(kind))
        process.join(share * usual.seconds)
        ended = process.exitcode is not None
        process.kill()
        process.join()
        told = _is_told(kind, place)
        faults = [] if not ended or process.exitcode == 0 else [f"ended with {process.exitcode}"]
        faults += _going_on(process)
        outcome = _beside(examine, place)
        if isinstance(outcome, str):
            return Outcome(
                seed, kind, share * usual.seconds, usual.seconds, ended, told, "neither", (outcome,)
            )
        checked, rows = outcome
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
        faults += _wrong_outputs(written_files(base, place), usual.outputs, process.exitcode == 0)
        try:
            _do(place, *_further(kind, place))
        except RuntimeError as error:
            faults.append(f"a further command: {error}")
        faults += [f"left over: {name}" for name in sorted(all_files(place) - usual.names)]
    return Outcome(
        seed, kind, share * usual.seconds, usual.seconds, ended, told, state, tuple(faults)
    )


def _is_told(kind: str, place: Path) -> bool:
    """Whether a command has printed that it was done."""
    path = place / "printed.txt"
    printed = path.read_text().strip() if path.exists() else ""
    return "added" in printed if kind == "fetch cmu" else bool(printed)


def _wrong_outputs(outputs: dict[str, str], usual: dict[str, str], is_done: bool) -> list[str]:
    """What is wrong with the files that a command wrote; drafts are looked at in the end.

    A scene's folder is written as a whole; a download is not, and continues at the next run.
    """
    faults = [
        f"{name} is not whole"
        for name in outputs
        if outputs[name] != usual.get(name, outputs[name])
    ]
    begun = {name.partition("/")[0] for name in outputs if "/" in name} - {"cmu"}
    missing = sorted(set(usual) - set(outputs))
    faults += [f"{name} is missing" for name in missing if name.partition("/")[0] in begun]
    return faults + [f"done, and {name} is not there" for name in missing if is_done]


def _start(place: Path, *commands_in_turn: tuple[str, ...]) -> BaseProcess:
    """Run commands in a process, and a session, of its own."""
    process = multiprocessing.get_context("fork").Process(
        target=_command, args=(place, commands_in_turn)
    )
    process.start()
    return process


def _command(place: Path, commands_in_turn: tuple[tuple[str, ...], ...]) -> None:
    """Be the command line: its own folder, output into files."""
    from motiondb.cli.main import main

    os.setsid()
    os.chdir(place)
    for number, name in ((1, "printed.txt"), (2, "errors.txt")):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), number)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    url, code = Path(_URL).read_text(), 0
    for words in commands_in_turn:
        sys.argv = ["motiondb", *commands.with_site(words, url)]
        try:
            main()
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
        sys.stdout.flush()
        if code == 1 and "not sure" in Path("printed.txt").read_text():
            code = 0  # `generate` says by it that the small database has no judge of motion
        if code:
            break
    sys.stderr.flush()
    # at once: multiprocessing would wait for the readers of `add`, which wait for more work
    os._exit(code)


def _going_on(process: BaseProcess) -> list[str]:
    """Processes of the command's session that outlive it by more than 20 s; they are ended."""
    import psutil

    def alive() -> list[psutil.Process]:
        problems = []
        for other in psutil.process_iter():
            try:
                if os.getsid(other.pid) == process.pid and other.status() != "zombie":
                    problems.append(other)
            except (OSError, psutil.Error):
                continue
        return problems

    limit = time.monotonic() + 20.0
    while (left := alive()) and time.monotonic() < limit:
        time.sleep(0.1)
    faults = [f"a process goes on: {' '.join(other.cmdline())[:80]}" for other in left]
    for other in left:
        os.kill(other.pid, signal.SIGKILL)
    return faults


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
