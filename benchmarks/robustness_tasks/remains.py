"""What a killed command left: faults of the database, its rows, and files."""

from __future__ import annotations

import hashlib
from pathlib import Path

from robustness_tasks.commands import DB


def examine(place: Path) -> tuple[list[str], dict[str, str]]:
    """What ``check`` finds, also in a database that was rescued, and the rows."""
    return _check(place / DB) + _examine_rescued(place), row_sums(place)


def _examine_rescued(place: Path) -> list[str]:
    """What ``check`` finds in a database that ``rescue`` made, if it is there."""
    path = place / "rescued.duckdb"
    return [f"rescued: {fault}" for fault in _check(path)] if path.exists() else []


def _check(path: Path) -> list[str]:
    """What ``motiondb check`` finds, in this process."""
    from motiondb import store
    from motiondb.database.checking import check

    with store.open_store(path, read_only=True, wait=60.0) as opened:
        return check(opened)


def row_sums(place: Path) -> dict[str, str]:
    """Table -> number of its rows and sums of their hashes; times and random marks are left out."""
    import duckdb

    sources = {
        "run": "SELECT run_id, kind FROM run",
        "meta": "SELECT * FROM meta WHERE key = 'revision'",
    }
    with duckdb.connect(str(place / DB), read_only=True) as connection:
        run = connection.execute
        names = [name for (name,) in run("SELECT table_name FROM duckdb_tables()").fetchall()]
        sum_of_table = {}
        for name in names:
            source = sources.get(name, f'SELECT * FROM "{name}"')
            sums = "SELECT count(*), bit_xor(hash(row)), sum(hash(row))"
            sum_of_table[name] = repr(run(f"{sums} FROM ({source}) AS row").fetchone())
        return sum_of_table


def all_files(place: Path) -> set[str]:
    """Files of a case, but whole parts of the cache."""
    names = set()
    for path in place.rglob("*"):
        name = path.relative_to(place).as_posix()
        if path.is_file() and not _is_cached(path):
            names.add(name)
    return names


def _is_cached(path: Path) -> bool:
    """Whether a file is a whole part of the cache: its names hold random marks."""
    return path.parent.name.endswith(".cache") and path.suffix == ".arrays"


def written_files(base: Path, place: Path) -> dict[str, str]:
    """Files that a command wrote for the user, new ones and changed ones -> digest."""
    names = all_files(place) - {"printed.txt", "errors.txt", "rescued.duckdb", DB, f"{DB}.wal"}
    digests = {name: _digest(place / name) for name in names}
    return {
        name: digest
        for name, digest in digests.items()
        if not (base / name).exists() or digest != _digest(base / name)
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
