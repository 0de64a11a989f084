"""Captions and tags from sheets for captures that are added, and the entries that are not used."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from motiondb import store
from motiondb.files.sheets import EventSheet, Sheet
from motiondb.records import Caption


@dataclass(frozen=True)
class Sheets:
    """Captions and tags of the captures to add."""

    words: Sheet | None = None
    events: EventSheet | None = None

    def unknown(self, names: Iterable[str]) -> list[str]:
        """A sentence for every entry whose file is not among the captures."""
        return [
            sentence
            for sheet in (self.words, self.events)
            if sheet is not None
            for sentence in sheet.unknown(names)
        ]


def sheet_notes(sheets: Sheets) -> list[str]:
    """Notes of the sheets, and one for every sheet without rows."""
    notes = []
    for sheet in (sheets.words, sheets.events):
        if sheet is not None:
            empty = f"{sheet.path}: holds a header and no rows"
            notes += [*sheet.notes] if sheet.entries else [empty]
    return notes


def events_left(
    opened: store.Store, sheet: EventSheet | None, known: Sequence[tuple[str, str]]
) -> list[str]:
    """A note where a sheet has other events for captures that are there already."""
    if sheet is None or not known:
        return []
    kept = store.load_events(opened)
    numbers = {info.name: info.capture_id for info in store.load_captures(opened)}
    count = sum(
        {event for _, event in sheet.entries[name]} != set(kept.get(numbers.get(there, -1), ()))
        for name, there in known
        if name in sheet.entries
    )
    if not count:
        return []
    return [
        f"{sheet.path}: has other events for {count} captures that had been added before; they "
        f"were not changed (motiondb events import {sheet.path} replaces them)"
    ]


def words_left(
    opened: store.Store, sheet: Sheet | None, known: Sequence[tuple[str, str]]
) -> list[str]:
    """A note where a sheet has other words for captures that are there already."""
    if sheet is None or not known:
        return []
    captions = store.load_captions(opened)
    numbers = {info.name: info.capture_id for info in store.load_captures(opened)}
    count = 0
    for name, there in known:
        entry = sheet.find(name)
        old = captions.get(numbers.get(there, -1), ())
        count += bool(entry and entry.captions and set(entry.captions) != set(old))
    if not count:
        return []
    return [
        f"{sheet.path}: has other words for {count} captures that had been added before; they "
        f"were not changed (motiondb words import {sheet.path} replaces them)"
    ]


def captions_within(
    name: str, captions: Sequence[Caption], duration: float, notes: list[str]
) -> tuple[Caption, ...]:
    """Captions that begin before a capture's end (seconds); a note for every other one."""
    kept = []
    for caption in captions:
        if caption.start is not None and caption.start >= duration:
            notes.append(
                f"{name}: words {caption.words!r} start at {caption.start:g} s, after the "
                f"capture's end at {duration:g} s, and were left out"
            )
            continue
        kept.append(caption)
    return tuple(kept)
