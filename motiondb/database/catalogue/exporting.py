"""Motion that leaves the database: changed as a user asks, then written.

The changes are the same for captures, generated and joined motion. Each says what it did.
Captures also leave as a data set in the form of another program.
"""

from __future__ import annotations

import importlib.util
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from motiondb import answers, store
from motiondb.answers.catalogue import Exported, MatchFile
from motiondb.answers.plain import to_json
from motiondb.body import body, changes, retarget
from motiondb.body.contacts import find_contacts
from motiondb.body.joint_names import joint_map
from motiondb.body.joint_proposals import map_text
from motiondb.body.kinematics import clip_positions
from motiondb.database.catalogue import parts
from motiondb.database.catalogue.parts import check_new_folder
from motiondb.database.session import Session
from motiondb.errors import CaptureError, QueryError, SkeletonError
from motiondb.files import humanml3d, packed_files
from motiondb.files.arrays import ARRAY_ENDINGS, ROBOT_ENDINGS, write_arrays, write_robot
from motiondb.files.limits import MAX_FPS, MIN_FPS
from motiondb.files.own_files import WRITER, check_overwriting, digest_of, provenance_path
from motiondb.files.readers.first_bytes import MODEL_ENDINGS
from motiondb.files.rigs import own_rig, read_model, read_rig
from motiondb.files.safe_files import whole_folder, write_bytes
from motiondb.files.sheet_writer import write_table
from motiondb.files.units import UNITS
from motiondb.generate.cycles import Cycle, looped
from motiondb.generate.material import SequenceMotion
from motiondb.generate.onto import at_rest, onto
from motiondb.generate.onto_hinges import FittedRobot, onto_robot
from motiondb.records import (
    MOTION_FPS,
    BoolArray,
    CaptureInfo,
    Clip,
    Fit,
    FloatArray,
    Match,
    Motion,
)

_UNUSUAL = re.compile(r"[^\w.-]+")  # Characters that names of files of matches do not have
GLTF = (".glb", ".gltf")
FIXED_UNITS = MappingProxyType(
    {".glb": 1.0, ".gltf": 1.0, ".fbx": 0.01} | dict.fromkeys(ARRAY_ENDINGS, 1.0)
)
"""Ending -> metres per length unit, of formats that are written in no other."""


@dataclass(frozen=True)
class MotionChanges:
    """How a motion is changed before it is written."""

    unit: float | None = None
    """Metres per length unit of the file; None: a centimetre for a new BVH of a capture in another
    format, otherwise that of the capture."""
    fps: float | None = None
    """Frames per second of the file; None: those of the capture. Rotations are interpolated along
    the shortest arc."""
    loop: bool = False
    """Whether a cycle is cut out and closed, so that its first frame follows its last."""
    in_place: bool = False
    """Whether the travel over the ground is taken out."""
    mirror: bool = False
    """Whether left and right are exchanged."""
    onto: Path | None = None
    """File with a rig (.bvh, .fbx, .glb or .gltf), onto whose joints and proportions the motion on
    the canonical body is put; the model of a robot (MJCF, URDF), for whose hinges it is solved; or
    "lafan1", "soma", "mixamo" or "smpl", rigs of this program with the joints of these."""
    joint_map: Mapping[str, str] = field(default_factory=dict)
    """Role -> joint name, for a rig, or a capture, that no convention fits."""
    is_cycle: bool = False
    """Whether the first frame follows the last already, as after ``loop``."""
    own_unit: bool = False
    """Whether the unit of the capture is kept in every file."""
    speed: float = 1.0
    """Tempo of the file: 2 is twice as fast, with the frames between interpolated."""
    reduce_keys: float | None = None
    """Degrees, and centimetres, within which keys of glTF are left out; None: a key a frame."""

    @property
    def of_motion(self) -> MotionChanges:
        """Those that make another motion, which shows other things: loop, in place, mirror."""
        return MotionChanges(loop=self.loop, in_place=self.in_place, mirror=self.mirror)

    @property
    def of_file(self) -> MotionChanges:
        """The others, for a motion that the first have changed."""
        is_cycle = self.is_cycle or self.loop
        return replace(self, loop=False, in_place=False, mirror=False, is_cycle=is_cycle)

    @property
    def are_any(self) -> bool:
        """Whether anything is asked for."""
        return self != MotionChanges(joint_map=self.joint_map, own_unit=self.own_unit)


