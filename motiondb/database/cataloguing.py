"""Adding captures: find the files, read them in parallel, save all that is new in one transaction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motiondb import capture, store
from motiondb.capture.sheet import Sheet, SheetEntry, capture_name
from motiondb.errors import MotionDBError
from motiondb.pose import retarget
from motiondb.records import Caption, CaptureInfo, Motion, Relation
from motiondb.search import copies

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many are done, how many there are."""
_FEW = 4


@dataclass(frozen=True)
class AddSettings:
    """How files are read. unit: metres per length unit (None: found). joint_map: role -> joint."""

    unit: float | None = None
    fps: float | None = None
    skip_bad_frames: bool = False
    joint_map: Mapping[str, str] = field(default_factory=dict)
    jobs: int = 2


@dataclass(frozen=True)
class AddReport:
    """What ``add`` did.

    Attributes
    ----------
    added : names of new captures. known : (name, name it is known by) of files already there.
    problems : a sentence per file or sheet row that could not be used.
    relations : copies, mirror images and cuts found. notes : what was odd but used.
    seconds : motion added.
    """

    added: tuple[str, ...]
    known: tuple[tuple[str, str], ...]
    problems: tuple[str, ...]
    relations: tuple[Relation, ...]
    notes: tuple[str, ...]
    seconds: float


@dataclass(frozen=True, eq=False)
class _Reading:
    """A file read by a worker: everything to save, or why not."""

    name: str
    path: str
    source: store.Source | None = None
    motion: Motion | None = None
    fps: float = 0.0
    n_frames: int = 0
    notes: tuple[str, ...] = ()
    problem: str = ""


def add_captures(
    database: store.Store,
    folder: Path,
    sheet: Sheet | None,
    settings: AddSettings,
    progress: Progress | None = None,
) -> AddReport:
    """Add a file, or all captures below a folder, with the words of a sheet.

    Raises
    ------
    MotionDBError
        when there is nothing to add at the path. Broken files do not raise: they are reported.
    """
    tell = progress or (lambda _what, _done, _total: None)
    files = _files(folder)
    names = {capture_name(_below(path, folder)): path for path in reversed(files)}
    problems = sheet.unknown(names) if sheet else []
    problems += [
        f"{path}: expected one file per name, found {names[capture_name(_below(path, folder))].name}"
        " beside it. Rename one of them."
        for path in files
        if names[capture_name(_below(path, folder))] != path
    ]
    jobs = [
        (name, path, _entry(sheet, name), folder, settings) for name, path in sorted(names.items())
    ]
    readings = []
    for done, reading in enumerate(_read_all(jobs, settings.jobs), start=1):
        readings.append(reading)
        tell("reading captures", done, len(jobs))
    problems += [r.problem for r in readings if r.problem]
    return _save(database, folder, sheet, settings, readings, problems, tell)


def _save(
    database: store.Store,
    folder: Path,
    sheet: Sheet | None,
    settings: AddSettings,
    readings: Sequence[_Reading],
    problems: list[str],
    tell: Progress,
) -> AddReport:
    known, added, notes, seconds = [], [], list(sheet.notes if sheet else ()), 0.0
    digests = store.load_digests(database)
    names = {info.name for info in store.load_captures(database)}
    new: list[_Reading] = []
    for reading in readings:
        if reading.source is None:
            continue
        if reading.source.sha256 in digests:
            known.append((reading.name, digests[reading.source.sha256]))
        elif reading.name in names:
            problems.append(
                f"{reading.path}: expected a new name, found another capture called {reading.name}. "
                f"Remove that one first (motiondb remove {reading.name}) or rename the file."
            )
        else:
            digests[reading.source.sha256] = reading.name
            new.append(reading)
    if not new:
        return AddReport((), tuple(known), tuple(problems), (), tuple(notes), 0.0)
    with store.transaction(database):
        parameters = {
            "folder": str(folder), "sheet": sheet.path if sheet else None, "unit": settings.unit,
            "skip_bad_frames": settings.skip_bad_frames, "joint_map": dict(settings.joint_map),
        }  # fmt: skip
        run_id = store.start_run(database, "add", parameters)
        for done, reading in enumerate(new, start=1):
            info, captions = _info(reading, _entry(sheet, reading.name), run_id, notes)
            assert reading.motion is not None
            assert reading.source is not None
            store.save_capture(database, info, reading.motion, reading.source, captions)
            added.append(reading.name)
            seconds += info.duration
            tell("saving captures", done, len(new))
        tell("looking for copies", 0, 1)
        relations = find_relations(database, set(added))
        store.save_relations(database, relations)
        store.finish_run(database, run_id)
    tell("looking for copies", 1, 1)
    return AddReport(
        tuple(added), tuple(known), tuple(problems), tuple(relations), tuple(notes), seconds
    )


