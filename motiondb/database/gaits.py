"""The gait of a capture or a file, at its own rate and in the metres of its performer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, pictures, store
from motiondb.body import gait, retarget
from motiondb.database.catalogue.parts import cut_clip
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.records import Clip, Motion

if TYPE_CHECKING:
    from motiondb.database.values import Example

_STANDS = "no gait: no foot swings to another place and strikes there, with the other in turn"


def gait_of(
    session: Session,
    example: Example,
    start: float | None = None,
    end: float | None = None,
    png: str | Path | None = None,
) -> answers.GaitReport:
    """Find foot strikes, and measure the cycles between them, as ``Captures.gait`` says."""
    name = str(example) if isinstance(example, str | Path) else "motion"
    clip, joint_map = _clip_of(session, example)
    clip = cut_clip(clip, start, end)
    points, belt = gait.over_ground(retarget.clip_keypoints(clip, joint_map), clip.fps)
    events = gait.foot_events(points, clip.fps)
    cycles = gait.gait_cycles(points, clip.fps, events)
    angles = gait.cycle_angles(points, clip.fps, cycles)
    prints = gait.foot_prints(points, clip.fps, events)
    notes = [] if events else [_STANDS]
    if belt:
        notes.append(f"on a treadmill at {belt:.2f} m/s: lengths are those over the belt")
    if events and not cycles:
        notes.append("no whole cycle: no foot strikes twice with one strike of the other between")
    if png is not None:
        if not events:
            raise QueryError(f"{name}: expected steps to draw, found {_STANDS}.")
        stances = {
            side: float(np.mean([c.stance for c in cycles if c.side == side]))
            for side in {c.side for c in cycles}
        }
        pictures.save_png(pictures.gait_figure(name, prints, angles, stances), png)
    return answers.GaitReport(
        name,
        round(clip.duration, 3),
        clip.fps,
        tuple(events),
        cycles,
        gait.measures(cycles),
        angles,
        prints,
        round(belt, 3),
        tuple(notes),
        None if png is None else Path(png),
    )


def _clip_of(session: Session, example: Example) -> tuple[Clip, dict[str, str]]:
    """Return the clip of an example, and the joint map with which it was added."""
    from motiondb.database.catalogue.exporting import added_joint_map, load_clip
    from motiondb.files.formats import read_capture, split_take
    from motiondb.files.safe_files import is_file

    if isinstance(example, Clip):
        return example, {}
    if isinstance(example, Motion):
        return retarget.to_clip(example), {}
    if is_file(split_take(example)[0]):
        return read_capture(example), {}
    with session.reading():
        info = store.load_capture(session.store, str(example), or_file=True)
        if info.kind == "generated":
            return retarget.to_clip(store.load_motion(session.store, info.capture_id)), {}
        return load_clip(session, info.name), added_joint_map(session, info)
