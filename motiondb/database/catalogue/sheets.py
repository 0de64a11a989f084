"""Captions, tags and events from sheets, for captures that are added or that are there already."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from motiondb import store
from motiondb.answers.catalogue import SheetWritten
from motiondb.database.learn import updating
from motiondb.errors import QueryError
from motiondb.files.annotation_sheets import FORMS, write_annotations
from motiondb.files.sheet_writer import write_sheet
from motiondb.files.sheets import (
    EventSheet,
    Sheet,
    SheetEntry,
    is_within,
    read_event_sheet,
    read_sheet,
    resolved,
    spoken_part,
)
from motiondb.records import Caption, CaptureInfo


@dataclass(frozen=True)
class Sheets:
    """Captions, tags and events of the captures to add."""

    words: Sheet | None = None
    events: EventSheet | None = None

    @classmethod
    def read(cls, words: str | Path | None, events: str | Path | None) -> Sheets:
        """The sheets of two files, each of which may be missing."""
        return cls(
            read_sheet(words) if words is not None else None,
            read_event_sheet(events) if events is not None else None,
        )

    @property
    def each(self) -> list[Sheet | EventSheet]:
        """The sheets that there are."""
        return [sheet for sheet in (self.words, self.events) if sheet is not None]

    def unknown(self, names: Iterable[str]) -> list[str]:
        """A sentence for every entry whose file is not among the captures."""
        return [sentence for sheet in self.each for sentence in sheet.unknown(names)]

    def below(self, prefix: str) -> Sheets:
        """The same for captures whose names begin with a prefix that the sheets do not have."""
        return Sheets(*(_below(sheet, prefix) for sheet in (self.words, self.events)))

    def resolved(self, files: Mapping[str, str]) -> Sheets:
        """The same for captures as they are called, where a sheet may name one in another way."""
        return Sheets(
            self.words and resolved(self.words, files), self.events and resolved(self.events, files)
        )

    def entry(self, name: str) -> SheetEntry | None:
        """What the sheet of words says of a capture."""
        return self.words.find(name) if self.words else None


def _below(sheet: Any, prefix: str) -> Any:  # noqa: ANN401  a sheet of either kind, or None
    """A sheet with a prefix before the name of every capture."""
    if sheet is None or not prefix:
        return sheet
    return replace(sheet, entries={prefix + name: entry for name, entry in sheet.entries.items()})


def sheet_notes(opened: store.Store, sheets: Sheets, known: Sequence[tuple[str, str]]) -> list[str]:
    """Notes of the sheets; one for a sheet without rows, or with other data than the database.

    `known` names captures in the sheets and in the database, where they had been added before.
    """
    notes = []
    for sheet in sheets.each:
        notes += [*sheet.notes] if sheet.entries else [f"{sheet.path}: holds a header and no rows"]
    if not known or not sheets.each:
        return notes
    numbers = {info.name: info.capture_id for info in store.load_captures(opened)}
    if sheets.words is not None:
        captions, count = store.load_captions(opened), 0
        for name, there in known:
            entry, old = sheets.entry(name), captions.get(numbers.get(there, -1), ())
            count += bool(entry and entry.captions and set(entry.captions) != set(old))
        notes += _not_changed(sheets.words.path, "words", count)
    if sheets.events is not None:
        events, entries = store.load_events(opened), sheets.events.entries
        count = sum(
            {event for _, event in entries[name]} != set(events.get(numbers.get(there, -1), ()))
            for name, there in known
            if name in entries
        )
        notes += _not_changed(sheets.events.path, "events", count)
    return notes


def _not_changed(path: object, what: str, count: int) -> list[str]:
    """A note where a sheet has other words or events for captures that are there already."""
    if not count:
        return []
    return [
        f"{path}: has other {what} for {count} captures that had been added before; they "
        f"were not changed (motiondb {what} import {path} replaces them)"
    ]


def captions_within(
    name: str, captions: Sequence[Caption], duration: float, notes: list[str]
) -> tuple[Caption, ...]:
    """Captions within a capture that replaces another one (seconds); a note for the others."""
    notes += [
        f"{name}: the words {spoken_part(caption)} were left out: the new file ends at "
        f"{duration:.4g} s"
        for caption in captions
        if not is_within(caption, duration)
    ]
    return tuple(caption for caption in captions if is_within(caption, duration))


@dataclass(frozen=True)
class ImportReport:
    """The result of an import of words.

    captures : how many have the sheet's words and tags now. problems : a sentence per row without a
    capture, or about a part beyond its end. notes : what of the sheet was left out, and why.
    """

    captures: int
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class EventReport:
    """The result of an import of events.

    captures, events : how many captures have the sheet's events now, and how many these are.
    problems : a sentence per row without a capture, or after its end. notes : what was odd.
    """

    captures: int
    events: int
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def import_words(opened: store.Store, path: str | Path) -> ImportReport:
    """Replace words and tags by those of a sheet; captures for which it has no words keep theirs.

    Words about a part that is not within the capture are a problem. Frame rates, axes and skeletons
    decide how a file is read, so they do nothing for captures that are there.
    """
    sheet = read_sheet(path)
    with store.transaction(opened):
        infos = _captures_by_name(opened)
        sheet = resolved(sheet, {name: info.path for name, info in infos.items()})
        named = [(infos[name], entry) for name, entry in sheet.entries.items() if name in infos]
        notes = [*sheet.notes, *_read_already(sheet, infos)]
        problems = sheet.unknown(infos)
        numbers = [info.capture_id for info, _ in named]
        with updating.changing(opened, "words", {"sheet": str(path)}, numbers):
            for info, entry in named:
                captions = sheet.within(info.name, info.duration, problems)
                if captions:
                    store.save_captions(opened, info.capture_id, captions)
                store.save_tags(opened, info.capture_id, {**info.tags, **entry.tags})
    return ImportReport(len(named), tuple(problems), tuple(notes))


def _captures_by_name(opened: store.Store) -> dict[str, CaptureInfo]:
    """The captures, read in the transaction that changes them: others may have changed them."""
    assert opened.in_transaction
    return {info.name: info for info in store.load_captures(opened)}


def export_words(opened: store.Store, path: str | Path, where: str, form: str = "") -> SheetWritten:
    """Write captions and tags of captures as a sheet that :func:`import_words` reads.

    `form`: "boris" or "elan" for a sheet of these, with words and events, without tags.
    """
    infos = store.load_captures(opened, where)
    captions = store.load_captions(opened)
    if form:
        if form not in FORMS:
            raise QueryError(f"words export: expected --as boris or elan, found {form!r}.")
        events = store.load_events(opened)
        said = [
            (info.name, info.duration, info.fps, captions.get(n, ()), events.get(n, ()))
            for n, info in ((info.capture_id, info) for info in infos)
        ]
        write_annotations(Path(path), said, form)
        count = sum(len(spoken) for *_, spoken, _ in said)
        n_events = sum(len(instants) for *_, instants in said)
        told = (f"{n_events} events are in it, too, without their joints",) if n_events else ()
        left = "tags are not in it: such a sheet has no place for them"
        return SheetWritten(Path(path), len(said), count, (*told, left))
    rows = [(info.name, captions.get(info.capture_id, ()), info.tags) for info in infos]
    notes = write_sheet(Path(path), sorted(rows, key=lambda row: row[0]))
    count = sum(len(spoken) for _, spoken, _ in rows)
    return SheetWritten(Path(path), len(rows), count, tuple(notes))


def _read_already(sheet: Sheet, infos: Mapping[str, CaptureInfo]) -> list[str]:
    """A note if a sheet says how to read captures that were already added."""
    notes, known = [], [entry for name, entry in sheet.entries.items() if name in infos]
    for what in ("fps", "skeleton", "up"):
        count = sum(getattr(entry, what) is not None for entry in known)
        if count:
            notes.append(
                f"{sheet.path}: has a column {what} for {count} captures that were read already; "
                f"it was left out (remove and add them to read them by another {what})"
            )
    return notes


def import_events(opened: store.Store, path: str | Path) -> EventReport:
    """Replace the events of the captures that a sheet names, all in one transaction.

    Nothing is learned from events, so the learned model does not change.
    """
    sheet = read_event_sheet(path)
    captures = count = 0
    with store.transaction(opened):
        infos = _captures_by_name(opened)
        sheet = resolved(sheet, {name: info.path for name, info in infos.items()})
        problems = sheet.unknown(infos)
        named = [infos[name] for name in sheet.entries if name in infos]
        numbers = [info.capture_id for info in named]
        with (
            store.running(opened, "events", {"sheet": str(path)}) as run_id,
            store.noting_edits(opened, run_id, numbers),
        ):
            for info in named:
                events = sheet.within(info.name, info.motion_frames, problems)
                store.save_events(opened, info.capture_id, events)
                captures, count = captures + 1, count + len(events)
    return EventReport(captures, count, tuple(problems), sheet.notes)