def check_joint_map(asked: MotionChanges, uses_names: bool) -> None:
    """Refuse a joint map that nothing uses (QueryError).

    `uses_names`: Whether the joints of the motion itself are named by it.
    """
    if asked.joint_map and asked.onto is None and not uses_names:
        raise QueryError(
            "joint map: expected a rig for it (--onto RIG), found none; nothing would use it. "
            "Name the rig, or leave the map out."
        )


def check_changes(asked: MotionChanges, path: Path) -> None:
    """Refuse changes that a file cannot have (QueryError)."""
    fps, unit = asked.fps, asked.unit
    if fps is not None and not (math.isfinite(fps) and MIN_FPS <= fps <= MAX_FPS):
        raise QueryError(
            f"fps: expected a frame rate from {MIN_FPS:g} to {MAX_FPS:g}, found {fps:g}."
        )
    if unit is not None and not LEAST_UNIT <= unit <= LARGEST_UNIT:
        raise QueryError(
            f"unit: expected {LEAST_UNIT:g} to {LARGEST_UNIT:g} metres, found {unit:g}."
        )
    if not 0.1 <= asked.speed <= 10.0:
        raise QueryError(f"speed: expected 0.1 to 10, found {asked.speed:g}.")
    if asked.reduce_keys is not None and path.suffix.lower() not in GLTF:
        raise QueryError(
            f"{path}: expected .glb or .gltf to reduce keys, found {path.suffix or 'no ending'}. "
            "BVH, USD and arrays hold every frame, and Blender writes FBX with a key a frame."
        )
    fixed = FIXED_UNITS.get(path.suffix.lower(), unit)
    if unit is not None and unit != fixed:
        raise QueryError(
            f"{path}: expected the unit {unit_name(fixed or 1.0)} for {path.suffix}, which has no "
            f"other, found {unit_name(unit)}."
        )
    if path.suffix.lower() not in ARRAY_ENDINGS:
        parts.check_motion_file(path, ARRAY_ENDINGS)


def formats_here() -> tuple[str, ...]:
    """The formats that can be written on this computer, as endings without the dot.

    FBX needs Blender, USD and Parquet need packages.
    """
    needed = {".parquet": importlib.util.find_spec("pyarrow") is not None}

    def can(ending: str) -> bool:
        try:
            if ending not in ARRAY_ENDINGS:
                parts.check_motion_file(Path(f"motion{ending}"))
        except CaptureError:
            return False
        return needed.get(ending, True)

    endings = (".bvh", ".glb", ".fbx", ".usd", *ARRAY_ENDINGS)
    return tuple(ending[1:] for ending in endings if can(ending))


@dataclass(frozen=True, eq=False)
class Changed:
    """A clip after changes, as it stands in a file."""

    clip: Clip
    said: tuple[str, ...]  # A sentence for everything that was done
    first: int = 0  # Frame of the clip before at which it begins
    fit: Fit | None = None  # How well a rig follows it


def changed(clip: Clip, asked: MotionChanges) -> Changed:
    """Change a clip."""
    said: list[str] = []
    first = 0
    if asked.loop or asked.in_place or asked.mirror:
        clip, said = _upright(clip, asked)
    if asked.mirror:
        changes.check_pairs(clip)
        clip = changes.mirrored(clip)
        said.append("mirrored: left and right are exchanged")
    if asked.loop:
        loop = looped(clip, asked.joint_map, asked.in_place)
        first = round(loop.start * clip.fps)
        clip = loop.clip
        said += _say_loop(loop)
    if asked.in_place:
        hips = changes.from_hips(clip, asked.joint_map)
        way = retarget.clip_keypoints(clip, asked.joint_map)[:, 0]
        part, length = changes.in_place(hips.clip, way, asked.loop or asked.is_cycle)
        clip = hips.restored(part)
        said.append(f"in place: {length:.2f} m of travel are taken out, the sway is kept")
    if asked.speed != 1.0:
        slower = changes.resampled(clip, clip.fps / asked.speed, asked.loop or asked.is_cycle)
        said.append(f"{asked.speed:g} times as fast: {clip.duration:.2f} s became ")
        clip = replace(slower, fps=clip.fps)
        said[-1] += f"{clip.duration:.2f} s"
    if asked.fps is not None and asked.fps != clip.fps:
        before = clip.fps
        clip = changes.resampled(clip, asked.fps, asked.loop or asked.is_cycle)
        said.append(f"resampled from {before:g} to {asked.fps:g} frames a second")
    if asked.unit is not None:
        clip = replace(clip, unit=asked.unit)
    return Changed(clip, tuple(said), first)


