"""What captures lack: measured when it is asked for, kept with the captures, and told."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, pictures, store
from motiondb.body import body
from motiondb.body.joint_names import joint_map
from motiondb.body.retarget import keypoints_of, up_axis
from motiondb.database.catalogue.exporting import added_joint_map, joint_map_of, load_clip
from motiondb.database.catalogue.file_reading import read_source, stored_options
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.own_files import WRITER
from motiondb.files.processes import in_processes
from motiondb.files.safe_files import write_bytes
from motiondb.quality.assess import assess, performer_rate, to_mjcf, to_values
from motiondb.records import MOTION_FPS, CaptureInfo, Clip, FloatArray, Quality

if TYPE_CHECKING:
    from concurrent.futures import Future

    from matplotlib.figure import Figure
    from pebble import ProcessPool

    from motiondb.database.session import Session
    from motiondb.files.formats import ReadOptions
    from motiondb.files.packed_files import Source

Progress = Callable[[str, float, float], None]
_FEW = 20  # Captures that are measured in this process: starting others takes as long
_AT_ONCE = 100  # Captures that are saved together: what was measured is kept if it is interrupted


def quality_of(
    session: Session,
    infos: Sequence[CaptureInfo],
    again: bool = False,
    progress: Progress | None = None,
) -> answers.QualityAnswer:
    """Measure captures of which nothing is known, or all again, and tell of all.

    Of markers without a body nothing is told; that there are only such is an error.
    """
    bodies = [info for info in infos if info.has_body]
    if infos and not bodies:
        raise QueryError(f"{infos[0].name}: {store.MARKERS_ONLY}")
    without_body, infos = len(infos) - len(bodies), bodies
    known, measured, problems = known_quality(session, infos, again, progress)
    found = {i.name: known[i.capture_id] for i in infos if i.capture_id in known}
    return answers.QualityAnswer(
        [answers.capture_quality(name, each) for name, each in found.items()],
        rates(found, {i.name: performer_of(i) for i in infos}),
        measured,
        problems,
        without_body,
    )


def known_quality(
    session: Session,
    infos: Sequence[CaptureInfo],
    again: bool = False,
    progress: Progress | None = None,
) -> tuple[dict[int, Quality], int, list[str]]:
    """What captures lack, by number; how many were measured for it, and which could not be."""
    known = {} if again else store.load_quality(session.store, [i.capture_id for i in infos])
    lacking = [info for info in infos if info.capture_id not in known]
    problems: list[str] = []
    made: dict[int, Quality] = {}
    for done, (info, found) in enumerate(zip(lacking, _measured(session, lacking))):
        if progress is not None:
            progress("measuring", done, len(lacking))
        if isinstance(found, str):
            problems.append(f"{info.name}: {found}")
        else:
            made[info.capture_id] = found
        if len(made) >= _AT_ONCE:
            known |= _saved(session, made)
            made = {}
    if made:
        known |= _saved(session, made)
    return known, len(lacking) - len(problems), problems


def _saved(session: Session, made: Mapping[int, Quality]) -> Mapping[int, Quality]:
    """Save what was measured as a run of its own, where the database is not only read."""
    if not session.store.read_only:
        with store.running(session.store, "quality", {"captures": len(made)}) as run_id:
            store.save_quality(session.store, made, run_id)
    return made


def performer_of(info: CaptureInfo) -> str:
    """Who is captured: the performer, else the folder."""
    return info.tags.get("performer") or info.name.rpartition("/")[0] or "captures in no folder"


def _measured(session: Session, infos: Sequence[CaptureInfo]) -> Iterator[Quality | str]:
    """Measure captures on their own skeletons, in their own size and at their own rate.

    A sentence says why one cannot be measured. More than a few are measured in other processes.
    """
    stored = _stored(session, infos)
    if len(infos) < _FEW:
        yield from map(_assessed, stored)
        return
    yield from in_processes(stored, len(infos), _submit, _result)


def _submit(pool: ProcessPool, stored: _Stored | str) -> Future[Quality | str]:
    return pool.schedule(_assessed, args=(stored,))


def _result(stored: _Stored | str, future: Future[Quality | str] | None) -> Quality | str:
    """What was measured; a sentence where the process ended."""
    from pebble import ProcessExpired

    try:
        return _assessed(stored) if future is None else future.result()
    except (ProcessExpired, BrokenProcessPool):
        return "its process ended. Measure it alone, or see how much memory is free"


@dataclass(frozen=True)
class _Stored:
    """What a capture is read from, and how."""

    name: str
    source: Source
    options: ReadOptions
    joint_map: Mapping[str, str]


def _stored(session: Session, infos: Sequence[CaptureInfo]) -> Iterator[_Stored | str]:
    """What captures are read from; a sentence for one that cannot be loaded."""
    runs: dict[int, Mapping[str, object]] = {}
    for info in infos:
        try:
            with session.reading():
                if info.run_id not in runs:
                    runs[info.run_id] = store.load_run(session.store, info.run_id).parameters
                source = store.load_source(session.store, info.capture_id)
        except MotionDBError as error:
            yield str(error)
            continue
        parameters = runs[info.run_id]
        options = stored_options(info, source, parameters, info.fps)
        yield _Stored(info.name, source, options, joint_map_of(parameters))


def _assessed(stored: _Stored | str) -> Quality | str:
    """Measure a capture; a sentence if it cannot be read."""
    if isinstance(stored, str):
        return stored
    try:
        clip = read_source(stored.name, stored.source, stored.options)
        clip, points, has_toes = points_of(clip, stored.joint_map)
    except MotionDBError as error:
        return str(error)
    return assess(points, clip.fps, has_toes)


def load_points(session: Session, info: CaptureInfo) -> tuple[Clip, FloatArray, bool]:
    """A stored clip and its joints, as :func:`points_of` has them."""
    return points_of(load_clip(session, info.name), added_joint_map(session, info))


def ghosts(session: Session, name: str) -> tuple[answers.Ghost, ...]:
    """Boxes for what a capture needs, as far as it was measured, where its motion is played.

    The motion has the size and the ground of the standard body: a box stands to the pelvis as it
    does in the capture, in the middle of its time.
    """
    info = store.load_capture(session.store, name)
    known = store.load_quality(session.store, [info.capture_id])
    found = [f for each in known.values() for f in each.findings if f.boxes]
    if not found or not info.has_body:
        return ()
    clip, points, _ = load_points(session, info)
    root = store.load_motion(session.store, info.capture_id).root_positions
    scale, out = body.LEG_LENGTH / info.leg_length, list[answers.Ghost]()
    for each in found:
        middle = (each.start + each.end) / 2.0
        there = points[min(round(middle * clip.fps), len(points) - 1), body.INDEX["pelvis"]]
        here = root[min(round(middle * MOTION_FPS), len(root) - 1)]
        for box in each.boxes if np.isfinite(there).all() else ():
            x, y, z = (here + scale * (np.array(box.centre) - there)).round(4).tolist()
            a, b, c = (scale * np.array(box.size)).round(4).tolist()
            out.append(answers.Ghost(each.sentence, each.start, each.end, (x, y, z), (a, b, c)))
    return tuple(out)


def points_of(clip: Clip, user_map: Mapping[str, str]) -> tuple[Clip, FloatArray, bool]:
    """A clip, its joints (frames, 21, 3), metres, y up, and whether it has toes."""
    roles = joint_map(clip.skeleton, user_map)
    return clip, keypoints_of(clip, roles)[0], {"l_toe", "r_toe"} <= roles.keys()


def rates(
    found: Mapping[str, Quality], performers: Mapping[str, str]
) -> list[answers.PerformerRate]:
    """The speed at which the captures of each performer play."""
    flights: dict[str, list[tuple[float, float]]] = {}
    for name, quality in found.items():
        flights.setdefault(performers[name], []).extend(quality.flights)
    out = []
    for whose, rows in flights.items():
        speed, error, said = performer_rate(rows, whose)
        out.append(answers.PerformerRate(whose, len(rows), speed, error, said))
    return out


def write_boxes(session: Session, found: Mapping[str, Quality], path: Path) -> None:
    """Write the boxes of captures as JSON, or of one as MJCF, in the world of its file."""
    if path.suffix.lower() == ".xml" and len(found) != 1:
        raise QueryError(
            f"{path}: expected one capture for boxes as MJCF, found {len(found)}. "
            "Name one, or write .json."
        )
    rows, text = [], ""
    for name, quality in found.items():
        info = store.load_capture(session.store, name)
        up = up_axis(load_clip(session, name), added_joint_map(session, info))
        if path.suffix.lower() == ".xml":
            text = to_mjcf(quality.findings, up, name)
        rows.append(
            {"capture": name, "up": up, "unit": "m", "boxes": to_values(quality.findings, up)}
        )
    values = {"written_by": WRITER, "captures": rows}
    write_bytes(path, (text or json.dumps(values, indent=1)).encode())


def draw_quality(session: Session, name: str, path: str | Path | None) -> Path | Figure:
    """Figures of a capture over the floor with what it needs as boxes, and its findings."""
    info = store.load_capture(session.store, name)
    known = store.load_quality(session.store, [info.capture_id]).get(info.capture_id)
    clip, points, has_toes = load_points(session, info)
    quality = known or assess(points, clip.fps, has_toes)
    return pictures.save_png(pictures.ghosts_figure(points, clip.fps, quality, info.name), path)
