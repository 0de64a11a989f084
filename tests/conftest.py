"""One database learned from the sample data, built once per session and shared by its processes."""

from __future__ import annotations

import contextlib
import fcntl
import gc
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import duckdb
import pytest
from hypothesis import HealthCheck, settings

import motiondb

settings.register_profile("any", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any")  # a machine that is busy, or compiles first, is slow and not wrong

_SAMPLES = Path(__file__).resolve().parents[1] / "sample_data"
FIRST_COMMANDS = {
    "motiondb add sample_data/captures --words sample_data/captions.tsv": (
        "--events sample_data/events.tsv"
    ),
    "motiondb learn": "",
}
"""As README begins, and what the tests need besides; a test of README compares what they said."""


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit code, standard output, standard error."""

    code: int
    out: str
    err: str


Command = Callable[..., Ended]


def pytest_configure() -> None:
    """Give matrix products one thread, also in processes that tests start.

    Those of two processes on two processors wait for one another: the axes of 260 columns took 100
    times as long. And collect garbage seldom: most objects are modules, tests and trees of code.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(100_000, 20, 20)


def pytest_collection_finish() -> None:
    """Leave out of the collections of garbage what was imported for all tests."""
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def read_here() -> Iterator[None]:
    """A folder of a few files is read in this process: starting two takes a second and a half."""
    with pytest.MonkeyPatch.context() as patch:
        if reading := sys.modules.get("motiondb.database.catalogue.file_reading"):
            patch.setattr(reading, "_FEW", 30)
        yield


@pytest.fixture
def read_beside(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is read in other processes, as it is by a program."""
    monkeypatch.setattr("motiondb.database.catalogue.file_reading._FEW", 4)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest files, so that no process waits for the last of them."""
    items.sort(key=lambda item: item.path.parent != Path(__file__).parent)


@pytest.fixture(autouse=True)
def unprotected() -> None:
    """A command that a test ran in this process may have protected the files of others."""
    motiondb.protect_others(False)


@pytest.fixture(scope="session")
def samples_folder() -> Path:
    """The captures that motiondb made itself."""
    return _SAMPLES / "captures"


@pytest.fixture(scope="session")
def samples_sheet() -> Path:
    """Their words."""
    return _SAMPLES / "captions.tsv"


def _learn_samples(folder: Path) -> None:
    """Make the database with the first commands of README, and keep what they said."""
    from joblib.externals.loky import get_reusable_executor
    from readme_blocks import run

    get_reusable_executor().shutdown(wait=True)  # its processes may stand in another test's folder
    (folder / "sample_data").symlink_to(_SAMPLES)
    with contextlib.chdir(folder), pytest.MonkeyPatch.context() as patch:
        patch.delenv("MOTIONDB", raising=False)
        said = {}
        for command, more in FIRST_COMMANDS.items():
            code, said[command], err = run(f"{command} {more}")
            assert code == 0, err
    (folder / "said.json").write_text(json.dumps(said))


@pytest.fixture(scope="session")
def learned_file(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Iterator[Path]:
    """A database with all sample data, learned, and held open: to write, take a copy."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "learned"
    folder.mkdir(exist_ok=True)
    path = folder / "motions.duckdb"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "done").exists():
            _learn_samples(folder)
            (folder / "done").touch()
    with motiondb.open(path, read_only=True) as db:
        db.info()  # opens it: from now on, a test that writes is refused whatever runs beside it
        yield path


@pytest.fixture(scope="module")
def db(learned_file: Path) -> Iterator[motiondb.MotionDB]:
    """The learned database, to be asked only."""
    with motiondb.open(learned_file, read_only=True) as opened:
        yield opened


def _copied(path: Path, folder: Path) -> Path:
    """A copy of a database with its cache."""
    copy = shutil.copy(path, folder / "motions.duckdb")
    cache = path.with_name(f"{path.name}.cache")
    if cache.is_dir():
        shutil.copytree(cache, copy.with_name(f"{copy.name}.cache"))
    return copy


@pytest.fixture
def learned_copy(tmp_path: Path, learned_file: Path) -> Path:
    """A copy of the learned database that a test may change."""
    return _copied(learned_file, tmp_path)


_FEW = (
    *("ana/bow_1", "ana/jump_1", "ana/walk_1", "ana/wave_1"),
    *("boris/kick_1", "boris/punch_1", "boris/walk_1", "boris/wave_1"),
    *("fatou/kick_1", "fatou/walk_1", "goran/kick_1", "goran/jump_1"),
)


@pytest.fixture(scope="session")
def learned_few(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Twelve captures of four performers, learned, and held open: to write, take a copy."""
    from sample_motions import copied_samples

    folder = tmp_path_factory.mktemp("few")
    captures, words = copied_samples(folder, _FEW)
    with motiondb.open(folder / "motions.duckdb") as db:
        db.add(captures, words=words)
        db.learn()
    with motiondb.open(folder / "motions.duckdb", read_only=True) as db:
        db.info()
        yield folder / "motions.duckdb"


@pytest.fixture
def few_copy(tmp_path: Path, learned_few: Path) -> Path:
    """A copy of it that a test may change."""
    return _copied(learned_few, tmp_path)


@pytest.fixture
def some(tmp_path: Path, samples_folder: Path) -> Path:
    """A folder with four short captures of two performers."""
    folder = tmp_path / "captures"
    for name in ("ana/bow_1", "ana/jump_1", "boris/kick_1", "boris/punch_1"):
        target = folder / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    return folder


@pytest.fixture
def command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Command:
    """Runs ``motiondb ...`` in this process, in a folder of its own, without terminal colours."""
    from motiondb.cli import main

    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MOTIONDB", raising=False)
    monkeypatch.setenv("COLUMNS", "160")

    def run(*words: object) -> Ended:
        monkeypatch.setattr(sys, "argv", ["motiondb", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main.main()
        out, err = capsys.readouterr()
        code = ended.value.code
        return Ended(code if isinstance(code, int) else 0, out, err)

    return run


@pytest.fixture(scope="session")
def contents() -> Callable[[Path], dict[str, list[tuple[object, ...]]]]:
    """Gives every row of every table of a database file."""

    def read(path: Path) -> dict[str, list[tuple[object, ...]]]:
        with duckdb.connect(str(path), read_only=True) as connection:
            run = connection.execute
            names = [name for (name,) in run("SELECT table_name FROM duckdb_tables()").fetchall()]
            return {n: sorted(run(f'SELECT * FROM "{n}"').fetchall(), key=repr) for n in names}

    return read