def _upright(clip: Clip, asked: MotionChanges) -> tuple[Clip, list[str]]:
    """Turn a clip so that y is up, and say from what."""
    turned = changes.upright(clip, asked.joint_map)
    up = clip.up or retarget.up_axis(clip, asked.joint_map)
    return turned, [f"turned from {up} up to y up"] if turned is not clip else []


@dataclass(frozen=True, eq=False)
class ChangedSequence:
    """A new motion after changes, with the origin of its frames."""

    made: SequenceMotion
    said: tuple[str, ...]
    first: int  # Frame of the motion before at which it begins


def change_sequence(made: SequenceMotion, asked: MotionChanges) -> ChangedSequence:
    """Change a new motion on the canonical body, before it is judged, drawn and kept."""
    before = retarget.to_clip(made.motion)
    done = changed(before, asked.of_motion)
    clip, first = done.clip, done.first
    size = made.motion.leg_length / body.LEG_LENGTH
    motion = replace(
        made.motion,
        local_rotations=clip.local_rotations.astype(np.float32),
        root_positions=(clip.root_positions / size).astype(np.float32),
    )
    frames = np.arange(first, first + clip.n_frames)
    names = {"loop": asked.loop, "in place": asked.in_place, "mirror": asked.mirror}
    more = [name for name, wanted in names.items() if wanted]
    ends = np.clip(np.cumsum([0, *made.lengths]) - first, 0, clip.n_frames)
    edits = tuple(", ".join(filter(None, [made.edits[frame], *more])) for frame in frames)
    part = SequenceMotion(
        motion, made.captures[frames], made.frames[frames], edits, tuple(np.diff(ends).tolist())
    )
    return ChangedSequence(part, done.said, first)


def _say_loop(loop: Cycle) -> list[str]:
    """Say what was done to close a cycle."""
    travel = f"it travels {loop.travel:.2f} m" if loop.travel > 0.01 else "it stays where it is"
    if abs(loop.turning) > math.radians(0.5):
        travel += f" and turns by {math.degrees(loop.turning):.1f} degrees"
    said = [
        f"loop: {loop.start:.2f}-{loop.end:.2f} s of the motion, {loop.clip.duration:.2f} s long; "
        f"the first frame follows the last, and {travel} a cycle",
        f"loop: both ends were {100 * loop.gap:.1f} cm apart at most, and were bent together; the "
        f"largest step of a joint over the seam is {100 * loop.step:.1f} cm, elsewhere "
        f"{100 * loop.usual_step:.1f} cm",
    ]
    if abs(loop.turn) > math.radians(0.5):
        said.append(f"loop: a turn of {math.degrees(loop.turn):.1f} degrees was taken out")
    if loop.gap > _WIDE:
        said.append("loop: the ends are far apart, so the seam will be seen; choose another part")
    return said


LEAST_UNIT, LARGEST_UNIT = 1e-4, 10.0  # Metres; a body in other units is not found again
_WIDE = 0.25  # Metres between both ends of a cycle that no blend hides


def unit_name(unit: float) -> str:
    """Return the name of a length unit, or its metres.

    >>> unit_name(0.01), unit_name(0.5)
    ('cm', '0.5 m')
    """
    return next((name for name, metres in UNITS.items() if metres == unit), f"{unit:.4g} m")


def unit_in(path: Path, clip: Clip) -> str:
    """Return the name of the length unit in which a file has a clip."""
    return unit_name(FIXED_UNITS.get(path.suffix.lower(), clip.unit))


def write_changed(clip: Clip, path: Path, asked: MotionChanges, owner: str = "") -> Changed:
    """Write a clip with changes; a file that has a place for it says whose it is."""
    check_changes(asked, path)
    said: list[str] = []
    if asked.unit is None and not asked.own_unit and clip.format != "bvh":
        clip = replace(clip, unit=0.01)
    if path.suffix.lower() != ".bvh":  # BVH has the axes of the file, the others have y up
        with suppress(SkeletonError):  # joints that are not known have no up
            clip, said = _upright(clip, asked)
    done = changed(clip, asked)
    return replace(done, said=(*said, *done.said, *_write(done.clip, path, asked, owner)))


