"""Words, tags and events of a sheet for captures that are there already."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from motiondb import store
from motiondb.database.catalogue.added_sheets import captions_within
from motiondb.database.learn import updating
from motiondb.files.sheets import Sheet, read_event_sheet, read_sheet
from motiondb.records import CaptureInfo


@dataclass(frozen=True)
class ImportReport:
    """The result of an import of words.

    captures : how many have the sheet's words and tags now. problems : a sentence per row without a
    capture. notes : what of the sheet was left out, and why.
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

    Words that begin after a capture's end are left out. Frame rates and skeletons decide how a file
    is read, so they do nothing for captures that are there.
    """
    sheet = read_sheet(path)
    with store.reading(opened):
        infos = {info.name: info for info in store.load_captures(opened)}
    named = [(infos[name], entry) for name, entry in sheet.entries.items() if name in infos]
    notes = [*sheet.notes, *_read_already(sheet, infos)]
    numbers = [info.capture_id for info, _ in named]
    with updating.changing(opened, "words", {"sheet": str(path)}, numbers):
        for info, entry in named:
            captions = captions_within(info.name, entry.captions, info.duration, notes)
            if captions:
                store.save_captions(opened, info.capture_id, captions)
            store.save_tags(opened, info.capture_id, {**info.tags, **entry.tags})
    return ImportReport(len(named), tuple(sheet.unknown(infos)), tuple(notes))


def _read_already(sheet: Sheet, infos: Mapping[str, CaptureInfo]) -> list[str]:
    """A note if a sheet says how to read captures that were already added."""
    notes = []
    for what in ("fps", "skeleton"):
        count = sum(
            getattr(entry, what) is not None
            for name, entry in sheet.entries.items()
            if name in infos
        )
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
    with store.reading(opened):
        infos = {info.name: info for info in store.load_captures(opened)}
    problems = sheet.unknown(infos)
    captures = count = 0
    with store.transaction(opened):
        run_id = store.start_run(opened, "events", {"sheet": str(path)})
        for name in sheet.entries:
            if name in infos:
                events = sheet.within(name, infos[name].motion_frames, problems)
                store.save_events(opened, infos[name].capture_id, events)
                captures, count = captures + 1, count + len(events)
        store.finish_run(opened, run_id)
    return EventReport(captures, count, tuple(problems), sheet.notes)
