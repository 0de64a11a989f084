"""Adding captures: find the files, read them, save what is new.

Files are read and saved in batches that fit into memory, each in one transaction. If the command is
killed, the batches that were saved stay, whole; the same command then adds the others.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.answers.database import AddReport
from motiondb.answers.plain import extended
from motiondb.body import world
from motiondb.database.catalogue.file_reading import (
    AddSettings,
    FileToRead,
    ReadFile,
    Readings,
    read_all,
)
from motiondb.database.catalogue.known_files import KnownFiles
from motiondb.database.catalogue.sheets import Sheets, captions_within, sheet_notes
from motiondb.database.learn import updating
from motiondb.errors import MotionDBError, QueryError
from motiondb.files import folder as files
from motiondb.files import packed_files
from motiondb.files.safe_files import is_file, is_folder, odd_kind
from motiondb.files.sheets import EventSheet, SheetEntry, capture_name
from motiondb.records import Caption, CaptureInfo, Event
from motiondb.workers import HERE, Workers

if TYPE_CHECKING:
    from motiondb.database.cluster import Cluster

Progress = Callable[[str, int, int], None]
"""Called with the name of the step, the number done, and the total number."""

_KEPT_SETTINGS = (
    *("unit", "up", "mirror_world", "swap_sides", "skip_bad_frames"),
    *("joint_map", "keep_implausible", "originals"),
)  # With the run: those by which files are read again
BATCH_BYTES = 256 * 2**20
"""Motions and packed files that are read before they are saved, bytes: about three hours."""


def add_captures(
    opened: store.Store,
    folders: Sequence[Path],
    sheets: Sheets,
    settings: AddSettings,
    progress: Progress | None = None,
    workers: Cluster | None = None,
) -> AddReport:
    """Add files, and all captures below folders, as ``MotionDB.add`` does."""
    if settings.prefix:
        store.check_new_name(f"{settings.prefix}x", "capture")
    sheets = sheets.below(settings.prefix)
    at_hand = [(path, folder) for folder in folders for path in _files(folder, settings.within)]
    usable, unusable = _text_names([path for path, _ in at_hand])
    readable = set(usable)
    paths = {path: folder for path, folder in reversed(at_hand) if path in readable}
    names, shared, doubles = _names(paths, settings.prefix)
    sheets = sheets.resolved({name: str(path) for name, path in names.items()})
    problems = unusable + doubles
    jobs = [
        FileToRead(name, path, sheets.entry(name), paths[path], settings)
        for name, path in sorted(names.items())
    ]
    store.check_writable(opened)
    known = KnownFiles(opened, jobs)
    tell = progress if progress and known.lacking else lambda _what, _done, _total: None
    adding = _Adding(
        opened,
        folders,
        sheets,
        settings,
        workers or HERE,
        known,
        known.read(settings.jobs, workers),
        {j.name: j for j in jobs},
        tell,
    )
    report = AddReport((), (), tuple(problems), (), (), 0.0)
    while True:
        # No name here holds a batch, so that it is gone before the next one is read
        report = _joined(report, adding.save(adding.read()))
        tell("saving captures", adding.n_read, len(jobs))
        if adding.n_read == len(jobs):
            break
    others = [sentence for folder in folders for sentence in files.not_read(folder)]
    if shared & {name.partition("#")[0] for name in report.added}:
        others.append(
            f"{len(shared)} files have the name of another one but for its ending: their captures "
            f"are called by the whole name ({', '.join(sorted(shared)[:4])}"
            f"{', ...' if len(shared) > 4 else ''})"
        )
    if report.known and settings.is_asked and not settings.replace:
        others.append(
            f"{len(report.known)} files were there already and stay as they were read: --replace "
            "reads them in another way"
        )
    others += [_takes_note(each, sheets) for each in adding.takes]
    unknown = sheets.unknown({*names, *(name for each in adding.takes for name in each)})
    return replace(
        report,
        notes=(*others, *report.notes),
        problems=(*unknown, *report.problems),
    )


def _names(paths: Mapping[Path, Path], prefix: str) -> tuple[dict[str, Path], set[str], list[str]]:
    """Name the captures of files (path -> folder): files by name, names with ending, problems.

    Where files of a folder differ only in their ending, this is a part of their names.
    """
    whole = {
        path: prefix + (path.name if path == folder else path.relative_to(folder).as_posix())
        for path, folder in paths.items()
    }
    alike = Counter(capture_name(name) for name in set(whole.values()))
    shared = {name for name in whole.values() if alike[capture_name(name)] > 1}
    names: dict[str, Path] = {}
    problems = []
    for path in sorted(whole):
        name = whole[path] if whole[path] in shared else capture_name(whole[path])
        first = names.setdefault(name, path)
        if first != path:
            problems.append(
                f"{path}: expected one file per name, found {first} with the same one. Add it by "
                "itself with --prefix FOLDER/, or rename one of them."
            )
    return names, shared, problems


def _takes_note(takes: Sequence[str], sheets: Sheets) -> str:
    """A note on a file that became several captures."""
    file = takes[0].rpartition("#")[0]
    note = f"{file} holds {len(takes)} takes: {', '.join(takes)}"
    entry = sheets.entry(file)
    if entry is None or not entry.captions:
        return note
    return (
        f"{note}; the sheet's captions of {file} are given to none of them, since they do not say "
        f"which is meant (write {takes[0]} in the column `file`)"
    )


@dataclass
class _Adding:
    """An ``add`` under way: what is left to read, and what it keeps from batch to batch."""

    opened: store.Store
    folders: Sequence[Path]
    sheets: Sheets
    settings: AddSettings
    workers: Workers
    known: KnownFiles
    readings: Iterator[Readings]
    jobs: Mapping[str, FileToRead]  # By the name of the file's capture
    tell: Progress
    n_read: int = 0
    run_id: int | None = None  # The run of all batches, begun with the first new capture
    found: dict[str, list[world.Found]] = field(default_factory=dict)
    """Axes up of captures, by digest of the skeleton."""
    together: dict[str, str] = field(default_factory=dict)
    """Axis up by name of the capture, where other captures of its skeleton decided."""
    worlds: dict[str, str] = field(default_factory=dict)  # Axis up, by digest of the capture
    takes: list[tuple[str, ...]] = field(default_factory=list)  # Names, of files with several

    def __post_init__(self) -> None:
        """Note no file yet."""
        self.n_files = len(self.jobs)
        self.left = store.NotSaved(self.folders)

    def read(self) -> list[Readings]:
        """Read files that fit into memory together; the file of the database is free meanwhile."""
        batch, n_bytes = list[Readings](), 0
        with store.released(self.opened) if self.known.lacking else nullcontext():
            for reading in self.readings:
                batch.append(reading)
                n_bytes += sum(each.n_bytes for each in reading)
                self.n_read += 1
                self.tell("reading captures", self.n_read, self.n_files)
                if n_bytes > BATCH_BYTES:
                    break
            return self._in_one_world(batch)

    def _in_one_world(self, batch: list[Readings]) -> list[Readings]:
        """Read again captures that are less sure of what is up than others of their skeleton.

        One that stood as still as it may lie gives way to one that moved.
        """
        for each in (reading for readings in batch for reading in readings):
            if each.found is not None and each.skeleton:
                self.found.setdefault(each.skeleton, []).append(each.found)
        for place, readings in enumerate(batch):
            for of_file in readings:
                others = self.found.get(of_file.skeleton, ())
                if of_file.found is None or of_file.is_known or len(others) < 2:
                    continue
                is_moved = any(each.is_by_motion for each in others)
                if of_file.found.is_by_motion or (of_file.found.is_sure and not is_moved):
                    continue
                up, is_sure = world.pooled(others)
                own = world.up_notes(of_file.found)
                if up == of_file.found.up and not (is_sure and own):
                    continue
                batch[place] = self._read_with(up, readings)
                break
        return batch

    def _read_with(self, up: str, readings: Readings) -> Readings:
        """Read a file again with another axis up."""
        name = readings[0].name
        self.together[name] = up
        job = self.jobs.get(name) or self.jobs[name.rpartition("#")[0]]
        told: tuple[str, ...] = (world.AS_OTHERS.format(up=up),)
        if readings[0].found is not None and readings[0].found.up == up:
            again, told = readings, () if up == readings[0].found.usual else told
        else:
            again = next(iter(read_all([replace(job, settings=replace(job.settings, up=up))], 1)))
        own = {note for each in again if each.found for note in each.found.notes}
        return tuple(
            replace(
                each,
                notes=(*(note for note in each.notes if note not in own), *told),
                found=replace(each.found, up=up) if each.found else None,
            )
            for each in again
        )

    def save(self, batch: Sequence[Readings]) -> AddReport:
        """Save what is new in a batch, in one transaction; gives the report of it."""
        opened, sheets, settings = self.opened, self.sheets, self.settings
        readings = [reading for of_file in batch for reading in of_file]
        self.takes += [tuple(r.name for r in of_file) for of_file in batch if len(of_file) > 1]
        faults = [r.problem for r in readings if r.problem and not r.is_known]
        self.left.faulty.update({r.path: r.problem for r in readings if r.problem})
        paths = {reading.name: reading.path for reading in readings}
        with store.reading(opened):  # where nothing is new, nothing is written
            chosen = _sort_readings(opened, readings, settings)
            part = _report_known(opened, sheets, chosen, faults)
            renamed = [(paths[name], known) for name, known in chosen.known if name != known]
            self.left.same.update(renamed)
            is_noted = self.n_read < self.n_files or store.is_noted(opened, self.left)
        if chosen.new or chosen.filled:
            with store.bounded_memory(opened, sum(reading.n_bytes for reading in readings)):
                part = self._save_chosen(readings, faults)
        elif self.known.noted or not is_noted:
            with store.transaction(opened):
                self._save_notes()
        self.known.noted.clear()
        return replace(
            part, known_faulty=tuple(r.problem for r in readings if r.problem and r.is_known)
        )

    def _save_notes(self) -> None:
        """Save what is noted of the files of a batch, and after the last one of those left out."""
        store.save_known_files(self.opened, self.known.noted)
        if self.n_read == self.n_files:
            store.save_not_saved(self.opened, self.left)

    def _save_chosen(self, readings: Sequence[ReadFile], faults: Sequence[str]) -> AddReport:
        """Save what is new, if others have not added it meanwhile; look for copies of it."""
        from motiondb.database import loading  # compiled code

        opened, sheets, settings = self.opened, self.sheets, self.settings
        made = dict[int, loading.OutlineMade]()
        loading.load_outlines(opened)  # keeps them: within a transaction nothing is kept
        with store.transaction(opened):
            chosen = _sort_readings(opened, readings, settings)
            part = _report_known(opened, sheets, chosen, faults)
            if chosen.new or chosen.filled:
                run_id = self.run_id or _start_run(opened, self.folders, sheets, settings)
                self.run_id = run_id
                self._note_worlds(chosen.new)
                for source in chosen.filled:
                    store.fill_in(opened, source)
                part = _save(opened, sheets, settings, chosen, part, run_id)
            if chosen.new:
                motions = {each.name: each.motion for each in chosen.new if each.motion}
                new = set(part.added)
                found, made = loading.find_relations(opened, new, self.workers, motions)
                store.save_relations(opened, found)
                part = replace(part, relations=tuple(found))
            self._save_notes()
        loading.load_outlines(opened, made)  # so that the next ``add`` has them
        return part

    def _note_worlds(self, readings: Sequence[ReadFile]) -> None:
        """Note in the run which axis was up where a new reading could find another one.

        The sheet or other captures say it, or the motion shows one that is not the usual one.
        """
        assert self.run_id is not None
        before = len(self.worlds)
        for each in readings:
            entry = self.sheets.entry(each.name)
            up = (entry and entry.up) or self.together.get(each.name, "")
            if not up and each.skeleton and each.found and each.found.up != each.found.usual:
                up = each.found.up
            if each.source is not None and up and up != self.settings.up:
                self.worlds[each.source.sha256] = up
        if len(self.worlds) > before:
            store.note_in_run(self.opened, self.run_id, worlds=self.worlds)


def _joined(first: AddReport, second: AddReport) -> AddReport:
    """The report of two batches."""
    both = {name: value + vars(second)[name] for name, value in vars(first).items()}
    return AddReport(**both | {"new_words": tuple(sorted({*both["new_words"]}))})


def _start_run(
    opened: store.Store, folders: Sequence[Path], sheets: Sheets, settings: AddSettings
) -> int:
    """The run of all batches."""
    parameters = {
        "folder": ", ".join(map(str, folders)),
        "sheet": sheets.words.path if sheets.words else None,
        "events": sheets.events.path if sheets.events else None,
        **{name: getattr(settings, name) for name in _KEPT_SETTINGS},
        "joint_map": dict(settings.joint_map),
    }
    return store.start_run(opened, "add", parameters)


def _save(
    opened: store.Store,
    sheets: Sheets,
    settings: AddSettings,
    chosen: _Chosen,
    known: AddReport,
    run_id: int,
) -> AddReport:
    """Save the new captures of a batch; inside a transaction.

    `known`: The report without them.
    """
    notes, faults = list(known.notes), list(known.problems)
    seconds, n_events = 0.0, 0
    old = {info.name: info for info in store.load_captures(opened)} if settings.replace else {}
    replaced = {r.name: old[r.name] for r in chosen.new if r.name in old}
    touched = [info.capture_id for info in replaced.values()]
    with updating.counted(opened, run_id, touched) as change:
        saved, kepts = list[store.NewCapture](), list[_Kept]()
        for reading in chosen.new:
            info = extended(
                CaptureInfo,
                reading,
                capture_id=0,
                sha256="",
                format=reading.source.format if reading.source else "",
                kind="captured",
                duration=reading.n_frames / reading.fps,
                motion_frames=0,
                leg_length=0.0,
                run_id=run_id,
                tags=_tags(sheets.entry(reading.name)),
            )
            captions = sheets.words.within(info.name, info.duration, faults) if sheets.words else ()
            assert reading.motion is not None
            assert reading.source is not None
            kept = _Kept.of(opened, replaced[info.name]) if info.name in replaced else _Kept()
            info = replace(info, tags={**kept.tags, **info.tags})
            captions = captions or captions_within(info.name, kept.captions, info.duration, notes)
            saved.append(store.NewCapture(info, reading.motion, reading.source, captions))
            kepts.append(kept)
        infos = store.save_captures(opened, saved)
        for reading, info, kept in zip(chosen.new, infos, kepts):
            given = _save_events(opened, sheets.events, info, faults)
            if not given and kept.events:
                kept.save_events(opened, info, notes)
            elif not given and reading.events:
                store.save_events(opened, info.capture_id, reading.events)
                given = len(reading.events)
            n_events += given
            change.added.append(info.capture_id)
            seconds += info.duration
    notes += _guesses(chosen.new)
    added = tuple(reading.name for reading in chosen.new)
    store.finish_run(opened, run_id)
    return AddReport(
        added,
        chosen.known,
        tuple(faults),
        (),
        tuple(notes),
        seconds,
        len(change.counted),
        change.new_words,
        n_events,
        sum("performer" not in _tags(sheets.entry(name)) for name in added),
        tuple(replaced),
    )


_GUESS = re.compile(
    r"--(up|mirror-world|swap-sides|fps)\b|they slide|radians|unit is a guess"
    r"|if (it|this) is wrong|exchanged|more than once|Nothing moves|straight line|no motion"
    r"|header says|Kept as (?:markers|series)|Lost for long|Another performer|as a copy of them"
)
"""What a note on the reading of a file says where a person should look at it."""


def _guesses(readings: Sequence[ReadFile]) -> list[str]:
    """Notes on what was guessed of files, each once, with the captures that have it."""
    found: dict[str, list[tuple[str, str]]] = {}
    for reading in readings:
        for note in filter(_GUESS.search, reading.notes):
            found.setdefault(re.sub(r"[\d.]+", "", note), []).append((reading.name, note))
    return [
        f"{of[0][0]}{f' and {len(of) - 1} more' * (len(of) > 1)}: {of[0][1]}"
        for of in found.values()
    ]


@dataclass(frozen=True)
class _Kept:
    """What the capture that takes another one's place keeps of it."""

    tags: Mapping[str, str] = field(default_factory=dict)
    captions: tuple[Caption, ...] = ()
    events: tuple[Event, ...] = ()

    @classmethod
    def of(cls, opened: store.Store, info: CaptureInfo) -> _Kept:
        """Load it, and remove the capture."""
        number = info.capture_id
        captions = store.load_captions(opened, [number]).get(number, ())
        events = store.load_events(opened, [number]).get(number, ())
        store.remove_captures(opened, [number])
        return cls(info.tags, captions, events)

    def save_events(self, opened: store.Store, info: CaptureInfo, notes: list[str]) -> None:
        """Save the events that lie within the new capture; a note if there are others."""
        within = [event for event in self.events if event.frame < info.motion_frames]
        if within:
            store.save_events(opened, info.capture_id, within)
        if len(within) < len(self.events):
            left = len(self.events) - len(within)
            notes.append(f"{info.name}: {left} events after the end of the new file were left out")