def _write(clip: Clip, path: Path, asked: MotionChanges, owner: str) -> tuple[str, ...]:
    """Write a clip in the format that the ending names; return what is missing in the file."""
    if path.suffix.lower() not in ARRAY_ENDINGS:
        return parts.write_clip(clip, path, owner, asked.reduce_keys or 0.0)
    try:
        write_arrays(clip, path, _contacts(clip, asked))
    except SkeletonError as error:
        write_arrays(clip, path)
        return (f"without contacts of the feet: {error}",)
    return ()


def write_motion(motion: Motion, path: Path, asked: MotionChanges, owner: str = "") -> Changed:
    """Write a motion of the canonical body, or of a rig, with changes."""
    if asked.onto is None:
        return write_changed(retarget.to_clip(motion), path, asked, owner)
    check_changes(asked, path)
    if asked.onto.suffix.lower() in MODEL_ENDINGS:
        return _write_on_robot(motion, path, asked, owner)
    rig = read_rig(asked.onto, asked.joint_map)
    fitted = onto(motion, rig, _map_of(rig, path, asked))
    done = changed(fitted.clip, asked)
    clip = done.clip
    # a BVH may have joint frames of its own beside the pose in which it stands
    has_frames = bool((abs(rig.local_rotations[..., 0]) < 1.0).any())
    own = path.suffix.lower() in GLTF or (asked.onto.suffix.lower() == ".bvh" and has_frames)
    clip = clip if own else at_rest(clip, fitted.rig)
    missing = _write(clip, path, asked, owner)
    said = (*_say_fit(asked.onto, fitted.fit), *done.said, *missing)
    return Changed(clip, said, fit=fitted.fit)


def _write_on_robot(motion: Motion, path: Path, asked: MotionChanges, owner: str) -> Changed:
    """Write a motion of the canonical body on the hinges of a robot, with changes."""
    assert asked.onto is not None
    robot = read_model(asked.onto)
    first = changed(retarget.to_clip(motion), asked.of_motion)
    size = motion.leg_length / body.LEG_LENGTH
    before = replace(
        motion,
        local_rotations=first.clip.local_rotations.astype(np.float32),
        root_positions=(first.clip.root_positions / size).astype(np.float32),
    )
    fitted = onto_robot(before, robot, asked.joint_map)
    said = [*first.said, *_say_robot(asked.onto, fitted)]
    made = fitted.motion
    if asked.speed != 1.0 or asked.fps not in (None, made.fps):
        made = made.resampled(asked.fps or made.fps, asked.speed)
        tempo = "" if asked.speed == 1.0 else f", {asked.speed:g} times as fast"
        said.append(f"interpolated to {made.fps:g} frames a second{tempo}")
    clip = made.clip()
    if path.suffix.lower() in ROBOT_ENDINGS:
        beside = write_robot(path, robot, made.fps, made.root, made.turns, made.values)
        order = "x, y, z, w" if beside else "w, x, y, z"
        said.append(
            f"z up, metres, radians; quaternions {order}; joints in the order of {asked.onto.name}"
            + (f" (columns and rate: {beside})" if beside else "")
        )
    else:
        unit = asked.unit or FIXED_UNITS.get(path.suffix.lower(), 0.01)
        said += _write(replace(clip, unit=unit), path, asked, owner)
    return Changed(clip, tuple(said), first.first, fitted.fit)


def _say_robot(model: Path, fitted: FittedRobot) -> list[str]:
    """Say how well a robot follows a motion."""
    fit = fitted.fit
    return [
        f"onto {model.name}: {fit.driven} hinges follow the motion within their limits; the legs "
        f"are {fit.scale:.2f} times those of the canonical body",
        f"onto: joints are {1000 * fitted.joint_error:.0f} mm from their scaled places in the mean "
        f"({1000 * fitted.most_joint_error:.0f} at most), the feet {1000 * fit.foot_error:.0f} "
        f"({1000 * fit.most_foot_error:.0f}), the hands {1000 * fit.hand_error:.0f} "
        f"({1000 * fit.most_hand_error:.0f}; {fit.hands}); feet in contact slip "
        f"{100 * fit.slip:.1f} cm/s, in the motion {100 * fit.slip_of_motion:.1f}",
    ]


def _map_of(rig: Clip, path: Path, asked: MotionChanges) -> Mapping[str, str]:
    """Return the joint map of a rig; without one for unknown names, write a proposal and say so."""
    assert asked.onto is not None
    try:
        joint_map(rig.skeleton, asked.joint_map)
    except SkeletonError as error:
        if asked.joint_map:
            raise
        proposal = path.with_name(f"{asked.onto.stem}.map")
        text = map_text(rig.skeleton, asked.onto.name)
        if proposal.exists():
            place = f"{proposal} exists already and stays as it is"
        else:
            write_bytes(proposal, text.encode())
            place = f"A proposal was written to {proposal}"
        raise SkeletonError(
            f"{asked.onto}: {error} {place}: check it, and pass --joint-map {proposal}."
        ) from None
    return asked.joint_map


