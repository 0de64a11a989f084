"""Copies among the captures of a database, looked for when captures are added.

The outlines of captures (:mod:`motiondb.search.copy_outlines`) are kept in the cache of the
database, so that the motions of captures that are there already need not be loaded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS, Float32Array, IntArray, Motion, Relation
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array, outline
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
    # One after another: a merge may bring many hours
    return {n: _make([motion])[0] for n, motion in store.readable_motions(opened, numbers)}


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
    made = new_outlines(opened, known) if made is None else made
    held = {number: place for place, number in enumerate(known.capture_ids.tolist())}
    infos = store.load_captures(opened)
    infos = [i for i in infos if i.capture_id in made or i.capture_id in held]  # the sound ones
    numbers = [info.capture_id for info in infos]

    def outline_of(n: int) -> Int16Array:
        if numbers[n] in made:
            return made[numbers[n]][0]
        place = held[numbers[n]]
        return known.rows[known.bounds[place] : known.bounds[place + 1]]

    def outlines_at(takes: IntArray, frames: IntArray) -> Int16Array:
        found = np.zeros((*frames.shape, N_AXES), dtype=np.int16)
        is_made = np.array([numbers[n] in made for n in takes], dtype=bool)
        for n in np.flatnonzero(is_made):
            found[n] = outline_of(int(takes[n]))[frames[n]]
        places = np.array([held[numbers[n]] for n in takes[~is_made]], dtype=np.int64)
        if len(places):
            found[~is_made] = known.rows[known.bounds[places][:, None] + frames[~is_made]]
        return found

    def poses_of(n: int) -> Float32Array:
        return copies.copy_poses(store.load_motion(opened, numbers[n]))

    sizes = np.array([info.motion_frames for info in infos], dtype=np.int64)
    reaches = [made[n][1] if n in made else float(known.values[held[n]]) for n in numbers]
    library = copies.Library(sizes, np.array(reaches), outline_of, outlines_at, poses_of)
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
