"""Reading capture files: several at a time, in other processes.

A file becomes a record of everything to save, or a sentence with the reason why not. The store is
not used here. A file that ends its process, or takes too much time or memory, becomes such a
sentence too, and the others are read.
"""

from __future__ import annotations

import hashlib
import math
import os
import pickle
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.answers.plain import extended
from motiondb.body import body, retarget
from motiondb.body.world import UPS, Found
from motiondb.errors import CaptureError, MotionDBError, NoBodyError
from motiondb.files import formats
from motiondb.files.folder import WITH_SKELETON, named_skeleton, skeleton_path
from motiondb.files.limits import (
    NO_LIMITS,
    ReadLimits,
    ReadOptions,
    SkeletonFile,
    cap_memory,
    guarded,
)
from motiondb.files.packed_files import Source, leave_out, pack_source
from motiondb.files.processes import in_processes, interrupts_wait, pool_of
from motiondb.files.readers.child_process import how_ended, too_slow
from motiondb.files.safe_files import read_bounded_text
from motiondb.files.sheets import SheetEntry
from motiondb.files.text import quoted
from motiondb.records import MOTION_FPS, CaptureInfo, Clip, Event, Motion, Skeleton
from motiondb.workers import is_array, trusted

if TYPE_CHECKING:
    from pebble import ProcessPool

    from motiondb.database.cluster import Cluster

_FEW = 4  # Files that are read faster than other processes start
_GRACE = 2.0
"""A process that reads for this multiple of a file's time limit is ended: then the limit could not
interrupt it, because it was inside a library."""
_PROCESS_MEMORY = 4.0
"""A process may take this multiple of the memory of a clip: resampling and solving the canonical
body hold a few arrays of the same size."""


@dataclass(frozen=True)
class AddSettings:
    """How files are read."""

    unit: float | None = None
    """Metres per length unit; None: the unit in each file, or estimated from the size of the
    body."""
    fps: float | None = None
    """Frames per second, instead of the rates in the files."""
    up: str = ""
    """The axis that points up in every file: "x", "y", "z", "-x", "-y" or "-z"; "": as each file
    says, or found from its motion."""
    mirror_world: bool = False
    """The axes of the files are left-handed: what they show are mirror images."""
    swap_sides: bool = False
    """The names of left and right are exchanged in the files."""
    skip_bad_frames: bool = False
    """Leave out bad frames instead of refusing their file."""
    joint_map: Mapping[str, str] = field(default_factory=dict)
    """Role -> joint name, for skeletons that no convention fits."""
    jobs: int = 2
    """Processes that read files."""
    limits: ReadLimits = field(default_factory=ReadLimits)
    """Limits for reading one file."""
    keep_implausible: bool = False
    """Keep captures that move faster than people can."""
    skeleton: Path | None = None
    """The skeleton file of the captures whose sheet names none: the model (MJCF, URDF) of a robot,
    an ASF, or names of joints, one a line."""
    outside_skeletons: bool = False
    """Allow a sheet to name skeletons outside the added folder."""
    within: Path | None = None
    """Folder that links must not lead out of; None: they may lead anywhere."""
    prefix: str = ""
    """Put before the name of every capture, such as "studio2/"."""
    replace: bool = False
    """Replace captures of the same names; captions, tags and events that no sheet gives are
    kept. Known files are read again if it is said how (unit, fps, up, sides, joints)."""
    originals: bool = True
    """Keep the files as they are, so that they can be exported bit for bit."""
    check_bytes: bool = False
    """Look at the bytes of files whose size and time of modification are known, too."""

    @property
    def is_asked(self) -> bool:
        """Whether files are to be read in another way than as they say."""
        asked = (self.up, self.mirror_world, self.swap_sides, self.unit, self.fps)
        return any(asked) or bool(self.joint_map) or self.skip_bad_frames

    @property
    def reads_again(self) -> bool:
        """Whether known files are read again, to replace their captures."""
        return self.replace and self.is_asked