def _say_fit(rig: Path, fit: Fit) -> list[str]:
    """Say how well a rig follows a motion."""

    def mm(metres: float) -> str:
        return f"{1000 * metres:.0f}"

    return [
        f"onto {rig.name}: {fit.driven} of {fit.joints} joints follow the motion, the others hang "
        f"from them; the legs are {fit.scale:.2f} times those of the canonical body",
        f"onto: the feet are {mm(fit.foot_error)} mm from their positions in the mean "
        f"({mm(fit.most_foot_error)} at most), the hands {mm(fit.hand_error)} mm "
        f"({mm(fit.most_hand_error)} at most; {fit.hands}); feet in contact slip "
        f"{100 * fit.slip:.1f} cm/s, in the motion {100 * fit.slip_of_motion:.1f}",
    ]


def _contacts(clip: Clip, asked: MotionChanges) -> BoolArray:
    """Which foot, left or right, is on the ground: array (frames, 2), found at 30 a second."""
    motion = retarget.to_motion(clip, asked.joint_map, keep_implausible=True)
    found = find_contacts(motion.joint_positions())
    frames = np.round(np.arange(clip.n_frames) / clip.fps * MOTION_FPS).astype(np.int64)
    return np.asarray(found[np.minimum(frames, len(found) - 1)])


def write_added(
    info: CaptureInfo, source: packed_files.Source, path: Path, unit: float
) -> Exported:
    """Write the file that was added, and the skeleton of an AMC beside it."""
    said: tuple[str, ...] = ()
    ending = Path(source.skeleton_name or "").suffix or ".asf"
    skeleton = path.with_suffix(ending) if source.skeleton_data is not None else None
    if skeleton is not None and source.skeleton_data is not None:
        check_overwriting(path)  # both files or none
        check_overwriting(skeleton)
        write_bytes(skeleton, source.skeleton_data)
    write_bytes(path, source.data)
    if source.take:
        said = (f"the file holds all of its takes; this capture is {source.take}",)
    return Exported(info.name, path, info.fps, info.n_frames, unit_name(unit), True, said, skeleton)


def load_clip(session: Session, name: str) -> Clip:
    """A stored capture on its own skeleton and at its own rate, as it was read when added."""
    from motiondb.database.catalogue.file_reading import read_source, stored_options

    with session.reading():
        info = store.load_capture(session.store, name)
        source = store.load_source(session.store, info.capture_id)
        run = store.load_run(session.store, info.run_id)
    return read_source(name, source, stored_options(info, source, run.parameters, info.fps))


def added_joint_map(session: Session, info: CaptureInfo) -> dict[str, str]:
    """The joint map with which a capture was added; empty without one."""
    return joint_map_of(store.load_run(session.store, info.run_id).parameters)


def joint_map_of(parameters: Mapping[str, object]) -> dict[str, str]:
    """The joint map among the parameters of a run; empty without one."""
    added = parameters.get("joint_map")
    return {str(k): str(v) for k, v in added.items()} if isinstance(added, dict) else {}


def export(
    session: Session,
    name: str,
    path: str | Path,
    start: float | None = None,
    end: float | None = None,
    canonical: bool = False,
    changes: MotionChanges | None = None,
) -> Exported:
    """Write a capture to a file, as ``MotionDB.export`` says."""
    path, asked = Path(path), changes or MotionChanges()
    is_named = asked.of_motion.are_any or path.suffix.lower() in ARRAY_ENDINGS
    check_joint_map(asked, is_named and not canonical)
    whole = start is None and end is None and not canonical and not asked.are_any
    with session.reading():
        info = store.load_capture(session.store, name)
        if not info.has_body:
            from motiondb.database.catalogue.marker_captures import export_markers

            return export_markers(session, info, path, whole, (start, end))
        if canonical or asked.onto is not None:
            motion = parts.cut_motion(store.load_motion(session.store, info.capture_id), start, end)
        else:
            source = store.load_source(session.store, info.capture_id)
            if whole and path.suffix.lower() == Path(source.own_name).suffix.lower():
                return write_added(info, source, path, load_clip(session, name).unit)
            motion, clip = None, parts.cut_clip(load_clip(session, name), start, end)
            if not asked.joint_map:
                asked = replace(asked, joint_map=added_joint_map(session, info))
    owner = f"{info.name}, licence {info.tags.get('licence', 'not known')}"
    if motion is not None:
        made = write_motion(motion, path, asked, owner)
    else:
        made = write_changed(clip, path, asked, owner)
    size = made.clip.fps, made.clip.n_frames, unit_in(path, made.clip)
    return Exported(info.name, path, *size, False, made.said, None, made.fit)


