"""Runs: the commands that wrote rows, with their parameters, seed and version."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime

from motiondb.records import Run
from motiondb.store.connection.handle import Store
from motiondb.store.connection.migrations import motiondb_version
from motiondb.store.connection.transactions import transaction


def start_run(
    store: Store, kind: str, parameters: Mapping[str, object] | None = None, seed: int | None = None
) -> int:
    """Record the start of a command, with the parameters that decide its result."""
    text = json.dumps(dict(parameters or {}), default=str, sort_keys=True)
    with transaction(store) as connection:
        number = int(connection.value("SELECT coalesce(max(run_id), 0) + 1 FROM run"))
        connection.execute(
            "INSERT INTO run VALUES (?, ?, ?, ?, ?, ?, NULL)",
            [number, kind, text, seed, motiondb_version(), _now()],
        )
    return number


def note_in_run(store: Store, run_id: int, **values: object) -> None:
    """Add parameters of a run that were found while it went on."""
    with transaction(store) as connection:
        text = connection.value("SELECT parameters FROM run WHERE run_id = ?", [run_id])
        parameters = json.loads(str(text)) | values
        connection.execute(
            "UPDATE run SET parameters = ? WHERE run_id = ?",
            [json.dumps(parameters, default=str, sort_keys=True), run_id],
        )


def finish_run(store: Store, run_id: int) -> None:
    """Record the end of a run; a second call for the same run changes nothing."""
    with transaction(store) as connection:
        connection.execute(
            "UPDATE run SET finished = ? WHERE run_id = ? AND finished IS NULL", [_now(), run_id]
        )


@contextmanager
def running(
    store: Store, kind: str, parameters: Mapping[str, object] | None = None, seed: int | None = None
) -> Iterator[int]:
    """A transaction of one run, whose number is given; its end is recorded with what it saved."""
    with transaction(store):
        run_id = start_run(store, kind, parameters, seed)
        yield run_id
        finish_run(store, run_id)


def save_runs(store: Store, runs: Iterable[Run]) -> None:
    """Copy the runs of another store, with their numbers, into a store that has no runs."""
    with transaction(store) as connection:
        for run in runs:
            connection.execute(
                "INSERT INTO run VALUES (?, ?, ?, ?, ?, ?, ?)",
                [
                    run.run_id,
                    run.kind,
                    json.dumps(run.parameters, sort_keys=True),
                    run.seed,
                    run.version,
                    run.started,
                    run.finished,
                ],
            )


def copy_run(store: Store, run: Run) -> int:
    """Copy a run of another store under a new number, which is returned."""
    with transaction(store):
        number = start_run(store, run.kind)
        save = "UPDATE run SET parameters = ?, seed = ?, version = ?, started = ?, finished = ?"
        parameters = json.dumps(run.parameters, sort_keys=True)
        store.connection.execute(
            f"{save} WHERE run_id = ?",
            [parameters, run.seed, run.version, run.started, run.finished, number],
        )
    return number


def load_runs(store: Store) -> list[Run]:
    """Load all runs, oldest first."""
    return _runs(store, "ORDER BY run_id")


def load_run(store: Store, run_id: int) -> Run:
    """Load one run."""
    return _runs(store, "WHERE run_id = ?", run_id)[0]


def _runs(store: Store, which: str, *values: int) -> list[Run]:
    rows = store.connection.execute(f"SELECT * FROM run {which}", list(values)).fetchall()
    return [
        Run(number, kind, json.loads(parameters), seed, version, started, finished)
        for number, kind, parameters, seed, version, started, finished in rows
    ]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
