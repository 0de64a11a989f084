"""Runs: the commands that wrote rows; what they changed in captures, to undo it and to tell of it.

A run has its parameters, its seed and the version of motiondb.

A row of the table ``edit`` holds a capture as it was before a run changed it; parts that the run
left alone are NULL. The table of synonyms is noted as the tags of the number SYNONYMS. A run that
undoes another one is a run like any other, with rows of its own, so that it can be undone too.

Removed captures: their rows wait in the schema ``trash`` until the file is compacted.

A table of the trash has the columns of its table in ``main``, and is made when it is first needed.
A capture keeps its number in the trash, and so when it is restored.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

from motiondb.errors import QueryError
from motiondb.records import Caption, CaptureInfo, Event, Run
from motiondb.store.catalogue.annotations import (
    load_captions,
    load_events,
    load_synonyms,
    load_tags,
    save_tags,
)
from motiondb.store.connection.handle import Store
from motiondb.store.connection.migrations import motiondb_version
from motiondb.store.connection.statements import columns_of
from motiondb.store.connection.transactions import touch, transaction


def start_run(
    store: Store, kind: str, parameters: Mapping[str, object] | None = None, seed: int | None = None
) -> int:
    """Record the start of a command, with the parameters that decide its result."""
    run = Run(0, kind, dict(parameters or {}), seed, motiondb_version(), _now(), None)
    return copy_run(store, run)


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
    with transaction(store):
        for run in runs:
            _save_run(store, run.run_id, run)


def copy_run(store: Store, run: Run) -> int:
    """Copy a run of another store under a new number, which is returned."""
    with transaction(store) as connection:
        number = int(connection.value("SELECT coalesce(max(run_id), 0) + 1 FROM run"))
        _save_run(store, number, run)
    return number


def _save_run(store: Store, number: int, run: Run) -> None:
    parameters = json.dumps(run.parameters, default=str, sort_keys=True)
    told = (run.seed, run.version, run.started, run.finished)
    store.connection.insert_row("run", number, run.kind, parameters, *told)


def load_runs(store: Store) -> list[Run]:
    """Load all runs, oldest first."""
    return _runs(store, "ORDER BY run_id")


def load_run(store: Store, run_id: int) -> Run:
    """Load one run."""
    return _runs(store, "WHERE run_id = ?", run_id)[0]


def _runs(store: Store, which: str, *values: int) -> list[Run]:
    rows = store.connection.execute(f"SELECT * FROM run {which}", list(values)).fetchall()
    return [
        Run(number, kind, json.loads(parameters), *told) for number, kind, parameters, *told in rows
    ]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


UNDOABLE = ("add", "remove", "rename", "words", "tags", "events", "merge", "generate", "undo")
"""Kinds of runs that can be undone; grammars and scenes are not restored with their captures."""
SYNONYMS = -1
"""The number by which the table of synonyms is noted, which belongs to no capture."""
UNDO = "undo"
"""Kind of a run that undoes another one; its parameter ``run`` is the number of that."""


@dataclass(frozen=True)
class Edit:
    """A capture before a run changed it."""

    run_id: int
    capture_id: int
    kind: str  # "added", "changed" or "removed"
    name: str  # Before the change; of an added capture, the name that it got
    # Before the change; None where the run left them alone
    tags: Mapping[str, str] | None = None
    captions: tuple[Caption, ...] | None = None
    events: tuple[Event, ...] | None = None


_PARTS = ("tags", "captions", "events")  # Of a capture, that a run may leave alone


@contextmanager
def noting_edits(store: Store, run_id: int, touched: Iterable[int] = ()) -> Iterator[None]:
    """Surround changes in a transaction, so that the run can be undone; additions are found."""
    wanted = set(touched)
    before, there = _load_states(store, run_id, wanted), _numbers(store)
    synonyms = load_synonyms(store) if SYNONYMS in wanted else {}
    yield
    after, now = _load_states(store, run_id, wanted & there), _numbers(store)
    names = dict(store.connection.execute("SELECT capture_id, name FROM capture").fetchall())
    edits = [Edit(run_id, number, "added", names[number]) for number in sorted(now - there)]
    for number, old in before.items():
        new = after.get(number)
        if new is None:
            edits.append(replace(old, kind="removed", tags=None, events=None))
        elif new != old:
            same = [part for part in _PARTS if getattr(old, part) == getattr(new, part)]
            left_alone: dict[str, Any] = dict.fromkeys(same)
            edits.append(replace(old, **left_alone))
    if SYNONYMS in wanted and load_synonyms(store) != synonyms:
        edits.append(Edit(run_id, SYNONYMS, "changed", "synonyms", synonyms))
    _save_edits(store, edits)


def change_tags(
    store: Store, given: Mapping[str, str], every: Iterable[tuple[CaptureInfo, Mapping[str, str]]]
) -> list[str]:
    """Save all tags of captures, where they are others, in one run; return names of these captures.

    `given`: What the run tells of the change.
    """
    changed = [(info, tags) for info, tags in every if tags != info.tags]
    if changed:
        parameters = {"tags": dict(given), "captures": len(changed)}
        numbers = [info.capture_id for info, _ in changed]
        with running(store, "tags", parameters) as run_id, noting_edits(store, run_id, numbers):
            for info, tags in changed:
                save_tags(store, info.capture_id, tags)
    return [info.name for info, _ in changed]


def load_edits(store: Store, run_id: int | None = None) -> list[Edit]:
    """Load the edits of a run, or all; oldest first."""
    rows = store.connection.execute(
        "SELECT run_id, capture_id, kind, name, tags, captions, events FROM edit "
        "WHERE $run IS NULL OR run_id = $run ORDER BY run_id, capture_id",
        {"run": run_id},
    ).fetchall()
    return [
        Edit(
            run,
            capture,
            kind,
            name,
            None if tags is None else json.loads(tags),
            None if captions is None else tuple(Caption(*each) for each in json.loads(captions)),
            None if events is None else tuple(Event(*each) for each in json.loads(events)),
        )
        for run, capture, kind, name, tags, captions, events in rows
    ]


def find_undoable(store: Store, run_id: int | None = None) -> int:
    """Find the run that ``undo`` takes back: the latest that changed captures, or a given one.

    A run is refused if a later one changed one of its captures and still counts: one that was not
    undone, or the undoing of an earlier run.
    """
    history = _load_history(store)
    runs = history.runs
    if run_id is not None:
        is_known = run_id in runs and runs[run_id].kind in UNDOABLE
        if not is_known or run_id in history.undone:
            actual = (
                "one that was undone" if is_known else "none that changed captures, and only these"
            )
            raise QueryError(
                f"run {run_id}: expected a run that can be undone, found {actual}. motiondb info "
                "lists the runs."
            )
        if fault := history.fault(run_id):
            raise QueryError(fault)
        return run_id
    settled = history.undone | history.target.keys()
    standing = sorted(n for n in set(runs) - settled if runs[n].kind in UNDOABLE)
    if not standing:
        raise QueryError(
            f"{store.path}: expected a change of captures to undo, found none. "
            "motiondb info lists the runs."
        )
    if fault := history.fault(standing[-1]):
        before = [n for n in standing if not history.fault(n)]
        hint = f" motiondb undo {before[-1]} takes back the change before." if before else ""
        raise QueryError(fault + hint)
    return standing[-1]


@dataclass(frozen=True)
class _History:
    """The runs that changed captures."""

    runs: Mapping[int, Run]
    touched: Mapping[int, set[int]]  # Run -> numbers of the captures that it changed
    target: Mapping[int, int]  # Run that undoes -> the run that it takes back
    undone: set[int]
    final: set[int]  # Runs that removed captures of which the trash was emptied

    def fault(self, number: int) -> str:
        """Why a run cannot be undone; "" if it can."""
        told = f"run {number} ({self.runs[number].kind}): expected"
        if number in self.final:
            return (
                f"{told} its captures in the trash, found that it was emptied (motiondb compact). "
                "Add the files again."
            )
        counting = [
            n for n in self.runs if n not in self.undone and self.target.get(n, 0) <= number
        ]
        later = [n for n in counting if n > number and self.touched[n] & self.touched[number]]
        if not later:
            return ""
        last = self.runs[max(later)]
        advice = "Undo that one first." if last.kind in UNDOABLE else "That cannot be undone."
        return (
            f"{told} captures that nothing has changed since, found that run {last.run_id} "
            f"({last.kind}) changed some. {advice}"
        )


def _load_history(store: Store) -> _History:
    touched: dict[int, set[int]] = {}
    for run, capture in store.connection.execute("SELECT run_id, capture_id FROM edit").fetchall():
        touched.setdefault(run, set()).add(capture)
    runs = {run.run_id: run for run in load_runs(store) if run.run_id in touched}
    target = {n: int(str(r.parameters["run"])) for n, r in runs.items() if r.kind == UNDO}
    undone: set[int] = set()
    for number in sorted(target, reverse=True):
        if number not in undone:
            undone.add(target[number])
    return _History(runs, touched, target, undone, _final_runs(store))


def _final_runs(store: Store) -> set[int]:
    """The runs that removed captures which are neither there again nor in the trash."""
    kept = _numbers(store) | {number for number, _ in load_trash(store)}
    query = "SELECT run_id, capture_id FROM edit WHERE kind = 'removed'"
    return {run for run, n in store.connection.execute(query).fetchall() if n not in kept}


def _numbers(store: Store) -> set[int]:
    return set(store.connection.column("SELECT capture_id FROM capture"))


def _load_states(store: Store, run_id: int, wanted: set[int]) -> dict[int, Edit]:
    """Load what may be edited in some captures, those that are there."""
    if not wanted:
        return {}
    tags, captions = load_tags(store, wanted), load_captions(store, wanted)
    events = load_events(store, wanted)
    rows = store.connection.execute("SELECT capture_id, name FROM capture").fetchall()
    return {
        n: Edit(run_id, n, "changed", name, tags.get(n, {}), captions.get(n, ()), events.get(n, ()))
        for n, name in rows
        if n in wanted
    }


def _save_edits(store: Store, edits: list[Edit]) -> None:
    columns = columns_of(Edit, edits)
    columns |= {part: [_text(each) for each in columns[part]] for part in _PARTS}
    with transaction(store) as connection:
        connection.insert("edit", **columns)


def _text(part: Mapping[str, str] | tuple[Caption, ...] | tuple[Event, ...] | None) -> str | None:
    """Return a part of a capture as JSON; captions and events are lists of their fields."""
    if part is None:
        return None
    if isinstance(part, Mapping):
        return json.dumps(dict(part))
    return json.dumps([list(vars(each).values()) for each in part])


OWN_TABLES = (
    "capture",
    "capture_tag",
    "caption",
    "event",
    "motion",
    "generated_source",
    "frame_source",
    "derivation",
    "same_file",
    "scene_player",
)  # Whose rows have the number of their capture
_OF_CAPTURE = {
    **dict.fromkeys(OWN_TABLES, "capture_id IN (SELECT unnest($numbers))"),
    "relation": "(capture_id IN (SELECT unnest($numbers)) "
    "OR other_id IN (SELECT unnest($numbers)))",
    "source": "sha256 IN (SELECT sha256 FROM {schema}.capture "
    "WHERE capture_id IN (SELECT unnest($numbers)))",
}  # Table -> its rows that belong to captures
_THERE = {
    "relation": "AND capture_id IN (SELECT capture_id FROM main.capture) "
    "AND other_id IN (SELECT capture_id FROM main.capture)",
    "derivation": "AND EXISTS (FROM main.grammar g WHERE g.grammar_id = derivation.grammar_id "
    "AND g.run_id <= derivation.run_id)",
}  # Table -> which of the rows can be restored: those of captures and grammars that are there
_ONCE = "AND sha256 NOT IN (SELECT sha256 FROM trash.source)"
_LAST = "AND (SELECT count(*) FROM trash.capture c WHERE c.sha256 = source.sha256) = 1"
_LEFT_OUT = "octet_length(data) = 0 AND data_at IS NULL"
# The same content may be removed twice: its source is kept once, until the last of them is
# restored; one without its bytes makes place for any other


def put_in_trash(store: Store, numbers: Sequence[int]) -> None:
    """Copy captures and everything that belongs to them into the trash; inside a transaction."""
    connection, asked = store.connection, {"numbers": list(numbers)}
    connection.execute("CREATE SCHEMA IF NOT EXISTS trash")
    for table, rows in _OF_CAPTURE.items():
        connection.execute(
            f"CREATE TABLE IF NOT EXISTS trash.{table} AS SELECT * FROM main.{table} LIMIT 0"
        )
        rows = rows.format(schema="main")
        if table == "source":
            connection.execute(f"DELETE FROM trash.source WHERE {rows} AND {_LEFT_OUT}", asked)
            rows = f"{rows} {_ONCE}"
        connection.execute(
            f"INSERT INTO trash.{table} BY NAME SELECT * FROM main.{table} WHERE {rows}", asked
        )


def restore_captures(store: Store, numbers: Sequence[int]) -> None:
    """Take captures out of the trash, in one transaction; QueryError if one is not there."""
    if not numbers:
        return
    with transaction(store) as connection:
        asked = {"numbers": list(numbers)}
        for number in sorted(set(numbers) - dict(load_trash(store)).keys()):
            raise QueryError(
                f"capture {number}: expected it in the trash, found that it was emptied "
                "(motiondb compact). Add the file again."
            )
        taken = connection.execute(
            "SELECT t.name, c.name FROM capture c JOIN trash.capture t "
            "ON c.name = t.name OR c.sha256 = t.sha256 "
            "WHERE t.capture_id IN (SELECT unnest($numbers)) ORDER BY t.capture_id",
            asked,
        ).fetchone()
        if taken is not None:
            raise QueryError(
                f"{taken[0]}: expected its name and its content to be free, found the capture"
                f" {taken[1]}. Rename or remove that one first."
            )
        for table, rows in _OF_CAPTURE.items():
            if table != "scene_player":
                rows = f"{rows.format(schema='trash')} {_THERE.get(table, '')}"
                once = "DISTINCT ON (sha256)" if table == "source" else ""
                connection.execute(
                    f"INSERT INTO main.{table} BY NAME SELECT {once} * FROM trash.{table} "
                    f"WHERE {rows}",
                    asked,
                )
        connection.execute(
            "UPDATE main.scene_player p SET capture_id = t.capture_id "
            "FROM trash.scene_player t WHERE t.capture_id IN (SELECT unnest($numbers)) "
            "AND p.capture_id = -1 AND p.scene_id = t.scene_id "
            "AND p.ordinal = t.ordinal AND p.run_id = t.run_id",
            asked,
        )
        for table in reversed(_OF_CAPTURE):  # the source is found by the capture
            only = _LAST if table == "source" else _THERE.get(table, "")
            rows = f"{_OF_CAPTURE[table].format(schema='trash')} {only}"
            connection.execute(f"DELETE FROM trash.{table} WHERE {rows}", asked)
        touch(store, motions=True)


def load_trash(store: Store) -> list[tuple[int, str]]:
    """Load number and name of the captures in the trash, in order of number."""
    if not _is_there(store):
        return []
    query = "SELECT capture_id, name FROM trash.capture ORDER BY capture_id"
    return [(int(number), str(name)) for number, name in store.connection.execute(query).fetchall()]


def empty_trash(store: Store) -> None:
    """Remove for good what is in the trash."""
    if _is_there(store):
        with transaction(store) as connection:
            connection.execute("DROP SCHEMA trash CASCADE")


def _is_there(store: Store) -> bool:
    query = "SELECT count(*) FROM duckdb_tables() WHERE schema_name = 'trash' AND table_name ="
    return bool(store.connection.value(f"{query} 'capture' AND database_name = current_database()"))
