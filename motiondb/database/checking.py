"""Check a database in another process: its store, and that grammars give back their strings.

Deriving every sentence by its stored rule numbers must give exactly the terminals of its segments,
so that the takes follow from the grammar alone.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.errors import MotionDBError, StoreError
from motiondb.files.processes import end_with_parent, is_main_thread
from motiondb.files.safe_files import check_file_name

if TYPE_CHECKING:
    from motiondb.database.loading import LearnedGrammar


def check(opened: store.Store) -> list[str]:
    """Every fault of an open database, one sentence each; none if it is sound."""
    from motiondb.database.loading import load_learned_grammar

    faults = store.check_store(opened, sources=True)
    if faults:  # grammars cannot be loaded from broken tables
        return faults
    for name in store.load_grammar_names(opened):
        learned = load_learned_grammar(opened, name)
        faults += _wrong_parses(learned) + _wrong_derivations(opened, learned)
    return faults


def _wrong_parses(learned: LearnedGrammar) -> list[str]:
    from motiondb.grammar.cfg.context_free import check_grammar

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
    from motiondb.grammar.cfg.context_free import derive_by

    try:
        return derive_by(learned.grammar, rules).leaves()
    except MotionDBError:
        return None


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
        The file cannot be opened, or memory ran out; the message says why, and what to do.
    """
    path = Path(path)
    check_file_name(path)
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
    if ended.returncode >= 0:
        try:
            answer = json.loads(ended.stdout)
        except ValueError:
            if "MemoryError" in ended.stderr:
                raise _unknown(path) from None
            last = (ended.stderr.strip().splitlines() or ["nothing"])[-1]
            return [_damage(path, f"that reading it fails ({last}).")]
        if answer["error"]:
            raise StoreError(answer["error"])
        return [str(fault) for fault in answer["faults"]]
    found = f"that reading it ends the program ({signal.Signals(-ended.returncode).name})."
    if _is_memory_limited():  # libraries end the program where they get no memory
        found += " Either memory ran out (allow more with ulimit -v and check again), or:"
    return [_damage(path, found)]


def _damage(path: Path, found: str) -> str:
    return store.damage_sentence(path, found)


def _is_memory_limited() -> bool:
    """Whether the system limits the memory of this process, as ``ulimit -v`` does."""
    try:
        import resource
    except ImportError:  # Windows
        return False
    return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY


def _unknown(path: Path) -> StoreError:
    """The error for a file of which nothing is known, because memory ran out."""
    return StoreError(
        f"{path}: expected enough memory to check it, found that it ran out. Whether the file is "
        "sound is not known: allow more memory (ulimit -v), and check again."
    )


def _answer(path: Path, wait: float, quick: bool) -> dict[str, object]:
    """The result of the other process: faults, or the error that prevented the check."""
    try:
        with store.open_store(path, read_only=True, wait=wait, is_others=True) as opened:
            if quick:
                return {"error": None, "faults": store.check_quickly(opened)}

            return {"error": None, "faults": check(opened)}
    except MemoryError:
        return {"error": str(_unknown(path)), "faults": []}
    except StoreError as error:
        return {"error": str(error), "faults": []}


if __name__ == "__main__":
    _path, _wait, _quick, _parent, _by_main_thread = sys.argv[1:]
    end_with_parent(int(_parent), _by_main_thread == "1")
    sys.stdout.write(json.dumps(_answer(Path(_path), float(_wait), _quick == "1")))
