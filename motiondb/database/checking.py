"""Check a database: its store, and that the parses of its grammars give back their strings.

Deriving every sentence by its stored rule numbers must give exactly the terminals of its segments,
so that the takes follow from the grammar alone.

DuckDB may abort or crash on a file that is damaged in a way it does not expect. A file is therefore
checked in another process, which runs this module as a program and returns its results as JSON on
its standard output; if it dies, this is a fault.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from motiondb import store
from motiondb.database.learned_grammar import LearnedGrammar, load_learned_grammar
from motiondb.errors import MotionDBError, StoreError
from motiondb.files.parent_process import end_with_parent, is_main_thread
from motiondb.grammar.cfg.context_free import check_grammar, derive_by


def check_file(path: str | Path, *, wait: float = 0.0, quick: bool = False) -> list[str]:
    """Every fault of a database file, one sentence each; none if it is sound.

    Reads every column, checks every rule of the tables, the grammars, and the digest of every
    stored file, in another process.

    Parameters
    ----------
    path : str or Path
        The file; this process may have it open for reading only.
    wait : float
        Seconds to wait for a process that writes to it.
    quick : bool
        Check the tables, the catalogue and what was learned, but read no motions, scores and
        stored files: damage in those is not found.

    Raises
    ------
    StoreError
        The file cannot be opened; the message says why, and what to do.
    """
    path = Path(path)
    parent = [str(os.getpid()), str(int(is_main_thread()))]
    # -P: modules of the working folder must not replace those that are imported
    command = [sys.executable, "-P", "-m", __name__, str(path), str(wait), str(int(quick)), *parent]
    try:
        ended = subprocess.run(
            command, capture_output=True, text=True, errors="replace", check=False
        )
    except OSError as error:
        raise StoreError(
            f"{path}: expected to start a process that checks it, found: "
            f"{error.strerror or error}. Try again; the system may allow too few processes."
        ) from error
    if ended.returncode < 0:
        name = signal.Signals(-ended.returncode).name
        return [store.damage_sentence(path, f"that reading it ends the program ({name}).")]
    try:
        answer = json.loads(ended.stdout)
    except ValueError:
        last = (ended.stderr.strip().splitlines() or ["nothing"])[-1]
        return [store.damage_sentence(path, f"that reading it fails ({last}).")]
    if answer["error"]:
        raise StoreError(answer["error"])
    return [str(fault) for fault in answer["faults"]]


def check(opened: store.Store) -> list[str]:
    """Every fault of an open database, one sentence each; none if it is sound."""
    faults = store.check_store(opened, sources=True)
    if faults:  # grammars cannot be loaded from broken tables
        return faults
    for name in store.load_grammar_names(opened):
        learned = load_learned_grammar(opened, name)
        faults += _wrong_parses(learned) + _wrong_derivations(opened, learned)
    return faults


def _wrong_parses(learned: LearnedGrammar) -> list[str]:
    try:
        check_grammar(learned.grammar)
    except MotionDBError as error:
        return [f"grammar {learned.name}: {error}"]
    takes = learned.terminals.takes
    return [
        f"grammar {learned.name}: expected sentence {number} to be derived by its rules within one "
        "take, found otherwise."
        for number, (string, rules) in enumerate(zip(learned.strings, learned.parses))
        if _derived(learned, rules) != string
        or len(set(takes[slice(*learned.sentences[number])].tolist())) != 1
    ]


def _wrong_derivations(opened: store.Store, learned: LearnedGrammar) -> list[str]:
    n, faults = len(learned.terminals.takes), []
    for name, derivation in store.load_derivations(opened, learned.grammar_id).items():
        known = all(0 <= clip < n for clip in derivation.clips)
        played = tuple(learned.string(c, c + 1)[0] for c in derivation.clips) if known else ()
        if not known or _derived(learned, derivation.rules) != played:
            faults.append(
                f"{name}: expected clips of the terminals that grammar {learned.name} derived, "
                "found others."
            )
    return faults


def _derived(learned: LearnedGrammar, rules: tuple[int, ...]) -> tuple[str, ...] | None:
    try:
        return derive_by(learned.grammar, rules).leaves()
    except MotionDBError:
        return None


def _answer(path: Path, wait: float, quick: bool) -> dict[str, object]:
    """The result of the other process: faults, or the error that prevented the check."""
    try:
        with store.open_store(path, read_only=True, wait=wait) as opened:
            faults = store.check_quickly(opened) if quick else check(opened)
            return {"error": None, "faults": faults}
    except StoreError as error:
        return {"error": str(error), "faults": []}


if __name__ == "__main__":
    _path, _wait, _quick, _parent, _by_main_thread = sys.argv[1:]
    end_with_parent(int(_parent), _by_main_thread == "1")
    sys.stdout.write(json.dumps(_answer(Path(_path), float(_wait), _quick == "1")))