def find_relations(database: store.Store, new: set[str]) -> list[Relation]:
    """Copies, mirror images and cuts among the captures, of which at least one is new."""
    infos = store.load_captures(database)
    pool = store.load_motion_pool(database)
    poses = [copies.copy_poses(pool.motion(info.capture_id)) for info in infos]
    library = copies.build_library(poses)
    fresh = [n for n, info in enumerate(infos) if info.name in new]
    old = [n for n in range(len(infos)) if n not in set(fresh)]
    found = copies.find_copies(library, fresh) + copies.find_copies(library, old, fresh)
    return [
        Relation(
            infos[c.query].name,
            infos[c.take].name,
            c.kind,
            c.start / 30.0,
            c.end / 30.0,
            c.distance,
        )
        for c in found
    ]


def _files(folder: Path) -> list[Path]:
    if folder.is_file():
        return [folder]
    if not folder.is_dir():
        raise MotionDBError(f"{folder}: expected a capture or a folder of captures, found nothing.")
    files = capture.find_captures(folder)
    if not files:
        raise MotionDBError(
            f"{folder}: expected captures ({', '.join(capture.CAPTURE_ENDINGS)}), found none."
        )
    return files


def _below(path: Path, folder: Path) -> str:
    return path.name if path == folder else path.relative_to(folder).as_posix()


def _entry(sheet: Sheet | None, name: str) -> SheetEntry | None:
    return sheet.find(name) if sheet else None


_Job = tuple[str, Path, "SheetEntry | None", Path, AddSettings]


def _read_all(jobs: Sequence[_Job], n_jobs: int) -> Iterator[_Reading]:
    """Readings in the order of the jobs; in other processes where there are more than a few."""
    if len(jobs) <= _FEW or n_jobs == 1:
        yield from (_read_one(*job) for job in jobs)
        return
    from joblib import Parallel, delayed

    yield from Parallel(n_jobs=n_jobs, return_as="generator")(
        delayed(_read_one)(*job) for job in jobs
    )


def _read_one(
    name: str, path: Path, entry: SheetEntry | None, folder: Path, settings: AddSettings
) -> _Reading:
    try:
        data = path.read_bytes()
        kind = capture.capture_format(path)
        asf = _skeleton(path, entry, folder)
        skeleton_data = asf.read_bytes() if asf else None
        fps = entry.fps if entry and entry.fps else settings.fps
        clip = capture.read_capture_bytes(
            data,
            kind,
            path=path,
            skeleton=skeleton_data,
            skeleton_path=asf or "",
            fps=fps,
            unit=settings.unit,
            skip_bad_frames=settings.skip_bad_frames,
        )
        motion = retarget.to_motion(clip, settings.joint_map)
        source = store.pack_source(path.name, data, kind, asf.name if asf else None, skeleton_data)
    except MotionDBError as error:
        message = str(error)
        return _Reading(
            name, str(path), problem=message if str(path) in message else f"{path}: {message}"
        )
    except OSError as error:
        return _Reading(
            name, str(path), problem=f"{path}: expected a readable file, found {error.strerror}."
        )
    if not np.isfinite(motion.root_positions).all():
        return _Reading(name, str(path), problem=f"{path}: expected finite positions, found none.")
    notes = clip.notes + motion.notes
    return _Reading(name, str(path), source, motion, clip.fps, clip.n_frames, notes)


def _skeleton(path: Path, entry: SheetEntry | None, folder: Path) -> Path | None:
    """The ASF of an AMC: as the sheet names it below the folder or beside the file, or found."""
    if path.suffix.lower() != ".amc":
        return None
    if entry and entry.skeleton:
        for base in (folder, path.parent):
            for ending in ("", ".asf"):
                candidate = base / (entry.skeleton + ending)
                if candidate.is_file():
                    return candidate
    return capture.skeleton_path(path)


def _info(
    reading: _Reading, entry: SheetEntry | None, run_id: int, notes: list[str]
) -> tuple[CaptureInfo, tuple[Caption, ...]]:
    duration = reading.n_frames / reading.fps
    captions = []
    for caption in entry.captions if entry else ():
        if caption.start is not None and caption.start >= duration:
            notes.append(
                f"{reading.name}: words {caption.words!r} start at {caption.start:g} s, after the "
                f"capture's end at {duration:g} s, and were left out"
            )
            continue
        captions.append(caption)
    info = CaptureInfo(
        capture_id=0,
        name=reading.name,
        sha256="",
        format=reading.source.format if reading.source else "",
        kind="captured",
        fps=reading.fps,
        n_frames=reading.n_frames,
        duration=duration,
        motion_frames=0,
        leg_length=0.0,
        path=reading.path,
        run_id=run_id,
        tags=dict(entry.tags) if entry else {},
        notes=reading.notes,
    )
    return info, tuple(captions)


def read_joint_map(path: Path) -> dict[str, str]:
    """Read lines ``role = joint`` (# begins a comment) for skeletons that no convention fits.

    Raises
    ------
    MotionDBError
        with every line that is no such pair.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise MotionDBError(f"{path}: expected a readable joint map, found {error}.") from None
    pairs: dict[str, str] = {}
    faults = []
    for number, line in enumerate(lines, start=1):
        text = line.split("#")[0].strip()
        role, equals, joint = (part.strip() for part in text.partition("="))
        if text and not (role and equals and joint):
            faults.append(f"{path}:{number}: expected `role = joint`, found {text!r}.")
        elif text:
            pairs[role] = joint
    if faults:
        raise MotionDBError("\n".join(faults))
    return pairs