@dataclass(frozen=True, eq=False)
class ReadFile:
    """A file that was read: everything to save, or why not."""

    name: str  # Name of the capture
    path: str
    source: Source | None = None  # The file's bytes and digest
    motion: Motion | None = None
    fps: float = 0.0  # Frames per second of the file
    n_frames: int = 0  # Frames of the file
    notes: tuple[str, ...] = ()  # What is unusual in the file
    skeleton: str = ""  # Digest of its joints where the axis up was found from the motion
    found: Found | None = None  # This axis
    problem: str = ""  # Why the file cannot be saved; "" where it can
    events: tuple[Event, ...] = ()  # That the file names
    is_known: bool = False  # It was read before, and is the same; then motion and bytes are missing

    @property
    def n_bytes(self) -> int:
        """Memory that its motion and its packed files take, bytes."""
        arrays = () if self.motion is None else vars(self.motion).values()
        packed = (self.source.data, self.source.skeleton_data or b"") if self.source else ()
        return sum(map(len, packed)) + sum(a.nbytes for a in arrays if isinstance(a, np.ndarray))


Readings = tuple[ReadFile, ...]  # Of one file: more than one where it holds several takes


@dataclass(frozen=True)
class FileToRead:
    """A file to read, and how."""

    name: str  # Of its capture
    path: Path
    entry: SheetEntry | None  # What a sheet says of it
    folder: Path  # The folder that is added
    settings: AddSettings

    def seconds(self, n_bytes: int) -> float:
        """Seconds that reading so many bytes may take."""
        return self.settings.limits.seconds_for(n_bytes)

    def options(self) -> ReadOptions:
        """How it is read, by its sheet and the settings."""
        settings, entry = self.settings, self.entry
        fps = entry.fps if entry and entry.fps else settings.fps
        up = entry.up if entry and entry.up else settings.up
        options = extended(ReadOptions, settings, fps=fps, up=up)
        return formats.with_rate_beside(self.path, options)

    def skeleton(self) -> Path | None:
        """The skeleton file that the capture needs; CaptureError if it is not found."""
        entry, path, given = self.entry, self.path, self.settings.skeleton
        endings = WITH_SKELETON.get(path.suffix.lower(), ())
        named = entry.skeleton if entry and endings else None
        if not named:
            fits = given is not None and given.suffix.lower() in endings
            return skeleton_path(path, given if fits else None)
        return named_skeleton(path, named, self.folder, self.settings.outside_skeletons)


def read_all(
    jobs: Sequence[FileToRead], n_jobs: int, workers: Cluster | None = None
) -> Iterator[Readings]:
    """Read files, in other processes if there are more than a few; readings in order of the jobs.

    `workers`: Who reads in place of processes of this machine; the files' bytes are sent to them.

    A file with several takes becomes as many readings.

    A file that kills its process, or takes too long, becomes a problem; the others go on.
    """
    if workers is not None:
        yield from _read_by(workers, jobs)
        return
    if len(jobs) <= _FEW or n_jobs == 1:
        yield from map(_read, jobs)
        return
    try:
        folder = str(Path.cwd())
    except FileNotFoundError:  # it was removed meanwhile
        folder = os.sep
    n_jobs = min(n_jobs, len(jobs))
    yield from in_processes(jobs, n_jobs, partial(_submit, folder), partial(_result, folder))


def _submit(folder: str, pool: ProcessPool, job: FileToRead) -> Future[Readings]:
    """Hand out a file; the first starts the processes."""
    n_bytes = _size(job.path)
    seconds = min(_GRACE * job.seconds(n_bytes), threading.TIMEOUT_MAX)
    packed = pickle.dumps(job)  # a process that dies from it has then said that it has begun
    return pool.schedule(_read_beside, args=(folder, packed, n_bytes), timeout=seconds)


def _result(folder: str, job: FileToRead, future: Future[Readings] | None) -> Readings:
    """The result for a file that was handed out; it is read again if its process ended.

    A process may end without fault of the file: the system ends one where memory is short, and the
    pool breaks if a process ends that has no file.
    """
    from pebble import ProcessExpired

    try:
        return _read_alone(folder, job) if future is None else future.result()
    except (BrokenProcessPool, ProcessExpired):
        return _read_alone(folder, job)
    except TimeoutError:
        return _too_slow(job, _size(job.path))