def write_matches(
    session: Session, matches: Sequence[Match], folder: Path, question: str
) -> list[MatchFile]:
    """Write matches as BVH into a folder, which is made if there is none."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise QueryError(
            f"{folder}: expected a folder that can be made, found: {error.strerror}. Name another."
        ) from None
    paths = [folder / f"{_file_name(match)}.bvh" for match in matches]
    for path in paths:  # before any is written
        check_overwriting(path)
        check_overwriting(provenance_path(path))
    with session.reading():
        return [_write_match(session, *each, question) for each in zip(matches, paths)]


def _file_name(match: Match) -> str:
    """The name of a file: rank, capture and interval."""
    plain = _UNUSUAL.sub("-", match.capture.replace("/", "-"))[:100]
    return f"{match.rank:03d}_{plain}_{match.start:.2f}-{match.end:.2f}"


def _write_match(session: Session, match: Match, path: Path, question: str) -> MatchFile:
    """Write one match as BVH, and its origin beside it."""
    info = store.load_capture(session.store, match.capture)
    sources = store.load_provenance(session.store, info.capture_id).sources
    licence = info.tags.get("licence", "unknown")
    export(session, match.capture, path, match.start, match.end)
    told = ("rank", "capture", "start", "end", "place", "score", "probability")
    origin = {
        "written_by": WRITER,
        "sha256": digest_of(path),
        "question": question,
        **{name: getattr(match, name) for name in told},
        "kind": info.kind,
        "licence": licence,
        "performer": info.tags.get("performer", "unknown"),
        "file": info.path,
        "file_sha256": info.sha256,
        "made_of": [vars(source) for source in sources],
    }
    beside = provenance_path(path)
    write_bytes(beside, json.dumps(to_json(origin), indent=1).encode())
    return MatchFile(match.rank, match.capture, path, beside, licence)


_FEWEST = 3  # Frames of a capture


def write_humanml3d(
    session: Session, infos: Sequence[CaptureInfo], folder: Path
) -> answers.DataSet:
    """Write captures in the form of HumanML3D into a new folder, with a table of what they are."""
    check_new_folder(folder)  # before captures are converted
    rows, left_out = list[tuple[str, ...]](), list[str]()
    with session.reading(), whole_folder(folder, check_new_folder) as draft:
        written = humanml3d.write_set(draft, _converted(session, infos, rows, left_out))
        columns = ("id", "capture", "frames", "captions", "performer", "licence")
        write_table(draft / "captures.csv", columns, rows)
    named = {"folder": folder, "form": "humanml3d", "captures": written.motions}
    return answers.extended(answers.DataSet, written, **named, left_out=tuple(left_out))


def _converted(
    session: Session,
    infos: Sequence[CaptureInfo],
    rows: list[tuple[str, ...]],
    left_out: list[str],
) -> Iterator[tuple[str, FloatArray, str]]:
    """Convert captures, one after the other; `rows` of the table and what is left out grow."""
    rig = own_rig("smpl")
    captions = store.load_captions(session.store, [info.capture_id for info in infos])
    for info in infos:
        if not info.has_body or info.motion_frames < _FEWEST:
            why = "it is too short" if info.has_body else "it has no body"
            left_out.append(f"{info.name} is left out: {why}.")
            continue
        motion = store.load_motion(session.store, info.capture_id)
        clip = changed(onto(motion, rig, {}).clip, MotionChanges(fps=humanml3d.FPS)).clip
        numbers = humanml3d.motion_numbers(clip_positions(clip)[0])
        text = humanml3d.text_lines(captions.get(info.capture_id, ()), info.duration)
        tags = (info.tags.get("performer", ""), info.tags.get("licence", ""))
        counts = str(len(numbers)), str(text.count("\n"))
        rows.append((f"{len(rows):06d}", info.name, *counts, *tags))
        yield rows[-1][0], numbers, text
