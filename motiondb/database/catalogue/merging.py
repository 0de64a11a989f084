"""Captures, words, tags and provenance of another database, taken over into this one.

Captures are the same if their files have the same digest. What people wrote about such a capture in
the other database is added to what is here; a tag with another value stays as it is here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from motiondb import store
from motiondb.answers.database import MergeReport
from motiondb.database import loading
from motiondb.database.learn import updating
from motiondb.errors import QueryError, StoreError
from motiondb.files.safe_files import check_file_name
from motiondb.records import Caption, CaptureInfo, Event

Progress = Callable[[str, int, int], None]
"""Called with the name of the step, the number done, and the total number."""


def check(path: Path, prefix: str, wait: float) -> None:
    """Refuse another database that cannot be read, and a prefix that no name may have."""
    if prefix:
        store.check_new_name(f"{prefix}x", "capture")
    check_file_name(path)
    if not path.exists():
        raise StoreError(f"{path}: expected another database, found no such file. Name another.")
    with store.open_store(path, read_only=True, wait=wait, is_others=True) as other:
        _refuse_lacking(other)


def merge(
    opened: store.Store, path: Path, prefix: str, wait: float, progress: Progress | None
) -> MergeReport:
    """Take over the captures of another database, all in one transaction."""
    tell = progress or (lambda _what, _done, _total: None)
    check_file_name(path)
    if path.exists() and path.samefile(opened.path):
        raise QueryError(f"{path}: expected another database, found this one. Name another.")
    loading.load_outlines(opened)  # keeps them: within a transaction nothing is kept
    with (
        store.open_store(path, read_only=True, wait=wait, is_others=True) as other,
        store.reading(other),
        store.transaction(opened),
    ):
        _refuse_lacking(other)
        run_id = store.start_run(opened, "merge", {"from": str(path), "prefix": prefix})
        merging = _Merging(opened, other, run_id, prefix)
        infos = store.load_captures(other)
        with updating.counted(opened, run_id, merging.shared) as change:
            for done, info in enumerate(infos, start=1):
                number = merging.take(info)
                change.added += [number] if number else []
                tell("taking captures over", done, len(infos))
        tell("looking for copies", 0, 1)
        added = set(merging.added)
        relations = loading.find_relations(opened, added)[0] if added else []
        store.save_relations(opened, relations)
        store.finish_run(opened, run_id)
        tell("looking for copies", 1, 1)
        return MergeReport(
            tuple(merging.added),
            tuple(merging.known),
            tuple(merging.changed),
            tuple(merging.problems),
            tuple(relations),
            (*merging.notes, *_left_out(other)),
            len(change.counted),
            change.new_words,
        )


def _refuse_lacking(other: store.Store) -> None:
    """Refuse a database that came without its log, which may yet be put beside it."""
    if other.lacked_log:
        raise StoreError(other.log_note)


@dataclass
class _Merging:
    """A merge under way."""

    opened: store.Store
    other: store.Store
    run_id: int
    prefix: str
    added: list[str] = field(default_factory=list)
    known: list[tuple[str, str]] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Load what captures are compared by."""
        self.here = {info.sha256: info for info in store.load_captures(self.opened)}
        self.names = {info.name for info in self.here.values()}
        self.own = store.load_captions(self.opened), store.load_events(self.opened)
        self.others = store.load_captions(self.other), store.load_events(self.other)
        self.runs = {run.run_id: run for run in store.load_runs(self.other)}
        self.copied: dict[int, int] = {}
        common = sorted(self.here.keys() & store.load_digests(self.other).keys())
        self.left_out = store.load_left_out(self.opened, common)

    @property
    def shared(self) -> list[int]:
        """Numbers of the captures here that are in the other database too."""
        digests = store.load_digests(self.other)
        return [info.capture_id for sha256, info in self.here.items() if sha256 in digests]

    def take(self, info: CaptureInfo) -> int | None:
        """Take a capture of the other database over; its number here if it is new."""
        captions = self.others[0].get(info.capture_id, ())
        events = self.others[1].get(info.capture_id, ())
        name = self.prefix + info.name
        if info.sha256 in self.here:
            self._join(info, captions, events)
            return None
        if name in self.names:
            self.problems.append(
                f"{name}: expected a free name, found another capture of that name here. It was "
                "left out; rename one of them, or put a folder before the new names (--prefix)."
            )
            return None
        try:
            store.check_new_name(name, "capture")
        except QueryError as error:
            self.problems.append(
                f"{error} It was left out; rename it in the other database, or shorten the prefix."
            )
            return None
        motion = store.load_motion(self.other, info.capture_id, or_markers=True)
        source = store.load_packed_source(self.other, info.capture_id)
        new = replace(info, name=name, run_id=self._run(info.run_id))
        saved = store.save_capture(self.opened, new, motion, source, captions)
        store.save_events(self.opened, saved.capture_id, events)
        if info.kind == "generated":
            origin = store.load_provenance(self.other, info.capture_id)
            store.save_provenance(self.opened, saved.capture_id, origin)
        self.here[info.sha256] = saved
        self.names.add(name)
        self.added.append(name)
        return saved.capture_id

    def _join(
        self, info: CaptureInfo, captions: tuple[Caption, ...], events: tuple[Event, ...]
    ) -> None:
        """Add words, tags and events of a capture to those of the same capture here."""
        here = self.here[info.sha256]
        self.known.append((info.name, here.name))
        old_captions = self.own[0].get(here.capture_id, ())
        old_events = self.own[1].get(here.capture_id, ())
        all_captions = tuple(dict.fromkeys((*old_captions, *captions)))
        all_events = {*old_events, *events}
        tags = {**info.tags, **here.tags}
        if store.SELECTION in tags:
            both = (each.tags.get(store.SELECTION, "") for each in (here, info))
            tags[store.SELECTION] = store.join_selections(*both)
        self.notes += _other_values(here, info.tags)
        if is_worded := all_captions != old_captions:
            store.save_captions(self.opened, here.capture_id, all_captions)
        if is_marked := all_events != set(old_events):
            store.save_events(self.opened, here.capture_id, all_events)
        if is_tagged := tags != here.tags:
            store.save_tags(self.opened, here.capture_id, tags)
        is_filled = False
        if info.sha256 in self.left_out:
            source = store.load_packed_source(self.other, info.capture_id)
            if is_filled := bool(source.data):
                store.fill_in(self.opened, source)
        if is_worded or is_marked or is_tagged or is_filled:
            self.changed.append(here.name)

    def _run(self, number: int) -> int:
        """The number here of a run of the other database, which is copied once."""
        if number not in self.copied:
            self.copied[number] = store.copy_run(self.opened, self.runs[number])
        return self.copied[number]


def _other_values(here: CaptureInfo, tags: Mapping[str, str]) -> list[str]:
    """A sentence for every tag that has another value in the other database."""
    return [
        f"{here.name}: {key} stays {here.tags[key]!r}; the other database has {value!r}"
        for key, value in tags.items()
        if here.tags.get(key, value) != value and key != store.SELECTION
    ]


def _left_out(other: store.Store) -> list[str]:
    """A sentence for everything that a merge does not take over."""
    scenes, grammars = store.load_scene_names(other), store.load_grammar_names(other)
    counts = {
        "synonyms": len(store.load_synonyms(other)),
        "grammars": len(grammars),
        "scenes": len(scenes),
        "removed captures": len(store.load_trash(other)),
        "faulty files": len(store.load_faulty(other)),
    }
    told = [f"{what} ({count})" for what, count in counts.items() if count]
    told += ["what it learned"] if store.is_learned(other) else []
    told += ["the history of its captions"]
    lost = [other.loss_note] if other.loss_note else []
    return [*lost, f"not taken over: {', '.join(told)}"]