def _read_alone(folder: str, job: FileToRead) -> Readings:
    """Read a file in a process of its own, or in this one if the system lets none start."""
    from pebble import ProcessExpired

    with pool_of(1) as pool:
        try:
            with interrupts_wait():
                future = _submit(folder, pool, job)
        except (OSError, RuntimeError):
            return _read(job)
        try:
            return future.result()
        except TimeoutError:
            return _too_slow(job, _size(job.path))
        except ProcessExpired as error:
            return _refused(job, how_ended(error.exitcode))
        except BrokenProcessPool as error:
            return _refused(job, how_ended(1, str(error).encode()))


def _refused(job: FileToRead, fault: str) -> Readings:
    """The result for a file that could not be read."""
    return (_with_problem(job.name, job.path, CaptureError(job.path, fault)),)


def _too_slow(job: FileToRead, n_bytes: int) -> Readings:
    """The result for a file of so many bytes that takes too long."""
    return _refused(job, too_slow(_GRACE * job.seconds(n_bytes)))


def _read_beside(folder: str, packed: bytes, n_bytes: int) -> Readings:
    """Read in another process; ``folder`` is the working directory of the one that asks."""
    os.chdir(folder)
    job: FileToRead = pickle.loads(packed)
    limits = job.settings.limits
    cap_memory(_PROCESS_MEMORY * max(limits.memory, _PROCESS_MEMORY * n_bytes))
    return _read(job)


def _read_by(workers: Cluster, jobs: Sequence[FileToRead]) -> Iterator[Readings]:
    """Load files here, and have workers read them; readings in order of the jobs.

    Bytes, names and digests are those of this process: only what is read in the files is theirs.
    """
    from motiondb.database.cluster import Bounds

    pieces = ((job, _load(job)) for job in jobs)
    bounds: Bounds[_Piece, Readings] = Bounds(
        lambda piece: _GRACE * piece[0].seconds(_n_bytes(piece[1])),
        lambda piece: _too_slow(piece[0], _n_bytes(piece[1])),
        lambda piece: _refused(
            piece[0],
            "expected a file that workers can read, found that several ended with it. Look at "
            "their logs; add it without --cluster, or give them more memory.",
        ),
    )
    for piece, found in trusted(workers, _are_readings, _read_loaded, pieces, bounds=bounds):
        yield _with_source(*piece, found)


def _are_readings(found: Readings, piece: _Piece) -> bool:
    """Whether a worker's readings can be those of a file: names, kinds, shapes, and the ground."""
    job, loaded = piece
    names = [reading.name for reading in found]
    takes = [name.removeprefix(job.name) for name in names]
    return not isinstance(loaded, _Loaded) or (
        type(found) is tuple
        and len({*names}) == len(names) > 0
        and (takes == [""] or all(take[:1] == "#" and take.isprintable() for take in takes))
        and all(each.name == job.name + take for each, take in zip(found, takes))
        and all(each.path in (f"{job.path}", f"{job.path}{t}") for each, t in zip(found, takes))
        and all(map(_is_reading, found))
    )


def _is_reading(reading: ReadFile) -> bool:
    """Whether a reading has the fields of one, and its motion stands on the ground at (0, 0)."""
    motion, problem = reading.motion, reading.problem
    if problem or motion is None:
        return type(problem) is str and motion is None and problem != ""
    n_frames, root = round(reading.n_frames / reading.fps * MOTION_FPS), motion.root_positions
    positions, _ = retarget.motion_positions(motion)
    return (
        isinstance(reading.n_frames, int)
        and isinstance(motion.leg_length, float)
        and all(type(note) is str for note in (*reading.notes, *motion.notes))
        and all(type(e) is Event and 0 <= e.frame < motion.n_frames for e in reading.events)
        and is_array(root, (max(n_frames, 1), 3))
        and is_array(motion.local_rotations, (len(root), len(body.JOINTS), 4))
        and np.allclose(np.linalg.norm(motion.local_rotations, axis=-1), 1.0, atol=1e-3)
        and bool((root[0, [0, 2]] == 0.0).all())
        and abs(retarget.ground_height(positions)) < 1e-3
        and motion.leg_length >= 0.0
        and type(reading.skeleton) is str
        and isinstance(reading.found, Found)
        and {reading.found.up, reading.found.usual} <= {*UPS}
        and len(reading.found.scores) == len(UPS)
        and all(isinstance(s, float) and math.isfinite(s) for s in reading.found.scores)
        and all(type(note) is str for note in reading.found.notes)
    )


