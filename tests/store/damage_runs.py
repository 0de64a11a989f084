"""Damage runs: copies of a learned database are damaged, checked and asked.

What must hold: no copy is called sound when a question fails or is answered otherwise than by the
undamaged database, and every error is one of motiondb's. Each run has a process of its own, since a
damaged file may crash it.
"""

from __future__ import annotations

import json
import multiprocessing
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

KINDS = ("flip", "zero", "page", "cut", "tail")
_BLOCK, _START = 262_144, 12_288
_PATIENCE = 120.0
"""Seconds after which a run counts as hanging."""


@dataclass(frozen=True)
class Outcome:
    """What became of one damaged database.

    Attributes
    ----------
    kind, seed : the damage.
    opened : whether it could be opened.
    faults : what `check` found; None where it could not be opened.
    wrong : what went wrong with questions: "refused", "differs", "crashed", "raw ERROR" or "".
    """

    kind: str
    seed: int
    opened: bool
    faults: tuple[str, ...] | None
    wrong: str

    @property
    def is_missed(self) -> bool:
        """Whether `check` calls it sound although a question fails."""
        return self.faults == () and self.wrong != ""


def damage(data: bytes, kind: str, seed: int) -> bytes:
    """A damaged copy of a database file; the same seed damages alike.

    ``flip`` 1 to 8 bits, ``zero`` a block of DuckDB's, ``page`` random bytes in place of 4096,
    ``cut`` the file anywhere, ``tail`` a few bytes off its end.
    """
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    damaged = bytearray(data)
    if kind == "flip":
        for place in rng.integers(len(data), size=rng.integers(1, 9)):
            damaged[place] ^= 1 << int(rng.integers(8))
    elif kind == "zero":
        start = _START + _BLOCK * int(rng.integers((len(data) - _START) // _BLOCK))
        damaged[start : start + _BLOCK] = bytes(_BLOCK)
    elif kind == "page":
        start = 4096 * int(rng.integers(len(data) // 4096))
        damaged[start : start + 4096] = rng.bytes(4096)
    elif kind == "cut":
        del damaged[int(rng.integers(len(data))) :]
    else:
        del damaged[-int(rng.integers(1, 5000)) :]
    return bytes(damaged)


def answers(path: Path) -> str:
    """What the database answers to a fixed set of questions, as text."""
    import motiondb

    with motiondb.open(path, read_only=True) as db:
        infos = db.captures()
        name = infos[len(infos) // 2].name
        return json.dumps(
            {
                "list": [repr(info) for info in infos],
                "captions": [repr(db.words.captions(info.name)) for info in infos[:5]],
                "search": [repr(match) for match in db.search("walk", limit=5).matches],
                "like": [repr(match) for match in db.like(name, limit=5).matches],
                "describe": [repr(part) for part in db.describe(name)],
                "export": [repr(db.clip(info.name).n_frames) for info in infos[:3]],
            }
        )


def run(data: bytes, kind: str, seed: int, expected: str) -> Outcome:
    """Damage, open, check and ask; ``expected`` is the undamaged database's :func:`answers`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.duckdb"
        path.write_bytes(damage(data, kind, seed))
        faults = _beside(_check, path)
        asked = _beside(answers, path)
    opened = not isinstance(faults, str) or not faults.startswith("refused")
    actual = None if isinstance(faults, str) else tuple(faults)
    wrong = "" if asked == expected else str(asked).partition(":")[0]
    if wrong not in ("", "refused", "crashed", "hangs") and not wrong.startswith("raw"):
        wrong = "differs"
    if isinstance(faults, str) and faults.startswith("raw"):
        wrong = faults
    return Outcome(kind, seed, opened, actual, wrong)


def runs(path: Path, seeds: Iterable[int], kinds: Iterable[str] = KINDS) -> Iterator[Outcome]:
    """All kinds of damage to the database at ``path``, for every seed."""
    import motiondb.database.motion_db  # once, before the processes part

    assert motiondb
    data, expected = path.read_bytes(), _beside(answers, path)
    for seed in seeds:
        for kind in kinds:
            yield run(data, kind, seed, expected)


def _check(path: Path) -> list[str]:
    from motiondb.database.checking import check_file

    return check_file(path)


def _beside(work, path: Path):
    """What ``work`` gives for a path, in a process of its own, or how that process failed."""
    here, there = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(target=_tell, args=(work, path, there))
    process.start()
    there.close()
    try:
        return here.recv() if here.poll(_PATIENCE) else "hangs: "
    except EOFError:
        return "crashed: "
    finally:
        process.kill()
        process.join()


def _tell(work, path: Path, pipe: Connection) -> None:
    from motiondb.errors import MotionDBError

    try:
        pipe.send(work(path))
    except MotionDBError as error:
        pipe.send(f"refused: {error}")
    except BaseException as error:
        pipe.send(f"raw {type(error).__name__} {error}: ")
