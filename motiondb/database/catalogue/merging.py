"""Another database: which captures it has too, and taking over what it has.

Captures, words, tags and provenance are taken over. Captures are the same if their files have the
same digest. What people wrote about such a capture in the other database is added to what is here;
a tag with another value stays as it is here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, store
from motiondb.answers.database import MergeReport
from motiondb.database import loading
from motiondb.database.learn import updating
from motiondb.errors import QueryError, StoreError
from motiondb.files.safe_files import check_file_name
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Event, Float32Array, IntArray
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array

if TYPE_CHECKING:
    from motiondb.database.session import Session

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
        self.notes += [
            f"{here.name}: {key} stays {here.tags[key]!r}; the other database has {value!r}"
            for key, value in info.tags.items()
            if here.tags.get(key, value) != value and key != store.SELECTION
        ]
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


def diff(
    session: Session,
    infos: Sequence[CaptureInfo],
    path: Path,
    wait: float,
    progress: Callable[[str, float, float], None] | None,
) -> answers.DiffAnswer:
    """Compare captures with those of another database, as :meth:`MotionDB.diff` says."""
    tell = progress or (lambda _what, _done, _total: None)
    check_file_name(path)
    if path.exists() and path.samefile(session.store.path):
        raise QueryError(f"{path}: expected another database, found this one. Name another.")
    check(path, "", wait)
    with (
        store.open_store(path, read_only=True, wait=wait, is_others=True) as other,
        store.reading(other),
        session.reading(),
    ):
        tell("comparing", 0, 1)
        both = _Both(session.store, infos, other)
        shared = both.same_files()
        known = {(each.capture, each.other) for each in shared}
        shared += [each for each in both.same_motions() if (each.capture, each.other) not in known]
        tell("comparing", 1, 1)
        notes = [other.loss_note] if other.loss_note else []
        notes += [f"{name}: its motion cannot be read, it was not compared" for name in both.unread]
    shared.sort(key=lambda each: (each.capture, each.distance, each.other))
    return answers.DiffAnswer(
        path,
        len(infos),
        len(both.there),
        tuple(shared),
        len({info.name for info in infos} - {each.capture for each in shared}),
        len({info.name for info in both.there} - {each.other for each in shared}),
        tuple(notes),
    )


class _Part:
    """The captures of one database that can be compared."""

    def __init__(self, opened: store.Store, infos: Iterable[CaptureInfo]) -> None:
        held = loading.load_outlines(opened)
        place = {number: n for n, number in enumerate(held.capture_ids.tolist())}
        every = list(infos)
        self.opened = opened
        self.infos = [info for info in every if info.capture_id in place]
        self.unread = [info.name for info in every if info.capture_id not in place]
        places = np.array([place[info.capture_id] for info in self.infos], dtype=np.int64)
        self.firsts, self.ends = held.bounds[places], held.bounds[places + 1]
        self.reaches = held.values[places]
        self.rows = held.rows if len(held.rows) else np.zeros((0, N_AXES), dtype=np.int16)
        self.n_rows = int(held.bounds[-1])


class _Rows:
    """Outlines of two databases, one after another, read where they are looked at."""

    def __init__(self, first: _Part, second: _Part) -> None:
        self.parts, self.edge = (first, second), first.n_rows

    def __getitem__(self, which: slice | IntArray, /) -> Int16Array:
        """Rows between two numbers of one database, or of an array of numbers."""
        if isinstance(which, slice):
            if which.start >= self.edge:
                moved = slice(which.start - self.edge, which.stop - self.edge)
                return np.asarray(self.parts[1].rows[moved])
            below = self.parts[0].rows[which.start : min(which.stop, self.edge)]
            more = self.parts[1].rows[0 : max(0, which.stop - self.edge)]
            return np.concatenate([below, more])
        out = np.empty((*which.shape, N_AXES), dtype=np.int16)
        there = which >= self.edge
        out[~there] = self.parts[0].rows[which[~there]]
        out[there] = self.parts[1].rows[which[there] - self.edge]
        return out


class _Both:
    """Captures here and those of another database."""

    def __init__(
        self, opened: store.Store, here: Sequence[CaptureInfo], other: store.Store
    ) -> None:
        self.here, self.there = here, store.load_captures(other)
        self.mine, self.theirs = _Part(opened, here), _Part(other, self.there)
        self.unread = [*self.mine.unread, *self.theirs.unread]

    def same_files(self) -> list[answers.SharedCapture]:
        """Captures of equal bytes."""
        by_digest: Mapping[str, CaptureInfo] = {info.sha256: info for info in self.there}
        pairs = [(info, by_digest.get(info.sha256)) for info in self.here if info.sha256]
        return [_shared(a, b, "same file", 0.0, a.duration, 0.0) for a, b in pairs if b is not None]

    def same_motions(self) -> list[answers.SharedCapture]:
        """Captures of equal motion, whole or in part, as it is or mirrored."""
        mine, theirs = self.mine, self.theirs
        n = len(mine.infos)
        infos = [*mine.infos, *theirs.infos]

        def poses_of(place: int) -> Float32Array:
            opened = mine.opened if place < n else theirs.opened
            return copies.copy_poses(store.load_motion(opened, infos[place].capture_id))

        library = copies.Library(
            np.concatenate([mine.ends - mine.firsts, theirs.ends - theirs.firsts]),
            np.concatenate([mine.reaches, theirs.reaches]),
            np.concatenate([mine.firsts, theirs.firsts + mine.n_rows]),
            _Rows(mine, theirs),
            poses_of,
        )
        first, second = list(range(n)), list(range(n, len(infos)))
        found = copies.find_copies(library, first, second)
        found += copies.find_copies(library, second, first)
        out = []
        for each in found:
            is_mine = each.query < n
            a, b = (each.query, each.take) if is_mine else (each.take, each.query)
            kinds = {"same": "same motion", "mirror": "mirrored"}
            kind = kinds.get(each.kind, "part of it" if is_mine else "contains it")
            start, end = each.start / MOTION_FPS, each.end / MOTION_FPS
            out.append(_shared(infos[a], infos[b], kind, start, end, each.distance))
        as_it_is = {(each.capture, each.other) for each in out if each.kind != "mirrored"}
        return [  # motion that is alike on both sides is its own mirror image
            e for e in out if e.kind != "mirrored" or (e.capture, e.other) not in as_it_is
        ]


def _shared(
    here: CaptureInfo, there: CaptureInfo, kind: str, start: float, end: float, distance: float
) -> answers.SharedCapture:
    return answers.SharedCapture(
        here.name,
        there.name,
        kind,
        abs(here.fps - there.fps) > 0.01 * here.fps,
        round(start, 3),
        round(end, 3),
        round(distance, 5),
        here.fps,
        there.fps,
        here.tags.get("licence", "unknown"),
        there.tags.get("licence", "unknown"),
    )