@dataclass(frozen=True, eq=False)
class _Chosen:
    """Readings that are new, those with known content, and those that cannot be saved."""

    new: tuple[ReadFile, ...]
    known: tuple[tuple[str, str], ...]
    problems: tuple[str, ...]
    filled: tuple[packed_files.Source, ...]  # Files of known captures that were without their bytes
    notes: tuple[str, ...]


def _sort_readings(
    opened: store.Store, readings: Sequence[ReadFile], settings: AddSettings
) -> _Chosen:
    """Divide the readings into new and known ones by the present database.

    A known file that was read again, in the way that is asked for, replaces its own capture.
    """
    replacing = settings.replace
    digests = store.load_digests(opened)
    names = {*digests.values()}
    new: list[ReadFile] = []
    known: list[tuple[str, str]] = []
    problems: list[str] = []
    given = {r.source.sha256: r.source for r in readings if r.source and r.source.data}
    left_out = store.load_left_out(opened, sorted(given.keys() & digests.keys()))
    notes = [f"{digests[d]}: its file, which was left out, is kept now" for d in sorted(left_out)]
    for reading in readings:
        if reading.source is None:
            continue
        holder = digests.get(reading.source.sha256)
        if holder == reading.name and settings.reads_again and not reading.is_known:
            new.append(reading)
        elif holder is not None:
            known.append((reading.name, holder))
            if replacing and reading.name in names and holder != reading.name:
                problems.append(
                    f"{reading.path}: expected new content for {reading.name}, found that of "
                    f"{holder}; {reading.name} was not replaced. Rename or remove {holder} first."
                )
        elif reading.name in names and not replacing:
            problems.append(
                f"{reading.path}: expected a new name, found another capture called "
                f"{reading.name}. Put a folder before the new names (--prefix FOLDER/), or let "
                "the new files take the place of the old ones (--replace)."
            )
        elif reading.is_known:
            problems.append(
                f"{reading.path}: expected the capture that it was added as, found that another "
                "process removed it meanwhile. Add it again."
            )
        else:
            digests[reading.source.sha256] = reading.name
            new.append(reading)
    filled = tuple(given[digest] for digest in sorted(left_out))
    return _Chosen(tuple(new), tuple(known), tuple(problems), filled, tuple(notes))