@dataclass(frozen=True, eq=False)
class _Loaded:
    """The bytes of a file and of its skeleton, and how they are read."""

    options: ReadOptions
    kind: str
    data: bytes
    asf: Path | None
    skeleton_data: bytes | None


_Piece = tuple[FileToRead, _Loaded | Readings]
"""A file that was loaded; or the reading that says why it cannot be."""


def _n_bytes(loaded: _Loaded | Readings) -> int:
    return len(loaded.data) if isinstance(loaded, _Loaded) else 0


def _read(job: FileToRead) -> Readings:
    """Read a file and its skeleton, and solve the canonical body for each of its takes."""
    loaded = _load(job)
    return _with_source(job, loaded, _read_loaded((job, loaded)))


def _with_source(job: FileToRead, loaded: _Loaded | Readings, readings: Readings) -> Readings:
    """Readings with the packed file, by the process that loaded it."""
    if not isinstance(loaded, _Loaded):
        return loaded
    skeleton = loaded.asf.name if loaded.asf else None
    given = job.path.name, loaded.data, loaded.kind, skeleton, loaded.skeleton_data

    def packed(name: str) -> Source:
        source = pack_source(*given, name[len(job.name) + 1 :])
        return source if job.settings.originals else leave_out(source)

    try:
        with guarded(job.path):
            return tuple(
                each if each.problem else replace(each, source=packed(each.name))
                for each in readings
            )
    except MotionDBError as error:
        return (_with_problem(job.name, job.path, error),)


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _load(job: FileToRead) -> _Loaded | Readings:
    """Load a file and its skeleton; an error becomes the problem of the reading."""
    path, options = job.path, job.options()
    try:
        with guarded(path, job.seconds(_size(path))):
            formats.capture_format(path)
            data = formats.read_file(path, options)
            kind = formats.data_format(data, path)
            asf = job.skeleton()
            skeleton_data = formats.read_skeleton(asf, options) if asf else None
            return _Loaded(options, kind, data, asf, skeleton_data)
    except MotionDBError as error:
        return (_with_problem(job.name, path, error),)


def _read_loaded(piece: _Piece) -> Readings:
    """Read a file that was loaded; an error becomes the problem of the reading."""
    job, loaded = piece
    if not isinstance(loaded, _Loaded):
        return loaded
    try:
        with guarded(job.path, job.seconds(len(loaded.data))):
            return _solve_takes(job, loaded)
    except MotionDBError as error:
        return (_with_problem(job.name, job.path, error),)


def _with_problem(name: str, path: Path, error: MotionDBError) -> ReadFile:
    """Return the reading of what cannot be saved."""
    message = str(error)
    problem = message if str(path) in message else f"{path}: {message}"
    return ReadFile(name, str(path), problem=problem)


def _solve_takes(job: FileToRead, loaded: _Loaded) -> Readings:
    """Solve the canonical body for each take of a file."""
    path, data, kind, asf = job.path, loaded.data, loaded.kind, loaded.asf
    skeleton_data, options = loaded.skeleton_data, loaded.options
    skeleton = SkeletonFile(skeleton_data, asf) if skeleton_data is not None else None
    try:
        clips = formats.read_takes_bytes(data, kind, path=path, skeleton=skeleton, options=options)
    except NoBodyError as error:
        return (_with_events(_as_markers(job.name, loaded, path, skeleton, error), loaded, ""),)
    readings = []
    for take, clip in clips.items():
        of = f"{job.name}#{take}" if take else job.name
        try:
            solved = _solved(of, path, clip, job.settings)
            readings.append(_with_events(solved, loaded, take))
        except MotionDBError as error:
            if len(clips) == 1:
                raise
            readings.append(_with_problem(of, Path(f"{path}#{take}"), error))
    return tuple(readings)


