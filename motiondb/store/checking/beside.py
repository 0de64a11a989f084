"""Check a file in another process, so that a damaged one cannot end this one.

DuckDB may abort or crash on a file that is damaged in a way it does not expect. The other process
returns its results as JSON on its standard output; if it dies, this is a fault.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from motiondb.errors import StoreError
from motiondb.files.parent_process import end_with_parent, is_main_thread
from motiondb.store.checking.blocks import find_damage
from motiondb.store.connection.faults import damage_sentence

_BLOCKS = "blocks"
_EVERYTHING = "everything"


def check_file(path: str | Path, *, wait: float = 0.0) -> list[str]:
    """Every fault of a database file, one sentence each; none if it is sound.

    Reads every block and every column, checks every rule of the tables and the digest of every
    stored file, in another process.

    Parameters
    ----------
    path : str or Path
        The file; this process may have it open for reading only.
    wait : float
        Seconds to wait for a process that writes to it.

    Raises
    ------
    StoreError
        The file cannot be opened; the message says why, and what to do.
    """
    return _ask(Path(path), _EVERYTHING, wait)


def block_faults(path: Path) -> list[str]:
    """A sentence where blocks of the file do not fit their checksums, none if all do."""
    return _ask(path, _BLOCKS, 0.0)


def _ask(path: Path, what: str, wait: float) -> list[str]:
    """Run this module as a program, and read its output."""
    try:
        ended = _run(what, path, wait)
    except OSError as error:
        raise StoreError(
            f"{path}: expected to start a process that checks it, found: "
            f"{error.strerror or error}. Try again; the system may allow too few processes."
        ) from error
    if ended.returncode < 0:
        name = signal.Signals(-ended.returncode).name
        return [damage_sentence(path, f"that reading it ends the program ({name}).")]
    try:
        answer = json.loads(ended.stdout)
    except ValueError:
        last = (ended.stderr.strip().splitlines() or ["nothing"])[-1]
        return [damage_sentence(path, f"that reading it fails ({last}).")]
    if answer["error"]:
        raise StoreError(answer["error"])
    return [str(fault) for fault in answer["faults"]]


def _run(what: str, path: Path, wait: float) -> subprocess.CompletedProcess[str]:
    """Run this module as a program, which ends when this process does."""
    return subprocess.run(
        [
            sys.executable,
            "-m",
            __name__,
            what,
            str(path),
            str(wait),
            str(os.getpid()),
            str(int(is_main_thread())),
        ],
        capture_output=True,
        text=True,
        check=False,
    )


def _answer(what: str, path: Path, wait: float) -> dict[str, object]:
    """The result of the other process: faults, or the error that prevented the check."""
    try:
        damage = find_damage(path) if path.is_file() else None
        faults = [damage_sentence(path, damage)] if damage else []
        if what == _EVERYTHING:
            from motiondb.store.checking.check import check_store
            from motiondb.store.connection.opening import open_store

            with open_store(path, read_only=True, wait=wait) as store:
                faults += check_store(store, sources=True, blocks=False)
    except StoreError as error:
        if faults:
            return {"error": None, "faults": [*faults, str(error)]}
        return {"error": str(error), "faults": []}
    return {"error": None, "faults": list(dict.fromkeys(faults))}


if __name__ == "__main__":
    _what, _path, _wait, _parent, _by_main_thread = sys.argv[1:]
    end_with_parent(int(_parent), _by_main_thread == "1")
    sys.stdout.write(json.dumps(_answer(_what, Path(_path), float(_wait))))