def _report_known(
    opened: store.Store, sheets: Sheets, chosen: _Chosen, problems: Sequence[str]
) -> AddReport:
    """The report of an ``add`` that saves nothing."""
    notes = [*chosen.notes, *sheet_notes(opened, sheets, chosen.known)]
    return AddReport((), chosen.known, (*problems, *chosen.problems), (), tuple(notes), 0.0)


def _save_events(
    opened: store.Store, sheet: EventSheet | None, info: CaptureInfo, problems: list[str]
) -> int:
    """Save the sheet's events of a capture; gives their number. Later ones become problems."""
    events = sheet.within(info.name, info.motion_frames, problems) if sheet else ()
    if events:
        store.save_events(opened, info.capture_id, events)
    return len(events)


def check_captures(folder: Path) -> None:
    """Check that there is a file or a folder to add, before a database is made.

    Parameters
    ----------
    folder : Path
        The folder, or one capture file.

    Raises
    ------
    MotionDBError
        There is neither.
    """
    if not is_file(folder) and not is_folder(folder):
        actual = odd_kind(folder) or "nothing"
        raise MotionDBError(
            f"{folder}: expected a capture or a folder of captures, found {actual}."
        )


def _files(folder: Path, within: Path | None) -> list[Path]:
    check_captures(folder)
    if is_file(folder):
        return [folder]
    found = files.find_captures(folder, within)
    if not found:
        others = "".join(f"\n{sentence}." for sentence in files.no_captures(folder))
        raise MotionDBError(
            f"{folder}: expected captures ({', '.join(files.CAPTURE_ENDINGS)}), found none."
            + others
        )
    return found


def _text_names(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """Split files into those whose names are text and problems for the others."""
    faults = [(path, files.name_fault(path)) for path in paths]
    usable = [path for path, fault in faults if not fault]
    problems = [
        f"{files.printable(path)}: expected a file name {fault}. Rename the file."
        for path, fault in faults
        if fault
    ]
    return usable, problems


def _tags(entry: SheetEntry | None) -> dict[str, str]:
    return dict(entry.tags) if entry else {}


def check_name_free(opened: store.Store, name: str) -> None:
    """Refuse an empty name, and one that a capture has already."""
    if not name.strip():
        raise QueryError("name: expected a name for the capture, found nothing. Give one.")
    store.check_new_name(name, "capture")
    with store.reading(opened):
        names = {info.name for info in store.load_captures(opened)}
    if name in names:
        raise QueryError(
            f"{name}: expected a name that is free, found a capture of that name. Remove that "
            f"one first (motiondb remove {name}), or give another name."
        )