def _with_events(reading: ReadFile, loaded: _Loaded, take: str) -> ReadFile:
    """Return a reading with the events of its file, unless frames were left out of it."""
    if loaded.options.skip_bad_frames:
        return reading
    assert reading.motion is not None
    found = formats.read_events_bytes(
        loaded.data, loaded.kind, path=reading.path, fps=reading.fps, take=take
    )
    last = reading.motion.n_frames - 1
    events = {replace(event, frame=min(event.frame, last)) for event in found}
    return replace(reading, events=tuple(sorted(events)))


def _as_markers(
    name: str, loaded: _Loaded, path: Path, skeleton: SkeletonFile | None, error: NoBodyError
) -> ReadFile:
    """Keep markers without a body."""
    # other files are read without the store
    from motiondb.database.catalogue.marker_captures import kept_markers

    tracks, motion, told = kept_markers(
        loaded.data, loaded.kind, path, skeleton, loaded.options, error
    )
    notes = (told, *tracks.notes)
    return ReadFile(name, str(path), None, motion, tracks.fps, len(tracks.places), notes)


def _solved(name: str, path: Path, clip: Clip, settings: AddSettings) -> ReadFile:
    """Solve the canonical body for a clip."""
    motion, found = retarget.solved(clip, settings.joint_map, settings.keep_implausible)
    if not (np.isfinite(motion.root_positions).all() and np.isfinite(motion.local_rotations).all()):
        raise CaptureError(path, "expected finite positions, found none.")
    pose = ("The file has one frame: a pose, no motion.",) if clip.n_frames == 1 else ()
    notes = clip.notes + pose + motion.notes
    skeleton = "" if clip.up else _digest(clip.skeleton)
    return ReadFile(name, str(path), None, motion, clip.fps, clip.n_frames, notes, skeleton, found)


def _digest(skeleton: Skeleton) -> str:
    """Return a digest of the joints of a skeleton, their hierarchy and their places."""
    places = np.round(skeleton.offsets[1:], 4) + 0.0  # a root may stand anywhere
    content = repr((skeleton.names, skeleton.parents.tolist(), places.tolist()))
    return hashlib.sha256(content.encode("utf-8", "surrogatepass")).hexdigest()


def read_joint_map(path: Path) -> dict[str, str]:
    """Read lines ``role = joint`` (# begins a comment) for skeletons that no convention fits.

    Raises
    ------
    MotionDBError
        with every line that is not such a pair.
    """
    try:
        lines = read_bounded_text(path).splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "another encoding than UTF-8"
        raise MotionDBError(f"{path}: expected a readable joint map, found: {reason}.") from None
    pairs: dict[str, str] = {}
    faults = []
    for number, line in enumerate(lines, start=1):
        text = line.split("#")[0].strip()
        role, equals, joint = (part.strip() for part in text.partition("="))
        if text and not (role and equals and joint):
            faults.append(f"{path}:{number}: expected `role = joint`, found {quoted(text)}.")
        elif text:
            pairs[role] = joint
    if faults:
        raise MotionDBError("\n".join(faults))
    return pairs


def read_source(name: str, source: Source, options: ReadOptions) -> Clip:
    """The clip of a stored file, read with :func:`stored_options` as it was when it was added."""
    skeleton = stored_skeleton(source)
    return formats.read_capture_bytes(
        source.data, source.format, path=name, skeleton=skeleton, options=options
    )


def stored_skeleton(source: Source) -> SkeletonFile | None:
    """The skeleton file that was stored beside a file, if any."""
    data = source.skeleton_data
    return None if data is None else SkeletonFile(data, source.skeleton_name or "")


def stored_options(
    info: CaptureInfo, source: Source, parameters: Mapping[str, object], fps: float | None
) -> ReadOptions:
    """How a stored file was read when it was added, without limits."""
    unit, worlds = parameters.get("unit"), parameters.get("worlds")
    up = worlds.get(info.sha256) if isinstance(worlds, Mapping) else None
    return ReadOptions(
        fps=fps,
        unit=float(str(unit)) if unit else None,
        skip_bad_frames=bool(parameters.get("skip_bad_frames")),
        up=str(up or parameters.get("up") or ""),
        mirror_world=bool(parameters.get("mirror_world")),
        swap_sides=bool(parameters.get("swap_sides")),
        limits=NO_LIMITS,
        take=source.take,
    )
