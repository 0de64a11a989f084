"""What runs changed in captures: to undo a run, and to tell how captions came about.

A row of the table ``edit`` holds a capture as it was before a run changed it; parts that the run
left alone are NULL. The table of synonyms is noted as the tags of the number SYNONYMS. A run that
undoes another one is a run like any other, with rows of its own, so that it can be undone too.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from motiondb.errors import QueryError
from motiondb.records import Caption, CaptureInfo, Event
from motiondb.store.catalogue.annotations import (
    load_captions,
    load_events,
    load_synonyms,
    save_tags,
)
from motiondb.store.catalogue.runs import Run, load_runs, running
from motiondb.store.catalogue.trash import load_trash
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction

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


@dataclass(frozen=True)
class _State:
    """What may be edited in a capture."""

    name: str
    tags: Mapping[str, str]
    captions: tuple[Caption, ...]
    events: tuple[Event, ...]


@contextmanager
def noting_edits(store: Store, run_id: int, touched: Iterable[int] = ()) -> Iterator[None]:
    """Surround changes in a transaction, so that the run can be undone; additions are found."""
    wanted = set(touched)
    before, there = _load_states(store, wanted), _numbers(store)
    synonyms = load_synonyms(store) if SYNONYMS in wanted else {}
    yield
    after, now = _load_states(store, wanted & there), _numbers(store)
    names = dict(store.connection.execute("SELECT capture_id, name FROM capture").fetchall())
    edits = [Edit(run_id, number, "added", names[number]) for number in sorted(now - there)]
    for number, old in before.items():
        new = after.get(number)
        if new is None:
            edits.append(Edit(run_id, number, "removed", old.name, captions=old.captions))
        elif new != old:
            parts = {
                part: getattr(old, part) if getattr(old, part) != getattr(new, part) else None
                for part in ("tags", "captions", "events")
            }
            edits.append(Edit(run_id, number, "changed", old.name, **parts))
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


def _load_states(store: Store, wanted: set[int]) -> dict[int, _State]:
    """Load what may be edited in some captures, those that are there."""
    if not wanted:
        return {}
    captions, events = load_captions(store, wanted), load_events(store, wanted)
    tags: dict[int, dict[str, str]] = {}
    for number, key, value in store.connection.execute(
        "SELECT capture_id, key, value FROM capture_tag WHERE capture_id IN (SELECT unnest($1))",
        [list(wanted)],
    ).fetchall():
        tags.setdefault(number, {})[key] = value
    rows = store.connection.execute("SELECT capture_id, name FROM capture").fetchall()
    return {
        n: _State(name, tags.get(n, {}), captions.get(n, ()), events.get(n, ()))
        for n, name in rows
        if n in wanted
    }


def _save_edits(store: Store, edits: list[Edit]) -> None:
    columns: dict[str, list[Any]] = {
        name: [getattr(edit, name) for edit in edits]
        for name in ("run_id", "capture_id", "kind", "name")
    }
    for part in ("tags", "captions", "events"):
        columns[part] = [_text(getattr(edit, part)) for edit in edits]
    with transaction(store) as connection:
        connection.insert("edit", **columns)


def _text(part: Mapping[str, str] | tuple[Caption, ...] | tuple[Event, ...] | None) -> str | None:
    """Return a part of a capture as JSON; captions and events are lists of their fields."""
    if part is None:
        return None
    if isinstance(part, Mapping):
        return json.dumps(dict(part))
    return json.dumps([list(vars(each).values()) for each in part])
