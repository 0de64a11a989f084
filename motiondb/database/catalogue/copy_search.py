"""Copies among the captures of a database, looked for when captures are added.

The outlines of captures (:mod:`motiondb.search.copy_outlines`) are kept in the cache of the
database, so that the motions of captures that are there already need not be loaded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS, Float32Array, Motion, Relation
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array, Outlines, outline
from motiondb.workers import HERE, Workers

KIND = "outlines"  # Name of the outlines of all captures in the cache of the database


Made = tuple[Int16Array, float]
"""Outline (frames, 12) of a capture, and how far from it a copy may be."""


def load_outlines(
    opened: store.Store, ready: Mapping[int, Made] = MappingProxyType({})
) -> store.CaptureRows:
    """Outlines of all captures, and how far from them a copy may be.

    `ready`: Those that were made already, by number of the capture (:func:`new_outlines`).
    """
    return store.cached_rows(opened, KIND, _make, ready)


def new_outlines(opened: store.Store, known: store.CaptureRows) -> dict[int, Made]:
    """Outlines of the captures that were saved after ``known`` was loaded, by number."""
    held = set(known.capture_ids.tolist())
    numbers = [i.capture_id for i in store.load_captures(opened) if i.capture_id not in held]
    return dict(zip(numbers, _make([store.load_motion(opened, number) for number in numbers])))


def find_relations(
    opened: store.Store,
    new: set[str],
    known: store.CaptureRows,
    made: Mapping[int, Made] | None = None,
    workers: Workers = HERE,
) -> list[Relation]:
    """Copies, mirror images and cuts among the captures, of which at least one is new.

    `new`: Names of captures.

    `known`: Outlines that were loaded before the new captures were saved.

    `made`: Those of :func:`new_outlines`; made here if they are not given.
    """
    infos = store.load_captures(opened)
    held = {number: place for place, number in enumerate(known.capture_ids.tolist())}
    made = new_outlines(opened, known) if made is None else made
    parts, reaches = list[Int16Array](), list[float]()
    for number in (info.capture_id for info in infos):
        if number in made:
            part, reach = made[number]
        else:
            place = held[number]
            part = known.rows[known.bounds[place] : known.bounds[place + 1]]
            reach = float(known.values[place])
        parts.append(part)
        reaches.append(reach)

    def poses_of(number: int) -> Float32Array:
        return copies.copy_poses(store.load_motion(opened, infos[number].capture_id))

    sizes = [0, *(len(part) for part in parts)]
    limbs = np.concatenate(parts) if parts else np.zeros((0, N_AXES), dtype=np.int16)
    outlines = Outlines(limbs, np.cumsum(sizes, dtype=np.int64), np.array(reaches))
    library = copies.Library(outlines, poses_of)
    fresh = [n for n, info in enumerate(infos) if info.name in new]
    old = [n for n, info in enumerate(infos) if info.name not in new]
    found = copies.find_copies(library, fresh, None, workers)
    found += copies.find_copies(library, old, fresh, workers)
    return [
        Relation(
            infos[c.query].name,
            infos[c.take].name,
            c.kind,
            c.start / MOTION_FPS,
            c.end / MOTION_FPS,
            c.distance,
        )
        for c in found
    ]


def _make(motions: Sequence[Motion]) -> list[Made]:
    """Outline and reach of some motions, in their order."""
    poses = (copies.copy_poses(motion) for motion in motions)
    return [(outline(each), copies.reach(each)) for each in poses]
